"""How long the strategies take over a proposal, as a function of the number of evaluated designs.

python benchmarks/proposal_overhead.py [--strategies dycors …] [--dimensions 10 20] [--sizes 50 100 200] [--repeats 3]

Needs coco-experiment. A short search lays down a history; every strategy is told its first n evaluations, and then asked
and told a few times, in turns with the others. The time is that of the thread's processor, so that other work on the machine
takes part in it by way of shared caches and cores only.
"""

import argparse
import itertools
import time

import numpy as np
from measuring import yardstick
from threadpoolctl import threadpool_limits

import railsearch
from railsearch.interfaces import Evaluation
from railsearch.plugin_manager import load_plugins
from railsearch.run import RunSettings, make_strategy, run_search

STRATEGIES = ("dycors", "lmsrs", "adaptive-rbf", "adaptive-kriging", "ego")
SUITES = {"8 of 10 integer": "bbob-mixint", "continuous": "bbob"}
FUNCTION = 15
BUDGET = 400
QUICK = {"candidates_per_dimension": 20, "tree_search": False}
"""Settings of the search that lays down a history."""


def main():
    """Print a line per space, dimension, strategy and size of history."""
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--strategies", nargs="+", default=STRATEGIES)
    arguments.add_argument("--dimensions", nargs="+", type=int, default=(10, 20))
    arguments.add_argument("--sizes", nargs="+", type=int, default=(50, 100, 200))
    arguments.add_argument("--repeats", type=int, default=3, help="histories, each of a seed of its own")
    arguments.add_argument("--proposals", type=int, default=8, help="proposals timed after each history")
    asked = arguments.parse_args()
    registry = load_plugins()
    print("space            d  strategy            n  ms per proposal: median (quartiles)", flush=True)
    with threadpool_limits(1):
        noise = [thread_seconds(yardstick)[0] for _ in range(5)]
        for (space, suite), dimension in itertools.product(SUITES.items(), asked.dimensions):
            measured(registry, asked, space, suite, dimension)
        noise += [thread_seconds(yardstick)[0] for _ in range(5)]
    print(f"noise of the machine, s for fixed arithmetic: {quartiles(noise)}")


def measured(registry, asked, space, suite, dimension):
    """The lines of one space."""
    problem = railsearch.problem(suite, sections={"coco": {"function": FUNCTION, "dimension": dimension}})
    times = {}
    for seed in range(1, asked.repeats + 1):
        history = run_search(registry, problem, RunSettings("dycors", max(asked.sizes), seed, QUICK)).evaluations
        for n, strategy in itertools.product(asked.sizes, asked.strategies):
            told = overheads(registry, problem, strategy, history[:n], asked.proposals, seed)
            times.setdefault((strategy, n), []).extend(told)
    for strategy, n in itertools.product(asked.strategies, asked.sizes):
        milliseconds = 1e3 * np.array(times[strategy, n])
        print(f"{space:15} {dimension:2}  {strategy:16} {n:4}  {quartiles(milliseconds)}", flush=True)


def overheads(registry, problem, name, history, count, seed):
    """Seconds of asking for a design and telling its values, `count` times after a history and one that is not timed."""
    strategy = make_strategy(registry, problem, RunSettings(name, BUDGET, seed))
    strategy.tell(history)
    seconds = []
    for number in range(len(history), len(history) + count + 1):
        asking, (proposal, *_) = thread_seconds(strategy.ask)
        values = problem.evaluate(proposal.design[None, :], return_as_dictionary=True)["F"][0]
        evaluation = Evaluation(number, proposal.design, values, np.empty(0), {}, proposal.origin, proposal.trajectory)
        telling, _ = thread_seconds(lambda evaluation=evaluation: strategy.tell([evaluation]))
        seconds.append(asking + telling)
    return seconds[1:]


def thread_seconds(work):
    """How long a piece of work takes of this thread's processor time, and what it gives."""
    start = time.thread_time()
    result = work()
    return time.thread_time() - start, result


def quartiles(values):
    """Median and quartiles in words."""
    low, middle, high = np.percentile(values, [25, 50, 75])
    return f"{middle:.4g} ({low:.4g} to {high:.4g})"


if __name__ == "__main__":
    main()
