"""Kriging that is in part a sum of processes of one variable."""

import copy

import numpy as np
import pytest
from scipy.optimize import minimize_scalar
from scipy.special import expit, logit

from railsearch.distributions import random_vector
from railsearch.errors import InputError
from railsearch.parameters import make_parameters
from railsearch.testing import check_surrogate
from railsearch_plugins.gaussian_process.additive import AdditiveProcess, additive_basis
from railsearch_plugins.gaussian_process.correlation import matern_5_2
from railsearch_plugins.gaussian_process.estimation import Hyperparameters
from railsearch_plugins.gaussian_process.parameters import GaussianProcessParameters
from railsearch_plugins.gaussian_process.system import Training
from railsearch_plugins.gaussian_process.trend import PolynomialTrend
from railsearch_plugins.surrogates.kriging import Kriging, KrigingParameters

SCALE = 0.15


def made(dimension, **settings):
    return Kriging(dimension, make_parameters(KrigingParameters, settings, "surrogate kriging"))


def fitted(points, values, **settings):
    model = made(points.shape[1], **settings)
    model.fit(points, values)
    return model


def waves(points):
    """A sum over the variables, with several waves in each."""
    return np.sum(np.sin(12.0 * points) + points, axis=1)


def additive_correlation(points, others, scale=SCALE):
    """The mean over the variables of Matérn's correlation, term by term."""
    squares = ((points[:, None, :] - others[None, :, :]) / scale) ** 2
    return matern_5_2(squares)[0].mean(axis=2)


@pytest.mark.parametrize("scale", [0.05, SCALE, 0.5, 1.5])
def test_the_basis_reproduces_the_correlations_of_one_variable_each(scale):
    points = np.random.default_rng(1).random((40, 3))
    functions = additive_basis(scale).values(points)
    np.testing.assert_allclose(functions @ functions.T, additive_correlation(points, points, scale), atol=0.01)
    np.testing.assert_allclose(np.sum(functions**2, axis=1), 1.0, rtol=1e-12)


def test_the_gradient_of_the_basis_is_that_of_its_values():
    points, basis, step = np.random.default_rng(2).random((5, 3)), additive_basis(SCALE), 1e-6
    for variable, gradient in enumerate(np.moveaxis(basis.gradient(points), 1, 0)):
        offset = step * np.eye(3)[variable]
        difference = (basis.values(points + offset) - basis.values(points - offset)) / (2.0 * step)
        blocks = difference.reshape(5, 3, -1)
        np.testing.assert_allclose(blocks[:, variable], gradient, atol=1e-6)
        assert not np.delete(blocks, variable, axis=1).any()


@pytest.mark.parametrize("estimation", ["maximum-likelihood", "restricted-maximum-likelihood", "leave-one-out"])
def test_the_derivatives_of_the_criterion_are_those_of_its_values(estimation):
    generator = np.random.default_rng(3)
    points = generator.random((30, 3))
    training = Training(points, np.ones((30, 1)), waves(points) + points[:, 0] * points[:, 1])
    settings = GaussianProcessParameters(estimation=estimation)
    process = AdditiveProcess(PolynomialTrend(0), settings, additive_basis(SCALE), 0.5)
    additive = additive_basis(SCALE).values(points)

    def criterion(eta):
        at = Hyperparameters(np.exp(eta[:3]), float(np.exp(eta[3])), float(expit(eta[4])))
        return process._criterion(training, additive @ additive.T, at)

    eta = np.array([-0.5, 0.2, 0.4, np.log(1e-3), 0.3])
    _, by_scales, by_nugget, by_share = criterion(eta)
    steps = 1e-5 * np.eye(5)
    differences = [(criterion(eta + step)[0] - criterion(eta - step)[0]) / 2e-5 for step in steps]
    np.testing.assert_allclose(np.append(by_scales, [by_nugget, by_share]), differences, rtol=1e-5, atol=1e-8)


def test_prediction_and_deviation_are_those_of_the_sum_of_both_correlations():
    generator = np.random.default_rng(4)
    points, queries = generator.random((25, 3)), generator.random((10, 3))
    values = waves(points)
    model = fitted(points, values, additive_share=0.5, nugget=0.01, length_scale_prior=0.5)
    at, functions = model.process.hyperparameters, additive_basis(SCALE).values

    def correlation(first, second):
        squares = np.sum(((first[:, None, :] - second[None, :, :]) / at.length_scales) ** 2, axis=2)
        return (1.0 - at.share) * matern_5_2(squares)[0] + at.share * functions(first) @ functions(second).T

    inverse = np.linalg.inv(correlation(points, points) + 0.01 * np.eye(25))
    ones = np.ones(25)
    mean = (ones @ inverse @ values) / (ones @ inverse @ ones)
    rest = inverse @ (values - mean)
    cross = correlation(queries, points)
    np.testing.assert_allclose(model.predict(queries), mean + cross @ rest, rtol=1e-8)
    unexplained = 1.0 - np.sum((cross @ inverse) * cross, axis=1)
    unexplained += (1.0 - cross @ inverse @ ones) ** 2 / (ones @ inverse @ ones)
    variance = (values - mean) @ rest / 25
    np.testing.assert_allclose(model.deviation(queries), np.sqrt(variance * unexplained), rtol=1e-8)


def test_few_points_suffice_to_learn_a_sum_of_waves():
    generator = np.random.default_rng(5)
    points, queries = generator.random((120, 6)), generator.random((200, 6))
    errors = {}
    for share in (0.0, 0.6):
        model = fitted(points, waves(points), additive_share=share, length_scale_prior=0.5)
        errors[share] = np.std(model.predict(queries) - waves(queries))
    assert errors[0.6] < 0.25 * errors[0.0]


def test_the_share_follows_what_the_function_is():
    points = np.random.default_rng(6).random((80, 4))
    together = np.prod(np.sin(4.0 * points), axis=1)
    shares = [
        fitted(points, values, additive_share=0.5, length_scale_prior=0.5).process.hyperparameters.share
        for values in (together, waves(points))
    ]
    assert shares[0] < 0.25
    assert shares[1] > 0.75


@pytest.mark.parametrize(
    "settings",
    [
        {"additive_share": 0.6, "length_scale_prior": 0.5, "starts": 2, "reoptimise_every": 5},
        {"additive_share": 0.5, "trend": "linear", "estimation": "leave-one-out"},
        {"additive_share": 0.9, "length_scales": [0.7]},
    ],
)
def test_it_is_a_surrogate_like_any_other(settings):
    check_surrogate(Kriging, settings)


def test_given_length_scales_stay_and_the_share_is_estimated():
    points = np.random.default_rng(7).random((60, 3))
    at = fitted(points, waves(points), additive_share=0.5, length_scales=(0.7, 0.8, 0.9)).process.hyperparameters
    np.testing.assert_array_equal(at.length_scales, [0.7, 0.8, 0.9])
    assert at.share > 0.6


def test_noise_is_told_from_the_sum():
    generator = np.random.default_rng(8)
    points, queries = generator.random((150, 2)), generator.random((100, 2))
    noisy = waves(points) + 0.3 * generator.standard_normal(150)
    model = fitted(points, noisy, additive_share=0.6, estimate_nugget=True)
    assert np.sqrt(model.process.hyperparameters.nugget * model.process.variance) == pytest.approx(0.3, rel=0.3)
    assert np.std(model.predict(queries) - waves(queries)) < 0.2


def test_points_that_change_in_place_are_seen_to_change():
    points = np.random.default_rng(9).random((30, 2))
    model = fitted(points, waves(points), additive_share=0.6)
    queries = np.full((1, 2), 0.3)
    model.predict(queries)
    queries[:] = points[4]
    assert model.predict(queries)[0] == pytest.approx(waves(queries)[0], abs=1e-5)


def test_a_copy_learns_by_itself():
    points = np.random.default_rng(10).random((30, 2))
    model = fitted(points, waves(points), additive_share=0.6)
    before = model.predict(points + 0.01)
    copy.deepcopy(model).add(np.array([[0.5, 0.5]]), np.array([100.0]))
    np.testing.assert_array_equal(model.predict(points + 0.01), before)


def test_random_inputs_are_refused():
    settings = make_parameters(KrigingParameters, {"additive_share": 0.6}, "surrogate kriging")
    with pytest.raises(InputError, match="additive_share"):
        Kriging.for_inputs(random_vector({"x": {"distribution": "uniform", "lower": 0.0, "upper": 1.0}}), settings)


@pytest.mark.parametrize("settings", [{"additive_share": 1.0}, {"additive_share": -0.1}, {"additive_length_scale": 0.0}])
def test_shares_and_length_scales_that_make_no_sense_are_refused(settings):
    with pytest.raises(InputError, match=next(iter(settings))):
        made(2, **settings)


@pytest.mark.parametrize("before", [0.05, 0.5, 0.9])
def test_the_share_is_the_most_probable_one(before):
    points = np.random.default_rng(11).random((12, 3))
    values, scales = points[:, 0] ** 2 + np.sin(5.0 * points[:, 1]), np.array([0.7, 0.8, 0.9])
    functions = additive_basis(SCALE).values(points)
    ellipsoidal = matern_5_2(np.sum(((points[:, None] - points) / scales) ** 2, axis=2))[0]

    def minus_twice_the_log_probability(eta):
        correlation = (1.0 - expit(eta)) * ellipsoidal + expit(eta) * functions @ functions.T
        inverse = np.linalg.inv(correlation)
        rest = values - inverse.sum(axis=0) @ values / inverse.sum()
        likelihood = 12 * np.log(rest @ inverse @ rest) + np.linalg.slogdet(correlation)[1]
        return likelihood + ((eta - logit(before)) / 1.5) ** 2

    most_probable = minimize_scalar(minus_twice_the_log_probability, bounds=(-6.0, 3.5), method="bounded").x
    found = fitted(points, values, additive_share=before, length_scales=tuple(scales)).process.hyperparameters.share
    assert logit(found) == pytest.approx(most_probable, abs=0.003)


@pytest.mark.parametrize("share", [0.1, 0.9])
def test_where_the_data_say_nothing_the_share_stays(share):
    points = np.linspace(0.0, 1.0, 3)[:, None] * np.ones((1, 2))
    values = np.array([0.0, 1.0, 0.0])
    found = fitted(points, values, additive_share=share, length_scale_prior=0.01).process.hyperparameters.share
    assert found == pytest.approx(share, abs=0.1)
