"""Surrogate `rbf`: radial basis function interpolant with a polynomial tail.

| symbol | meaning | shape | unit | source |
|---|---|---|---|---|
| X | points of the unit cube | (n, d) | - | |
| f | values at the points, capped if wished | (n,) | of f | Björkman and Holmström 2000 |
| φ | kernel: r³, r² log r or r | - | - | Powell 1992 |
| P | tail basis at the points, rows [xᵀ 1], or [1] for the linear kernel | (n, m) | - | Powell 1992 |
| λ, β | coefficients of the kernels and of the tail | (n,), (m,) | of f | |
| X₀, P₀, Φ₀ | m points that determine the tail, and P, Φ there | (m, ·) | - | |
| A₀ | leading block [[0, P₀ᵀ], [P₀, Φ₀]] | (2m, 2m) | - | |
| B | the rows [P Φ(·, X₀)] of the remaining points | (n − m, 2m) | - | |
| S | Schur complement s (Φ − B A₀⁻¹ Bᵀ), s the sign of the kernel | (n − m, n − m) | - | |
| L | Cholesky factor of S | (n − m, n − m) | - | |

The interpolant f̂(x) = Σ_k λ_k φ(‖x − x_k‖) + βᵀ p(x) solves [[Φ, P], [Pᵀ, 0]] [λ; β] = [f; 0]. With the tail and m
unisolvent points eliminated first, what is left is S, positive definite because s φ is conditionally positive definite of
the order of the tail. So a point more is a row more of L, at O(n²), and changed values cost two triangular solves.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgError, cholesky, lu_factor, lu_solve, qr, solve_triangular
from scipy.spatial.distance import cdist

from railsearch.errors import SurrogateError
from railsearch.hookspecs import Register, hookimpl
from railsearch.interfaces import parameter
from railsearch.space import FloatArray

CLOSEST = 1e-6
"""Points nearer to one another than this (unit cube) are duplicates: double precision cannot tell their kernels apart."""

UNISOLVENCE_TOLERANCE = 1e-8
"""Diagonal entries of the pivoted triangular factor of P below this fraction of the first count as zero."""


@dataclass(frozen=True)
class RadialBasisFunctionParameters:
    """What can be set of the interpolant."""

    kernel: str = parameter(
        "cubic",
        meaning="kernel; cubic and thin-plate carry a linear tail, linear a constant one",
        source="Regis & Shoemaker 2007",
        choices=("cubic", "thin-plate", "linear"),
    )
    cap_above_median: bool = parameter(
        False,
        meaning="replace values above the median by the median before the fit",
        source="Björkman & Holmström 2000",
    )


class RadialBasisFunctionInterpolant:
    """Radial basis functions with a polynomial tail, through every point; adding one costs O(n²)."""

    Parameters = RadialBasisFunctionParameters

    def __init__(self, dimension: int, parameters: RadialBasisFunctionParameters) -> None:
        self._dimension = dimension
        self._parameters = parameters
        self._tail_size = 1 if parameters.kernel == "linear" else dimension + 1
        self._sign = -1.0 if parameters.kernel == "linear" else 1.0
        self._points = np.empty((0, dimension))
        self._values = np.empty(0)

    def fit(self, points: FloatArray, values: FloatArray) -> None:
        """Fit to points X (n, d) of the unit cube with values f (n,).

        Raises SurrogateError for points of the wrong shape, too few or on a common hyperplane, nearer than 1e-6 to one
        another, or values that are not finite.
        """
        points, values = self._checked(points, values)
        order = _unisolvent_first(self._tail(points))
        leading, rest = order[: self._tail_size], order[self._tail_size :]
        self._start(points[leading], values[leading])
        try:
            self._extend(points[rest], values[rest])
        except SurrogateError:
            self._points = np.empty((0, self._dimension))
            raise

    def add(self, points: FloatArray, values: FloatArray) -> None:
        """Add points (k, d) with values (k,) to a fitted interpolant at O(k n²). Raises SurrogateError as `fit`."""
        self._check_fitted()
        self._extend(*self._checked(points, values))

    def predict(self, points: FloatArray) -> FloatArray:
        """The interpolant f̂ (k,) at points (k, d)."""
        self._check_fitted()
        points = np.atleast_2d(points)
        kernels: FloatArray = self._kernel(cdist(points, self._points))
        predicted: FloatArray = kernels @ self._weights + self._tail(points) @ self._coefficients
        return predicted

    def gradient(self, points: FloatArray) -> FloatArray:
        """The derivatives (k, d) of f̂ at points (k, d): Σ_k λ_k φ′(r)/r (x − x_k) + b; kinks of a kernel give zero."""
        self._check_fitted()
        points = np.atleast_2d(points)
        slopes = self._kernel_slope(cdist(points, self._points)) * self._weights
        gradient: FloatArray = slopes.sum(axis=1, keepdims=True) * points - slopes @ self._points
        return gradient + (self._coefficients[:-1] if self._tail_size > 1 else 0.0)

    def _start(self, points: FloatArray, values: FloatArray) -> None:
        """Factorise the leading block A₀ of the m points that determine the tail."""
        m = self._tail_size
        block = np.zeros((2 * m, 2 * m))
        block[m:, :m] = self._tail(points)
        block[:m, m:] = block[m:, :m].T
        block[m:, m:] = self._kernel(cdist(points, points))
        self._leading = lu_factor(block)
        self._points, self._values = points, values
        self._factor = np.empty((0, 0))
        self._rows = np.empty((0, 2 * m))
        self._solve()

    def _extend(self, points: FloatArray, values: FloatArray) -> None:
        """Append rows to B and to the Cholesky factor L of the Schur complement S; nothing is changed if that fails."""
        if not len(points):
            return
        self._check_distances(points)
        m, size, total = self._tail_size, len(self._rows), len(self._rows) + len(points)
        rows = np.hstack([self._tail(points), self._kernel(cdist(points, self._points[:m]))])
        projected = lu_solve(self._leading, rows.T)
        cross = self._sign * (self._kernel(cdist(self._points[m:], points)) - self._rows @ projected)
        corner = self._sign * (self._kernel(cdist(points, points)) - rows @ projected)
        below = solve_triangular(self._factor[:size, :size], cross, lower=True).T if size else cross.T
        try:
            last = cholesky(corner - below @ below.T, lower=True)
        except LinAlgError:
            raise SurrogateError(
                f"rbf: the points lie too close together: adding {len(points)} to {len(self._points)} leaves no positive "
                "definite system in double precision; leave out near duplicates"
            ) from None
        self._grow(total)
        self._factor[size:total, :size] = below
        self._factor[size:total, size:total] = last
        self._rows = np.vstack([self._rows, rows])
        self._points = np.vstack([self._points, points])
        self._values = np.concatenate([self._values, values])
        self._solve()

    def _grow(self, total: int) -> None:
        """Make room for `total` rows of L, twice as much as before, so that copying is amortised."""
        if total > len(self._factor):
            old = self._factor
            self._factor = np.zeros((max(total, 2 * len(old)),) * 2)
            self._factor[: len(old), : len(old)] = old

    def _solve(self) -> None:
        """The coefficients λ, β for the present values, by two triangular solves."""
        m, size = self._tail_size, len(self._rows)
        values = self._fitted_values()
        leading = np.concatenate([np.zeros(m), values[:m]])
        rest = np.empty(0)
        if size:
            factor = self._factor[:size, :size]
            reduced = self._sign * (values[m:] - self._rows @ lu_solve(self._leading, leading))
            half = solve_triangular(factor, reduced, lower=True)
            rest = solve_triangular(factor, half, lower=True, trans="T")
        first = lu_solve(self._leading, leading - self._rows.T @ rest)
        self._coefficients = first[:m]
        self._weights = np.concatenate([first[m:], rest])

    def _fitted_values(self) -> FloatArray:
        if not self._parameters.cap_above_median:
            return self._values
        return np.minimum(self._values, np.median(self._values))

    def _tail(self, points: FloatArray) -> FloatArray:
        ones = np.ones((len(points), 1))
        return ones if self._tail_size == 1 else np.hstack([points, ones])

    def _kernel(self, distances: FloatArray) -> FloatArray:
        """φ(r)."""
        if self._parameters.kernel == "cubic":
            return distances * distances * distances
        if self._parameters.kernel == "thin-plate":
            return distances * distances * np.log(distances, out=np.zeros_like(distances), where=distances > 0.0)
        return distances

    def _kernel_slope(self, distances: FloatArray) -> FloatArray:
        """φ′(r)/r."""
        if self._parameters.kernel == "cubic":
            return 3.0 * distances
        apart = distances > 0.0
        if self._parameters.kernel == "thin-plate":
            return np.where(apart, 2.0 * np.log(distances, out=np.zeros_like(distances), where=apart) + 1.0, 0.0)
        return np.divide(1.0, distances, out=np.zeros_like(distances), where=apart)

    def _check_fitted(self) -> None:
        if not len(self._points):
            raise SurrogateError("rbf: the interpolant is not fitted; call fit with the first points")

    def _checked(self, points: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
        points, values = np.array(points, dtype=float), np.array(values, dtype=float)
        if points.ndim != 2 or points.shape[1] != self._dimension or values.shape != (len(points),):
            raise SurrogateError(
                f"rbf: points (n, {self._dimension}) and values (n,) are needed, received shapes {points.shape} and "
                f"{values.shape}"
            )
        if not (np.isfinite(points).all() and np.isfinite(values).all()):
            raise SurrogateError("rbf: finite points and values are needed; leave failed evaluations out of the fit")
        return points, values

    def _check_distances(self, points: FloatArray) -> None:
        everything = np.vstack([self._points, points])
        distances = cdist(points, everything)
        distances[np.arange(len(points)), len(self._points) + np.arange(len(points))] = np.inf
        new, old = np.unravel_index(np.argmin(distances), distances.shape)
        if distances[new, old] < CLOSEST:
            raise SurrogateError(
                f"rbf: the points {points[new].tolist()} and {everything[old].tolist()} are {distances[new, old]:.1e} apart "
                f"in the unit cube; at least {CLOSEST:g} is needed, leave one of them out"
            )


def _unisolvent_first(tail: FloatArray) -> NDArray[np.intp]:
    """An order of the points whose first m determine the tail P (n, m). Raises SurrogateError if none do."""
    m = tail.shape[1]
    triangle, order = qr(tail.T, mode="r", pivoting=True) if len(tail) else (np.empty((m, 0)), np.empty(0, dtype=int))
    pivots = np.abs(np.diagonal(triangle))
    rank = int(np.sum(pivots > UNISOLVENCE_TOLERANCE * pivots[:1]))
    if rank < m:
        raise SurrogateError(
            f"rbf: {m} affinely independent points are needed to determine the tail, received {len(tail)} points of rank "
            f"{rank}: add {m - rank} or more points off their common hyperplane"
        )
    return np.concatenate([order[:m], np.sort(order[m:])])


@hookimpl
def railsearch_surrogates(register: Register) -> None:
    """Register `rbf`."""
    register("rbf", RadialBasisFunctionInterpolant)
