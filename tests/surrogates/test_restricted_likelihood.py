"""Long trends: the restricted likelihood, and leave-one-out errors by number of trend functions."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import null_space
from scipy.spatial.distance import cdist
from scipy.stats import multivariate_normal

from railsearch_plugins.gaussian_process import estimation as estimation_module
from railsearch_plugins.gaussian_process.estimation import Hyperparameters, criterion, estimated, solved, subset
from railsearch_plugins.gaussian_process.parameters import GaussianProcessParameters
from railsearch_plugins.gaussian_process.process import GaussianProcess
from railsearch_plugins.gaussian_process.system import Training, leave_one_out, leave_one_out_by_trend
from railsearch_plugins.gaussian_process.trend import PolynomialTrend

RESTRICTED = GaussianProcessParameters(correlation="gaussian", estimation="restricted-maximum-likelihood")
SCALES = np.array([0.4, 0.25])


def sample(n=40, seed=0):
    points = np.random.default_rng(seed).random((n, 2))
    return points, np.sin(5.0 * points[:, 0]) + points[:, 1] ** 3


def quadratic(points, values):
    return Training(points, PolynomialTrend(2).values(points), values)


def gaussian(points, scales=SCALES):
    return np.exp(-0.5 * cdist(points / scales, points / scales, "sqeuclidean"))


@pytest.mark.parametrize("scales", [SCALES, np.array([0.2, 0.6])])
def test_it_is_the_density_of_what_no_trend_explains(scales):
    """Of the contrasts Aᵀy, AᵀF = 0, at their best variance; the trend itself enters by a constant, ½ log det FᵀF."""
    points, values = sample(25)
    training = quadratic(points, values)
    contrasts = null_space(training.trend.T)
    matrix = contrasts.T @ (gaussian(points, scales) + 1e-3 * np.eye(25)) @ contrasts
    rest, m = contrasts.T @ values, contrasts.shape[1]
    variance = rest @ np.linalg.solve(matrix, rest) / m
    density = multivariate_normal(np.zeros(m), variance * matrix).logpdf(rest)
    value, _, _ = criterion(training, RESTRICTED, Hyperparameters(scales, 1e-3))
    constant = 0.5 * np.linalg.slogdet(training.trend.T @ training.trend)[1]
    assert -0.5 * m * (value + np.log(2.0 * np.pi) + 1.0) + constant == pytest.approx(density, rel=1e-8)


def test_its_variance_is_that_of_the_process_whatever_the_length_of_the_trend():
    """The plain one is short by p/n, here by half."""
    generator = np.random.default_rng(1)
    points = generator.random((40, 2))
    trend = np.column_stack([np.ones(40), generator.normal(size=(40, 19))])
    lower = np.linalg.cholesky(gaussian(points) + 1e-6 * np.eye(40))
    at = Hyperparameters(SCALES, 1e-6)
    plain, restricted = [], []
    for _ in range(300):
        training = Training(points, trend, lower @ generator.normal(size=40) + trend @ generator.normal(size=20))
        solution, _ = solved(training, RESTRICTED, at)
        plain.append(solution.variance)
        restricted.append(solution.restricted_variance)
    assert np.mean(restricted) == pytest.approx(1.0, abs=4.0 * np.sqrt(2.0 / 20.0 / 300.0))
    assert np.mean(plain) == pytest.approx(0.5 * np.mean(restricted))


def test_the_process_has_the_restricted_variance():
    points, values = sample(30)
    process = GaussianProcess(PolynomialTrend(2), replace(RESTRICTED, length_scales=tuple(SCALES), nugget=1e-3))
    process.fit(points, values, np.random.default_rng(0))
    trend, inverse = PolynomialTrend(2).values(points), np.linalg.inv(gaussian(points) + 1e-3 * np.eye(30))
    rest = values - trend @ np.linalg.solve(trend.T @ inverse @ trend, trend.T @ inverse @ values)
    assert process.variance == pytest.approx(rest @ inverse @ rest / 24.0, rel=1e-8)


def test_leave_one_out_residuals_of_shorter_trends_are_those_of_explicit_refits():
    points, values = sample(25)
    training, at = quadratic(points, values), Hyperparameters(SCALES, 1e-4)
    by_trend = leave_one_out_by_trend(solved(training, RESTRICTED, at)[0])
    assert by_trend.shape == (25, 6)
    for count in range(1, 7):
        shorter, _ = leave_one_out(solved(training.functions(count), RESTRICTED, at)[0])
        np.testing.assert_allclose(by_trend[:, count - 1], shorter, rtol=1e-6, atol=1e-12)
        others = training.functions(count).rows(np.arange(1, 25))
        solution, _ = solved(others, RESTRICTED, at)
        correlations = np.exp(-0.5 * cdist(points[:1] / SCALES, points[1:] / SCALES, "sqeuclidean"))
        predicted = training.trend[0, :count] @ solution.coefficients + correlations[0] @ solution.weights
        assert by_trend[0, count - 1] == pytest.approx(values[0] - predicted, rel=1e-6)


def test_a_subset_has_enough_points_for_a_long_trend(monkeypatch):
    monkeypatch.setattr(estimation_module, "SUBSET", 10)
    points, values = sample(60)
    assert subset(quadratic(points, values), np.random.default_rng(0)).size == 12
    assert subset(quadratic(points, values).functions(1), np.random.default_rng(0)).size == 10
    assert np.isfinite(estimated(quadratic(points, values), RESTRICTED, np.random.default_rng(0)).length_scales).all()


def test_errors_are_fractions_of_the_variance_of_the_values():
    points, values = sample(30)
    process = GaussianProcess(PolynomialTrend(1), GaussianProcessParameters(length_scales=(0.5,), nugget=0.1))
    process.fit(points, values, np.random.default_rng(0))
    training = np.mean((values - process.predict(points)) ** 2) / np.var(values)
    loo = np.mean(process.leave_one_out_residuals**2) / np.var(values)
    assert process.errors == {"training": pytest.approx(training), "leave-one-out": pytest.approx(loo)}
    assert loo > training > 1e-4
