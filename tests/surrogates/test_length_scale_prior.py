"""The prior of the length scales: its limits, and what it is for."""

import numpy as np
import pytest
from scipy.optimize import approx_fprime
from scipy.stats import lognorm

from railsearch.parameters import make_parameters
from railsearch_plugins.gaussian_process.estimation import Hyperparameters, criterion, surprise
from railsearch_plugins.gaussian_process.system import Training
from railsearch_plugins.surrogates.kriging import Kriging, KrigingParameters


def fitted(points, values, **settings):
    model = Kriging(points.shape[1], make_parameters(KrigingParameters, settings, "surrogate kriging"))
    model.fit(points, values)
    return model


def few_points(n=25, dimension=10):
    points = np.random.default_rng(4).random((n, dimension))
    return points, np.sum((points - 0.5) ** 2, axis=1)


def test_the_surprise_is_minus_twice_the_log_density_of_log_normal_scales():
    scales, deviation = np.array([0.2, 1.0, 3.0]), 0.7
    centre = 0.5 * np.sqrt(3.0)

    def minus_twice(logarithms):
        theta = np.exp(logarithms)
        density = lognorm.logpdf(theta, deviation, scale=centre) + logarithms
        return -2.0 * np.sum(density - lognorm.logpdf(centre, deviation, scale=centre) - np.log(centre))

    value, derivative = surprise(np.log(scales), deviation)
    assert value == pytest.approx(minus_twice(np.log(scales)))
    np.testing.assert_allclose(derivative, approx_fprime(np.log(scales), minus_twice), rtol=1e-5)


def test_without_a_prior_nothing_is_added():
    value, derivative = surprise(np.log([0.2, 1.0]), None)
    assert value == 0.0
    assert not derivative.any()


@pytest.mark.parametrize("estimation", ["maximum-likelihood", "leave-one-out"])
def test_a_sure_prior_is_what_comes_out_and_a_vague_one_changes_nothing(estimation):
    points, values = few_points()
    sure = fitted(points, values, length_scale_prior=1e-3, estimation=estimation)
    np.testing.assert_allclose(sure.process.hyperparameters.length_scales, 0.5 * np.sqrt(10.0), rtol=1e-2)
    vague, flat = (fitted(points, values, length_scale_prior=p, estimation=estimation) for p in (1e4, None))
    queries = np.random.default_rng(1).random((20, 10))
    np.testing.assert_allclose(vague.predict(queries), flat.predict(queries), rtol=1e-2)


def test_few_points_of_equally_important_variables_are_not_told_apart_by_chance():
    points, values = few_points()
    spread = {
        p: np.ptp(np.log(fitted(points, values, length_scale_prior=p).process.hyperparameters.length_scales))
        for p in (0.5, None)
    }
    assert spread[0.5] < 0.5 * spread[None]
    queries = np.random.default_rng(2).random((500, 10))
    truth = np.sum((queries - 0.5) ** 2, axis=1)
    errors = {p: np.std(fitted(points, values, length_scale_prior=p).predict(queries) - truth) for p in (0.5, None)}
    assert errors[0.5] < errors[None]


def test_the_estimate_is_the_minimiser_of_the_criterion_and_the_prior_together():
    points = np.random.default_rng(0).random((15, 1))
    values = np.sin(8.0 * points[:, 0])
    settings = make_parameters(KrigingParameters, {"length_scale_prior": 0.2}, "surrogate kriging")
    model = Kriging(1, settings)
    model.fit(points, values)
    training = Training(points, np.ones((15, 1)), values)
    scales = np.geomspace(0.05, 5.0, 4000)
    sums = [
        criterion(training, settings, Hyperparameters(np.array([scale]), 0.0))[0] + (np.log(scale / 0.5) / 0.2) ** 2 / 15
        for scale in scales
    ]
    assert model.process.hyperparameters.length_scales[0] == pytest.approx(scales[np.argmin(sums)], rel=3e-3)
