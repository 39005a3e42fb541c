"""Kriging against dense formulas written down independently, explicit refits, scikit-learn, theory and differences."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import approx_fprime
from scipy.spatial.distance import cdist
from scipy.stats import multivariate_normal
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, Matern

from railsearch.errors import InputError, SurrogateError
from railsearch.parameters import make_parameters
from railsearch.testing import check_surrogate
from railsearch_plugins.gaussian_process import estimation as estimation_module
from railsearch_plugins.gaussian_process import process
from railsearch_plugins.gaussian_process.correlation import CORRELATIONS
from railsearch_plugins.gaussian_process.estimation import CRITERIA, Hyperparameters, criterion, estimated
from railsearch_plugins.gaussian_process.process import GaussianProcess
from railsearch_plugins.gaussian_process.system import Training, factorise
from railsearch_plugins.gaussian_process.trend import DEGREES, PolynomialTrend
from railsearch_plugins.surrogates.kriging import Kriging, KrigingParameters

SCALES = np.array([0.5, 0.3, 0.8])
FORMULAS = {
    "matern-5/2": lambda h: (1.0 + np.sqrt(5.0) * h + 5.0 * h**2 / 3.0) * np.exp(-np.sqrt(5.0) * h),
    "matern-3/2": lambda h: (1.0 + np.sqrt(3.0) * h) * np.exp(-np.sqrt(3.0) * h),
    "gaussian": lambda h: np.exp(-(h**2) / 2.0),
    "exponential": lambda h: np.exp(-h),
}
every_correlation = pytest.mark.parametrize("correlation", list(CORRELATIONS))
every_trend = pytest.mark.parametrize("trend", list(DEGREES))
every_estimation = pytest.mark.parametrize("estimation", list(CRITERIA))


def smooth(points):
    return 50.0 + 10.0 * (np.sin(4.0 * points).sum(axis=1) + points[:, 0] * points[:, -1])


def sample(n, dimension=3, seed=0):
    points = np.random.default_rng(seed).random((n, dimension))
    return points, smooth(points)


def made(dimension=3, **changes):
    return Kriging(dimension, make_parameters(KrigingParameters, changes, "kriging"))


def fitted(points, values, **changes):
    model = made(points.shape[1], **changes)
    model.fit(points, values)
    return model


def monomials(points, trend):
    """The trend's functions as powers of x, another basis of the same space."""
    columns = [np.ones(len(points))]
    if trend != "constant":
        columns += list(points.T)
    if trend == "quadratic":
        columns += [points[:, i] * points[:, j] for i in range(points.shape[1]) for j in range(i + 1)]
    return np.column_stack(columns)


class DenseTwin:
    """Universal Kriging by inverses, as textbooks print it."""

    def __init__(self, points, values, trend="constant", correlation="matern-5/2", scales=SCALES, nugget=0.0):
        self.points, self.trend, self.correlation, self.scales = points, trend, correlation, scales
        self.matrix = self.correlate(points) + nugget * np.eye(len(points))
        self.inverse = np.linalg.inv(self.matrix)
        self.basis = monomials(points, trend)
        self.information = np.linalg.inv(self.basis.T @ self.inverse @ self.basis)
        self.beta = self.information @ self.basis.T @ self.inverse @ values
        self.rest = values - self.basis @ self.beta
        self.variance = self.rest @ self.inverse @ self.rest / len(values)

    def correlate(self, others):
        return FORMULAS[self.correlation](cdist(others / self.scales, self.points / self.scales))

    def predict(self, queries):
        return monomials(queries, self.trend) @ self.beta + self.correlate(queries) @ self.inverse @ self.rest

    def deviation(self, queries):
        r, f = self.correlate(queries).T, monomials(queries, self.trend).T
        u = self.basis.T @ self.inverse @ r - f
        explained = np.sum(r * (self.inverse @ r), axis=0) - np.sum(u * (self.information @ u), axis=0)
        return np.sqrt(self.variance * (1.0 - explained))


@every_correlation
@every_trend
@pytest.mark.parametrize("nugget", [0.0, 1e-2])
def test_prediction_and_deviation_are_those_of_the_textbook(correlation, trend, nugget):
    points, values = sample(30)
    twin = DenseTwin(points, values, trend, correlation, nugget=nugget)
    model = fitted(points, values, trend=trend, correlation=correlation, length_scales=list(SCALES), nugget=nugget)
    queries = np.random.default_rng(1).random((20, 3))
    np.testing.assert_allclose(model.predict(queries), twin.predict(queries), rtol=1e-8)
    np.testing.assert_allclose(model.deviation(queries), twin.deviation(queries), rtol=1e-6)
    assert model.process.variance == pytest.approx(twin.variance, rel=1e-8)
    assert model.process.nugget_added == 0.0


@pytest.mark.parametrize(
    ("correlation", "kernel"),
    [
        ("matern-5/2", Matern(SCALES, nu=2.5)),
        ("matern-3/2", Matern(SCALES, nu=1.5)),
        ("exponential", Matern(SCALES, nu=0.5)),
        ("gaussian", RBF(SCALES)),
    ],
)
def test_without_the_trend_the_process_is_that_of_scikit_learn(correlation, kernel):
    class Nothing:
        """A trend of no functions."""

        def values(self, points):
            return np.empty((len(points), 0))

        def gradient(self, points):
            return np.empty((*points.shape, 0))

    points, values = sample(25)
    queries = np.random.default_rng(1).random((20, 3))
    parameters = KrigingParameters(correlation=correlation, length_scales=tuple(SCALES))
    ours = GaussianProcess(Nothing(), parameters)
    ours.fit(points, values, np.random.default_rng(0))
    theirs = GaussianProcessRegressor(kernel, alpha=1e-300, optimizer=None).fit(points, values)
    predicted, deviation = theirs.predict(queries, return_std=True)
    np.testing.assert_allclose(ours.predict(queries), predicted, rtol=1e-7)
    np.testing.assert_allclose(ours.deviation(queries), np.sqrt(ours.variance) * deviation, rtol=1e-4)


@every_correlation
@every_trend
def test_gradients_agree_with_central_differences(correlation, trend):
    points, values = sample(30)
    model = fitted(points, values, trend=trend, correlation=correlation, length_scales=list(SCALES))
    queries, step = np.random.default_rng(5).random((20, 3)), 1e-5
    for function, gradient in ((model.predict, model.gradient), (model.deviation, model.deviation_gradient)):
        slopes = [(function(queries + h) - function(queries - h)) / (2.0 * step) for h in step * np.eye(3)]
        np.testing.assert_allclose(gradient(queries), np.transpose(slopes), atol=2e-5)


@every_correlation
def test_passes_through_the_points_where_it_is_certain(correlation):
    points, values = sample(30)
    model = fitted(points, values, correlation=correlation)
    np.testing.assert_allclose(model.predict(points), values, rtol=1e-7)
    assert np.max(model.deviation(points)) < 1e-4 * np.ptp(values)
    assert np.isfinite(model.deviation_gradient(points)).all()


@every_trend
@every_estimation
def test_leave_one_out_residuals_are_those_of_explicit_refits(trend, estimation):
    points, values = sample(25)
    settings = {"trend": trend, "estimation": estimation, "length_scales": [0.4], "nugget": 1e-3}
    model = fitted(points, values, **settings)
    refits = []
    for k in range(25):
        others = np.arange(25) != k
        refits.append(values[k] - fitted(points[others], values[others], **settings).predict(points[k : k + 1])[0])
    np.testing.assert_allclose(model.process.leave_one_out_residuals, refits, rtol=1e-6)


def test_the_variance_of_leave_one_out_makes_its_standardised_residuals_have_mean_square_one():
    points, values = sample(20)
    settings = {"estimation": "leave-one-out", "length_scales": [0.4]}
    model = fitted(points, values, **settings)
    ratios = []
    for k in range(20):
        others = np.arange(20) != k
        without = fitted(points[others], values[others], length_scales=[0.4])
        deviation = without.deviation(points[k : k + 1])[0] / np.sqrt(without.process.variance)
        ratios.append(model.process.leave_one_out_residuals[k] ** 2 / deviation**2)
    assert model.process.variance == pytest.approx(np.mean(ratios), rel=1e-6)


@every_correlation
def test_the_likelihood_is_the_density_of_the_values_at_its_best_trend_and_variance(correlation):
    points, values = sample(20)
    training = Training(points, PolynomialTrend(1).values(points), values)
    parameters = KrigingParameters(correlation=correlation)

    def log_density(scales, factor=1.0, shift=0.0):
        twin = DenseTwin(points, values, "linear", correlation, scales)
        mean = twin.basis @ (twin.beta + shift)
        return multivariate_normal(mean, factor * twin.variance * twin.matrix).logpdf(values)

    for scales in (SCALES, np.array([0.2, 0.9, 0.4])):
        value, _, _ = criterion(training, parameters, Hyperparameters(scales, 0.0))
        expected = -10.0 * (value + np.log(2.0 * np.pi) + 1.0)
        assert expected == pytest.approx(log_density(scales), rel=1e-8)
        assert max(log_density(scales, 1.1), log_density(scales, 0.9), log_density(scales, 1.0, 1e-2)) < expected


@every_correlation
@every_estimation
@every_trend
def test_criteria_have_the_gradient_of_their_differences(correlation, estimation, trend):
    points, values = sample(30)
    parameters = KrigingParameters(correlation=correlation, estimation=estimation)
    training = Training(points, PolynomialTrend(DEGREES[trend]).values(points), values)

    def at(eta):
        return criterion(training, parameters, Hyperparameters(np.exp(eta[:3]), float(np.exp(eta[3]))))

    eta = np.log([*SCALES, 1e-3])
    _, by_scales, by_nugget = at(eta)
    slopes = approx_fprime(eta, lambda x: at(x)[0], 1e-7)
    np.testing.assert_allclose([*by_scales, by_nugget], slopes, rtol=1e-4, atol=1e-6)


@every_estimation
def test_estimated_length_scales_are_no_worse_than_any_on_a_grid(estimation):
    points, values = sample(40, 2)
    training = Training(points, PolynomialTrend(0).values(points), values - values.mean())
    parameters = KrigingParameters(estimation=estimation)
    found = estimated(training, parameters, np.random.default_rng(0))
    grid = np.geomspace(0.011, 19.0, 14)
    values_on_grid = [criterion(training, parameters, Hyperparameters(np.array([a, b]), 0.0))[0] for a in grid for b in grid]
    assert criterion(training, parameters, found)[0] <= min(values_on_grid) + 1e-3


def test_length_scales_of_a_sampled_process_are_found_again():
    points = np.random.default_rng(3).random((250, 2))
    true = np.array([0.15, 0.6])
    correlations = FORMULAS["matern-5/2"](cdist(points / true, points / true))
    values = np.linalg.cholesky(correlations + 1e-12 * np.eye(250)) @ np.random.default_rng(4).standard_normal(250)
    model = fitted(points, values)
    np.testing.assert_allclose(model.process.hyperparameters.length_scales, true, rtol=0.25)
    assert 0.3 < model.process.variance < 3.0


def test_the_noise_of_values_is_found_as_a_nugget_when_that_is_asked_for():
    points, values = sample(150, 2)
    noise = 1.5 * np.random.default_rng(1).standard_normal(150)
    model = fitted(points, values + noise, estimate_nugget=True)
    found = model.process.hyperparameters.nugget * model.process.variance
    assert np.sqrt(found) == pytest.approx(1.5, rel=0.25)
    error = model.predict(points) - values
    assert np.sqrt(np.mean(error**2)) < 0.6 < np.sqrt(np.mean(noise**2))


def test_a_variable_without_effect_gets_a_long_scale():
    points, _ = sample(60)
    model = fitted(points, np.sin(6.0 * points[:, 0]) + np.cos(5.0 * points[:, 2]))
    scales = model.process.hyperparameters.length_scales
    assert scales[1] > 5.0 * max(scales[0], scales[2])


@every_trend
def test_values_on_the_trend_are_predicted_everywhere_and_with_certainty(trend):
    points = np.random.default_rng(0).random((30, 3))
    functions = monomials(points, trend)
    coefficients = np.arange(1.0, 1.0 + functions.shape[1])
    model = fitted(points, functions @ coefficients, trend=trend)
    queries = np.random.default_rng(1).uniform(-1.0, 2.0, (20, 3))
    np.testing.assert_allclose(model.predict(queries), monomials(queries, trend) @ coefficients, rtol=1e-9, atol=1e-9)
    assert np.max(model.deviation(queries)) < 1e-8


def test_predictions_go_with_the_unit_of_the_values():
    points, values = sample(30)
    queries = np.random.default_rng(1).random((20, 3))
    plain, scaled = fitted(points, values), fitted(points, 7e9 - 1e9 * values)
    np.testing.assert_allclose(scaled.predict(queries), 7e9 - 1e9 * plain.predict(queries), rtol=1e-4)
    np.testing.assert_allclose(scaled.deviation(queries), 1e9 * plain.deviation(queries), rtol=1e-2)


def test_far_from_all_points_the_prediction_is_the_trend_and_the_deviation_that_of_the_process():
    points, values = sample(30)
    model = fitted(points, values, length_scales=list(SCALES))
    twin = DenseTwin(points, values)
    far = np.full((1, 3), 100.0)
    assert model.predict(far)[0] == pytest.approx(twin.beta[0], rel=1e-9)
    expected = np.sqrt(twin.variance * (1.0 + twin.information[0, 0]))
    assert model.deviation(far)[0] == pytest.approx(expected, rel=1e-9)


@every_estimation
def test_added_points_at_the_same_scales_give_what_a_fit_to_all_gives(estimation):
    points, values = sample(60)
    settings = {"estimation": estimation, "length_scales": list(SCALES), "trend": "linear", "reoptimise_every": 1000}
    queries = np.random.default_rng(1).random((20, 3))
    model, whole = fitted(points[:20], values[:20], **settings), fitted(points, values, **settings)
    model.deviation(queries)
    model.add(points[20:35], values[20:35])
    for k in range(35, 60):
        model.add(points[k : k + 1], values[k : k + 1])
    np.testing.assert_allclose(model.predict(queries), whole.predict(queries), rtol=1e-9)
    np.testing.assert_allclose(model.deviation(queries), whole.deviation(queries), rtol=1e-6)
    np.testing.assert_allclose(model.process.leave_one_out_residuals, whole.process.leave_one_out_residuals, rtol=1e-6)


def test_scales_are_optimised_again_only_every_so_often_and_from_where_they_are(monkeypatch):
    points, values = sample(60)
    starts = []

    def watched(training, parameters, generator, start=None):
        starts.append(None if start is None else (training.size, start.length_scales))
        return estimated(training, parameters, generator, start)

    monkeypatch.setattr(process, "estimated", watched)
    model = fitted(points[:20], values[:20], reoptimise_every=15)
    first = model.process.hyperparameters.length_scales
    for k in range(20, 60):
        model.add(points[k : k + 1], values[k : k + 1])
    assert starts[0] is None
    assert [size for size, _ in starts[1:]] == [35, 50]
    np.testing.assert_array_equal(starts[1][1], first)
    np.testing.assert_allclose(model.predict(points), values, rtol=1e-7)


@pytest.mark.parametrize("late", [False, True])
def test_points_that_coincide_get_a_nugget_and_that_is_said(late):
    points, values = sample(30)
    twice, both = np.vstack([points, points[4:5]]), np.append(values, values[4])
    if late:
        model = fitted(points, values, length_scales=[0.5], reoptimise_every=1000)
        assert model.process.nugget_added == 0.0
        model.add(twice[-1:], both[-1:])
    else:
        model = fitted(twice, both, length_scales=[0.5])
    assert 0.0 < model.process.nugget_added < 1e-9
    assert model.process.hyperparameters.nugget == model.process.nugget_added
    np.testing.assert_allclose(model.predict(points), values, rtol=1e-6)


@pytest.mark.parametrize(("gap", "added"), [(1e-12, False), (1e-15, True)])
def test_a_pivot_that_is_but_rounding_error_is_not_taken_for_variance(gap, added):
    lower, nugget = factorise(np.array([[1.0, 1.0 - gap], [1.0 - gap, 1.0]]), 0.0)
    assert (nugget > 0.0) == added
    assert lower[1, 1] ** 2 == pytest.approx(2.0 * (gap + nugget), rel=1e-2, abs=2e-15)


def test_integers_are_rounded_before_anything_else():
    generator = np.random.default_rng(0)
    points, steps = generator.random((40, 3)), np.array([0, 4, 1])
    whole = np.where(steps > 0, np.round(points * steps) / np.maximum(steps, 1), points)
    values = smooth(whole)
    settings = {"trend": "linear", "length_scales": [0.6]}
    rounding, plain = fitted(points, values, integer_steps=[0, 4, 1], **settings), fitted(whole, values, **settings)
    queries = generator.random((20, 3))
    rounded = np.where(steps > 0, np.round(queries * steps) / np.maximum(steps, 1), queries)
    for method in ("predict", "deviation"):
        np.testing.assert_array_equal(getattr(rounding, method)(queries), getattr(plain, method)(rounded))
    for method in ("gradient", "deviation_gradient"):
        gradient = getattr(rounding, method)(queries)
        np.testing.assert_array_equal(gradient[:, 1:], 0.0)
        np.testing.assert_array_equal(gradient[:, 0], getattr(plain, method)(rounded)[:, 0])


def test_many_points_are_predicted_in_blocks_alike(monkeypatch):
    points, values = sample(30)
    model, queries = fitted(points, values, length_scales=[0.5]), np.random.default_rng(1).random((100, 3))
    whole = [method(queries) for method in (model.predict, model.gradient, model.deviation, model.deviation_gradient)]
    monkeypatch.setattr(process, "BLOCK", 7 * 30)
    parts = [method(queries) for method in (model.predict, model.gradient, model.deviation, model.deviation_gradient)]
    for one, other in zip(whole, parts, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-7, atol=1e-7)


def test_many_points_are_fitted_from_starts_on_a_subset(monkeypatch):
    sizes = []

    def watched(training, parameters, at):
        sizes.append(training.size)
        return criterion(training, parameters, at)

    points, values = sample(120, 2)
    with monkeypatch.context() as patch:
        patch.setattr(estimation_module, "SUBSET", 50)
        patch.setattr(estimation_module, "criterion", watched)
        few = fitted(points, values, starts=2)
    assert sizes == sorted(sizes)
    assert set(sizes) == {50, 120}
    training = Training(points, np.ones((120, 1)), values - values.mean())
    whole = estimated(training, KrigingParameters(), np.random.default_rng(0), Hyperparameters(np.ones(2), 0.0))
    found = few.process.hyperparameters
    best = [criterion(training, KrigingParameters(), replace(at, nugget=0.0))[0] for at in (found, whole)]
    assert best[0] == pytest.approx(best[1], abs=1e-3)


def test_the_error_falls_with_the_number_of_points():
    queries = np.random.default_rng(9).random((500, 2))

    def error(n):
        points, values = sample(n, 2)
        return np.sqrt(np.mean((fitted(points, values).predict(queries) - smooth(queries)) ** 2))

    assert error(80) < 0.05 * error(20)


@pytest.mark.parametrize(
    "settings", [{"estimation": "leave-one-out"}, {"trend": "quadratic"}, {"correlation": "exponential"}]
)
def test_the_conformance_suite_holds_with_other_settings(settings):
    check_surrogate(Kriging, settings)


def test_bad_input_is_refused():
    points, values = sample(20)
    model = made()
    for method in (model.predict, model.gradient, model.deviation, model.deviation_gradient):
        with pytest.raises(SurrogateError, match="not fitted"):
            method(points)
    with pytest.raises(SurrogateError, match="not fitted"):
        model.add(points, values)
    with pytest.raises(SurrogateError, match="a trend of 10 functions needs 11 points or more, received 10"):
        fitted(points[:10], values[:10], trend="quadratic")
    with pytest.raises(SurrogateError, match="tell only 3 of the 4 functions of the trend apart"):
        fitted(points * [1.0, 1.0, 0.0], values, trend="linear")
    with pytest.raises(SurrogateError, match=r"received shapes \(20, 2\) and \(20,\)"):
        model.fit(points[:, :2], values)
    values[3] = np.nan
    with pytest.raises(SurrogateError, match="finite points and values"):
        model.fit(points, values)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"integer_steps": [0, 3]}, r"integer_steps needs one number for each of 3 variables .*, received \[0, 3\]"),
        ({"length_scales": [0.1, 0.2]}, "length_scales: one or 3 are needed, received 2"),
        ({"length_scales": [0.0]}, "length_scales: allowed is > 0"),
        ({"length_scale_bounds": [1.0, 0.1]}, r"the shortest, then the longest is needed, received \[1.0, 0.1\]"),
        ({"correlation": "cubic"}, "'matern-5/2' or 'matern-3/2'"),
        ({"trend": "cubic"}, "'constant' or 'linear' or 'quadratic'"),
        ({"estimation": "guess"}, "'maximum-likelihood' or 'restricted-maximum-likelihood' or 'leave-one-out'"),
        ({"nugget": -1.0}, "nugget: allowed is ≥ 0"),
        ({"starts": 0}, "starts: allowed is ≥ 1"),
    ],
)
def test_bad_settings_are_refused(settings, message):
    with pytest.raises(InputError, match=message):
        made(**settings)


def test_nothing_is_warned_of():
    points, values = sample(40)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        model = fitted(points, values)
        model.deviation_gradient(points)
