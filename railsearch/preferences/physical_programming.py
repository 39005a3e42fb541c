"""Class functions of physical programming: ranges from highly desirable to unacceptable, as scores.

| symbol | meaning | shape | unit | source |
|---|---|---|---|---|
| g_1 … g_5 | ends of the ranges highly desirable … highly undesirable | (5,) | of the quantity | Messac 1996 |
| λ_k | width of range k, g_k − g_{k−1}, k = 2 … 5 | (4,) | of the quantity | Messac 1996 |
| z | class function, 0 is best; z_k at the end of range k | (n,) | - | Messac 1996 |
| z̃_k | rise of z over range k, r^{k−1} | (5,) | - | Messac 1996 |
| r | growth of the rise from range to range | scalar | - | β (n_sc − 1) in Messac 1996 |
| s_k | slope of z at g_k | (5,) | 1/unit of the quantity | Messac 1996 |
| α | how curved z is inside a range, 0 < α < 1 | scalar | - | Messac 1996 |
| ξ | place inside a range, 0 … 1 | (n,) | - | Messac 1996 |
| P | score 100 (1 − z/z_5) | (n,) | - | ours |

Construction. At the end of range k the class function is z_k = 1 + r + … + r^{k−1}, whatever the quantity: every range costs
r times as much as the one before. With r > n − 1 among n objectives, the way of one objective through a range costs more
than that of all others through the next better range (the one-versus-others rule). Inside the ranges 2 … 5, z is the
quartic with z″ = λ^{−2} (a ξ² + b (1 − ξ)²) through the values and slopes at both ends. It is convex (a, b ≥ 0) if the slope
s_k lies between (4 D − s_{k−1})/3 and 4 D − 3 s_{k−1}, D = z̃_k/λ_k, which asks for D > s_{k−1}; s_k is the lower bound
plus α of the difference. In the highly desirable range z = z_1 exp(s_1 (g − g_1)/z_1) with s_1 = α z̃_2/λ_2. So z is convex
and its slope continuous.

The score is linear in z: 100 where nothing is left to wish for, 0 at g_5 where the unacceptable range begins. A weighted
mean of such scores ranks designs as that of class functions does, which is what physical programming minimises.
"""

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from railsearch.errors import InputError
from railsearch.objective_values import check_finite
from railsearch.parameters import parameter
from railsearch.preferences.functions import EXTENDED, FULL_SCORE, Liking
from railsearch.space import FloatArray

RANGES = ("highly desirable", "desirable", "tolerable", "undesirable", "highly undesirable", "unacceptable")
LARGEST_GROWTH = 1e12
"""With a larger growth every range but the last costs less than a score can show."""
N_LIMITS = 5
CURVATURE = 0.1
GROWTH_STEP = 1.1


@dataclass(frozen=True)
class PhysicalProgramming:
    """Soft class function of physical programming: `upper` limits where smaller is better, `lower` where larger, or both.

    Limits are the ends of the highly desirable, desirable, tolerable, undesirable and highly undesirable range in this
    order; beyond them the value is unacceptable. Between both highly desirable ends the better side does not count.
    growth: r; without it the least power of 1.1 that keeps the function convex. Preferences stated together share theirs.
    Raises InputError for limits that are not five finite numbers in order, and for a growth that makes it not convex.
    Source: Messac 1996, classes 1S (upper), 2S (lower), 3S and 4S (both).
    """

    upper: tuple[float, ...] | None = parameter(None, meaning="five limits, ascending, where smaller values are better")
    lower: tuple[float, ...] | None = parameter(None, meaning="five limits, descending, where larger values are better")
    growth: float | None = parameter(None, meaning="how much more each range costs than the one before", above=1.0)
    extended: bool = parameter(False, meaning=EXTENDED)
    function: str = dataclasses.field(init=False, default="physical-programming")

    def __post_init__(self) -> None:
        if self.upper is None and self.lower is None:
            raise InputError(f"{self.function}: five limits are needed; give upper, lower, or both")
        for name, limits, factor in (("upper", self.upper, 1.0), ("lower", self.lower, -1.0)):
            if limits is not None:
                _check_limits(f"{self.function}: {name}", limits, factor)
        if self.lower is not None and self.upper is not None and self.lower[0] > self.upper[0]:
            raise InputError(
                f"{self.function}: the first lower limit must not lie above the first upper one, received "
                f"{self.lower[0]:g} and {self.upper[0]:g}"
            )
        if (self.growth or self.least_growth) > LARGEST_GROWTH:
            received = "these limits" if self.growth is None else f"{self.growth:g}"
            raise InputError(
                f"{self.function}: growth: at most {LARGEST_GROWTH:g} is needed for scores that can be told apart, received "
                f"{received}; bring the limits nearer to even distances, or leave growth out"
            )
        if self.growth is not None and not _convex(self._sides(), self.growth):
            raise InputError(
                f"{self.function}: growth: the class function is not convex with these limits and {self.growth:g}; leave "
                f"growth out, or give {self.least_growth:.4g} or more"
            )

    def score(self, values: FloatArray) -> FloatArray:
        """Scores P (n,) of values (n,)."""
        values = np.asarray(values, dtype=float)
        growth = self.least_growth if self.growth is None else self.growth
        scores = np.full(values.shape, FULL_SCORE)
        for factor, limits in self._sides():
            share = _class_function(factor * values, limits, growth) / _class_values(growth)[-1]
            scores = np.minimum(scores, FULL_SCORE * (1.0 - share))
        return scores if self.extended else np.clip(scores, 0.0, FULL_SCORE)

    @property
    def least_growth(self) -> float:
        """The least power of 1.1 above 1 as growth for which the class function is convex; ∞ beyond LARGEST_GROWTH."""
        growth = GROWTH_STEP
        while not _convex(self._sides(), growth):
            growth *= GROWTH_STEP
            if growth > LARGEST_GROWTH:
                return math.inf
        return growth

    @property
    def liking(self) -> Liking:
        """Whether smaller or larger values are liked better, or those between."""
        if self.upper is not None and self.lower is not None:
            return "between"
        return "larger" if self.upper is None else "smaller"

    @property
    def knots(self) -> Sequence[float]:
        """The limits."""
        return (*reversed(self.lower or ()), *(self.upper or ()))

    @property
    def ranges(self) -> Sequence[str]:
        """The names of the ranges from the smallest value to the largest."""
        below = RANGES[:0:-1] if self.lower is not None else ()
        above = RANGES[1:] if self.upper is not None else ()
        return (*below, RANGES[0], *above)

    def _sides(self) -> list[tuple[float, FloatArray]]:
        """For every side the sign with which values ascend from good to bad, and the limits (5,) with that sign."""
        sides = ((1.0, self.upper), (-1.0, self.lower))
        return [(factor, factor * np.array(limits)) for factor, limits in sides if limits is not None]


def _class_values(growth: float) -> FloatArray:
    """The class function z_1 … z_5 (5,) at the limits."""
    return np.cumsum(growth ** np.arange(N_LIMITS))


def _slopes(limits: FloatArray, growth: float) -> FloatArray:
    """The slopes s_1 … s_5 (5,) at the limits; NaN from the first range on that cannot be convex."""
    secants = growth ** np.arange(1, N_LIMITS) / np.diff(limits)
    slopes = [CURVATURE * secants[0]]
    for secant in secants:
        least, most = (4.0 * secant - slopes[-1]) / 3.0, 4.0 * secant - 3.0 * slopes[-1]
        slopes.append(least + CURVATURE * (most - least) if secant > slopes[-1] else np.nan)
    return np.array(slopes)


def _convex(sides: Sequence[tuple[float, FloatArray]], growth: float) -> bool:
    return not any(np.isnan(_slopes(limits, growth)).any() for _, limits in sides)


def _class_function(values: FloatArray, limits: FloatArray, growth: float) -> FloatArray:
    """The class function z (n,) at values (n,) that ascend from good to bad; linear beyond the last limit."""
    levels, slopes = _class_values(growth), _slopes(limits, growth)
    result = levels[0] * np.exp(slopes[0] / levels[0] * np.minimum(values - limits[0], 0.0))
    for k in range(1, N_LIMITS):
        inside, ends = values > limits[k - 1], slice(k - 1, k + 1)
        result[inside] = _quartic(np.minimum(values[inside], limits[k]), limits[ends], levels[ends], slopes[ends])
    everywhere: FloatArray = result + slopes[-1] * np.maximum(values - limits[-1], 0.0)
    return everywhere


def _quartic(values: FloatArray, ends: FloatArray, levels: FloatArray, slopes: FloatArray) -> FloatArray:
    """The curve with z″ = λ^{−2} (a ξ² + b (1 − ξ)²) from one end to the other, for values (n,) between them."""
    width = ends[1] - ends[0]
    place = (values - ends[0]) / width
    start, change, rise = slopes[0] * width, (slopes[1] - slopes[0]) * width, levels[1] - levels[0]
    # ∫ z″ dξ = (a + b)/3 = change and ∫ (1 − ξ) z″ dξ = a/12 + b/4 = rise − start.
    b = 6.0 * (rise - start) - 1.5 * change
    a = 3.0 * change - b
    bent = a * place**4 / 12.0 + b * ((1.0 - place) ** 4 - 1.0 + 4.0 * place) / 12.0
    curve: FloatArray = levels[0] + start * place + bent
    return curve


def _check_limits(field: str, limits: Sequence[float], factor: float) -> None:
    if len(limits) != N_LIMITS:
        raise InputError(f"{field}: five limits are needed ({', '.join(RANGES[:-1])}), received {len(limits)}")
    for limit in limits:
        check_finite(limit, field)
    if not np.all(factor * np.diff(limits) > 0.0):
        order = "ascend" if factor > 0.0 else "descend"
        raise InputError(
            f"{field}: limits must {order} from highly desirable to highly undesirable, received {list(limits)}"
        )
