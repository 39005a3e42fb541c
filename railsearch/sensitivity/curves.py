"""What is read off the curves of factors.

| symbol | meaning | shape | unit |
|---|---|---|---|
| x_j, w_j | grid of a factor and weights | (n,) | of the factor |
| Ȳ_j | extreme of the output with the factor held at x_j; NaN where none was found | (n,) | of the output |
| μ̄ | Σ w_j Ȳ_j / Σ w_j | scalar | of the output |
| Var | Σ w_j (Ȳ_j − μ̄)² / Σ w_j | scalar | its square |
| I_i | Var_i / Σ_i Var_i | (d,) | - |
| t | threshold | scalar | of the output |

Source: Shang, Nogal, Teixeira & Wolfert 2024, Reliability Engineering & System Safety 243, 109818.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from railsearch.space import FloatArray

Interval = tuple[float, float]


def weighted_variance(curve: FloatArray, weights: FloatArray) -> float:
    """Var of a curve (n,) with weights (n,), NaN left out; 0 where there are no values."""
    known = np.isfinite(curve)
    if not weights[known].sum() > 0.0:
        return 0.0
    mean = np.average(curve[known], weights=weights[known])
    return float(np.average((curve[known] - mean) ** 2, weights=weights[known]))


def shares(variances: FloatArray) -> FloatArray:
    """I (d,) of variances (d,); 0 for all where no curve varies."""
    total = float(np.sum(variances))
    return variances / total if total > 0.0 else np.zeros_like(variances)


def local_sensitivity(grid: FloatArray, curve: FloatArray) -> FloatArray:
    """dȲ/dx (n,) by finite differences: three points of second order inside, two at the ends; NaN beside a missing value."""
    if len(grid) < 2:
        return np.full(len(grid), np.nan)
    return np.asarray(np.gradient(curve, grid))


def intervals_below(grid: FloatArray, curve: FloatArray, threshold: float) -> list[Interval]:
    """The intervals of x in which a curve (n,) on a grid (n,) lies below t, ends interpolated linearly where it crosses t.

    Beside a missing value an interval ends at the last grid value that is known to lie below.
    """
    below = np.concatenate([[False], curve < threshold, [False]])
    first, last = np.flatnonzero(~below[:-1] & below[1:]), np.flatnonzero(below[:-1] & ~below[1:]) - 1
    return [
        (_end(grid, curve, threshold, int(start), -1), _end(grid, curve, threshold, int(stop), 1))
        for start, stop in zip(first, last, strict=True)
    ]


def intervals_above(grid: FloatArray, curve: FloatArray, threshold: float) -> list[Interval]:
    """The intervals of x in which a curve lies above t, as `intervals_below`."""
    return intervals_below(grid, -curve, -threshold)


def _end(grid: FloatArray, curve: FloatArray, threshold: float, inside: int, step: int) -> float:
    """Where the interval that holds grid value `inside` ends on the side of `step`."""
    outside = inside + step
    if not 0 <= outside < len(grid) or not np.isfinite(curve[outside]):
        return float(grid[inside])
    share = (threshold - curve[inside]) / (curve[outside] - curve[inside])
    return float(grid[inside] + share * (grid[outside] - grid[inside]))


def plain(values: FloatArray | NDArray[np.float64]) -> list[object]:
    """An array of any shape as lists of numbers, None for what is not finite."""
    array = np.asarray(values, dtype=float)
    if array.ndim > 1:
        return [plain(row) for row in array]
    return [float(value) if np.isfinite(value) else None for value in array]


def plain_intervals(intervals: Sequence[Interval]) -> list[list[float]]:
    """Intervals as lists."""
    return [list(interval) for interval in intervals]
