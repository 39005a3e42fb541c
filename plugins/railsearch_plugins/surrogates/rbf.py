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
| A | the whole matrix [[0, Pᵀ], [P, Φ]] | (n + m, n + m) | - | |
| u | [p(x); φ(‖x − x_k‖)] at a point x | (n + m,) | - | Gutmann 2001 |
| σ² | s fᵀλ/(n − m) | scalar | of f² | Gutmann 2001 |
| ℓ | length scales: φ sees the points divided by them, the tail does not | (d,) | - | |

The interpolant f̂(x) = Σ_k λ_k φ(‖x − x_k‖) + βᵀ p(x) solves [[Φ, P], [Pᵀ, 0]] [λ; β] = [f; 0]. With the tail and m
unisolvent points eliminated first, what is left is S, positive definite because s φ is conditionally positive definite of
the order of the tail. So a point more is a row more of L, at O(n²), and changed values cost two triangular solves. The same
factors give the power function s(φ(0) − uᵀA⁻¹u), which times σ² is the variance of the process behind the interpolant.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import LinAlgError, cholesky, lu_factor, lu_solve, solve_triangular
from scipy.spatial.distance import cdist

from railsearch.errors import InputError, SurrogateError
from railsearch.hookspecs import Register, hookimpl
from railsearch.interfaces import parameter
from railsearch.space import FloatArray

from ..radial_basis.kernels import KERNELS, unisolvent_first
from ..surrogate_data import checked_data

CLOSEST = 1e-6
"""Points nearer to one another than this (unit cube) are duplicates: double precision cannot tell their kernels apart."""


@dataclass(frozen=True)
class RadialBasisFunctionParameters:
    """What can be set of the interpolant."""

    kernel: str = parameter(
        "cubic",
        meaning="kernel; cubic and thin-plate carry a linear tail, linear a constant one",
        source="Regis & Shoemaker 2007",
        choices=tuple(KERNELS),
    )
    cap_above_median: bool = parameter(
        False,
        meaning="replace values above the median by the median before the fit",
        source="Björkman & Holmström 2000",
    )
    length_scales: tuple[float, ...] = parameter(
        (),
        meaning="by how much the kernel shrinks each variable, the tail none; if empty, 1 for all",
        source="own choice: Regis & Shoemaker 2013 leave the unit cube as it is",
        above=0.0,
    )


class RadialBasisFunctionInterpolant:
    """Radial basis functions with a polynomial tail, through every point; adding one costs O(n²)."""

    Parameters = RadialBasisFunctionParameters

    def __init__(self, dimension: int, parameters: RadialBasisFunctionParameters) -> None:
        scales = parameters.length_scales or (1.0,) * dimension
        if len(scales) != dimension:
            raise InputError(f"rbf: length_scales needs {dimension} numbers, one by variable, received {len(scales)}")
        self._dimension = dimension
        self._parameters = parameters
        self._kernel = KERNELS[parameters.kernel]
        self._tail_size = self._kernel.tail_size(dimension)
        self._scales = np.array(scales)
        self._points = np.empty((0, dimension))
        self._values = np.empty(0)
        self._order = np.empty(0, dtype=np.intp)

    def fit(self, points: FloatArray, values: FloatArray) -> None:
        """Fit to points X (n, d) of the unit cube with values f (n,).

        Raises SurrogateError for points of the wrong shape, too few or on a common hyperplane, nearer than 1e-6 to one
        another, or values that are not finite.
        """
        points, values = checked_data("rbf", self._dimension, points, values)
        order = unisolvent_first(self._kernel.tail(points))
        leading, rest = order[: self._tail_size], order[self._tail_size :]
        self._order = order
        self._start(points[leading], values[leading])
        try:
            self._extend(points[rest], values[rest])
        except SurrogateError:
            self._points = np.empty((0, self._dimension))
            raise

    def add(self, points: FloatArray, values: FloatArray) -> None:
        """Add points (k, d) with values (k,) to a fitted interpolant at O(k n²). Raises SurrogateError as `fit`."""
        self._check_fitted()
        self._extend(*checked_data("rbf", self._dimension, points, values))
        self._order = np.append(self._order, np.arange(len(self._order), len(self._points)))

    def predict(self, points: FloatArray) -> FloatArray:
        """The interpolant f̂ (k,) at points (k, d)."""
        self._check_fitted()
        points = np.atleast_2d(points)
        predicted: FloatArray = self._kernels(points, self._points) @ self._weights
        predicted += self._kernel.tail(points) @ self._coefficients
        return predicted

    def gradient(self, points: FloatArray) -> FloatArray:
        """The derivatives (k, d) of f̂ at points (k, d): Σ_k λ_k φ′(r)/r (x − x_k)/ℓ² + b; kinks of a kernel give zero."""
        self._check_fitted()
        return self._gradient(np.atleast_2d(points), self._weights, self._coefficients[None, :])

    def predict_with_gradient(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """What `predict` and `gradient` give at points (k, d), to the last bit, for little more than one of them."""
        self._check_fitted()
        points = np.atleast_2d(points)
        distances = cdist(points / self._scales, self._points / self._scales)
        predicted: FloatArray = self._kernel.value(distances) @ self._weights
        predicted += self._kernel.tail(points) @ self._coefficients
        return predicted, self._slopes(points, distances, self._weights, self._coefficients[None, :])

    def deviation(self, points: FloatArray) -> FloatArray:
        """Standard deviations (k,) at points (k, d): the square root of σ² s(φ(0) − uᵀA⁻¹u), zero at the points of the fit.

        With as many points as tail functions there is nothing to tell σ² from, and all are zero.
        Source: Gutmann 2001, Björkman and Holmström 2000 for the power function.
        """
        self._check_fitted()
        share, _, _ = self._power(np.atleast_2d(points))
        deviation: FloatArray = np.sqrt(self._variance() * share)
        return deviation

    def deviation_gradient(self, points: FloatArray) -> FloatArray:
        """The derivatives (k, d) of the standard deviation at points (k, d); zero where it is zero, which is a kink."""
        self._check_fitted()
        points, m = np.atleast_2d(points), self._tail_size
        share, first, half = self._power(points)
        last = np.empty((0, len(points)))
        if len(self._rows):
            last = solve_triangular(self._triangle(), half, lower=True, trans="T")
        leading = lu_solve(self._leading, self._rows.T @ last) - self._kernel.sign * first
        slope = self._gradient(points, np.vstack([leading[m:], -last]).T, leading[:m].T)
        root = np.sqrt(share)[:, None]
        gradient: FloatArray = np.divide(slope, root, out=np.zeros_like(slope), where=root > 0.0)
        gradient *= np.sqrt(self._variance())
        return gradient

    def leave_one_out_residuals(self) -> FloatArray:
        """Residuals (n,) in the order of the points: each value less the interpolant of the others, λ_k/(A⁻¹)_kk.

        Raises SurrogateError where a point cannot be spared: with as many points as tail functions, or where the others
        determine no tail. Source: Rippa 1999.
        """
        self._check_fitted()
        m, size = self._tail_size, len(self._rows)
        if not size:
            raise SurrogateError(f"rbf: leaving one out needs more than the {m} points that determine the tail")
        inverse = solve_triangular(self._triangle(), np.eye(size), lower=True)
        block = lu_solve(self._leading, np.eye(2 * m))
        leading = np.diagonal(block) + self._kernel.sign * np.sum((inverse @ self._rows @ block) ** 2, axis=0)
        diagonal = np.concatenate([leading[m:], self._kernel.sign * np.sum(inverse**2, axis=0)])
        if not (self._kernel.sign * diagonal > np.finfo(float).eps * np.abs(diagonal).max()).all():
            raise SurrogateError(f"rbf: without one of the points the others do not determine the {m} tail functions")
        residuals = np.empty(len(self._points))
        residuals[self._order] = self._weights / diagonal
        return residuals

    def _start(self, points: FloatArray, values: FloatArray) -> None:
        """Factorise the leading block A₀ of the m points that determine the tail."""
        m = self._tail_size
        block = np.zeros((2 * m, 2 * m))
        block[m:, :m] = self._kernel.tail(points)
        block[:m, m:] = block[m:, :m].T
        block[m:, m:] = self._kernels(points, points)
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
        rows = np.hstack([self._kernel.tail(points), self._kernels(points, self._points[:m])])
        projected = lu_solve(self._leading, rows.T)
        cross = self._kernel.sign * (self._kernels(self._points[m:], points) - self._rows @ projected)
        corner = self._kernel.sign * (self._kernels(points, points) - rows @ projected)
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
            reduced = self._kernel.sign * (values[m:] - self._rows @ lu_solve(self._leading, leading))
            half = solve_triangular(factor, reduced, lower=True)
            rest = solve_triangular(factor, half, lower=True, trans="T")
        first = lu_solve(self._leading, leading - self._rows.T @ rest)
        self._coefficients = first[:m]
        self._weights = np.concatenate([first[m:], rest])

    def _fitted_values(self) -> FloatArray:
        if not self._parameters.cap_above_median:
            return self._values
        return np.minimum(self._values, np.median(self._values))

    def _triangle(self) -> FloatArray:
        """L (n − m, n − m)."""
        size = len(self._rows)
        triangle: FloatArray = self._factor[:size, :size]
        return triangle

    def _variance(self) -> float:
        """σ²."""
        free = max(len(self._rows), 1)
        return max(self._kernel.sign * float(self._fitted_values() @ self._weights) / free, 0.0)

    def _power(self, points: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """s(φ(0) − uᵀA⁻¹u) (k,) at points (k, d), A₀⁻¹u₀ (2m, k), and L⁻¹ of what the leading points leave (n − m, k)."""
        m = self._tail_size
        leading = np.hstack([self._kernel.tail(points), self._kernels(points, self._points[:m])]).T
        first = lu_solve(self._leading, leading)
        half = np.empty((0, len(points)))
        if len(self._rows):
            rest = self._kernels(self._points[m:], points) - self._rows @ first
            half = solve_triangular(self._triangle(), rest, lower=True)
        share = -self._kernel.sign * np.sum(leading * first, axis=0) - np.sum(half * half, axis=0)
        return np.maximum(share, 0.0), first, half

    def _kernels(self, points: FloatArray, others: FloatArray) -> FloatArray:
        """φ (k, j) between points (k, d) and others (j, d)."""
        return self._kernel.value(cdist(points / self._scales, others / self._scales))

    def _gradient(self, points: FloatArray, weights: FloatArray, coefficients: FloatArray) -> FloatArray:
        """Derivatives (k, d) of Σ_j w_j φ_j + cᵀ p with weights w (n,) or (k, n) and coefficients c (1, m) or (k, m)."""
        distances = cdist(points / self._scales, self._points / self._scales)
        return self._slopes(points, distances, weights, coefficients)

    def _slopes(
        self, points: FloatArray, distances: FloatArray, weights: FloatArray, coefficients: FloatArray
    ) -> FloatArray:
        """The same with the scaled distances (k, n) to the points of the fit at hand."""
        slopes = self._kernel.slope(distances) * weights
        gradient: FloatArray = (slopes.sum(axis=1, keepdims=True) * points - slopes @ self._points) / self._scales**2
        return gradient + (coefficients[:, :-1] if self._kernel.linear_tail else 0.0)

    def _check_fitted(self) -> None:
        if not len(self._points):
            raise SurrogateError("rbf: the interpolant is not fitted; call fit with the first points")

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


@hookimpl
def railsearch_surrogates(register: Register) -> None:
    """Register `rbf`."""
    register("rbf", RadialBasisFunctionInterpolant)
