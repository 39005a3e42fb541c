"""The radial basis function interpolant against a dense solve of the full system, theory and finite differences."""

import numpy as np
import pytest
import scipy.linalg
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.distance import cdist

from railsearch.errors import InputError, SurrogateError
from railsearch.parameters import make_parameters
from railsearch_plugins.surrogates import rbf
from railsearch_plugins.surrogates.rbf import RadialBasisFunctionInterpolant, RadialBasisFunctionParameters

KERNELS = ("cubic", "thin-plate", "linear")


def made(dimension, kernel="cubic", cap=False):
    values = {"kernel": kernel, "cap_above_median": cap}
    return RadialBasisFunctionInterpolant(dimension, make_parameters(RadialBasisFunctionParameters, values, "rbf"))


def fitted(points, values, kernel="cubic", cap=False):
    model = made(points.shape[1], kernel, cap)
    model.fit(points, values)
    return model


class DenseTwin:
    """The interpolant as its definition says: the full system [[Φ, P], [Pᵀ, 0]] [λ; β] = [f; 0] solved at once."""

    def __init__(self, points, values, kernel):
        self.points, self.kernel = points, kernel
        tail = self.tail(points)
        m = tail.shape[1]
        matrix = np.block([[self.phi(points), tail], [tail.T, np.zeros((m, m))]])
        self.solution = np.linalg.solve(matrix, np.concatenate([values, np.zeros(m)]))

    def tail(self, points):
        ones = np.ones((len(points), 1))
        return ones if self.kernel == "linear" else np.hstack([points, ones])

    def phi(self, points):
        r = cdist(points, self.points)
        if self.kernel == "thin-plate":
            return np.where(r > 0.0, r**2 * np.log(np.where(r > 0.0, r, 1.0)), 0.0)
        return r**3 if self.kernel == "cubic" else r

    def predict(self, points):
        return np.hstack([self.phi(points), self.tail(points)]) @ self.solution


def smooth(points):
    return np.sin(4.0 * points).sum(axis=1) + points[:, 0] * points[:, -1]


def sample(n, dimension, seed=0):
    points = np.random.default_rng(seed).random((n, dimension))
    return points, smooth(points)


@pytest.mark.parametrize("kernel", KERNELS)
@pytest.mark.parametrize("dimension", [1, 3, 8])
def test_passes_through_every_point(kernel, dimension):
    points, values = sample(60, dimension)
    np.testing.assert_allclose(fitted(points, values, kernel).predict(points), values, atol=1e-9)


@settings(deadline=None, max_examples=40)
@given(st.sampled_from(KERNELS), st.integers(1, 5), st.integers(0, 20), st.integers(1, 20), st.integers(0, 2**32))
def test_points_added_one_by_one_and_in_blocks_equal_the_dense_solve(kernel, dimension, first, later, seed):
    generator = np.random.default_rng(seed)
    count = dimension + 1 + first + later
    levels = generator.permuted(np.tile(np.arange(count)[:, None], dimension), axis=0)
    points = (levels + generator.uniform(0.375, 0.625, levels.shape)) / count  # apart from one another
    values, queries = generator.standard_normal(len(points)), generator.random((10, dimension))
    start = dimension + 1 + first
    model = fitted(points[:start], values[:start], kernel)
    middle = start + later // 2
    model.add(points[start:middle], values[start:middle])
    for k in range(middle, len(points)):
        model.add(points[k : k + 1], values[k : k + 1])
    twin = DenseTwin(points, values, kernel)
    scale = np.max(np.abs(twin.solution))
    np.testing.assert_allclose(model.predict(queries), twin.predict(queries), atol=1e-10 * scale)


@pytest.mark.parametrize("kernel", KERNELS)
def test_gradient_agrees_with_central_differences(kernel):
    points, values = sample(50, 4)
    model, queries, step = fitted(points, values, kernel), np.random.default_rng(5).random((20, 4)), 1e-6
    slopes = [(model.predict(queries + h) - model.predict(queries - h)) / (2.0 * step) for h in step * np.eye(4)]
    np.testing.assert_allclose(model.gradient(queries), np.transpose(slopes), atol=1e-6)


@pytest.mark.parametrize("kernel", KERNELS)
def test_gradient_is_finite_at_the_points_themselves(kernel):
    points, values = sample(30, 3)
    assert np.isfinite(fitted(points, values, kernel).gradient(points)).all()


@pytest.mark.parametrize("kernel", ["cubic", "thin-plate"])
@given(seed=st.integers(0, 2**32))
def test_a_linear_polynomial_is_reproduced_everywhere(kernel, seed):
    generator = np.random.default_rng(seed)
    points, slope = generator.random((15, 3)), generator.uniform(-100.0, 100.0, 3)
    queries = generator.uniform(-1.0, 2.0, (20, 3))
    model = fitted(points, points @ slope + 7.0, kernel)
    np.testing.assert_allclose(model.predict(queries), queries @ slope + 7.0, rtol=1e-7, atol=1e-6)
    np.testing.assert_allclose(model.gradient(queries), np.tile(slope, (20, 1)), rtol=1e-6, atol=1e-6)


def test_the_linear_kernel_reproduces_a_constant_and_needs_one_point():
    model = fitted(np.array([[0.3, 0.4]]), np.array([5.0]), "linear")
    np.testing.assert_allclose(model.predict(np.random.default_rng(0).random((5, 2))), 5.0)
    model.add(np.array([[0.9, 0.1]]), np.array([5.0]))
    np.testing.assert_allclose(model.predict(np.random.default_rng(1).random((5, 2))), 5.0)


def test_in_one_variable_the_cubic_interpolant_is_the_natural_cubic_spline():
    from scipy.interpolate import CubicSpline

    points, values = sample(12, 1, seed=3)
    order = np.argsort(points[:, 0])
    spline = CubicSpline(points[order, 0], values[order], bc_type="natural")
    queries = np.linspace(points.min(), points.max(), 101)
    np.testing.assert_allclose(fitted(points, values).predict(queries[:, None]), spline(queries), atol=1e-10)


def test_error_falls_with_the_point_distance_at_the_rate_of_the_cubic_spline():
    def error(n):
        points = np.linspace(0.0, 1.0, n)[:, None]
        inside = np.linspace(0.4, 0.6, 500)[:, None]
        return np.max(np.abs(fitted(points, smooth(points)).predict(inside) - smooth(inside)))

    rate = np.log2(error(21) / error(41))
    assert rate == pytest.approx(4.0, abs=0.2)


def test_an_added_point_costs_no_factorisation_of_the_whole(monkeypatch):
    points, values = sample(200, 5)
    model = fitted(points[:50], values[:50])
    sizes = []
    real_cholesky = scipy.linalg.cholesky

    def watched_cholesky(matrix, lower):
        sizes.append(len(matrix))
        return real_cholesky(matrix, lower=lower)

    def refused(*arguments, **settings):
        raise AssertionError("the leading block was factorised again")

    monkeypatch.setattr(rbf, "cholesky", watched_cholesky)
    monkeypatch.setattr(rbf, "lu_factor", refused)
    monkeypatch.setattr(rbf, "unisolvent_first", refused)
    allocations, storage = 0, model._factor
    for k in range(50, 200):
        model.add(points[k : k + 1], values[k : k + 1])
        allocations, storage = allocations + (model._factor is not storage), model._factor
    assert sizes == [1] * 150
    assert allocations <= np.ceil(np.log2(200 / 44))
    np.testing.assert_allclose(model.predict(points), values, atol=1e-9)


def test_capping_replaces_what_lies_above_the_median_also_when_the_median_moves():
    points, values = sample(41, 3)
    model = fitted(points[:20], values[:20], cap=True)
    for k in range(20, 41):
        model.add(points[k : k + 1], values[k : k + 1])
        so_far = values[: k + 1]
        np.testing.assert_allclose(model.predict(points[: k + 1]), np.minimum(so_far, np.median(so_far)), atol=1e-10)


def test_four_hundred_points_with_integers_in_eight_dimensions():
    generator = np.random.default_rng(2)
    points = generator.random((3000, 8))
    points[:, 4:] = np.round(points[:, 4:] * [1, 3, 9, 40]) / [1, 3, 9, 40]
    points = np.unique(points, axis=0)[generator.permutation(3000)[:400]]
    clustered = np.clip(points[0] + 2e-3 * generator.standard_normal((40, 8)) * ([1] * 4 + [0] * 4), 0.0, 1.0)
    points = np.vstack([points[:360], clustered])
    values = smooth(points)
    model = fitted(points[:20], values[:20])
    for k in range(20, 400):
        model.add(points[k : k + 1], values[k : k + 1])
    np.testing.assert_allclose(model.predict(points), values, atol=1e-7)
    queries = generator.random((50, 8))
    np.testing.assert_allclose(model.predict(queries), DenseTwin(points, values, "cubic").predict(queries), atol=1e-7)


def test_too_few_points_and_points_on_a_plane_are_named():
    points, values = sample(20, 3)
    with pytest.raises(SurrogateError, match=r"4 affinely independent points .* received 3 points of rank 3: add 1 or more"):
        made(3).fit(points[:3], values[:3])
    points[:, 2] = 0.5 - 0.3 * points[:, 0]
    with pytest.raises(
        SurrogateError, match=r"received 20 points of rank 3: add 1 or more points off their common hyperplane"
    ):
        made(3).fit(points, values)
    with pytest.raises(SurrogateError, match="received 0 points of rank 0"):
        made(3).fit(np.empty((0, 3)), np.empty(0))


@pytest.mark.parametrize("distance", [0.0, 1e-8])
def test_duplicates_are_refused_and_leave_the_model_as_it_was(distance):
    points, values = sample(20, 3)
    model = fitted(points, values)
    near = points[7] + [distance, 0.0, 0.0]
    before = model.predict(points)
    with pytest.raises(SurrogateError, match="apart in the unit cube; at least 1e-06 is needed, leave one of them out"):
        model.add(near[None, :], values[:1])
    np.testing.assert_array_equal(model.predict(points), before)
    with pytest.raises(SurrogateError, match="leave one of them out"):
        model.fit(np.vstack([points, near]), np.append(values, 1.0))
    with pytest.raises(SurrogateError, match="not fitted"):
        model.predict(points)


def test_bad_input_is_refused():
    points, values = sample(20, 3)
    model = made(3)
    for method in (model.predict, model.gradient):
        with pytest.raises(SurrogateError, match="not fitted"):
            method(points)
    with pytest.raises(SurrogateError, match="not fitted"):
        model.add(points, values)
    with pytest.raises(SurrogateError, match=r"received shapes \(20, 2\) and \(20,\)"):
        model.fit(points[:, :2], values)
    values[3] = np.nan
    with pytest.raises(SurrogateError, match="finite points and values"):
        model.fit(points, values)
    with pytest.raises(InputError, match="'cubic' or 'thin-plate' or 'linear'"):
        made(3, "gaussian")
