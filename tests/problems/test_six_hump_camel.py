"""The six-hump camel: what it states of its optimum, its symmetry, its six local minima."""

import itertools

import numpy as np
import pytest
from scipy.optimize import minimize

import railsearch
from railsearch.errors import InputError
from railsearch_problems.six_hump_camel import LOWEST, SixHumpCamel, camel_values


def test_the_stated_optimum_is_attained_and_nothing_is_lower():
    problem = railsearch.problem("six-hump-camel")
    front, designs = problem.pareto_front(), problem.pareto_set()
    assert front == pytest.approx(np.array([[-1.031628453489877]]), abs=1e-14)
    np.testing.assert_allclose(camel_values(designs), front[0, 0], rtol=1e-14)
    assert problem.simulate(problem.optimum).objectives == front[0]
    step = 1e-5 * np.eye(2)
    assert np.abs(camel_values(LOWEST + step) - camel_values(LOWEST - step)).max() < 1e-12
    points = problem.space.from_unit(np.random.default_rng(0).random((20_000, 2)))
    assert camel_values(points).min() > front[0, 0]
    np.testing.assert_allclose(camel_values(points), camel_values(-points), atol=1e-12)


def test_it_has_six_local_minima():
    problem, found = SixHumpCamel(), []
    for start in itertools.product(np.linspace(-1.9, 1.9, 8), np.linspace(-0.9, 0.9, 6)):
        ended = minimize(lambda x: camel_values([x])[0], start, method="BFGS", tol=1e-10).x
        if np.all(np.abs(ended) <= problem.space.upper) and all(np.linalg.norm(ended - other) > 1e-3 for other in found):
            found.append(ended)
    assert len(found) == 6


def test_its_inputs_are_uniform_over_the_bounds():
    problem = SixHumpCamel()
    np.testing.assert_allclose(problem.distributions.ranges().T, [problem.space.lower, problem.space.upper])


def test_another_shape_is_refused():
    with pytest.raises(InputError, match=r"designs \(n, 2\)"):
        camel_values(np.ones((2, 3)))
