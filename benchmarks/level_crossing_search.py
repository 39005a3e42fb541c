"""How far the strategies get on the level crossing: asf with 400 evaluations, several seeds, against the reference design.

python benchmarks/level_crossing_search.py [--budget 400] [--seeds 3]
"""

import argparse

import numpy as np

from railsearch.plugin_manager import load_plugins
from railsearch.problem_factory import ProblemSettings, make_problem
from railsearch.result import improvement, reference_evaluation
from railsearch.run import RunSettings, best, run_search

STRATEGIES = ("dycors", "lmsrs", "ga", "random")


def main():
    """Print a line per strategy and seed, and the medians."""
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--budget", type=int, default=400)
    arguments.add_argument("--seeds", type=int, default=3)
    asked = arguments.parse_args()
    registry = load_plugins()
    print("strategy  seed      asf  F_max better by [%]  E_max better by [%]")
    for strategy in STRATEGIES:
        rows = np.array([searched(registry, strategy, seed, asked.budget) for seed in range(1, asked.seeds + 1)])
        for seed, row in enumerate(rows, start=1):
            print(f"{strategy:9} {seed:4} {row[0]:8.4f} {row[1]:20.1f} {row[2]:20.1f}", flush=True)
        middle = np.median(rows, axis=0)
        print(f"{strategy:7} median {middle[0]:8.4f} {middle[1]:20.1f} {middle[2]:20.1f}", flush=True)


def searched(registry, strategy, seed, budget):
    """The best scalar, and the improvements of F_max and E_max in per cent."""
    problem = make_problem(registry, ProblemSettings("level-crossing", scalariser="asf"))
    result = run_search(registry, problem, RunSettings(strategy, budget, seed), [problem.reference])
    found = best(result.evaluations)
    gain = improvement(problem, reference_evaluation(problem, result.evaluations), found)
    return found.objectives[0], gain["F_max"], gain["E_max"]


if __name__ == "__main__":
    main()
