"""On a budget of 100 to 200 evaluations the surrogate searches beat random search clearly, in the median over seeds."""

import numpy as np
import pytest

from railsearch.space import Space, Variable
from railsearch.testing import Trial, run_trial
from railsearch_plugins.strategies.dycors import DynamicCoordinateSearch
from railsearch_plugins.strategies.lmsrs import LocalMetricSearch
from railsearch_plugins.strategies.pymoo_algorithms import GeneticAlgorithm
from railsearch_plugins.strategies.random import RandomSearch

HALF_INTEGER = Space(tuple(Variable(f"x{k}", -15.0, 20.0, integer=k % 2 == 1) for k in range(8)))


def ackley(design):
    spread = np.exp(-0.2 * np.sqrt(np.mean(design**2)))
    waves = np.exp(np.mean(np.cos(2.0 * np.pi * design)))
    return np.array([-20.0 * spread - waves + 20.0 + np.e])


def sphere(design):
    return np.array([np.sum((design - 1.3) ** 2)])


def median_best(plugin, objective, budget, settings=None, seeds=5):
    trials = [Trial(HALF_INTEGER, budget=budget, seed=seed) for seed in range(seeds)]
    runs = [run_trial(plugin, trial, settings, objective=objective) for trial in trials]
    return np.median([min(e.objectives[0] for e in run) for run in runs])


@pytest.mark.parametrize("plugin", [DynamicCoordinateSearch, LocalMetricSearch])
@pytest.mark.parametrize("objective", [ackley, sphere])
def test_surrogate_search_leaves_a_fifth_of_what_random_search_leaves(plugin, objective):
    settings = {"tree_search": objective is sphere}
    assert median_best(plugin, objective, 150, settings, 3) < 0.2 * median_best(RandomSearch, objective, 150)


def test_sphere_is_solved_but_for_the_integers_that_cannot_be():
    attainable = 4 * 0.3**2
    assert median_best(DynamicCoordinateSearch, sphere, 100, seeds=3) < attainable + 0.01


def test_tree_search_helps_early_where_the_surrogate_can_be_trusted():
    with_tree, without = (
        median_best(DynamicCoordinateSearch, sphere, 40, {"tree_search": switch}) for switch in (True, False)
    )
    assert with_tree < 0.5 * without


def test_a_genetic_algorithm_beats_random_search_and_loses_to_surrogate_search():
    genetic = median_best(GeneticAlgorithm, ackley, 200)
    assert genetic < 0.8 * median_best(RandomSearch, ackley, 200)
    assert median_best(DynamicCoordinateSearch, ackley, 120, {"tree_search": False}, 3) < genetic
