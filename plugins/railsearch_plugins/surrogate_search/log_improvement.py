"""The logarithm of the expected improvement, which has a slope where the improvement itself is too small for a number.

| symbol | meaning | shape | unit | source |
|---|---|---|---|---|
| f̂, s | prediction and its standard deviation | (k,) | of f | |
| f_min | best value so far | scalar | of f | |
| z | (f_min − f̂)/s | (k,) | - | Jones et al. 1998 |
| Φ, ϕ | distribution and density of the standard normal variable | - | - | |
| h(z) | ϕ(z) + z Φ(z), so that EI = s h(z) | (k,) | - | Ament et al. 2023 |
| M(z) | Φ(z)/ϕ(z) | (k,) | - | |

For z < 0, M(z) = √(π/2) erfcx(−z/√2) and h = ϕ (1 + z M), in which 1 + z M falls as 1/z².
With ∇EI = ϕ ∇s − Φ ∇f̂

    ∇ log EI = (ϕ ∇s − Φ ∇f̂)/(s h),  for z < 0 (∇s − M ∇f̂)/(s (1 + z M)).
"""

import numpy as np
from scipy.special import erfcx, ndtr

from railsearch.interfaces import UncertainSurrogate
from railsearch.space import FloatArray

TAIL = -1e4
"""Below this z, 1 + z M is taken to be 1/z²: there both its series and its direct evaluation are exact to 3e-8."""

SMALLEST = 1e-10
"""Standard deviations are taken to be at least this fraction of the scale of the values, so that z stays finite."""


class NegativeLogImprovement:
    """−log EI of a surrogate's predictions on `best`, and its gradient: the lower, the better.

    scale: a typical difference of the values that the surrogate was fitted to, above 0.
    """

    def __init__(self, surrogate: UncertainSurrogate, best: float, scale: float) -> None:
        self._surrogate = surrogate
        self._best = best
        self._least = SMALLEST * scale
        self._last: tuple[FloatArray, FloatArray, FloatArray] | None = None

    def predict(self, points: FloatArray) -> FloatArray:
        """−log EI (k,) at points (k, d)."""
        z, deviations = self._standardised(points)
        return -(np.log(deviations) + _terms(z)[0])

    def gradient(self, points: FloatArray) -> FloatArray:
        """The derivatives (k, d) of −log EI at points (k, d)."""
        z, deviations = self._standardised(points)
        _, by_value, by_deviation = _terms(z)
        slope = by_value[:, None] * self._surrogate.gradient(points)
        slope -= by_deviation[:, None] * self._surrogate.deviation_gradient(points)
        return slope / deviations[:, None]

    def _standardised(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The pair z, s; that of the last points is kept, since a descent asks for value and gradient at the same one."""
        if self._last is None or not np.array_equal(self._last[0], points):
            deviations = np.maximum(self._surrogate.deviation(points), self._least)
            z = (self._best - self._surrogate.predict(points)) / deviations
            self._last = points.copy(), z, deviations
        return self._last[1], self._last[2]


def _terms(z: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The logarithm of h, and Φ/h and ϕ/h, which with M are M/(1 + z M) and 1/(1 + z M)."""
    below, above = np.minimum(z, 0.0), np.maximum(z, 0.0)
    mills = np.sqrt(0.5 * np.pi) * erfcx(-below / np.sqrt(2.0))
    rest = np.where(below < TAIL, 1.0 / np.maximum(below * below, 1.0), 1.0 + below * mills)
    density, distribution = np.exp(-0.5 * above * above) / np.sqrt(2.0 * np.pi), ndtr(above)
    h = density + above * distribution
    log_below = np.log(rest) - 0.5 * below * below - 0.5 * np.log(2.0 * np.pi)
    negative = z < 0.0
    return (
        np.where(negative, log_below, np.log(h)),
        np.where(negative, mills / rest, distribution / h),
        np.where(negative, 1.0 / rest, density / h),
    )
