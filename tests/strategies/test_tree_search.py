"""Branch and bound: the minimiser found by trying every design, and no loss by pruning where relaxations are exact."""

import itertools

import numpy as np
import pytest
from scipy.optimize import minimize
from threadpoolctl import threadpool_limits

from railsearch.space import Space, Variable
from railsearch_plugins.metric_search.tree_search import branch_and_bound, tree_search
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


def convex(seed):
    """A convex quadratic on the unit cube and its exact minimiser in a box."""
    generator = np.random.default_rng(seed)
    root = generator.standard_normal((4, 4))
    matrix, centre = root @ root.T + 0.1 * np.eye(4), generator.uniform(-0.2, 1.2, 4)

    def value(x):
        return float((x - centre) @ matrix @ (x - centre))

    def relaxation(lower, upper, start):
        result = minimize(
            value,
            0.5 * (lower + upper),
            jac=lambda x: 2.0 * matrix @ (x - centre),
            bounds=np.column_stack([lower, upper]),
            method="L-BFGS-B",
            options={"ftol": 1e-15, "gtol": 1e-10, "maxiter": 1000},
        )
        return result.x, result.fun

    return value, relaxation


@pytest.mark.parametrize("seed", range(20))
def test_pruning_never_loses_the_minimiser_where_relaxations_are_exact(seed):
    value, relaxation = convex(seed)
    designs = every_design(INTEGERS)
    best = designs[np.argmin([value(point) for point in INTEGERS.to_unit(designs)])]
    found = branch_and_bound(relaxation, value, INTEGERS, max_nodes=10_000)
    np.testing.assert_array_equal(INTEGERS.from_unit(found[-1]), best)


@pytest.mark.parametrize("seed", range(5))
def test_pruning_spares_nodes(seed):
    value, relaxation = convex(seed)
    boxes = []

    def counted(lower, upper, start):
        boxes.append((lower, upper))
        return relaxation(lower, upper, start)

    branch_and_bound(counted, value, INTEGERS, max_nodes=10_000)
    assert len(boxes) < INTEGERS.size / 4


def test_what_is_met_is_whole_inside_the_bounds_and_lower_and_lower():
    surrogate = wavy_surrogate(HALF, 3, n=60)
    found = tree_search(surrogate, HALF, np.random.default_rng(3).random((400, 4)), n_starts=3, max_nodes=200)
    for design in HALF.from_unit(found):
        HALF.checked(design)
    np.testing.assert_array_equal(HALF.to_unit(HALF.from_unit(found))[:, :2], found[:, :2])
    assert np.all(np.diff(surrogate.predict(found)) < 0.0)


def test_the_number_of_nodes_is_limited():
    value, relaxation = convex(0)
    boxes = []

    def counted(lower, upper, start):
        boxes.append(lower)
        return relaxation(lower, upper, start)

    branch_and_bound(counted, value, INTEGERS, max_nodes=3)
    assert len(boxes) <= 3
