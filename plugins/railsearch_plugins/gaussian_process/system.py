"""The Kriging equations at given length scales.

| symbol | meaning | shape | unit | source |
|---|---|---|---|---|
| X, y | points of the unit cube, standardised values | (n, d), (n,) | - | |
| F | trend functions at the points | (n, p) | - | Sacks et al. 1989 |
| ν | nugget, in units of the process variance | scalar | - | |
| R | correlation matrix of the points, + ν on its diagonal | (n, n) | - | |
| L | Cholesky factor of R | (n, n) | - | |
| G = Q₁S | L⁻¹F and its orthogonal triangular factors | (n, p), (p, p) | - | |
| β | trend coefficients by generalised least squares | (p,) | - | Sacks et al. 1989 |
| ε | L⁻¹(y − Fβ) | (n,) | - | |
| α | R⁻¹(y − Fβ) = Qy | (n,) | - | |
| Q | R⁻¹ − R⁻¹F (FᵀR⁻¹F)⁻¹ FᵀR⁻¹ | (n, n) | - | Dubrule 1983 |
| e | leave-one-out residuals α/diag Q, the trend being refitted each time | (n,) | - | Dubrule 1983 |

Nothing is inverted for a prediction: all goes through L and S.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import LinAlgError, cholesky, solve_triangular
from scipy.linalg.lapack import dpotri

from railsearch.errors import SurrogateError
from railsearch.space import FloatArray

NOISE = 10.0
"""A pivot of the factorisation below `NOISE` n ε (ε: double precision) is rounding error, not the variance that is left."""


@dataclass(frozen=True)
class Training:
    """What a Gaussian process is fitted to: points X (n, d), trend functions F (n, p) there, standardised values y (n,)."""

    points: FloatArray
    trend: FloatArray
    values: FloatArray

    @property
    def size(self) -> int:
        """How many points n there are."""
        return len(self.values)

    def rows(self, chosen: FloatArray) -> "Training":
        """Some of the rows."""
        return Training(self.points[chosen], self.trend[chosen], self.values[chosen])

    def functions(self, count: int) -> "Training":
        """The same points with the first trend functions only."""
        return Training(self.points, self.trend[:, :count], self.values)

    def joined(self, other: "Training") -> "Training":
        """These rows, then those of another."""
        both = zip((self.points, self.trend, self.values), (other.points, other.trend, other.values), strict=True)
        return Training(*(np.concatenate(pair) for pair in both))


@dataclass(frozen=True)
class Solution:
    """The solved equations: L, G with L⁻¹y as its last column, Q₁, S, β, ε and α."""

    lower: FloatArray
    whitened: FloatArray
    orthogonal: FloatArray
    triangle: FloatArray
    coefficients: FloatArray
    residual: FloatArray
    weights: FloatArray

    @property
    def variance(self) -> float:
        """The process variance of maximum likelihood, σ̂² = (y − Fβ)ᵀR⁻¹(y − Fβ)/n."""
        return float(self.residual @ self.residual) / len(self.residual)

    @property
    def restricted_variance(self) -> float:
        """The same with divisor n − p, that of restricted maximum likelihood."""
        n, p = self.orthogonal.shape
        return float(self.residual @ self.residual) / int(n - p)


def factorise(matrix: FloatArray, nugget: float) -> tuple[FloatArray, float]:
    """The Cholesky factor L of the correlation matrix (n, n) with a nugget, and the nugget that it took.

    It takes more than the given one where the points are so strongly correlated that double precision cannot tell the
    matrix from a singular one: then twice NOISE n ε, times the least power of ten that helps.
    """
    needed = _pivot_noise(len(matrix))
    for attempt in (nugget, *(nugget + 2.0 * needed * 10.0**k for k in range(9))):
        if (lower := _cholesky(matrix, attempt)) is not None:
            return lower, attempt
    raise SurrogateError("kriging: the correlation matrix of the points is not positive semidefinite")


def solve(lower: FloatArray, training: Training) -> Solution:
    """Solve the equations, L (n, n) being given."""
    right = np.column_stack([training.trend, training.values])
    return _projected(lower, solve_triangular(lower, right, lower=True, check_finite=False))


def extend(solution: Solution, cross: FloatArray, corner: FloatArray, training: Training) -> Solution | None:
    """The solution with k more points at O(k n²), or None where rounding errors forbid it.

    cross: correlations (n, k) of old and new points; corner: those (k, k) of the new points, with the nugget; training:
    the new rows.
    """
    old, new = cross.shape
    below = solve_triangular(solution.lower, cross, lower=True, check_finite=False).T
    last = _cholesky(corner - below @ below.T, 0.0, old + new)
    if last is None:
        return None
    lower = np.zeros((old + new, old + new))
    lower[:old, :old], lower[old:, :old], lower[old:, old:] = solution.lower, below, last
    right = np.column_stack([training.trend, training.values]) - below @ solution.whitened
    added = solve_triangular(last, right, lower=True, check_finite=False)
    return _projected(lower, np.vstack([solution.whitened, added]))


def inverse(solution: Solution) -> FloatArray:
    """R⁻¹ (n, n) in its lower triangle, zeros above it."""
    matrix, _ = dpotri(solution.lower.T, lower=0)
    inverted: FloatArray = matrix.T
    return inverted


def projected_trend(solution: Solution) -> FloatArray:
    """B = L⁻ᵀQ₁ (n, p), so that Q = R⁻¹ − BBᵀ."""
    product: FloatArray = solve_triangular(solution.lower, solution.orthogonal, lower=True, trans="T", check_finite=False)
    return product


def projection(solution: Solution) -> FloatArray:
    """Q (n, n)."""
    lower, trend = inverse(solution), projected_trend(solution)
    matrix: FloatArray = lower + np.tril(lower, -1).T - trend @ trend.T
    return matrix


def leave_one_out(solution: Solution) -> tuple[FloatArray, FloatArray]:
    """Leave-one-out residuals e = α/q (n,) at fixed length scales, and q = diag Q (n,), their precisions σ²/variance."""
    precisions = np.diagonal(inverse(solution)) - np.sum(projected_trend(solution) ** 2, axis=1)
    return solution.weights / precisions, precisions


def leave_one_out_by_trend(solution: Solution) -> FloatArray:
    """Leave-one-out residuals e (n, p) with the first 1, 2, … p trend functions alone, at fixed length scales.

    With b_j the columns of B, Q of the first k functions is Q + Σ_{j > k} b_j b_jᵀ: nothing is factorised again.
    """
    trend = projected_trend(solution)
    _, precisions = leave_one_out(solution)
    explained = trend * (solution.orthogonal.T @ solution.whitened[:, -1])
    return (solution.weights[:, None] + _later(explained)) / (precisions[:, None] + _later(trend**2))


def _later(columns: FloatArray) -> FloatArray:
    """Sums (n, p) of the columns after each column."""
    sums: FloatArray = np.cumsum(columns[:, ::-1], axis=1)[:, ::-1] - columns
    return sums


def _projected(lower: FloatArray, whitened: FloatArray) -> Solution:
    orthogonal, triangle = np.linalg.qr(whitened[:, :-1])
    values = whitened[:, -1]
    share = orthogonal.T @ values
    residual = values - orthogonal @ share
    return Solution(
        lower,
        whitened,
        orthogonal,
        triangle,
        solve_triangular(triangle, share, check_finite=False),
        residual,
        solve_triangular(lower, residual, lower=True, trans="T", check_finite=False),
    )


def _cholesky(matrix: FloatArray, nugget: float, size: int | None = None) -> FloatArray | None:
    """The factor of the matrix + ν I; None if a pivot is nothing but rounding error of a matrix of that size."""
    shifted = matrix.copy()
    shifted.flat[:: len(matrix) + 1] += nugget
    try:
        lower: FloatArray = cholesky(shifted, lower=True, overwrite_a=True, check_finite=False)
    except LinAlgError:
        return None
    pivots = np.diagonal(lower)
    return lower if np.min(pivots) ** 2 >= _pivot_noise(size or len(matrix)) else None


def _pivot_noise(size: int) -> float:
    return NOISE * size * float(np.finfo(float).eps)
