"""Polynomials orthonormal for an input: by quadrature, against scipy's families, against exact moments."""

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import eval_genlaguerre, eval_hermitenorm, eval_jacobi, eval_legendre, gammaln

from railsearch.distributions import random_vector
from railsearch.errors import InputError
from railsearch_plugins.polynomial_chaos.families import families, orthonormal_family
from railsearch_plugins.polynomial_chaos.stieltjes import nodes_and_weights, stieltjes

DEGREE = 20
TABLES = {
    "uniform": {"distribution": "uniform", "lower": 2.0, "upper": 5.0},
    "normal": {"distribution": "normal", "mean": 3.0, "std": 0.5},
    "lognormal": {"distribution": "lognormal", "mean": 3.0, "std": 0.5},
    "exponential": {"distribution": "scipy.stats.expon", "loc": 1.0, "scale": 2.0},
    "gamma": {"distribution": "scipy.stats.gamma", "a": 2.5, "loc": 1.0, "scale": 3.0},
    "beta": {"distribution": "beta", "alpha": 2.0, "beta": 3.5, "lower": -1.0, "upper": 4.0},
    "arcsine-like beta": {"distribution": "beta", "alpha": 0.5, "beta": 0.5},
    "gumbel-max": {"distribution": "gumbel-max", "mean": 5.0e4, "std": 7.5e3},
    "gumbel-min": {"distribution": "gumbel-min", "mean": 5.0, "std": 0.75},
    "triangular": {"distribution": "triangular", "lower": 0.0, "mode": 1.0, "upper": 3.0},
    "truncated": {"distribution": "normal", "mean": 0.0, "std": 1.0, "truncate_below": -1.0, "truncate_above": 2.5},
    "truncated uniform": {"distribution": "uniform", "lower": 0.0, "upper": 1.0, "truncate_above": 0.5},
    "weibull": {"distribution": "scipy.stats.weibull_min", "c": 1.5},
}
MARGINALS = random_vector(TABLES).marginals


def gram(name, basis, degree):
    """E[ψ_j ψ_k] (degree + 1, degree + 1) by quadrature."""
    nodes, weights = nodes_and_weights(MARGINALS[name])
    values = orthonormal_family(MARGINALS[name], degree, basis).values(nodes, degree)
    return (values * weights) @ values.T


@pytest.mark.parametrize("name", [name for name in TABLES if "beta" not in name])
def test_polynomials_are_orthonormal(name):
    np.testing.assert_allclose(gram(name, "own", DEGREE), np.eye(DEGREE + 1), atol=1e-12)


@pytest.mark.parametrize("name", ["normal", "lognormal", "gumbel-max", "gumbel-min", "weibull"])
def test_mapped_polynomials_are_orthonormal(name):
    np.testing.assert_allclose(gram(name, "hermite", DEGREE), np.eye(DEGREE + 1), atol=1e-11)


@pytest.mark.parametrize(("alpha", "beta"), [(2.0, 3.5), (0.5, 0.5), (1.0, 1.0), (0.5, 1.5)])
def test_jacobi_polynomials_are_scipys(alpha, beta):
    """Also where α + β is 0 or −1 and the general formula of the recurrence has none."""
    marginal = random_vector({"x": {"distribution": "beta", "alpha": alpha, "beta": beta}}).marginals["x"]
    x = np.linspace(0.0, 1.0, 33)
    ours = orthonormal_family(marginal, DEGREE).values(x, DEGREE)
    for k in range(DEGREE + 1):
        textbook = eval_jacobi(k, beta - 1.0, alpha - 1.0, 2.0 * x - 1.0)
        np.testing.assert_allclose(
            ours[k], textbook / math.sqrt(jacobi_norm(k, beta - 1.0, alpha - 1.0)), rtol=1e-9, atol=1e-9
        )


def jacobi_norm(k, a, b):
    """∫ P_k² (1 − t)^a (1 + t)^b dt over ∫ (1 − t)^a (1 + t)^b dt; Abramowitz & Stegun 22.2.1."""
    if k == 0:
        return 1.0
    total = gammaln(a + b + 2.0) - gammaln(a + 1.0) - gammaln(b + 1.0)
    norm = gammaln(k + a + 1.0) + gammaln(k + b + 1.0) - gammaln(k + 1.0) - gammaln(k + a + b + 1.0)
    return math.exp(norm + total) / (2.0 * k + a + b + 1.0)


@pytest.mark.parametrize(
    ("name", "textbook"),
    [
        ("uniform", lambda k, x: eval_legendre(k, (x - 3.5) / 1.5) * math.sqrt(2 * k + 1)),
        ("normal", lambda k, x: eval_hermitenorm(k, (x - 3.0) / 0.5) / math.sqrt(math.factorial(k))),
        ("exponential", lambda k, x: (-1) ** k * eval_genlaguerre(k, 0.0, (x - 1.0) / 2.0)),
        (
            "gamma",
            lambda k, x: (-1) ** k * eval_genlaguerre(k, 1.5, (x - 1.0) / 3.0)
            / math.exp(0.5 * (gammaln(k + 2.5) - gammaln(k + 1.0) - gammaln(2.5))),
        ),
    ],
)  # fmt: skip
def test_classical_families_are_scipys(name, textbook):
    x = MARGINALS[name].percentile(np.linspace(0.01, 0.99, 25))
    ours = orthonormal_family(MARGINALS[name], DEGREE).values(x, DEGREE)
    for k in range(DEGREE + 1):
        np.testing.assert_allclose(ours[k], textbook(k, x), rtol=1e-10, atol=1e-10)


def test_the_polynomials_of_a_logarithm_are_those_of_its_normal():
    marginal = MARGINALS["lognormal"]
    x = marginal.percentile(np.linspace(0.01, 0.99, 25))
    xi = (np.log(x) - np.log(3.0 / math.sqrt(1.0 + 1.0 / 36.0))) / math.sqrt(math.log1p(1.0 / 36.0))
    expected = [eval_hermitenorm(k, xi) / math.sqrt(math.factorial(k)) for k in range(6)]
    np.testing.assert_allclose(orthonormal_family(marginal, 5).values(x, 5), expected, rtol=1e-10, atol=1e-10)
    np.testing.assert_allclose(orthonormal_family(marginal, 5, "hermite").values(x, 5), expected, rtol=1e-10, atol=1e-10)


@pytest.mark.parametrize("name", ["uniform", "normal", "exponential", "gamma"])
def test_stieltjes_finds_the_classical_recurrences(name):
    family, (nodes, weights) = orthonormal_family(MARGINALS[name], DEGREE), nodes_and_weights(MARGINALS[name])
    a, b = stieltjes(family.coordinate(nodes), weights, DEGREE)
    np.testing.assert_allclose(a, family.a, rtol=1e-11, atol=1e-12)
    np.testing.assert_allclose(b, family.b, rtol=1e-11, atol=1e-12)


def test_the_recurrence_of_a_gumbel_distribution_is_that_of_its_exact_cumulants():
    """The cumulants of (x − μ)/σ are (k − 1)! ζ(k) (√6/π)^k; a_1 and b_2 follow from the third and fourth."""
    scale, zeta3 = math.sqrt(6.0) / math.pi, 1.2020569031595942
    skewness, kurtosis = 2.0 * zeta3 * scale**3, 3.0 + 6.0 * math.pi**4 / 90.0 * scale**4
    for name, sign in (("gumbel-max", 1.0), ("gumbel-min", -1.0)):
        family = orthonormal_family(MARGINALS[name], DEGREE)
        np.testing.assert_allclose(family.a[:2], [0.0, sign * skewness], atol=1e-12)
        np.testing.assert_allclose(family.b[:3], [0.0, 1.0, kurtosis - skewness**2 - 1.0], rtol=1e-12, atol=1e-12)


def test_polynomials_of_a_gumbel_distribution_are_orthonormal_by_its_density():
    """Integrals over x with the density exp(−z − exp(−z)), which the construction does not use."""
    family = orthonormal_family(MARGINALS["gumbel-max"], DEGREE)
    scale = 7.5e3 * math.sqrt(6.0) / math.pi
    z, step = np.linspace(-6.0, 250.0, 60001, retstep=True)
    values = family.values(5.0e4 + scale * (z - np.euler_gamma), DEGREE)
    np.testing.assert_allclose((values * (np.exp(-z - np.exp(-z)) * step)) @ values.T, np.eye(DEGREE + 1), atol=1e-12)


@pytest.mark.parametrize("name", ["triangular", "truncated"])
def test_means_over_a_density_with_an_edge(name):
    """Σ w f against adaptive quadrature of the density in x."""
    marginal = MARGINALS[name]
    nodes, weights = nodes_and_weights(marginal)
    points = [1.0] if name == "triangular" else None
    for k in (1, 4, 9):
        exact = quad(lambda x, k=k: x**k * float(marginal.pdf(x)), *marginal.support, points=points, epsabs=1e-12)[0]
        assert np.sum(weights * nodes**k) == pytest.approx(exact, rel=1e-10)


@pytest.mark.parametrize("basis", ["own", "hermite"])
@pytest.mark.parametrize("name", TABLES)
def test_slopes_are_differences(name, basis):
    marginal = MARGINALS[name]
    x = marginal.percentile(np.linspace(0.1, 0.9, 9))
    family, step = orthonormal_family(marginal, 6, basis), 1e-5 * marginal.std
    values, slopes = family.values_and_slopes(x, 6)
    np.testing.assert_array_equal(values, family.values(x, 6))
    differences = (family.values(x + step, 6) - family.values(x - step, 6)) * 0.5e5
    np.testing.assert_allclose(slopes * marginal.std, differences, rtol=1e-6, atol=1e-6)


def test_a_mapped_basis_is_finite_at_the_bounds():
    family = orthonormal_family(MARGINALS["uniform"], 3, "hermite")
    assert np.isfinite(family.values([2.0, 5.0], 3)).all()


@pytest.mark.parametrize(
    ("table", "degree"), [({"distribution": "scipy.stats.t", "df": 5}, 10), ({"distribution": "scipy.stats.cauchy"}, 2)]
)
def test_a_distribution_without_moments_has_no_polynomials_of_its_own(table, degree):
    marginal = random_vector({"x": table}).marginals["x"]
    with pytest.raises(InputError, match="choose the basis 'hermite'"):
        orthonormal_family(marginal, degree)
    assert np.isfinite(orthonormal_family(marginal, degree, "hermite").values([-1.0, 0.0, 3.0], degree)).all()


def test_an_unknown_basis_is_refused():
    with pytest.raises(InputError, match="allowed is 'own' or 'hermite', received 'legendre'"):
        families(MARGINALS.values(), 2, ["legendre"] * len(MARGINALS))
