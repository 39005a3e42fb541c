from itertools import chain, combinations, product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from railsearch.errors import InputError
from railsearch.indicators import attainment_surface, hypervolume, hypervolume_curve, igd_plus, non_dominated

NAN = np.nan
GRID = st.integers(0, 6).map(float)
FRONTS = st.lists(hnp.arrays(float, st.tuples(st.integers(0, 4), st.just(2)), elements=GRID), min_size=1, max_size=5)


def dominates(a: np.ndarray, b: np.ndarray) -> bool:
    return bool(np.all(a <= b) and np.any(a < b))


@given(hnp.arrays(float, st.tuples(st.integers(1, 12), st.integers(1, 3)), elements=st.integers(0, 4).map(float)))
def test_the_front_is_what_its_definition_says(objectives: np.ndarray) -> None:
    rows = non_dominated(objectives)
    members = objectives[rows]
    assert len(np.unique(members, axis=0)) == len(members)
    for row, vector in enumerate(objectives):
        beaten = any(dominates(other, vector) for other in objectives)
        first = not any(np.array_equal(vector, earlier) for earlier in objectives[:row])
        assert (row in rows) == (first and not beaten)


def volume_by_inclusion_and_exclusion(objectives: np.ndarray, reference: np.ndarray) -> float:
    """λ(∪ boxes) = Σ over the sets of boxes of (−1)^(size + 1) λ(their intersection)."""
    rows = range(len(objectives))
    sets = chain.from_iterable(combinations(rows, size) for size in range(1, len(objectives) + 1))
    return sum((-1.0) ** (len(s) + 1) * np.prod(np.maximum(reference - objectives[list(s)].max(axis=0), 0.0)) for s in sets)


@given(hnp.arrays(float, st.tuples(st.integers(1, 6), st.integers(2, 4)), elements=st.integers(-4, 8).map(float)))
def test_hypervolume_is_that_of_the_union_of_boxes(objectives: np.ndarray) -> None:
    reference = np.array([5.0, 6.0, 4.0, 5.0])[: objectives.shape[1]]
    assert hypervolume(objectives, reference) == pytest.approx(volume_by_inclusion_and_exclusion(objectives, reference))


def test_hypervolume_is_that_of_random_points_below_the_reference() -> None:
    generator = np.random.default_rng(1)
    objectives, points = generator.random((20, 3)), generator.random((100_000, 3))
    inside = np.zeros(len(points), dtype=bool)
    for vector in objectives:
        inside |= np.all(points >= vector, axis=1)
    deviation = inside.std() / np.sqrt(len(points))
    assert abs(hypervolume(objectives, np.ones(3)) - inside.mean()) < 4.0 * deviation


def test_hypervolume_by_hand() -> None:
    objectives = np.array([[-1.0, 2.0], [0.0, 1.0], [2.0, -1.0], [3.0, -9.0]])
    assert hypervolume(objectives, np.array([3.0, 3.0])) == 4.0 + 3.0 + 2.0
    assert hypervolume(np.array([[3.0, 1.0]]), np.array([3.0, 3.0])) == 0.0
    assert hypervolume(np.empty((0, 2)), np.array([3.0, 3.0])) == 0.0


@given(hnp.arrays(float, st.tuples(st.integers(1, 12), st.integers(2, 3)), elements=st.one_of(GRID, st.just(NAN))))
def test_hypervolume_curve_is_the_hypervolume_of_every_beginning(objectives: np.ndarray) -> None:
    reference = np.full(objectives.shape[1], 5.0)
    curve = hypervolume_curve(objectives, reference)
    complete = ~np.isnan(objectives).any(axis=1)
    for number in range(len(objectives)):
        beginning = objectives[: number + 1][complete[: number + 1]]
        assert curve[number] == pytest.approx(hypervolume(beginning, reference))
    assert np.all(np.diff(curve) >= 0.0)


def test_igd_plus_counts_only_being_worse() -> None:
    """Ishibuchi et al. 2015, example 4: A = {(4, 2), (3, 3), (2, 4)} dominates B = {(8, 2), (4, 4), (2, 8)}."""
    reference = np.array([[10.0, 0.0], [6.0, 1.0], [2.0, 2.0], [1.0, 6.0], [0.0, 10.0]])
    better, worse = np.array([[4.0, 2.0], [3.0, 3.0], [2.0, 4.0]]), np.array([[8.0, 2.0], [4.0, 4.0], [2.0, 8.0]])
    assert igd_plus(better, reference) == pytest.approx((2.0 + 1.0 + np.sqrt(2.0) + 1.0 + 2.0) / 5.0)
    assert igd_plus(better, reference) < igd_plus(worse, reference)


@given(
    hnp.arrays(float, st.tuples(st.integers(1, 6), st.just(3)), elements=GRID),
    hnp.arrays(float, st.tuples(st.integers(1, 6), st.just(3)), elements=GRID),
)
def test_igd_plus_is_what_its_formula_says(objectives: np.ndarray, reference: np.ndarray) -> None:
    distances = np.linalg.norm(np.maximum(objectives[None, :, :] - reference[:, None, :], 0.0), axis=2)
    assert igd_plus(objectives, reference) == pytest.approx(distances.min(axis=1).mean())
    assert igd_plus(np.vstack([objectives, reference]), reference) == 0.0


def test_igd_plus_of_nothing_is_infinite() -> None:
    assert igd_plus(np.empty((0, 2)), np.zeros((1, 2))) == np.inf


def test_attainment_surfaces_by_hand() -> None:
    fronts = [np.array([[1.0, 3.0], [3.0, 1.0]]), np.array([[2.0, 2.0]]), np.array([[0.0, 4.0], [4.0, 0.0]])]
    best, median, worst = attainment_surface(fronts, (1.0 / 3.0, 0.5, 1.0))
    np.testing.assert_array_equal(best, [[0.0, 4.0], [1.0, 3.0], [2.0, 2.0], [3.0, 1.0], [4.0, 0.0]])
    np.testing.assert_array_equal(median, [[1.0, 4.0], [2.0, 3.0], [3.0, 2.0], [4.0, 1.0]])
    np.testing.assert_array_equal(worst, [[2.0, 4.0], [4.0, 2.0]])


def test_a_run_without_a_front_attains_nothing() -> None:
    fronts = [np.array([[1.0, 1.0]]), np.empty((0, 2)), np.empty((0, 2)), np.array([[2.0, 0.0]])]
    quarter, half, most = attainment_surface(fronts)
    np.testing.assert_array_equal(quarter, [[1.0, 1.0], [2.0, 0.0]])
    np.testing.assert_array_equal(half, [[2.0, 1.0]])
    assert most.shape == (0, 2)


@given(FRONTS, st.sampled_from([0.1, 0.25, 1.0 / 3.0, 0.5, 0.75, 1.0]))
def test_the_surface_bounds_what_so_many_runs_attain(fronts: list[np.ndarray], fraction: float) -> None:
    corners = attainment_surface(fronts, [fraction])[0]
    for point in product(range(7), range(7)):
        attained = np.mean([bool(np.any(np.all(front <= point, axis=1))) for front in fronts])
        above = bool(np.any(np.all(corners <= point, axis=1)))
        assert above == (attained >= fraction - 1e-12)
    assert len(non_dominated(corners)) == len(corners)
    assert np.all(np.diff(corners[:, 0]) > 0.0)


def test_measures_refuse_what_they_cannot_measure() -> None:
    good, short = np.zeros((2, 2)), np.zeros((2, 3))
    with pytest.raises(InputError, match="reference_point"):
        hypervolume(short, np.ones(2))
    with pytest.raises(InputError, match="reference_point"):
        hypervolume_curve(good, np.array([1.0, np.inf]))
    with pytest.raises(InputError, match="objectives"):
        hypervolume(np.array([[0.0, 0.0], [NAN, 0.0]]), np.ones(2))
    with pytest.raises(InputError, match="reference_front"):
        igd_plus(good, np.empty((0, 2)))
    with pytest.raises(InputError, match="objectives"):
        igd_plus(np.full((1, 2), NAN), good)
    with pytest.raises(InputError, match="fronts"):
        attainment_surface([])
    with pytest.raises(InputError, match="two objectives"):
        attainment_surface([short])
    with pytest.raises(InputError, match="fractions"):
        attainment_surface([good], [0.0])
