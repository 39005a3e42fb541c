"""Time of a sensitivity analysis on a polynomial chaos expansion, and how far its extremes are from the best known.

    python benchmarks/sensitivity.py [--factors 16] [--points 100] [--terms 400] [--repeats 3]

All inner problems (factors × points, maximum and minimum) and three thresholds on an expansion with random coefficients of
degree 9 and norm 0.5 that fall with the order of the terms, over uniform inputs. Such a function has far more local optima
than a structure's response. The extremes are compared with those of a search with four times the starts and samples.
"""

import argparse

import numpy as np
from measuring import both_seconds, seconds, spread, yardstick
from threadpoolctl import threadpool_limits

from railsearch.distributions import random_vector
from railsearch.sensitivity import (
    SENSES,
    SearchSettings,
    direct_threshold_surfaces,
    extreme_surfaces,
    factors_on,
    input_space,
    threshold_surfaces,
)
from railsearch_plugins.polynomial_chaos.expansion import Expansion
from railsearch_plugins.polynomial_chaos.families import families
from railsearch_plugins.polynomial_chaos.multi_indices import hyperbolic_set

DEGREE, NORM = 9, 0.5
SHARES = np.array([0.25, 0.5, 0.75])
THOROUGH = SearchSettings(starts=12, sample=256, check=512)


def main():
    """Print times, counts and the check."""
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--factors", type=int, default=16)
    arguments.add_argument("--points", type=int, default=100)
    arguments.add_argument("--terms", type=int, default=400)
    arguments.add_argument("--repeats", type=int, default=3)
    asked = arguments.parse_args()
    with threadpool_limits(1):
        for decay in (1.0, 2.0):
            report(asked, decay)
        print(f"noise of the machine, s for fixed arithmetic: {spread([seconds(yardstick) for _ in range(5)])}")


def report(asked, decay):
    """Times and checks of one expansion, whose coefficients fall as (1 + Σα)^−decay."""
    inputs, expansion = random_expansion(asked.factors, asked.terms, decay)
    factors = factors_on(input_space(inputs), asked.points)
    found, times = [], []
    for seed in range(asked.repeats):
        times.append(both_seconds(lambda seed=seed: found.append(analysed(expansion, factors, seed)))[1])
    print(f"{asked.factors} factors × {asked.points} points × 3 thresholds, {asked.terms} terms, decay {decay:g}")
    print(f"  extremes and thresholds by clipping, s of processor time: {spread(times)}")
    for extremes, _ in found:
        print(f"  asked {extremes.effort.asked}, {extremes.effort.check}")
    extremes, thresholds = found[0]
    values = [threshold.value for threshold in thresholds.thresholds]
    direct = []
    time = both_seconds(
        lambda: direct.append(direct_threshold_surfaces(expansion, extremes, values, np.random.default_rng(7)))
    )[1]
    print(f"  direct minimisation of (g − t)², s: {time:.3g}; largest difference {difference(thresholds, direct[0]):.1e}")
    best = extreme_surfaces(expansion, factors, np.random.default_rng(99), THOROUGH)
    print(f"  a thorough search: {best.effort.check}; missed extremes: {missed([one for one, _ in found], best)}")


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
    """Of how many inner problems each search has not found the best known extreme, and by how much of the range at most."""
    words = []
    for extremes in found:
        gaps = np.concatenate(
            [
                np.abs(extremes.surface(name, sense).values - best.surface(name, sense).values)
                for name in best.factors.names
                for sense in SENSES
            ]
        )
        width = np.ptp([best.extreme(sense) for sense in SENSES])
        words.append(f"{int(np.sum(gaps > 1e-6 * width))} of {len(gaps)} (at most {gaps.max() / width:.1e} of the range)")
    return "; ".join(words)


if __name__ == "__main__":
    main()
