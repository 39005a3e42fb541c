"""Values, gradients, moments and Sobol' indices of expansions, and what is recovered exactly."""

import itertools
import math

import numpy as np
import pytest

from railsearch.distributions import random_vector
from railsearch.errors import SurrogateError
from railsearch.sampling import latin_hypercube
from railsearch_plugins.polynomial_chaos.expansion import Expansion, design_matrix
from railsearch_plugins.polynomial_chaos.families import families
from railsearch_plugins.polynomial_chaos.multi_indices import hyperbolic_set
from railsearch_plugins.polynomial_chaos.parameters import PolynomialChaosParameters
from railsearch_plugins.polynomial_chaos.search import fit_expansion

MIXED = random_vector(
    {
        "u": {"distribution": "uniform", "lower": -1.0, "upper": 3.0},
        "n": {"distribution": "normal", "mean": 10.0, "std": 2.0},
        "l": {"distribution": "lognormal", "mean": 2.0, "std": 0.4},
        "g": {"distribution": "gumbel-max", "mean": 5.0e4, "std": 7.5e3},
        "b": {"distribution": "beta", "alpha": 2.0, "beta": 3.0},
    }
)


def uniform(dimension, lower=0.0, upper=1.0):
    table = {"distribution": "uniform", "lower": lower, "upper": upper}
    return random_vector({f"x{k + 1}": table for k in range(dimension)})


def fitted(inputs, points, values, **settings):
    chosen = PolynomialChaosParameters(**settings)
    made = families(inputs.marginals.values(), chosen.degree, ["own"] * inputs.dimension)
    return fit_expansion(made, points, values, chosen)


def random_expansion(inputs, degree=5, q=1.0, seed=0):
    indices = hyperbolic_set(inputs.dimension, degree, q, 10_000)
    made = families(inputs.marginals.values(), degree, ["own"] * inputs.dimension)
    return Expansion(made, indices, np.random.default_rng(seed).normal(size=len(indices)))


def test_values_are_those_of_the_design_matrix():
    """The products by order against the plain product over all inputs, more points than a block."""
    expansion, generator = random_expansion(MIXED), np.random.default_rng(1)
    points = MIXED.from_uniform(generator.random((1200, 5)))
    plain = design_matrix(expansion.families, expansion.indices, points) @ expansion.coefficients
    np.testing.assert_allclose(expansion.predict(points), plain, rtol=1e-10, atol=1e-10)
    np.testing.assert_allclose(expansion.predict_with_gradient(points)[0], plain, rtol=1e-10, atol=1e-10)
    assert expansion.predict(points[:0]).shape == (0,)


def test_gradients_are_differences():
    expansion, generator = random_expansion(MIXED), np.random.default_rng(2)
    points = MIXED.from_uniform(generator.uniform(0.1, 0.9, (1100, 5)))
    gradient = expansion.gradient(points) * MIXED.std
    for i, step in enumerate(1e-5 * np.diag(MIXED.std)):
        slope = (expansion.predict(points + step) - expansion.predict(points - step)) * 0.5e5
        np.testing.assert_allclose(gradient[:, i], slope, rtol=1e-6, atol=1e-5)


def test_mean_and_variance_are_those_of_a_large_sample():
    expansion = random_expansion(MIXED, degree=2)
    sample = expansion.predict(latin_hypercube(MIXED, 100_000, np.random.default_rng(3)))
    assert sample.mean() == pytest.approx(expansion.mean, abs=5.0 * math.sqrt(expansion.variance / 1e5))
    assert sample.var() == pytest.approx(expansion.variance, rel=0.05)


def test_a_polynomial_in_the_span_is_recovered_exactly():
    """Of degree 3, in inputs of five kinds, a logarithm for the lognormal one: values, mean and where there is no data."""
    generator = np.random.default_rng(4)
    points, fresh = (MIXED.from_uniform(generator.random((n, 5))) for n in (120, 500))

    def truth(x):
        loads = (x[:, 3] - 5.0e4) / 7.5e3
        return 2.0 + x[:, 0] ** 3 - x[:, 1] * np.log(x[:, 2]) + loads * x[:, 4] ** 2 + loads**2

    result = fitted(MIXED, points, truth(points), degree=6)
    np.testing.assert_allclose(result.expansion.predict(fresh), truth(fresh), rtol=1e-9, atol=1e-9)
    assert result.corrected_error < 1e-20
    lognormal_mean = math.log(2.0) - 0.5 * math.log1p(0.04)
    beta_square = 2.0 * 3.0 / (5.0 * 6.0)
    exact = 2.0 + 5.0 - 10.0 * lognormal_mean + 0.0 * beta_square + 1.0
    assert result.expansion.mean == pytest.approx(exact, rel=1e-9)


def test_the_six_hump_camel_is_exact_from_degree_six():
    inputs = random_vector(
        {
            "x1": {"distribution": "uniform", "lower": -2.0, "upper": 2.0},
            "x2": {"distribution": "uniform", "lower": -1.0, "upper": 1.0},
        }
    )
    points = latin_hypercube(inputs, 100, np.random.default_rng(5))

    def camel(x):
        a, b = x.T
        return (4.0 - 2.1 * a**2 + a**4 / 3.0) * a**2 + a * b + (-4.0 + 4.0 * b**2) * b**2

    expansion = fitted(inputs, points, camel(points)).expansion
    fresh = inputs.from_uniform(np.random.default_rng(6).random((1000, 2)))
    np.testing.assert_allclose(expansion.predict(fresh), camel(fresh), atol=1e-11)


def test_leave_one_out_residuals_are_those_of_refits():
    points = np.random.default_rng(7).random((40, 3))
    values = np.exp(points.sum(axis=1)) + 0.1 * np.sin(20.0 * points[:, 0])
    result = fitted(uniform(3), points, values)
    matrix = design_matrix(result.expansion.families, result.expansion.indices, points)
    for i in range(40):
        coefficients = np.linalg.lstsq(np.delete(matrix, i, 0), np.delete(values, i))[0]
        assert result.leave_one_out[i] == pytest.approx(values[i] - matrix[i] @ coefficients, rel=1e-6, abs=1e-12)
    np.testing.assert_allclose(result.residuals, values - result.expansion.predict(points), atol=1e-10)


def test_sobol_indices_of_the_ishigami_function():
    """sin x₁ + 7 sin² x₂ + 0.1 x₃⁴ sin x₁ on [−π, π]³; Ishigami & Homma 1990, closed form in Sudret 2008, section 5.2."""
    a, b = 7.0, 0.1
    inputs = uniform(3, -math.pi, math.pi)
    points = latin_hypercube(inputs, 400, np.random.default_rng(8))
    x, y, z = points.T
    expansion = fitted(inputs, points, np.sin(x) + a * np.sin(y) ** 2 + b * z**4 * np.sin(x)).expansion
    first = 0.5 * (1.0 + b * math.pi**4 / 5.0) ** 2
    second, pair = a**2 / 8.0, b**2 * math.pi**8 * (1.0 / 18.0 - 1.0 / 50.0)
    variance = first + second + pair
    assert expansion.mean == pytest.approx(a / 2.0, rel=1e-5)
    assert expansion.variance == pytest.approx(variance, rel=1e-5)
    np.testing.assert_allclose(expansion.first_order_indices, np.array([first, second, 0.0]) / variance, atol=1e-5)
    np.testing.assert_allclose(expansion.total_indices, np.array([first + pair, second, pair]) / variance, atol=1e-5)
    assert expansion.sobol_index([0, 2]) == pytest.approx(pair / variance, abs=1e-5)
    assert expansion.closed_index([2, 0]) == pytest.approx((first + pair) / variance, abs=1e-5)
    assert expansion.sobol_index([0, 1, 2]) == pytest.approx(0.0, abs=1e-5)


def test_sobol_indices_of_the_g_function_of_sobol():
    """Π (|4x − 2| + a)/(1 + a): kinks keep an expansion from being exact; V_u = Π 1/(3 (1 + a)²). Saltelli & Sobol' 1995."""
    a = np.array([1.0, 2.0, 5.0])
    points = latin_hypercube(uniform(3), 500, np.random.default_rng(9))
    expansion = fitted(uniform(3), points, np.prod((np.abs(4.0 * points - 2.0) + a) / (1.0 + a), axis=1)).expansion
    parts = 1.0 / (3.0 * (1.0 + a) ** 2)
    variance = np.prod(1.0 + parts) - 1.0
    np.testing.assert_allclose(expansion.first_order_indices, parts / variance, atol=0.01)
    assert expansion.sobol_index([0, 1]) == pytest.approx(parts[0] * parts[1] / variance, abs=0.01)


def test_indices_of_all_sets_add_up_to_one():
    expansion = random_expansion(MIXED)
    sets = [u for size in range(1, 6) for u in itertools.combinations(range(5), size)]
    assert sum(expansion.sobol_index(u) for u in sets) == pytest.approx(1.0)
    within = [u for u in sets if set(u) <= {0, 3, 4}]
    assert expansion.closed_index([0, 3, 4]) == pytest.approx(sum(map(expansion.sobol_index, within)))
    assert expansion.sobol_index([]) == expansion.closed_index([]) == 0.0


def test_a_constant_is_an_expansion_of_one_term():
    points = np.random.default_rng(10).random((20, 3))
    result = fitted(uniform(3), points, np.full(20, 4.5))
    assert result.expansion.mean == pytest.approx(4.5)
    assert result.expansion.variance == 0.0
    assert not result.expansion.total_indices.any()
    np.testing.assert_allclose(result.expansion.predict(points), 4.5)
    np.testing.assert_array_equal(result.expansion.gradient(points), np.zeros((20, 3)))


def test_the_search_ends_at_the_target_and_leaves_out_degrees_only_if_asked():
    points = np.random.default_rng(11).random((60, 6))
    values = np.exp(points @ np.arange(1.0, 7.0) / 6.0)
    every = fitted(uniform(6), points, values, norms=(0.5,), growth=False)
    stopped = fitted(uniform(6), points, values, norms=(0.5,), growth=False, stop_early=True)
    reached = fitted(uniform(6), points, values, growth=True, target_error=0.02)
    assert every.trials[-1].origin.startswith("q = 0.5")
    assert len(stopped.trials) < len(every.trials)
    assert every.corrected_error <= stopped.corrected_error == min(trial.error for trial in stopped.trials)
    assert reached.trials[-1].error <= 0.02 < min(trial.error for trial in reached.trials[:-1])


def test_two_points_are_refused_with_the_number_needed():
    with pytest.raises(SurrogateError, match=r"3 or more points are needed .* received 2"):
        fitted(uniform(2), np.zeros((2, 2)), np.arange(2.0))
