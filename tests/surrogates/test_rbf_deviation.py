"""Standard deviation, leave-one-out residuals and length scales of the interpolant against dense solves and refits."""

import numpy as np
import pytest
from scipy.spatial.distance import cdist

from railsearch.errors import InputError, SurrogateError
from railsearch_plugins.surrogates.rbf import RadialBasisFunctionInterpolant, RadialBasisFunctionParameters

KERNELS = ("cubic", "thin-plate", "linear")
PHI = {"cubic": lambda r: r**3, "thin-plate": lambda r: r**2 * np.log(np.where(r > 0.0, r, 1.0)), "linear": lambda r: r}
SIGN = {"cubic": 1.0, "thin-plate": 1.0, "linear": -1.0}


def fitted(points, values, kernel, scales=()):
    model = RadialBasisFunctionInterpolant(points.shape[1], RadialBasisFunctionParameters(kernel, length_scales=scales))
    model.fit(points, values)
    return model


def sample(n, dimension, seed=3):
    points = np.random.default_rng(seed).random((n, dimension))
    return points, np.sin(3.0 * points).sum(axis=1) + points[:, 0] * points[:, -1]


def dense_deviation(points, values, queries, kernel):
    """The square root of σ² s(φ(0) − uᵀA⁻¹u) from the full matrix."""

    def tail(x):
        return np.ones((len(x), 1)) if kernel == "linear" else np.column_stack([x, np.ones(len(x))])

    m = tail(points).shape[1]
    matrix = np.block([[np.zeros((m, m)), tail(points).T], [tail(points), PHI[kernel](cdist(points, points))]])
    weights = np.linalg.solve(matrix, np.concatenate([np.zeros(m), values]))[m:]
    rows = np.hstack([tail(queries), PHI[kernel](cdist(queries, points))])
    power = -SIGN[kernel] * np.sum(rows * np.linalg.solve(matrix, rows.T).T, axis=1)
    variance = SIGN[kernel] * values @ weights / (len(points) - m)
    return np.sqrt(np.maximum(power, 0.0) * variance)


@pytest.mark.parametrize("kernel", KERNELS)
def test_deviation_is_that_of_the_dense_system(kernel):
    points, values = sample(40, 3)
    queries = np.random.default_rng(8).random((25, 3))
    expected = dense_deviation(points, values, queries, kernel)
    assert expected.min() > 1e-3
    np.testing.assert_allclose(fitted(points, values, kernel).deviation(queries), expected, rtol=1e-8)


@pytest.mark.parametrize("kernel", KERNELS)
def test_deviation_vanishes_at_the_points_and_grows_away_from_them(kernel):
    points, values = sample(30, 2)
    model = fitted(points[:25], values[:25], kernel)
    before = model.deviation(points)
    model.add(points[25:], values[25:])
    assert np.max(model.deviation(points)) < 1e-6
    assert np.min(before[25:]) > 1e-4


@pytest.mark.parametrize("kernel", KERNELS)
def test_deviation_does_not_see_the_order_of_the_points(kernel):
    points, values = sample(30, 3)
    queries = np.random.default_rng(1).random((9, 3))
    backwards = fitted(points[::-1], values[::-1], kernel)
    np.testing.assert_allclose(fitted(points, values, kernel).deviation(queries), backwards.deviation(queries), rtol=1e-7)


def test_as_many_points_as_tail_functions_tell_no_deviation():
    points = np.vstack([np.zeros(2), np.eye(2)])
    model = fitted(points, np.array([0.0, 1.0, 2.0]), "cubic")
    assert np.all(model.deviation(np.array([[0.3, 0.4]])) == 0.0)
    with pytest.raises(SurrogateError, match="more than the 3 points"):
        model.leave_one_out_residuals()


def test_a_point_that_alone_leaves_a_plane_cannot_be_left_out():
    points, values = sample(9, 3)
    points[:-1, 2] = 0.25
    with pytest.raises(SurrogateError, match="without one of the points"):
        fitted(points, values, "cubic").leave_one_out_residuals()


@pytest.mark.parametrize("kernel", KERNELS)
def test_leave_one_out_residuals_are_those_of_refits(kernel):
    points, values = sample(25, 3)
    model = fitted(points[:20], values[:20], kernel)
    model.add(points[20:], values[20:])
    keep = [np.delete(np.arange(25), k) for k in range(25)]
    refitted = [fitted(points[rows], values[rows], kernel).predict(points[k : k + 1])[0] for k, rows in enumerate(keep)]
    np.testing.assert_allclose(model.leave_one_out_residuals(), values - np.array(refitted), atol=1e-9)


@pytest.mark.parametrize("kernel", KERNELS)
def test_length_scales_are_those_of_points_divided_by_them(kernel):
    points, values = sample(40, 3)
    scales = np.array([0.5, 1.0, 2.0])
    queries = np.random.default_rng(2).random((9, 3))
    scaled = fitted(points, values, kernel, (0.5, 1.0, 2.0))
    plain = fitted(points / scales, values, kernel)
    np.testing.assert_allclose(scaled.predict(queries), plain.predict(queries / scales), rtol=1e-9)
    np.testing.assert_allclose(scaled.gradient(queries), plain.gradient(queries / scales) / scales, rtol=1e-8)
    np.testing.assert_allclose(scaled.deviation(queries), plain.deviation(queries / scales), rtol=1e-7)
    expected = plain.deviation_gradient(queries / scales) / scales
    np.testing.assert_allclose(scaled.deviation_gradient(queries), expected, rtol=1e-6)


@pytest.mark.parametrize("kernel", KERNELS)
def test_gradient_of_the_deviation_is_that_of_finite_differences(kernel):
    points, values = sample(40, 3)
    model = fitted(points, values, kernel, (0.7, 1.0, 1.5))
    queries, step = np.random.default_rng(5).random((6, 3)), 1e-6
    moved = [(model.deviation(queries + step * e) - model.deviation(queries - step * e)) / (2.0 * step) for e in np.eye(3)]
    np.testing.assert_allclose(model.deviation_gradient(queries), np.column_stack(moved), rtol=1e-4, atol=1e-6)


def test_wrong_number_of_length_scales_is_refused():
    with pytest.raises(InputError, match="length_scales needs 3 numbers, one by variable, received 2"):
        RadialBasisFunctionInterpolant(3, RadialBasisFunctionParameters(length_scales=(1.0, 2.0)))
