"""The pieces of the metric search: probability, candidates, merit and step size."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from railsearch.space import Space, Variable
from railsearch_plugins.metric_search.candidates import perturbation_probability, perturbed, reflected
from railsearch_plugins.metric_search.merit import merit, select
from railsearch_plugins.metric_search.step_size import StepSize

MIXED = Space(
    (
        Variable("real", -2.0, 6.0),
        Variable("flag", 0, 1, integer=True),
        Variable("rows", 3, 9, integer=True),
        Variable("length", 100.0, 101.0),
    )
)


def candidates(incumbent, sigma=0.2, probability=0.5, count=4000, seed=0):
    return perturbed(MIXED, np.array(incumbent), sigma, probability, count, np.random.default_rng(seed))


def test_probability_falls_from_p0_to_zero_by_the_logarithm():
    assert perturbation_probability(20, 20, 200, 0.8) == 0.8
    assert perturbation_probability(199, 20, 200, 0.8) == pytest.approx(0.0, abs=1e-15)
    # n − n₀ + 1 = √(N − n₀) is half way down
    assert perturbation_probability(20 + 11, 20, 20 + 144, 1.0) == pytest.approx(0.5)
    assert perturbation_probability(65, 20, 200, 1.0) == pytest.approx(1.0 - math.log(46) / math.log(180))


def test_probability_stays_p0_where_one_evaluation_or_none_is_left_after_the_initial_design():
    for budget in (20, 21):
        assert perturbation_probability(20, 20, budget, 0.7) == 0.7


@given(st.integers(1, 50), st.integers(0, 500), st.integers(0, 300), st.floats(0.01, 1.0))
def test_probability_is_one_and_does_not_grow(n_initial, budget, n, p_initial):
    first, second = (perturbation_probability(n_initial + k, n_initial, budget, p_initial) for k in (n, n + 1))
    assert 0.0 <= second <= first <= p_initial


def test_every_candidate_differs_from_the_incumbent_and_is_allowed():
    incumbent = np.array([6.0, 1.0, 3.0, 100.5])
    for probability in (0.0, 0.3, 1.0):
        for sigma in (0.2 / 64, 0.2, 1.0):
            designs = candidates(incumbent, sigma, probability)
            assert np.all((designs != incumbent).any(axis=1))
            for design in designs:
                MIXED.checked(design)


def test_coordinates_that_are_not_chosen_keep_the_incumbents_value_to_the_last_bit():
    incumbent = np.array([0.1 + 0.2, 1.0, 5.0, 100.0 + 1.0 / 3.0])
    changed = candidates(incumbent, probability=0.0) != incumbent
    assert np.all(changed.sum(axis=1) == 1)
    counts = changed.sum(axis=0)
    assert np.sum((counts - 1000) ** 2 / 1000) < 16.3  # chi-squared with 3 degrees of freedom at 0.1 %


def test_chosen_coordinates_change_and_are_as_many_as_the_probability_says():
    changed = candidates([1.0, 0.0, 3.0, 100.5], probability=0.4) != [1.0, 0.0, 3.0, 100.5]
    idle = 0.6**4  # in that share of the candidates one coordinate is chosen in place of none
    expected = 4000 * (0.4 + idle / 4.0)
    assert np.all(np.abs(changed.sum(axis=0) - expected) < 4.0 * math.sqrt(expected))


def test_integers_move_by_one_step_or_more_however_small_sigma_is():
    designs = candidates([1.0, 0.0, 6.0, 100.5], sigma=1e-6, probability=1.0)
    assert np.all(designs[:, 1] == 1.0)
    assert set(designs[:, 2]) == {5.0, 7.0}
    assert abs(np.mean(designs[:, 2] == 5.0) - 0.5) < 0.04


def test_reals_have_the_standard_deviation_sigma_of_their_range():
    designs = candidates([2.0, 0.0, 6.0, 100.5], sigma=0.05, probability=1.0)
    np.testing.assert_allclose(designs[:, [0, 3]].std(axis=0), [0.05 * 8.0, 0.05], rtol=0.05)


@given(st.floats(-5.0, 5.0))
def test_reflection_mirrors_at_both_faces(x):
    inside = float(reflected(np.array([x]))[0])
    assert 0.0 <= inside <= 1.0
    np.testing.assert_allclose(reflected(np.array([-x, 2.0 - x, x + 2.0])), inside, atol=1e-12)


def test_points_inside_are_not_reflected():
    np.testing.assert_array_equal(reflected(np.array([0.0, 0.3, 1.0])), [0.0, 0.3, 1.0])


def test_merit_by_hand():
    scores = merit(np.array([1.0, 3.0, 2.0]), np.array([0.1, 0.5, 0.2]), 0.8)
    np.testing.assert_allclose(scores, [0.8 * 0.0 + 0.2 * 1.0, 0.8 * 1.0 + 0.2 * 0.0, 0.8 * 0.5 + 0.2 * 0.75])


def test_a_term_without_range_leaves_the_choice_to_the_other():
    same = np.full(3, 2.0)
    assert np.argmin(merit(same, np.array([0.1, 0.3, 0.2]), 0.95)) == 1
    assert np.argmin(merit(np.array([5.0, 4.0, 3.0]), same, 0.3)) == 2
    assert np.ptp(merit(same, same, 0.5)) == 0.0


def test_a_batch_keeps_away_from_its_own_members():
    points = np.array([[0.5], [0.51], [0.9]])
    chosen = select(points, np.array([0.0, 0.0, 0.0]), np.array([[0.0]]), itertools.repeat(0.5), 3, 1e-3)
    assert chosen == [2, 0, 1]


def test_a_batch_goes_on_with_the_weights():
    points, values = np.array([[0.1], [0.9], [0.5]]), np.array([0.0, 2.0, 1.0])
    weights = iter([1.0, 0.0, 1.0])
    assert select(points, values, np.array([[0.0]]), weights, 2, 1e-3) == [0, 1]
    assert next(weights) == 1.0


def test_candidates_too_near_to_evaluated_points_are_left_out():
    points = np.array([[0.5], [0.7004], [0.2]])
    evaluated = np.array([[0.5], [0.7], [0.9]])
    assert select(points, np.array([0.0, 1.0, 9.0]), evaluated, itertools.repeat(1.0), 2, 1e-3) == [2]
    assert select(points[:2], np.array([0.0, 1.0]), evaluated, itertools.repeat(1.0), 2, 1e-3) == []


def recorded(step, outcomes):
    for outcome in outcomes:
        step.record(outcome)
    return step.sigma


def test_sigma_is_halved_after_failures_in_a_row():
    assert recorded(StepSize(0.2, 6, 5, 3), [False] * 4) == 0.2
    assert recorded(StepSize(0.2, 6, 5, 3), [False] * 5) == 0.1
    assert recorded(StepSize(0.2, 6, 5, 3), [False] * 4 + [True] + [False] * 4) == 0.2
    assert recorded(StepSize(0.2, 6, 5, 3), [False] * 10) == 0.05


def test_sigma_is_doubled_after_successes_in_a_row_but_not_above_its_start():
    assert recorded(StepSize(0.2, 6, 5, 3), [False] * 10 + [True] * 3) == 0.1
    assert recorded(StepSize(0.2, 6, 5, 3), [False] * 10 + [True, True, False, True]) == 0.05
    assert recorded(StepSize(0.2, 6, 5, 3), [False] * 5 + [True] * 9) == 0.2


def test_sigma_is_exhausted_below_its_start_over_two_to_the_sixth():
    step = StepSize(0.2, 6, 5, 3)
    recorded(step, [False] * 30)
    assert step.sigma == 0.2 / 64
    assert not step.exhausted
    recorded(step, [False] * 5)
    assert step.exhausted
