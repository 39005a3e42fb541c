"""Branch and bound: the minimiser found by trying every design, and no loss by pruning where relaxations are exact.

The slow twin of the vectorised relaxations minimises one box after the other, by scipy's L-BFGS-B.
"""

import itertools

import numpy as np
import pytest
from scipy.optimize import minimize
from threadpoolctl import threadpool_limits

from railsearch.projected_gradient import minimised
from railsearch.space import Space, Variable
from railsearch_plugins.metric_search.tree_search import Boxes, branch_and_bound, tree_search
from railsearch_plugins.surrogates.rbf import RadialBasisFunctionInterpolant, RadialBasisFunctionParameters

INTEGERS = Space(tuple(Variable(f"k{k}", -2.0, upper, integer=True) for k, upper in enumerate((3.0, 4.0, -1.0, 5.0))))
HALF = Space((*INTEGERS.variables[:2], Variable("x", 0.0, 10.0), Variable("y", -1.0, 1.0)))


@pytest.fixture(autouse=True, scope="module")
def one_core():
    """As in a run: threads cost small matrices more than they save."""
    with threadpool_limits(1):
        yield


def every_design(space):
    ranges = [np.arange(v.lower, v.upper + 1.0) for v in space.variables]
    return np.array(list(itertools.product(*ranges)))


def wavy_surrogate(space, seed, n=45):
    generator = np.random.default_rng(seed)
    points = space.to_unit(space.from_unit(generator.random((200, space.dimension))))
    points = np.unique(points, axis=0)[generator.permutation(len(np.unique(points, axis=0)))[:n]]
    centre = generator.random(space.dimension)
    values = np.sum((points - centre) ** 2, axis=1) + 0.3 * np.cos(7.0 * points).sum(axis=1)
    surrogate = RadialBasisFunctionInterpolant(space.dimension, RadialBasisFunctionParameters())
    surrogate.fit(points, values)
    return surrogate


@pytest.mark.parametrize("seed", range(20))
def test_finds_the_surrogates_true_minimiser_on_a_space_of_integers(seed):
    surrogate, designs = wavy_surrogate(INTEGERS, seed), every_design(INTEGERS)
    values = surrogate.predict(INTEGERS.to_unit(designs))
    pool = np.random.default_rng(seed).random((400, 4))
    found = tree_search(surrogate, INTEGERS, pool, n_starts=3, max_nodes=200)
    np.testing.assert_array_equal(INTEGERS.from_unit(found[-1]), designs[np.argmin(values)])


@pytest.mark.parametrize("seed", range(5))
def test_with_reals_it_is_as_low_as_minimising_over_them_for_every_setting_of_the_integers(seed):
    surrogate = wavy_surrogate(HALF, seed, n=60)
    pool = np.random.default_rng(seed).random((400, 4))
    found = tree_search(surrogate, HALF, pool, n_starts=3, max_nodes=200)
    lowest = np.inf
    for first, second in every_design(Space(HALF.variables[:2])):
        whole = HALF.to_unit([first, second, 0.0, 0.0])[:2]
        for start in pool[:6, 2:]:
            result = minimize(
                lambda x, whole=whole: surrogate.predict(np.concatenate([whole, x])[None, :])[0],
                start,
                bounds=[(0.0, 1.0)] * 2,
                method="L-BFGS-B",
            )
            lowest = min(lowest, result.fun)
    assert surrogate.predict(found[-1:])[0] <= lowest + 1e-6


def slow_relaxations(value, gradient, starts_of):
    """The twin: scipy's L-BFGS-B from each start in each box, one after the other, to the last digits."""

    def relaxations(boxes):
        found = [lowest(*box) for box in zip(boxes.lower, boxes.upper, boxes.starts, strict=True)]
        return np.array([result.x for result in found]), np.array([result.fun for result in found])

    def lowest(lower, upper, start):
        bounds, exact = np.column_stack([lower, upper]), {"ftol": 1e-15, "gtol": 1e-10, "maxiter": 1000}
        results = [
            minimize(value, x, jac=gradient, bounds=bounds, method="L-BFGS-B", options=exact)
            for x in starts_of(lower, upper, np.clip(start, lower, upper))
        ]
        return min(results, key=lambda result: result.fun)

    return relaxations


class Convex:
    """A convex quadratic on the unit cube; its exact minimisers in boxes."""

    def __init__(self, seed, dimension=4, floor=0.1):
        generator = np.random.default_rng(seed)
        root = generator.standard_normal((dimension, dimension))
        self.matrix = root @ root.T + floor * np.eye(dimension)
        self.centre = generator.uniform(-0.2, 1.2, dimension)
        self.relaxations = slow_relaxations(
            lambda x: float(self.predict(x[None, :])[0]),
            lambda x: self.gradient(x[None, :])[0],
            lambda lower, upper, start: [0.5 * (lower + upper)],
        )

    def predict(self, points):
        return np.einsum("ki,ij,kj->k", points - self.centre, self.matrix, points - self.centre)

    def gradient(self, points):
        return 2.0 * (points - self.centre) @ self.matrix


def counted(relaxations):
    """The relaxations, and a list that gets the number of boxes of every call."""
    numbers = []

    def counting(boxes):
        numbers.append(len(boxes))
        return relaxations(boxes)

    return counting, numbers


@pytest.mark.parametrize("seed", range(10))
def test_rows_reach_the_minimisers_of_a_convex_function_in_their_boxes_as_the_slow_twin_does(seed):
    function, generator = Convex(seed), np.random.default_rng(seed + 100)
    lower, upper = np.sort(generator.random((2, 25, 4)), axis=0)
    starts = generator.random((25, 4))
    points, values = minimised(function, starts, lower, upper, 1e-14, 2000)
    expected, lowest = function.relaxations(Boxes(lower, upper, starts, np.full(25, -np.inf)))
    np.testing.assert_allclose(points, expected, atol=1e-5)
    np.testing.assert_allclose(values, lowest, rtol=1e-9, atol=1e-9)
    np.testing.assert_array_equal(values, function.predict(points))


@pytest.mark.parametrize("seed", range(5))
def test_rows_end_where_the_gradient_leaves_the_box_and_never_above_their_start(seed):
    surrogate, generator = wavy_surrogate(HALF, seed, n=60), np.random.default_rng(seed)
    lower, upper = np.sort(generator.random((2, 20, 4)), axis=0)
    starts = lower + generator.random((20, 4)) * (upper - lower)
    points, values = minimised(surrogate, starts, lower, upper, 1e-15, 2000)
    left = np.clip(points - surrogate.gradient(points), lower, upper) - points
    assert np.abs(left).max() < 1e-5
    assert np.all(values <= surrogate.predict(starts))
    assert np.all((points >= lower) & (points <= upper))


@pytest.mark.parametrize("kernel", ["cubic", "thin-plate", "linear"])
def test_values_and_gradients_at_once_are_those_of_the_single_calls(kernel):
    generator = np.random.default_rng(5)
    parameters = RadialBasisFunctionParameters(kernel=kernel, length_scales=(0.5, 1.0, 2.0))
    surrogate = RadialBasisFunctionInterpolant(3, parameters)
    surrogate.fit(generator.random((30, 3)), generator.standard_normal(30))
    points = generator.random((7, 3))
    values, gradients = surrogate.predict_with_gradient(points)
    assert values.tobytes() == surrogate.predict(points).tobytes()
    assert gradients.tobytes() == surrogate.gradient(points).tobytes()


def test_a_row_does_not_depend_on_what_is_minimised_beside_it():
    function, starts = Convex(1), np.random.default_rng(1).random((9, 4))
    zeros, ones = np.zeros((9, 4)), np.ones((9, 4))
    together, _ = minimised(function, starts, zeros, ones, 1e-12, 200)
    alone = [minimised(function, starts[k : k + 1], zeros[:1], ones[:1], 1e-12, 200)[0][0] for k in range(9)]
    np.testing.assert_allclose(together, alone, atol=1e-6)


def test_a_box_without_extent_and_a_flat_function_stay_where_they_are():
    point = np.full((1, 4), 0.3)
    assert np.array_equal(minimised(Convex(0), point + 0.5, point, point, 1e-9, 50)[0], point)
    flat = Convex(0)
    flat.matrix = np.zeros((4, 4))
    assert np.array_equal(minimised(flat, point, 0.0 * point, 0.0 * point + 1.0, 1e-9, 50)[0], point)


@pytest.mark.parametrize("space", [INTEGERS, HALF], ids=["integers", "half reals"])
@pytest.mark.parametrize("seed", range(5))
def test_it_comes_as_low_as_a_search_whose_relaxations_the_slow_twin_minimises(space, seed):
    surrogate, pool = wavy_surrogate(space, seed, n=45), np.random.default_rng(seed).random((400, 4))
    ranked = pool[np.argsort(surrogate.predict(pool), kind="stable")]

    def starts_of(lower, upper, start):
        inside = ranked[((ranked >= lower) & (ranked <= upper)).all(axis=1)]
        return [start, *inside[:2]]

    slow = slow_relaxations(
        lambda x: float(surrogate.predict(x[None, :])[0]), lambda x: surrogate.gradient(x[None, :])[0], starts_of
    )
    expected = branch_and_bound(slow, surrogate.predict, space, max_nodes=200)[-1]
    found = tree_search(surrogate, space, pool, n_starts=3, max_nodes=200)[-1]
    assert surrogate.predict(found[None, :])[0] <= surrogate.predict(expected[None, :])[0] + 1e-6


def test_the_same_arguments_give_the_same_points_to_the_last_bit():
    surrogate, pool = wavy_surrogate(HALF, 4, n=60), np.random.default_rng(4).random((400, 4))
    first, second = (tree_search(surrogate, HALF, pool, n_starts=2, max_nodes=200) for _ in range(2))
    assert first.tobytes() == second.tobytes()


@pytest.mark.parametrize("seed", range(20))
def test_pruning_never_loses_the_minimiser_where_relaxations_are_exact(seed):
    function, designs = Convex(seed), every_design(INTEGERS)
    best = designs[np.argmin(function.predict(INTEGERS.to_unit(designs)))]
    found = branch_and_bound(function.relaxations, function.predict, INTEGERS, max_nodes=10_000)
    np.testing.assert_array_equal(INTEGERS.from_unit(found[-1]), best)


@pytest.mark.parametrize("seed", range(5))
def test_pruning_spares_nodes(seed):
    function = Convex(seed)
    relaxations, numbers = counted(function.relaxations)
    branch_and_bound(relaxations, function.predict, INTEGERS, max_nodes=10_000)
    assert sum(numbers) < INTEGERS.size / 4


@pytest.mark.parametrize("seed", range(5))
def test_the_lowest_met_cannot_be_improved_by_a_single_step_of_an_integer(seed):
    surrogate = wavy_surrogate(INTEGERS, seed)
    found = tree_search(surrogate, INTEGERS, np.random.default_rng(seed).random((400, 4)), n_starts=1, max_nodes=1)
    steps = np.vstack([np.eye(4), -np.eye(4)])
    near = INTEGERS.from_unit(found[-1]) + steps
    near = near[((near >= INTEGERS.lower) & (near <= INTEGERS.upper)).all(axis=1)]
    assert surrogate.predict(found[-1:])[0] <= surrogate.predict(INTEGERS.to_unit(near)).min()


def test_what_is_met_is_whole_inside_the_bounds_and_lower_and_lower():
    surrogate = wavy_surrogate(HALF, 3, n=60)
    found = tree_search(surrogate, HALF, np.random.default_rng(3).random((400, 4)), n_starts=3, max_nodes=200)
    for design in HALF.from_unit(found):
        HALF.checked(design)
    np.testing.assert_array_equal(HALF.to_unit(HALF.from_unit(found))[:, :2], found[:, :2])
    assert np.all(np.diff(surrogate.predict(found)) < 0.0)


def test_the_number_of_nodes_is_limited():
    function = Convex(0)
    for limit in (1, 3, 20):
        relaxations, numbers = counted(function.relaxations)
        branch_and_bound(relaxations, function.predict, INTEGERS, max_nodes=limit)
        assert sum(numbers) <= limit
