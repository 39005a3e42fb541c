"""What the benchmarks of regressors on the truss share: samples, errors on fresh points, seconds of a fit."""

import time

import numpy as np

from railsearch.sampling import latin_hypercube
from railsearch_problems.truss import Truss, closed_form

FRESH = 10_000


def truss_inputs():
    """The random inputs: moduli and cross-sections lognormal, loads of Gumbel's distribution for maxima."""
    return Truss().distributions


def truss_points(size, seed):
    """A Latin hypercube (size, 10) to fit to, and fresh random points (10 000, 10) to be tried on."""
    inputs, generator = truss_inputs(), np.random.default_rng(seed)
    points = latin_hypercube(inputs, size, generator)
    return points, inputs.from_uniform(generator.random((FRESH, inputs.dimension)))


def measured(model, size, seed):
    """ε_gen on fresh points, and seconds of the fit to a Latin hypercube."""
    points, fresh = truss_points(size, seed)
    fit = seconds(lambda: model.fit(points, closed_form(points)))
    return generalisation_error(model.predict(fresh), closed_form(fresh)), fit


def generalisation_error(predicted, truth):
    """ε_gen = E[(g − ĝ)²]/Var(g)."""
    return float(np.mean((predicted - truth) ** 2) / np.var(truth))


def spread_of_errors(errors):
    """Median, least and largest error in words."""
    return f"{np.median(errors):.2e} ({np.min(errors):.1e} to {np.max(errors):.1e})"


def seconds(work):
    """How long a piece of work takes of this thread's processor time."""
    start = time.thread_time()
    work()
    return time.thread_time() - start
