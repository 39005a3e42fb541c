"""PC-Kriging against Kriging, the expansion, dense algebra, explicit refits and differences."""

import numpy as np
import pytest
from scipy.spatial.distance import cdist

from railsearch.distributions import random_vector
from railsearch.errors import InputError, SurrogateError
from railsearch.parameters import make_parameters
from railsearch.sampling import latin_hypercube
from railsearch.testing import check_surrogate
from railsearch_plugins.gaussian_process.estimator import KrigingRegressor
from railsearch_plugins.polynomial_chaos.coordinates import coordinates_over, unit_cube
from railsearch_plugins.polynomial_chaos.expansion import Expansion
from railsearch_plugins.polynomial_chaos.families import families
from railsearch_plugins.polynomial_chaos.multi_indices import hyperbolic_set
from railsearch_plugins.polynomial_chaos_kriging.model import fit_polynomial_chaos_kriging, process_on_terms
from railsearch_plugins.polynomial_chaos_kriging.parameters import PolynomialChaosKrigingParameters as Parameters
from railsearch_plugins.polynomial_chaos_kriging.trend import ExpansionTrend
from railsearch_plugins.surrogates.pck import PolynomialChaosKriging, SurrogateParameters

INPUTS = random_vector(
    {
        "a": {"distribution": "lognormal", "mean": 3.0e10, "std": 5.0e9},
        "b": {"distribution": "gumbel-max", "mean": 10.0, "std": 2.0},
        "c": {"distribution": "uniform", "lower": -1e-3, "upper": 2e-3},
    }
)
FAMILIES = families(INPUTS.marginals.values(), 15, ["own"] * 3)
TERMS = hyperbolic_set(3, 3, 1.0, 100)
VARIANTS = pytest.mark.parametrize("variant", ["sequential", "optimal"])


def smooth(x):
    return 1e3 * (x[:, 1] / np.log(x[:, 0]) + np.sin(1e3 * x[:, 2]))


def sample(n=40, seed=0):
    points = latin_hypercube(INPUTS, n, np.random.default_rng(seed))
    return points, smooth(points)


def on_terms(points, values, indices, coordinates=None, **settings):
    placed = coordinates or coordinates_over(FAMILIES, points)
    return process_on_terms(placed, indices, points, values, Parameters(**settings), np.random.default_rng(0))


def fitted(points, values, **settings):
    return fit_polynomial_chaos_kriging(FAMILIES, points, values, Parameters(**settings), np.random.default_rng(0))


def camel(x):
    a, b = 4.0 * x[:, 0] - 2.0, 2.0 * x[:, 1] - 1.0
    return (4.0 - 2.1 * a**2 + a**4 / 3.0) * a**2 + a * b + (-4.0 + 4.0 * b**2) * b**2


def test_the_trend_are_the_terms_of_the_expansion_in_other_coordinates():
    points, _ = sample()
    coordinates = coordinates_over(FAMILIES, points)
    trend = ExpansionTrend(coordinates.polynomials, TERMS)
    coefficients = np.random.default_rng(1).normal(size=len(TERMS))
    expansion = Expansion(FAMILIES, TERMS, coefficients)
    placed = coordinates.placed(points)
    np.testing.assert_allclose(trend.values(placed) @ coefficients, expansion.predict(points), rtol=1e-9, atol=1e-9)
    gradient = coordinates.pulled_back(trend.gradient(placed) @ coefficients, points)
    scale = 1.0 / INPUTS.std
    np.testing.assert_allclose(gradient / scale, expansion.gradient(points) / scale, rtol=1e-8, atol=1e-8)


def test_without_terms_it_is_kriging_with_a_constant_trend():
    points, values = sample()
    settings = {"correlation": "gaussian", "estimation": "maximum-likelihood", "starts": 1}
    model = on_terms(points, values, TERMS[:1], **settings)
    kriging = KrigingRegressor(inputs=INPUTS, **settings).fit(points, values)
    queries, _ = sample(20, 1)
    predicted, deviation = kriging.predict(queries, return_std=True)
    np.testing.assert_allclose(model.predict(queries), predicted, rtol=1e-10)
    np.testing.assert_allclose(model.deviation(queries), deviation, rtol=1e-6)


def test_with_short_correlations_it_is_the_expansion_between_the_points():
    points, values = sample(60)
    found = fitted(points, values, length_scales=[1e-3])
    queries, _ = sample(20, 1)
    np.testing.assert_allclose(found.model.predict(queries), found.expansion.expansion.predict(queries), rtol=1e-9)
    assert len(found.indices) == len(found.expansion.expansion.indices) > 5


@VARIANTS
def test_what_is_in_the_span_of_its_terms_it_predicts_exactly_and_with_certainty(variant):
    points = np.random.default_rng(0).random((60, 2))
    surrogate = PolynomialChaosKriging(2, SurrogateParameters(variant=variant))
    surrogate.fit(points, camel(points))
    queries = np.random.default_rng(1).random((50, 2))
    np.testing.assert_allclose(surrogate.predict(queries), camel(queries), atol=1e-9)
    assert np.max(surrogate.deviation(queries)) < 1e-8
    assert surrogate.loo_error < 1e-20


def test_prediction_coefficients_and_deviation_are_those_of_generalised_least_squares():
    """By inverses, as textbooks print it, with the terms as the expansion has them."""
    points, values = sample()
    scales, nugget = np.array([0.6, 0.5, 0.4]), 1e-3
    model = on_terms(points, values, TERMS, length_scales=list(scales), nugget=nugget)
    coordinates, queries = coordinates_over(FAMILIES, points), sample(20, 1)[0]

    def terms(x):
        return np.column_stack([Expansion(FAMILIES, TERMS[k : k + 1], np.ones(1)).predict(x) for k in range(len(TERMS))])

    def correlations(x, y):
        return np.exp(-0.5 * cdist(coordinates.placed(x) / scales, coordinates.placed(y) / scales, "sqeuclidean"))

    inverse = np.linalg.inv(correlations(points, points) + nugget * np.eye(40))
    basis, f, r = terms(points), terms(queries), correlations(queries, points)
    information = np.linalg.inv(basis.T @ inverse @ basis)
    beta = information @ basis.T @ inverse @ values
    rest = values - basis @ beta
    np.testing.assert_allclose(model.process.coefficients, beta, rtol=1e-7, atol=1e-7)
    np.testing.assert_allclose(model.predict(queries), f @ beta + r @ inverse @ rest, rtol=1e-8)
    u = f - r @ inverse @ basis
    variance = rest @ inverse @ rest / (40 - len(TERMS))
    share = 1.0 - np.sum((r @ inverse) * r, axis=1) + np.sum((u @ information) * u, axis=1)
    np.testing.assert_allclose(model.deviation(queries), np.sqrt(variance * share), rtol=1e-6)


def test_leave_one_out_residuals_are_those_of_explicit_refits():
    points, values = sample(30)
    settings = {"length_scales": [0.5], "nugget": 1e-4, "coordinates": coordinates_over(FAMILIES, points)}
    refits = []
    for k in range(30):
        others = np.arange(30) != k
        model = on_terms(points[others], values[others], TERMS[:12], **settings)
        refits.append(values[k] - model.predict(points[k : k + 1])[0])
    found = on_terms(points, values, TERMS[:12], **settings).process
    np.testing.assert_allclose(found.leave_one_out_residuals, refits, rtol=1e-6)
    assert found.errors["leave-one-out"] == pytest.approx(np.mean(np.square(refits)) / np.var(values))


def test_the_optimal_number_of_terms_is_the_best_of_all_tried_one_by_one():
    points, values = sample(35)
    settings = {"length_scales": [0.8], "growth": False, "correlation": "matern-5/2"}
    found = fitted(points, values, variant="optimal", **settings)
    every = fitted(points, values, **settings).indices
    errors = [
        on_terms(points, values, every[:k], length_scales=[0.8], correlation="matern-5/2").process.errors["leave-one-out"]
        for k in range(1, len(every) + 1)
    ]
    assert len(found.indices) == int(np.argmin(errors)) + 1
    assert 1 < len(found.indices) < len(every)
    np.testing.assert_array_equal(found.indices, every[: len(found.indices)])


@pytest.mark.parametrize("seed", range(2))
def test_the_optimal_variant_has_no_larger_error_than_all_terms_or_none(seed):
    points, values = sample(40, seed)
    settings = {"growth": False, "starts": 2}
    optimal, sequential = (fitted(points, values, variant=variant, **settings) for variant in ("optimal", "sequential"))
    bounds = [sequential.model.process, on_terms(points, values, TERMS[:1], starts=2).process]
    error = optimal.model.process.errors["leave-one-out"]
    assert error <= 1.05 * min(process.errors["leave-one-out"] for process in bounds)


@VARIANTS
def test_it_passes_through_the_points_where_it_is_certain(variant):
    points, values = sample()
    model = fitted(points, values, variant=variant, growth=False).model
    np.testing.assert_allclose(model.predict(points), values, rtol=1e-7)
    assert np.max(model.deviation(points)) < 1e-4 * np.ptp(values)


def test_gradients_are_by_the_inputs_in_their_own_units():
    points, values = sample()
    model = on_terms(points, values, TERMS, length_scales=[0.6], correlation="matern-5/2")
    queries, _ = sample(15, 1)
    for function, gradient in ((model.predict, model.gradient), (model.deviation, model.deviation_gradient)):
        for k, step in enumerate(1e-4 * INPUTS.std):
            offset = step * np.eye(3)[k]
            slope = (function(queries + offset) - function(queries - offset)) / (2.0 * step)
            scale = np.ptp(values) / INPUTS.std[k]
            np.testing.assert_allclose(gradient(queries)[:, k] / scale, slope / scale, rtol=1e-5, atol=1e-6)


def test_the_conformance_suite_holds_for_the_optimal_variant():
    """Longer scales leave deviations of 1e-7 of that of the process, the root of rounding, with no slope to speak of."""
    settings = {"variant": "optimal", "correlation": "matern-5/2", "length_scale_bounds": [0.01, 2.0], "degree": 5}
    check_surrogate(PolynomialChaosKriging, settings)


def test_added_points_are_met_and_bring_a_new_search_only_every_so_often():
    points, values = sample(60)
    model = PolynomialChaosKriging.for_inputs(INPUTS, SurrogateParameters(refit_every=15))
    model.fit(points[:30], values[:30])
    first = model.fitted
    model.add(points[30:44], values[30:44])
    assert model.fitted is first
    np.testing.assert_allclose(model.predict(points[:44]), values[:44], rtol=1e-7)
    model.add(points[44:45], values[44:45])
    assert model.fitted is not first
    whole = PolynomialChaosKriging.for_inputs(INPUTS, SurrogateParameters())
    whole.fit(points[:45], values[:45])
    np.testing.assert_array_equal(model.predict(points), whole.predict(points))


def test_points_that_coincide_get_a_nugget_and_that_is_said():
    points, values = sample(30)
    twice, both = np.vstack([points, points[4:5]]), np.append(values, values[4])
    model = fitted(twice, both).model
    assert 0.0 < model.process.nugget_added < 1e-9
    np.testing.assert_allclose(model.predict(points), values, rtol=1e-6)


@VARIANTS
def test_a_constant_is_predicted_with_certainty(variant):
    points, _ = sample(20)
    found = fitted(points, np.full(20, 0.3), variant=variant)
    assert len(found.indices) == 1
    np.testing.assert_allclose(found.model.predict(sample(10, 1)[0]), 0.3)
    np.testing.assert_allclose(found.model.deviation(sample(10, 1)[0]), 0.0, atol=1e-12)
    assert found.model.process.errors == {"training": 0.0, "leave-one-out": 0.0}


def test_bad_input_is_refused():
    points, values = sample(20)
    model = PolynomialChaosKriging.for_inputs(INPUTS, SurrogateParameters())
    for method in (model.predict, model.gradient, model.deviation, model.deviation_gradient):
        with pytest.raises(SurrogateError, match="pck: the model is not fitted"):
            method(points)
    with pytest.raises(SurrogateError, match="pck: the model is not fitted"):
        model.add(points, values)
    with pytest.raises(SurrogateError, match=r"3 or more points are needed .*, received 2"):
        model.fit(points[:2], values[:2])
    with pytest.raises(SurrogateError, match="a trend of 20 functions needs 21 points or more, received 20"):
        on_terms(points, values, TERMS)
    with pytest.raises(SurrogateError, match=r"pck: points .*received shapes \(20, 2\) and \(20,\)"):
        model.fit(points[:, :2], values)
    values[3] = np.nan
    with pytest.raises(SurrogateError, match="pck: finite points and values"):
        model.fit(points, values)
    points[2, 0] = -1.0
    with pytest.raises(InputError, match="a: lognormal"):
        model.fit(points, np.arange(20.0))


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"variant": "best"}, "variant: allowed is 'sequential' or 'optimal'"),
        ({"norms": []}, "norms: one or more are needed"),
        ({"length_scale_bounds": [1.0, 0.1]}, "the shortest, then the longest is needed"),
        ({"length_scales": [0.1, 0.2]}, "length_scales: one or 3 are needed, received 2"),
        ({"degree": 0}, "degree: allowed is"),
    ],
)
def test_bad_settings_are_refused(settings, message):
    with pytest.raises(InputError, match=message):
        PolynomialChaosKriging.for_inputs(INPUTS, make_parameters(SurrogateParameters, settings, "pck"))


def test_a_dimension_of_nothing_is_refused():
    with pytest.raises(InputError, match="a dimension of 1 or more, received 0"):
        unit_cube(0)
