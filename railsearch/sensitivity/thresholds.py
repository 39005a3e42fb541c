"""Threshold formulation: where a limit state can be reached, and in which ranges of a factor it is out of reach.

| symbol | meaning | shape | unit |
|---|---|---|---|
| t_k | thresholds | (K,) | of the output |
| Ȳmin, Ȳmax | extreme surfaces of a factor | (n,) | of the output |
| Ỹ^k_j | g at the minimiser of (g − t_k)² with X_i = x_ij | (n,) | of the output |
| G_k | g − t_k: failing above 0, reliable below (upper limit) | | of the output |

A continuous g takes on the connected box every value between its extremes, so Ỹ^k = min(max(t_k, Ȳmin), Ȳmax): t_k where it
can be reached, the extreme that comes nearest where it cannot. Two extreme problems serve all thresholds. The minimisation
itself is `direct_threshold_surfaces`. Source: Shang, Nogal, Teixeira & Wolfert 2024, RESS 243, 109818.
"""

import math
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from railsearch.errors import InputError
from railsearch.projected_gradient import SmoothFunction
from railsearch.space import FloatArray

from .curves import Interval, intervals_above, intervals_below, plain, plain_intervals
from .extremes import MAXIMUM, MINIMUM, Asker, Effort, ExtremeSurfaces
from .inner_problems import InnerProblems
from .inner_search import Nearest, SearchSettings, solved

UPPER, LOWER = LIMITS = ("upper", "lower")
RELIABLE, REACHABLE, FAILING = STATES = ("reliable", "reachable", "failing")
"""The limit state is out of reach; depends on the other factors; is exceeded whatever they are."""

NEVER, REACHED, ALWAYS = ("never reached", "reached", "always beyond")
CLIPPING, DIRECT = ("clipping", "direct minimisation")


@dataclass(frozen=True)
class FactorThreshold:
    """One factor at one threshold.

    curve: Ỹ (n,); states: `reliable`, `reachable` or `failing` by grid value, None where an extreme is missing; safe: the
    intervals of the factor in which the limit state is out of reach, ends interpolated; critical: whether the state
    changes along the grid, so that holding the factor in a range decides.
    """

    name: str
    curve: FloatArray
    states: tuple[str | None, ...]
    safe: tuple[Interval, ...]

    @property
    def critical(self) -> bool:
        """Ỹ is neither t all along nor on one side of it all along."""
        return len({state for state in self.states if state is not None}) > 1


@dataclass(frozen=True)
class Threshold:
    """One threshold: its value, whether the output comes to it at all, and all factors."""

    value: float
    status: str
    factors: tuple[FactorThreshold, ...]

    @property
    def critical(self) -> tuple[str, ...]:
        """The factors that are critical."""
        return tuple(factor.name for factor in self.factors if factor.critical)


@dataclass(frozen=True)
class ThresholdSurfaces:
    """The thresholds of an output. limit: `upper` if going above them is failing, `lower` if below.

    method: how Ỹ was found; effort: what a direct minimisation has spent, None of clipping, which asks nothing.
    """

    extremes: ExtremeSurfaces
    limit: str
    method: str
    thresholds: tuple[Threshold, ...]
    effort: Effort | None = None

    def document(self) -> dict[str, Any]:
        """All of it in plain types, ready for JSON."""
        output, units = self.extremes.output, [variable.unit for variable in self.extremes.factors.space.variables]
        return {
            "output": {"name": output.name, "unit": output.unit},
            "limit": self.limit,
            "method": self.method,
            "effort": None if self.effort is None else asdict(self.effort),
            "thresholds": [
                {
                    "value": threshold.value,
                    "status": threshold.status,
                    "message": self.message(threshold),
                    "critical": list(threshold.critical),
                    "factors": [_plain(*pair) for pair in zip(threshold.factors, units, strict=True)],
                }
                for threshold in self.thresholds
            ],
        }

    def message(self, threshold: Threshold) -> str:
        """What the status means, in words with numbers and unit."""
        output = self.extremes.output
        low, high = (f"{self.extremes.extreme(sense):.5g}" for sense in (MINIMUM, MAXIMUM))
        words = f"{output.name} lies between {low} and {high} {output.unit}".rstrip()
        return f"{threshold.value:.5g} {output.unit}".rstrip() + f" is {threshold.status}: {words}"


def check_limit(limit: str) -> None:
    """Raise InputError for anything but `upper` and `lower`."""
    if limit not in LIMITS:
        raise InputError(f"limit: {' or '.join(LIMITS)} is needed, received {limit!r}")


def threshold_surfaces(
    extremes: ExtremeSurfaces, thresholds: ArrayLike, limit: str = UPPER, method: str = CLIPPING
) -> ThresholdSurfaces:
    """Find Ỹ, states, safe intervals and critical factors at thresholds (K,) from the extreme surfaces, with no evaluation.

    limit: `upper` if outputs above a threshold fail, `lower` if those below do. A threshold outside the range of the output
    is a result: see `Threshold.status`. Raises InputError for no thresholds or some that are not finite, another limit, and
    extremes of one sense only. Source: Shang et al. 2024.
    """
    check_limit(limit)
    values = checked_thresholds(thresholds)
    return ThresholdSurfaces(extremes, limit, method, tuple(_threshold(extremes, value, limit) for value in values))


def direct_threshold_surfaces(
    model: SmoothFunction,
    extremes: ExtremeSurfaces,
    thresholds: ArrayLike,
    generator: np.random.Generator,
    settings: SearchSettings | None = None,
    limit: str = UPPER,
) -> ThresholdSurfaces:
    """The same with Ỹ by minimising (g − t)² over the other factors, as published; a check of the clipping.

    model: that of the extremes, from which states and safe intervals are read. Raises InputError, SurrogateError and
    SimulationError as `threshold_surfaces` and `extreme_surfaces`.
    """
    found = threshold_surfaces(extremes, thresholds, limit, DIRECT)
    asker, problems = Asker(model, extremes.factors), InnerProblems(extremes.factors)
    goals = [Nearest(threshold.value) for threshold in found.thresholds]
    chosen = settings or SearchSettings()
    searches, check = solved(asker.box, problems, goals, chosen, generator)
    replaced = []
    for threshold, search in zip(found.thresholds, searches, strict=True):
        values = np.where(np.isfinite(search.merits), asker.box.predict(search.points), np.nan)
        pairs = zip(threshold.factors, problems.split(values), strict=True)
        replaced.append(replace(threshold, factors=tuple(replace(factor, curve=curve) for factor, curve in pairs)))
    return replace(found, thresholds=tuple(replaced), effort=asker.effort(check if chosen.check else None))


def margin(values: ArrayLike, threshold: float, limit: str = UPPER) -> FloatArray:
    """G (…) of outputs (…): their distance beyond a threshold; failing above 0, reliable below. Unit of the output."""
    check_limit(limit)
    beyond = np.asarray(values, dtype=float) - threshold
    return beyond if limit == UPPER else -beyond


def checked_thresholds(thresholds: ArrayLike) -> list[float]:
    """Thresholds (K,) as numbers. Raises InputError unless there are some and all are finite."""
    values = [float(value) for value in np.atleast_1d(np.asarray(thresholds, dtype=float)).ravel()]
    if not values or not all(map(math.isfinite, values)):
        raise InputError(f"thresholds: one or more finite numbers are needed, received {values}")
    return values


def _threshold(extremes: ExtremeSurfaces, value: float, limit: str) -> Threshold:
    factors = tuple(_factor(extremes, name, value, limit) for name in extremes.factors.names)
    low, high = (float(margin(extremes.extreme(sense), value, limit)) for sense in (MINIMUM, MAXIMUM))
    beyond = max(low, high) < 0.0, min(low, high) > 0.0
    return Threshold(value, NEVER if beyond[0] else ALWAYS if beyond[1] else REACHED, factors)


def _factor(extremes: ExtremeSurfaces, name: str, value: float, limit: str) -> FactorThreshold:
    lowest, highest = (extremes.surface(name, sense).values for sense in (MINIMUM, MAXIMUM))
    grid = extremes.factors.grids[extremes.factors.index(name)]
    curve = np.where(np.isnan(lowest + highest), np.nan, np.clip(value, lowest, highest))
    worst, best = (highest, lowest) if limit == UPPER else (lowest, highest)
    intervals = intervals_below(grid, worst, value) if limit == UPPER else intervals_above(grid, worst, value)
    states = _states(margin(worst, value, limit), margin(best, value, limit))
    return FactorThreshold(name, curve, states, tuple(intervals))


def _states(worst: FloatArray, best: FloatArray) -> tuple[str | None, ...]:
    """The state of each grid value from G at the worst and at the best that the other factors can do."""
    names = np.select([np.isnan(worst + best), worst < 0.0, best > 0.0], ["", RELIABLE, FAILING], REACHABLE)
    return tuple(str(name) or None for name in names)


def _plain(factor: FactorThreshold, unit: str) -> dict[str, Any]:
    return {
        "name": factor.name,
        "unit": unit,
        "curve": plain(factor.curve),
        "states": list(factor.states),
        "safe": plain_intervals(factor.safe),
        "critical": factor.critical,
    }
