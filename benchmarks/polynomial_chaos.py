"""How far polynomial chaos expansions are off on the truss with Gumbel (maxima) loads, and how long they take.

python benchmarks/polynomial_chaos.py [--sizes 100 400 1000] [--seeds 10] [--bases own own-hyperbolic …]

Latin hypercubes of every size and seed, 10 000 fresh random points each. The error is ε_gen = E[(g − ĝ)²]/Var(g). Times
are those of the thread's processor.
"""

import argparse

import numpy as np
from measuring import spread, yardstick
from threadpoolctl import threadpool_limits
from truss_errors import FRESH, measured, seconds, spread_of_errors, truss_inputs

from railsearch_plugins.polynomial_chaos.estimator import PolynomialChaosRegressor
from railsearch_plugins.polynomial_chaos.expansion import Expansion
from railsearch_plugins.polynomial_chaos.families import families
from railsearch_plugins.polynomial_chaos.multi_indices import hyperbolic_set

BASES = {
    "own": {},
    "own-hyperbolic": {"growth": False},
    "hermite": {"basis": "hermite"},
    "hermite-hyperbolic": {"basis": "hermite", "growth": False},
}
"""Loads on their own orthonormal polynomials or mapped to Hermite's, the set of terms grown or hyperbolic only."""


HEADER = "   N  basis               ε_gen: median (range)                    ε_LOO     terms  seconds of a fit"


def main():
    """Print a line per size and basis, and the time of evaluation."""
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--sizes", nargs="+", type=int, default=(100, 400, 1000))
    arguments.add_argument("--seeds", type=int, default=10)
    arguments.add_argument("--bases", nargs="+", default=tuple(BASES), choices=tuple(BASES))
    asked = arguments.parse_args()
    inputs = truss_inputs()
    with threadpool_limits(1):
        print(HEADER, flush=True)
        for size in asked.sizes:
            for basis in asked.bases:
                print(line(inputs, size, basis, asked.seeds), flush=True)
        print(f"value and gradient of {FRESH} points, 400 terms: {spread(evaluation_seconds(inputs))} s")
        print(f"noise of the machine, s for fixed arithmetic: {spread([seconds(yardstick) for _ in range(5)])}")


def line(inputs, size, basis, seeds):
    """Error, leave-one-out error, number of terms and time of one size and basis."""
    rows = []
    for seed in range(seeds):
        model = PolynomialChaosRegressor(inputs=inputs, **BASES[basis])
        error, fit = measured(model, size, seed)
        rows.append((error, model.loo_error, len(model.expansion_.coefficients), fit))
    errors, *others = np.array(rows).T
    loo, terms, fit = np.median(others, axis=1)
    return f"{size:4}  {basis:18}  {spread_of_errors(errors):40} {loo:.2e}  {terms:5.0f}  {fit:.2f}"


def evaluation_seconds(inputs):
    """Times of value and gradient of a random expansion of 400 terms of degree 9 and norm 0.5."""
    generator = np.random.default_rng(0)
    terms = hyperbolic_set(inputs.dimension, 9, 0.5, 1000)
    chosen = np.vstack([terms[:1], terms[1:][generator.permutation(len(terms) - 1)[:399]]])
    made = families(inputs.marginals.values(), 9, ["own"] * inputs.dimension)
    expansion = Expansion(made, chosen, generator.normal(size=len(chosen)))
    points = inputs.from_uniform(generator.random((FRESH, inputs.dimension)))
    return [seconds(lambda: expansion.predict_with_gradient(points)) for _ in range(6)][1:]


if __name__ == "__main__":
    main()
