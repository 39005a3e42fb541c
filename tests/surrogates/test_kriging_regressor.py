"""The Gaussian process as a scikit-learn regressor."""

import json
from pathlib import Path

import numpy as np
import pytest
from sklearn.base import clone
from sklearn.model_selection import LeaveOneOut, cross_val_predict, cross_val_score
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler
from sklearn.utils.estimator_checks import parametrize_with_checks

from railsearch.errors import InputError
from railsearch_plugins.gaussian_process.estimator import KrigingRegressor


@parametrize_with_checks([KrigingRegressor(starts=1)])
def test_conventions_of_scikit_learn(estimator, check):
    if check.func.__name__ != "check_array_api_input":  # arrays of other libraries are not taken
        check(estimator)


def camel(x):
    a, b = x[:, 0], x[:, 1]
    return (4.0 - 2.1 * a**2 + a**4 / 3.0) * a**2 + a * b + (-4.0 + 4.0 * b**2) * b**2


def truss_deflection(x):
    """Midspan deflection (m) of the truss of 23 bars, closed form; columns E1, E2, A1, A2 and the loads P1 … P6."""
    horizontal = np.array([36.0, 100.0, 140.0, 140.0, 100.0, 36.0])
    diagonal = np.sqrt(2.0) * np.array([2.0, 6.0, 10.0, 10.0, 6.0, 2.0])
    loads = x[:, 4:]
    return loads @ horizontal / (x[:, 0] * x[:, 2]) + loads @ diagonal / (x[:, 1] * x[:, 3])


def sample(n=60, seed=0):
    x = np.random.default_rng(seed).uniform([-2.0, -1.0], [2.0, 1.0], (n, 2))
    return x, camel(x)


def test_inputs_in_units_of_any_size():
    generator = np.random.default_rng(0)
    lower = np.array([1.6e11, 1.6e11, 1.5e-3, 0.75e-3] + [3.5e4] * 6)
    upper = np.array([2.6e11, 2.6e11, 2.5e-3, 1.25e-3] + [6.5e4] * 6)
    x, fresh = generator.uniform(lower, upper, (150, 10)), generator.uniform(lower, upper, (500, 10))
    model = KrigingRegressor(starts=2).fit(x, truss_deflection(x))
    error = np.mean((model.predict(fresh) - truss_deflection(fresh)) ** 2) / np.var(truss_deflection(fresh))
    assert error < 1e-3
    assert model.loo_error == pytest.approx(error, rel=2.0)
    step = 1e-5 * (upper - lower)
    for j in (0, 3, 7):
        offset = np.zeros(10)
        offset[j] = step[j]
        slope = (model.predict(fresh + offset) - model.predict(fresh - offset)) / (2.0 * step[j])
        np.testing.assert_allclose(model.gradient(fresh)[:, j] * step[j], slope * step[j], atol=1e-10)


def test_gradients_are_by_the_inputs_themselves():
    x, y = sample(30)
    model, step = KrigingRegressor(starts=1).fit(x, y), 1e-5
    queries = sample(10, 1)[0]

    def deviation(points):
        return model.predict(points, return_std=True)[1]

    for function, gradient in ((model.predict, model.gradient), (deviation, model.deviation_gradient)):
        slopes = [(function(queries + h) - function(queries - h)) / (2.0 * step) for h in step * np.eye(2)]
        np.testing.assert_allclose(gradient(queries), np.transpose(slopes), atol=1e-5)


def test_leave_one_out_is_the_cross_validation_of_scikit_learn_at_the_same_length_scales():
    x, y = sample(40)
    corners = np.array([[-2.0, -1.0], [2.0, 1.0], [-2.0, 1.0], [2.0, -1.0]])  # the range is the same without any one point
    x, y = np.vstack([x, corners]), np.append(y, camel(corners))
    model = KrigingRegressor(trend="linear", length_scales=(0.3, 0.5)).fit(x, y)
    predicted = cross_val_predict(clone(model), x, y, cv=LeaveOneOut())
    np.testing.assert_allclose(model.loo_residuals, y - predicted, rtol=1e-6, atol=1e-9)
    assert model.loo_error == pytest.approx(np.mean((y - predicted) ** 2) / np.var(y), rel=1e-6)
    assert model.errors == {"training": 0.0, "leave-one-out": model.loo_error}


def test_training_error_is_that_of_the_predictions_at_the_points():
    x, y = sample(40)
    model = KrigingRegressor(nugget=0.05, length_scales=(0.4,)).fit(x, y)
    expected = np.mean((y - model.predict(x)) ** 2) / np.var(y)
    assert model.errors["training"] == pytest.approx(expected, rel=1e-8)
    assert expected > 1e-4


def test_pipelines_and_cross_validation():
    x, _ = sample(60)
    pipeline = make_pipeline(StandardScaler(), KrigingRegressor(starts=1))
    assert np.min(cross_val_score(pipeline, x, np.sin(x[:, 0]) + x[:, 1] ** 2, cv=3)) > 0.99


class Even:
    """A trend of the powers of camel that the process cannot but welcome, in the units of the inputs."""

    def values(self, points):
        a, b = points.T
        return np.column_stack([np.ones(len(points)), a**2, a**4, a**6, a * b, b**2, b**4])

    def gradient(self, points):
        a, b = points.T
        zero = np.zeros(len(points))
        by_a = np.column_stack([zero, 2 * a, 4 * a**3, 6 * a**5, b, zero, zero])
        by_b = np.column_stack([zero, zero, zero, zero, a, 2 * b, 4 * b**3])
        return np.stack([by_a, by_b], axis=1)


def test_any_basis_serves_as_trend_in_the_units_of_the_inputs():
    x, y = sample(30)
    model = KrigingRegressor(trend=Even(), starts=1).fit(x, y)
    queries = sample(50, 1)[0]
    np.testing.assert_allclose(model.predict(queries), camel(queries), atol=1e-9)
    np.testing.assert_allclose(model.process_.coefficients, [0.0, 4.0, -2.1, 1.0 / 3.0, 1.0, -4.0, 4.0], atol=1e-9)
    a, b = queries.T
    slope = np.column_stack([8 * a - 8.4 * a**3 + 2 * a**5 + b, a - 8 * b + 16 * b**3])
    np.testing.assert_allclose(model.gradient(queries), slope, atol=1e-8)


def test_the_extreme_surface_of_the_camel_function_is_met():
    reference = json.loads((Path(__file__).parents[1] / "reference" / "camel.json").read_text(encoding="utf-8"))
    x = np.array([[a, b] for a in np.linspace(-2.0, 2.0, 25) for b in np.linspace(-1.0, 1.0, 11)])
    model = KrigingRegressor(starts=1).fit(x, camel(x))
    x2 = np.linspace(-1.0, 1.0, 401)
    for fixed, exact in zip(reference["x1"][::7], reference["min_fix_x1"][::7], strict=True):
        predicted = model.predict(np.column_stack([np.full(401, fixed), x2]))
        assert predicted.min() == pytest.approx(exact, abs=0.005)


def test_the_same_seed_gives_the_same_model():
    x, y = sample(40)
    first, second = (KrigingRegressor(random_state=5).fit(x, y).length_scales_ for _ in range(2))
    np.testing.assert_array_equal(first, second)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"trend": "cubic"}, "KrigingRegressor.trend: allowed is 'constant' or 'linear' or 'quadratic' or a Trend"),
        ({"correlation": "cubic"}, "KrigingRegressor.correlation: allowed is 'matern-5/2'"),
        ({"length_scales": (0.1, 0.2, 0.3)}, "length_scales: one or 2 are needed, received 3"),
        ({"nugget": -1.0}, "KrigingRegressor.nugget: allowed is ≥ 0"),
    ],
)
def test_bad_settings_are_refused(settings, message):
    with pytest.raises(InputError, match=message):
        KrigingRegressor(**settings).fit(*sample(20))
