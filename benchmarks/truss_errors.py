"""What the benchmarks of regressors on the truss share: samples, errors on fresh points, seconds of a fit."""

import time

import numpy as np

from railsearch.sampling import latin_hypercube
from railsearch_problems.truss import Truss, closed_form

FRESH = 10_000


def truss_inputs():
    """The random inputs: moduli and cross-sections lognormal, loads of Gumbel's distribution for maxima."""
    return Truss().distributions


def measured(model, size, seed):
    """ε_gen = E[(g − ĝ)²]/Var(g) on fresh points, and seconds of the fit to a Latin hypercube."""
    inputs, generator = truss_inputs(), np.random.default_rng(seed)
    points = latin_hypercube(inputs, size, generator)
    fresh = inputs.from_uniform(generator.random((FRESH, inputs.dimension)))
    fit = seconds(lambda: model.fit(points, closed_form(points)))
    truth = closed_form(fresh)
    return np.mean((model.predict(fresh) - truth) ** 2) / np.var(truth), fit


def spread_of_errors(errors):
    """Median, least and largest error in words."""
    return f"{np.median(errors):.2e} ({np.min(errors):.1e} to {np.max(errors):.1e})"


def seconds(work):
    """How long a piece of work takes of this thread's processor time."""
    start = time.thread_time()
    work()
    return time.thread_time() - start
