"""Hypervolume gains against moocore's volumes, against sampling, and in their limits."""

import itertools

import numpy as np
import pytest

from railsearch.indicators import hypervolume, non_dominated
from railsearch_plugins.metric_search.expected_improvement import expected_improvement
from railsearch_plugins.surrogate_search.front import Candidates, Front, select_by_gain
from railsearch_plugins.surrogate_search.hypervolume_gain import hypervolume_gain, non_dominated_boxes


def random_front(m, seed, size=12):
    """A front, some of it beyond the reference point (1, …, 1), and vectors on all sides of it."""
    generator = np.random.default_rng(seed)
    points = generator.random((size, m)) * 1.2
    front = points[non_dominated(points)]
    values = np.vstack([generator.uniform(-0.3, 1.3, (60, m)), front, front - 0.01])
    return front, values, np.ones(m)


def by_volumes(values, front, reference):
    before = hypervolume(front, reference)
    return np.array([hypervolume(np.vstack([front, value]), reference) - before for value in values])


@pytest.mark.parametrize(("m", "seed"), list(itertools.product((1, 2, 3, 4), range(3))))
def test_gain_is_the_difference_of_volumes(m, seed):
    front, values, reference = random_front(m, seed)
    np.testing.assert_allclose(hypervolume_gain(values, front, reference), by_volumes(values, front, reference), atol=1e-12)


@pytest.mark.parametrize(("m", "seed"), list(itertools.product((3, 4), range(3))))
def test_sum_over_boxes_gives_the_same_with_deviations_of_zero(m, seed):
    front, values, reference = random_front(m, seed)
    certain = np.zeros_like(values)
    np.testing.assert_allclose(
        hypervolume_gain(values, front, reference, certain), by_volumes(values, front, reference), atol=1e-12
    )


@pytest.mark.parametrize("m", [1, 2, 3])
def test_boxes_have_no_common_volume_and_fill_what_is_not_dominated(m):
    front, _, reference = random_front(m, 5)
    lower, upper = non_dominated_boxes(front, reference)
    points = np.random.default_rng(1).uniform(-0.5, 1.0, (2000, m))
    inside = ((points[:, None] > lower) & (points[:, None] <= upper)).all(axis=2).sum(axis=1)
    dominated = (front[None] <= points[:, None]).all(axis=2).any(axis=1)
    np.testing.assert_array_equal(inside, np.where(dominated, 0, 1))


def test_without_a_front_the_gain_is_the_box_to_the_reference_point():
    gain = hypervolume_gain(np.array([[0.25, 0.5], [1.5, 0.0]]), np.empty((0, 2)), np.ones(2))
    np.testing.assert_allclose(gain, [0.375, 0.0], rtol=1e-15)


@pytest.mark.parametrize("m", [1, 2, 3])
def test_expected_gain_is_the_mean_gain_of_samples(m):
    front, values, reference = random_front(m, 2)
    generator = np.random.default_rng(3)
    values, deviations = values[:6], generator.uniform(0.3, 0.6, (6, m))
    expected = hypervolume_gain(values, front, reference, deviations)
    for value, deviation, gain in zip(values, deviations, expected, strict=True):
        samples = hypervolume_gain(value + deviation * generator.standard_normal((4000, m)), front, reference)
        assert abs(gain - samples.mean()) < 5.0 * samples.std() / np.sqrt(len(samples))


def test_with_one_objective_it_is_the_expected_improvement():
    values, deviations = np.linspace(-1.0, 3.0, 9)[:, None], np.linspace(0.1, 1.0, 9)[:, None]
    gain = hypervolume_gain(values, np.array([[0.7]]), np.array([5.0]), deviations)
    np.testing.assert_allclose(gain, expected_improvement(values[:, 0], deviations[:, 0], 0.7), rtol=1e-12)


def test_many_candidates_are_worked_on_in_blocks(monkeypatch):
    front, values, reference = random_front(2, 4)
    whole = hypervolume_gain(values, front, reference)
    monkeypatch.setattr("railsearch_plugins.surrogate_search.hypervolume_gain.BLOCK", 30)
    np.testing.assert_array_equal(hypervolume_gain(values, front, reference), whole)


def choice(count, weights=(1.0,), minimum_distance=0.0):
    """Candidates of two objectives on the plane, and those chosen of them."""
    objectives = np.array([[0.0, 10.0], [0.5, 5.0], [1.0, 0.0]])
    front = Front(np.zeros((3, 2)), objectives, objectives.min(axis=0), np.ptp(objectives, axis=0))
    generator = np.random.default_rng(6)
    points = generator.random((200, 2))
    values = np.column_stack(
        [points[:, 0] ** 2 + 0.2 * points[:, 1], 10.0 * ((1.0 - points[:, 0]) ** 2 + 0.2 * points[:, 1])]
    )
    evaluated = generator.random((3, 2))
    chosen = select_by_gain(
        Candidates(points, values), front, evaluated, itertools.cycle(weights), count, minimum_distance, 0.1
    )
    return chosen, values, points, evaluated, front


def test_the_batch_is_the_greedy_one():
    chosen, values, _, _, front = choice(4)
    scale, known = np.array([1.0, 10.0]), front.objectives
    for k in chosen:
        gains = by_volumes(values / scale, known / scale, np.array([1.1, 1.1]))
        assert gains[k] == pytest.approx(gains.max(), rel=1e-12)
        known = np.vstack([known, values[k]])
    assert len(set(chosen)) == 4


def test_distance_counts_by_its_weight_among_those_that_gain():
    (chosen,), values, points, evaluated, front = choice(1, weights=(0.0,))
    scale = np.array([1.0, 10.0])
    gains = by_volumes(values / scale, front.objectives / scale, np.array([1.1, 1.1]))
    distances = np.linalg.norm(points[:, None] - evaluated, axis=2).min(axis=1)
    assert gains[chosen] > 0.0
    assert distances[chosen] == distances[gains > 0.0].max()


def test_nothing_is_chosen_nearer_than_the_minimum_distance():
    chosen, _, points, evaluated, _ = choice(200, minimum_distance=0.2)
    everything = np.vstack([evaluated, points[chosen]])
    apart = np.linalg.norm(everything[:, None] - everything, axis=2) + np.eye(len(everything))
    assert 0 < len(chosen) < 200
    assert apart.min() >= 0.2
