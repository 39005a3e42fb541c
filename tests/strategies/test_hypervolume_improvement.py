"""Surrogate search for a front: far beyond NSGA-II on few evaluations, with integers, batches and either gain."""

import itertools

import numpy as np
import pytest

from railsearch.errors import CapabilityError
from railsearch.indicators import hypervolume
from railsearch.interfaces import Evaluation
from railsearch.plugin_manager import load_plugins
from railsearch.space import Space, Variable
from railsearch.testing import Trial, run_trial
from railsearch_plugins.strategies.hypervolume_improvement import HypervolumeImprovementSearch
from railsearch_plugins.surrogate_search.front import Front, recent_gain

SPACE = Space(tuple(Variable(f"x{k}", -2.0, 2.0) for k in range(5)))
HALF = Space((*SPACE.variables[:3], Variable("k", -4.0, 4.0, integer=True), Variable("l", -4.0, 4.0, integer=True)))
QUICK = {"evolution_generations": 8, "evolution_size": 20, "candidates_per_dimension": 40}


def two_bowls(design):
    """Distances from (1, …, 1) and (−1, …, −1): the front is √f₁ + √f₂ = 1."""
    dimension = len(design)
    return np.array([np.sum((design - 1.0) ** 2), np.sum((design + 1.0) ** 2)]) / (4.0 * dimension)


def attainable(space):
    """The hypervolume of the whole front: real variables all on one place between the centres, integers −1, 0 or 1."""
    places = [[-1.0, 0.0, 1.0] if variable.integer else [np.nan] for variable in space.variables]
    lines = np.linspace(-1.0, 1.0, 101)[:, None] * np.ones(space.dimension)
    designs = [np.where(np.isnan(integers), line, integers) for integers in itertools.product(*places) for line in lines]
    return hypervolume(np.array([two_bowls(design) for design in designs]), np.ones(2))


def volume(plugin, space, budget, settings=None, batch=1):
    """The part of the attainable hypervolume that a run fills."""
    run = run_trial(plugin, Trial(space, 2, budget=budget, batch_size=batch, seed=3), settings, objective=two_bowls)
    return hypervolume(np.array([e.objectives for e in run]), np.ones(2)) / attainable(space)


def test_the_front_of_two_bowls_is_nine_tenths_filled_after_60_evaluations_and_nsga2_is_far_from_it():
    assert volume(HypervolumeImprovementSearch, SPACE, 60, QUICK) > 0.9
    assert volume(load_plugins().get("strategy", "nsga2"), SPACE, 60) < 0.8


def test_integers_and_batches():
    assert volume(HypervolumeImprovementSearch, HALF, 60, QUICK, batch=5) > 0.9


def test_a_surrogate_without_deviation_is_refused_for_the_expected_gain():
    class Certain:
        """Says nothing about its deviation."""

    with pytest.raises(CapabilityError, match=r"surrogate rbf has no deviation, which .*: choose one"):
        run_trial(
            HypervolumeImprovementSearch,
            Trial(SPACE, 2),
            {"gain": "expected"},
            surrogate=lambda name, dimension, settings: Certain(),
        )


def test_a_front_that_hardly_grows_is_left_for_a_new_start():
    settings = {**QUICK, "restart_after": 10, "restart_gain": 0.9}
    run = run_trial(HypervolumeImprovementSearch, Trial(HALF, 2, budget=120, seed=5), settings, objective=two_bowls)
    origins = {number: [e.origin for e in run if e.trajectory == number] for number in range(3)}
    # With 30 evaluations left there is no room for another start of 20 and a search.
    assert [len(names) for names in origins.values()] == [30, 30, 60]
    for names in origins.values():
        assert names[:20] == ["initial"] * 20
        assert set(names[20:]) <= {"perturbation", "evolution"}
    assert len({HALF.key(e.design) for e in run}) == 120


def test_the_gain_of_the_last_evaluations_is_their_part_of_the_volume():
    objectives = np.array([[1.0, 3.0], [3.0, 1.0], [1.0, 1.0]])
    told = [Evaluation(k, np.zeros(1), f, np.empty(0), {}, "given") for k, f in enumerate(objectives)]
    front = Front(np.zeros((2, 1)), objectives[:2], np.array([1.0, 1.0]), np.array([2.0, 2.0]))
    # Below (2, 2): 1 × 2 + 1 × 1 without the last one, 2 × 2 with it.
    assert recent_gain(told, front, 1, margin=1.0) == pytest.approx(0.25)
    assert recent_gain(told, front, 3, margin=1.0) == 1.0
