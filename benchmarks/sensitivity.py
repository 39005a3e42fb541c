"""Time of a sensitivity analysis on polynomial chaos expansions, and how far its extremes are from the best known.

    python benchmarks/sensitivity.py [--factors 16] [--points 100] [--terms 400] [--repeats 3] [--thorough]

All inner problems (factors × points, maximum and minimum) and three thresholds: on an expansion of the truss of 23 bars
fitted to 400 points, and on expansions with random terms of degree 9 and norm 0.5 over uniform inputs, whose coefficients
fall as (1 + degree)^−decay. These have far more local optima than a structure's response. `--thorough` compares with one
that has more starts, exchanges and samples. Times are those of the processor.
"""

import argparse

import numpy as np
from measuring import both_seconds, seconds, spread, yardstick
from threadpoolctl import threadpool_limits

from railsearch.distributions import random_vector
from railsearch.sampling import latin_hypercube
from railsearch.sensitivity import (
    SENSES,
    SearchSettings,
    direct_threshold_surfaces,
    extreme_surfaces,
    factors_on,
    input_space,
    threshold_surfaces,
)
from railsearch_plugins.polynomial_chaos.estimator import PolynomialChaosRegressor
from railsearch_plugins.polynomial_chaos.expansion import Expansion
from railsearch_plugins.polynomial_chaos.families import families
from railsearch_plugins.polynomial_chaos.multi_indices import hyperbolic_set
from railsearch_problems.truss import Truss, closed_form

DEGREE, NORM = 9, 0.5
SHARES = np.array([0.25, 0.5, 0.75])
THOROUGH = SearchSettings(starts=4, sample=256, exchanges=4, pool=256, check=256)


def main():
    """Print times, counts and the check."""
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--factors", type=int, default=16)
    arguments.add_argument("--points", type=int, default=100)
    arguments.add_argument("--terms", type=int, default=400)
    arguments.add_argument("--repeats", type=int, default=3)
    arguments.add_argument("--thorough", action="store_true")
    asked = arguments.parse_args()
    with threadpool_limits(1):
        report("truss", *truss_expansion(), 50, asked)
        for decay in (1.0, 2.0, 3.0):
            report(f"decay {decay:g}", *random_expansion(asked.factors, asked.terms, decay), asked.points, asked)
        print(f"noise of the machine, s for fixed arithmetic: {spread([seconds(yardstick) for _ in range(5)])}")


def report(title, inputs, expansion, points, asked):
    """Times and checks of one expansion."""
    factors = factors_on(input_space(inputs), points)
    found, times = [], []
    for seed in range(asked.repeats):
        times.append(both_seconds(lambda seed=seed: found.append(analysed(expansion, factors, seed)))[1])
    terms = len(expansion.coefficients)
    print(f"{title}: {factors.dimension} factors × {points} points × 3 thresholds, {terms} terms")
    print(f"  extremes, thresholds by clipping, s: {spread(times)}", flush=True)
    for extremes, _ in found:
        check = extremes.effort.check
        print(f"  asked {extremes.effort.asked}, rescued {check.rescued} in {check.rounds} rounds, held {check.held}")
    direct, time = directly(expansion, *found[0])
    print(f"  direct minimisation of (g − t)², s: {time:.3g}; largest difference {difference(found[0][1], direct):.1e}")
    if asked.thorough:
        best = extreme_surfaces(expansion, factors, np.random.default_rng(99), THOROUGH)
        print(f"  missed extremes: {missed([extremes for extremes, _ in found], best)}", flush=True)


def directly(expansion, extremes, thresholds):
    """The same thresholds by direct minimisation, and its seconds."""
    found, values = [], [threshold.value for threshold in thresholds.thresholds]
    generator = np.random.default_rng(7)
    time = both_seconds(lambda: found.append(direct_threshold_surfaces(expansion, extremes, values, generator)))[1]
    return found[0], time


def truss_expansion():
    """The truss fitted to 400 points."""
    inputs = Truss().distributions
    points = latin_hypercube(inputs, 400, np.random.default_rng(0))
    model = PolynomialChaosRegressor(inputs=inputs).fit(points, closed_form(points))
    return inputs, model.expansion_


def random_expansion(dimension, terms, decay):
    """An expansion of random terms and coefficients over uniform inputs."""
    generator = np.random.default_rng(0)
    uniform = {"distribution": "uniform", "lower": -1.0, "upper": 1.0}
    inputs = random_vector({f"x{k + 1}": uniform for k in range(dimension)})
    indices = hyperbolic_set(dimension, DEGREE, NORM, 20_000)
    chosen = np.vstack([indices[:1], indices[1:][generator.permutation(len(indices) - 1)[: terms - 1]]])
    coefficients = generator.normal(size=terms) * (1.0 + chosen.sum(axis=1)) ** -decay
    made = families(inputs.marginals.values(), DEGREE, ["own"] * dimension)
    return inputs, Expansion(made, chosen, coefficients)


def analysed(expansion, factors, seed):
    """Extreme surfaces and three thresholds between the extremes."""
    extremes = extreme_surfaces(expansion, factors, np.random.default_rng(seed))
    low, high = (extremes.extreme(sense) for sense in reversed(SENSES))
    return extremes, threshold_surfaces(extremes, low + SHARES * (high - low))


def difference(first, second):
    """The largest difference between two sets of threshold curves as a fraction of the range of the output."""
    pairs = zip(first.thresholds, second.thresholds, strict=True)
    largest = max(
        np.abs(a.curve - b.curve).max() for one, other in pairs for a, b in zip(one.factors, other.factors, strict=True)
    )
    return largest / np.ptp([first.extremes.extreme(sense) for sense in SENSES])


def missed(found, best):
    """Of how many inner problems a search has not found the best extreme of all searches, and by how much of the range."""
    merits = np.array([merits_of(extremes) for extremes in (*found, best)])
    width = np.ptp([best.extreme(sense) for sense in SENSES])
    gaps = (merits - merits.min(axis=0)) / width
    words = [f"{int(np.sum(row > 1e-6))} (at most {row.max():.1e} of the range)" for row in gaps]
    return f"{'; '.join(words[:-1])}; the thorough one {words[-1]}; of {merits.shape[1]}"


def merits_of(extremes):
    """All extremes with a sign by which the lowest is the best."""
    signs = dict(zip(SENSES, (-1.0, 1.0), strict=True))
    return np.concatenate([signs[sense] * curve.values for sense in SENSES for curve in extremes.curves[sense]])


if __name__ == "__main__":
    main()
