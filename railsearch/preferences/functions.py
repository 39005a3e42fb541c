"""Preference functions: how much a value is liked, from 0 (not at all) to 100 (there is nothing better).

| symbol | meaning | shape | unit | source |
|---|---|---|---|---|
| v | values with their natural sign | (n,) | of the quantity | |
| P | scores | (n,) | - | Barzilai 2005; Zhilyaev et al. 2022 |
| (v_k, P_k) | points of a curve | (k, 2) | of the quantity, - | |
| L, T, U | lower limit, target, upper limit | scalars | of the quantity | Derringer and Suich 1980 |
| s, t | exponents below and above the target | scalars | - | Derringer and Suich 1980 |
| d | desirability, P/100 | (n,) | - | Derringer and Suich 1980 |

Outside their range of values scores stay what they are at its ends (clipped), or go on linearly (extended), below 0 and
above 100, so that a search has a slope to follow there.
"""

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np

from railsearch.errors import InputError
from railsearch.objective_values import check_finite
from railsearch.parameters import parameter
from railsearch.space import FloatArray

Liking = Literal["smaller", "larger", "between"]
EXTENDED = "scores go on linearly outside the range, below 0 and above 100, instead of being clipped"
FULL_SCORE = 100.0


class PreferenceFunction(Protocol):
    """From values of a quantity, with their natural sign, to scores. A frozen dataclass; `function` is its name."""

    @property
    def function(self) -> str:
        """The name under which it is stated."""

    @property
    def extended(self) -> bool:
        """Whether scores go on outside 0 … 100."""

    def score(self, values: FloatArray) -> FloatArray:
        """Scores (n,) of values (n,)."""

    @property
    def liking(self) -> Liking:
        """Whether smaller or larger values are liked better, or one between."""

    @property
    def knots(self) -> Sequence[float]:
        """The values, ascending, at which something begins or ends: where the curve is worth drawing."""

    @property
    def ranges(self) -> Sequence[str]:
        """Names of the ranges below, between and above the knots; none if they have no names."""


class Curve:
    """A curve through points (v_k, P_k), clipped, or extended with the mean slopes of its outermost pieces."""

    extended: bool
    ranges: Sequence[str] = ()

    def score(self, values: FloatArray) -> FloatArray:
        """Scores P (n,) of values v (n,)."""
        values = np.asarray(values, dtype=float)
        knots, levels = self._points()
        scores = self._between(np.clip(values, knots[0], knots[-1]), knots, levels)
        if self.extended:
            slopes = np.diff(levels) / np.diff(knots)
            below, above = np.minimum(values - knots[0], 0.0), np.maximum(values - knots[-1], 0.0)
            scores = scores + slopes[0] * below + slopes[-1] * above
        return scores

    @property
    def liking(self) -> Liking:
        """Whether smaller or larger values are liked better."""
        _, levels = self._points()
        return "larger" if levels[-1] > levels[0] else "smaller"

    @property
    def knots(self) -> Sequence[float]:
        """The values v_k."""
        return tuple(self._points()[0].tolist())

    def _points(self) -> tuple[FloatArray, FloatArray]:
        raise NotImplementedError

    def _between(self, values: FloatArray, knots: FloatArray, levels: FloatArray) -> FloatArray:
        scores: FloatArray = np.interp(values, knots, levels)
        return scores


@dataclass(frozen=True)
class Linear(Curve):
    """Linear from a best value (100) to a worst one (0): P = 100 (v_worst − v)/(v_worst − v_best).

    Raises InputError for values that are not finite or equal.
    """

    best: float = parameter(meaning="value with score 100")
    worst: float = parameter(meaning="value with score 0")
    extended: bool = parameter(False, meaning=EXTENDED)
    function: str = dataclasses.field(init=False, default="linear")

    def __post_init__(self) -> None:
        check_numbers(self, "best", "worst")
        if self.best == self.worst:
            raise InputError(f"linear: best and worst must differ, received {self.best:g} for both; change one of them")

    def _points(self) -> tuple[FloatArray, FloatArray]:
        return _ascending(((self.best, FULL_SCORE), (self.worst, 0.0)))


@dataclass(frozen=True)
class PiecewiseLinear(Curve):
    """Straight lines between points (v_k, P_k), whose scores rise or fall all the way, with level pieces where wanted.

    Raises InputError for fewer than two points, values given twice, scores outside 0 … 100, and scores that turn round.
    """

    points: tuple[tuple[float, ...], ...] = parameter(meaning="pairs [value, score]")
    extended: bool = parameter(False, meaning=EXTENDED)
    function: str = dataclasses.field(init=False, default="piecewise-linear")

    def __post_init__(self) -> None:
        _check_points(self.function, self.points)

    def _points(self) -> tuple[FloatArray, FloatArray]:
        return _ascending(self.points)


@dataclass(frozen=True)
class MonotoneSpline(Curve):
    """Smooth curve through points (v_k, P_k): piecewise cubic Hermite polynomials that do not overshoot (PCHIP).

    Points and errors are those of `PiecewiseLinear`. Source: Fritsch and Carlson 1980; Fritsch and Butland 1984.
    """

    points: tuple[tuple[float, ...], ...] = parameter(meaning="pairs [value, score]")
    extended: bool = parameter(False, meaning=EXTENDED)
    function: str = dataclasses.field(init=False, default="monotone-spline")

    def __post_init__(self) -> None:
        _check_points(self.function, self.points)

    def _points(self) -> tuple[FloatArray, FloatArray]:
        return _ascending(self.points)

    def _between(self, values: FloatArray, knots: FloatArray, levels: FloatArray) -> FloatArray:
        from scipy.interpolate import PchipInterpolator

        # Rounding at the end of a piece may leave 0 … 100 by an ulp.
        scores: FloatArray = np.clip(PchipInterpolator(knots, levels)(values), 0.0, FULL_SCORE)
        return scores


@dataclass(frozen=True)
class Desirability:
    """Desirability of Derringer and Suich, P = 100 d.

    With a lower limit L alone larger is better: d = ((v − L)/(T − L))^s from L to the target T, 0 below, 1 above.
    With an upper limit U alone smaller is better: d = ((U − v)/(U − T))^t from T to U, 1 below, 0 above.
    With both the target is best. Extended, the straight line from limit to target goes on outside.
    Raises InputError without a limit, for limits on the wrong side of the target, and for exponents ≤ 0.
    Source: Derringer and Suich 1980, eqs. 2 and 3.
    """

    target: float = parameter(meaning="value T with score 100")
    lower: float | None = parameter(None, meaning="limit L below which the score is 0")
    upper: float | None = parameter(None, meaning="limit U above which the score is 0")
    lower_exponent: float = parameter(1.0, meaning="exponent s below the target: above 1 only values close to it are liked")
    upper_exponent: float = parameter(1.0, meaning="exponent t above the target")
    extended: bool = parameter(False, meaning=EXTENDED)
    function: str = dataclasses.field(init=False, default="desirability")
    ranges = ()

    def __post_init__(self) -> None:
        check_numbers(self, "target", "lower_exponent", "upper_exponent")
        if self.lower is None and self.upper is None:
            raise InputError("desirability: a limit is needed; give lower, upper, or both")
        for limit, factor in (("lower", 1.0), ("upper", -1.0)):
            value = getattr(self, limit)
            if value is None:
                continue
            check_numbers(self, limit)
            if not factor * value < factor * self.target:
                side = "below" if factor > 0.0 else "above"
                raise InputError(f"desirability: {limit} must lie {side} the target {self.target:g}, received {value:g}")
        for exponent in ("lower_exponent", "upper_exponent"):
            if getattr(self, exponent) <= 0.0:
                raise InputError(f"desirability: {exponent} > 0 is needed, received {getattr(self, exponent):g}")

    def score(self, values: FloatArray) -> FloatArray:
        """Scores P (n,) of values v (n,)."""
        values = np.asarray(values, dtype=float)
        sides = ((self.lower, self.lower_exponent), (self.upper, self.upper_exponent))
        scores = np.full(values.shape, FULL_SCORE)
        for limit, exponent in sides:
            if limit is not None:
                line = (values - limit) / (self.target - limit)
                scores = np.minimum(scores, FULL_SCORE * np.clip(line, 0.0, 1.0) ** exponent)
                if self.extended:
                    rise = 0.0 if self.liking == "between" else np.maximum(line - 1.0, 0.0)
                    scores = scores + FULL_SCORE * (np.minimum(line, 0.0) + rise)
        return scores

    @property
    def liking(self) -> Liking:
        """Whether smaller or larger values are liked better, or the target between."""
        if self.lower is not None and self.upper is not None:
            return "between"
        return "smaller" if self.lower is None else "larger"

    @property
    def knots(self) -> Sequence[float]:
        """Limits and target."""
        return tuple(value for value in (self.lower, self.target, self.upper) if value is not None)


def check_numbers(function: PreferenceFunction, *fields: str) -> None:
    """Raise InputError unless these fields are finite numbers."""
    for field in fields:
        check_finite(getattr(function, field), f"{function.function}: {field}")


def _ascending(points: Sequence[Sequence[float]]) -> tuple[FloatArray, FloatArray]:
    """Values (k,), ascending, and scores (k,) of points."""
    table = np.array(sorted(tuple(point) for point in points), dtype=float)
    return table[:, 0], table[:, 1]


def _check_points(function: str, points: Sequence[Sequence[float]]) -> None:
    """Raise InputError unless points make a curve whose scores rise or fall all the way."""
    if len(points) < 2:
        raise InputError(f"{function}: two points [value, score] or more are needed, received {len(points)}")
    for point in points:
        if len(point) != 2:
            raise InputError(f"{function}: points are pairs [value, score], received {list(point)}")
        for number in point:
            check_finite(number, f"{function}: points")
        if not 0.0 <= point[1] <= FULL_SCORE:
            raise InputError(f"{function}: scores lie in 0 … 100, received {point[1]:g} at the value {point[0]:g}")
    values, scores = _ascending(points)
    if np.any(np.diff(values) == 0.0):
        twice = values[int(np.argmin(np.diff(values)))]
        raise InputError(f"{function}: each value may have one score, received {twice:g} twice; remove one of the points")
    steps = np.diff(scores)
    if np.all(steps == 0.0):
        raise InputError(f"{function}: all scores are {scores[0]:g}, no value is preferred; change one of them")
    if np.any(steps > 0.0) and np.any(steps < 0.0):
        listed = ", ".join(f"{score:g} at {value:g}" for value, score in zip(values, scores, strict=True))
        raise InputError(
            f"{function}: scores must rise or fall with the value all the way, received {listed}; where a value between is "
            "best, use desirability or physical-programming with limits on both sides"
        )
