"""All inner problems solved together: projected gradients from many starts, warm starts along the curves, a global check.

| symbol | meaning | shape | unit |
|---|---|---|---|
| R, d | number of problems, of factors | scalar | - |
| u | point of the unit box | (d,) | - |
| g | output | scalar | of the output |
| φ | what is minimised: g, −g, or (g − t)² | scalar | of the output or its square |

Every problem starts from its best sampled points, then from the best point of all problems, with its own coordinate held;
solutions travel to the problems beside them on the curve until none of these becomes better. Then a fresh sample is compared
with what was found: a more extreme point is a new start, its solution travels again, and another sample is drawn.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from railsearch.errors import InputError, SimulationError
from railsearch.projected_gradient import minimised
from railsearch.space import FloatArray

from .inner_problems import InnerProblems, Rows
from .models import BoxModel

SAME = 1e-6
"""Points nearer to one another than this in every coordinate are the same start."""

SIGNIFICANT = 1e-8
"""An improvement below this fraction of the spread of φ is rounding: it is kept, but nothing else is done about it."""


@dataclass(frozen=True)
class SearchSettings:
    """How much work the inner problems may be.

    starts: sampled points from which each problem starts; sample: points from which these are chosen; check: points of each
    problem in a round of the global check, 0 for no check; rounds: the most rounds; sweeps: the most times that solutions
    travel by one grid value; iterations: the most steps of a descent; tolerance: decrease at which a descent ends, as a fraction
    of the spread of φ. Raises InputError for numbers that are too small.
    """

    starts: int = 3
    sample: int = 64
    check: int = 128
    rounds: int = 10
    sweeps: int = 200
    iterations: int = 200
    tolerance: float = 1e-10

    def __post_init__(self) -> None:
        least = {"starts": 1, "sample": self.starts, "check": 0, "rounds": 1, "sweeps": 0, "iterations": 1}
        for name, minimum in least.items():
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, int) or value < minimum:
                raise InputError(f"{name}: an integer ≥ {minimum} is needed, received {value!r}")
        if not 0.0 < self.tolerance < 1.0:
            raise InputError(f"tolerance: a number between 0 and 1 is needed, received {self.tolerance!r}")


@dataclass(frozen=True)
class GlobalCheck:
    """How the comparison with sampled points ended.

    points: compared with in all; rounds: samples drawn; rescued: how often a problem was solved again because a sampled
    point was more extreme; held: no point of the last sample was; settled: the solutions travelled until nothing improved.
    """

    points: int
    rounds: int
    rescued: int
    held: bool
    settled: bool


class Goal(Protocol):
    """What is minimised in place of g."""

    def merit(self, values: FloatArray) -> FloatArray:
        """φ (k,) of g (k,)."""

    def slope(self, values: FloatArray) -> FloatArray:
        """dφ/dg (k,) at g (k,)."""

    def spread(self, spread: float) -> float:
        """The spread of φ that belongs to one of g."""


@dataclass(frozen=True)
class Extreme:
    """The minimum of g with sign 1, the maximum with sign −1."""

    sign: float

    def merit(self, values: FloatArray) -> FloatArray:
        """±g."""
        return self.sign * values

    def slope(self, values: FloatArray) -> FloatArray:
        """±1."""
        return np.full_like(values, self.sign)

    def spread(self, spread: float) -> float:
        """That of g."""
        return spread


@dataclass(frozen=True)
class Nearest:
    """The value of g nearest to a threshold."""

    threshold: float

    def merit(self, values: FloatArray) -> FloatArray:
        """(g − t)²."""
        return (values - self.threshold) ** 2

    def slope(self, values: FloatArray) -> FloatArray:
        """2 (g − t)."""
        return 2.0 * (values - self.threshold)

    def spread(self, spread: float) -> float:
        """A small part of the square, so that g itself is found to half as many digits as φ."""
        return SIGNIFICANT * spread**2


class _Objective:
    """φ on the unit box; infinite where the evaluation failed, so that no descent goes there."""

    def __init__(self, model: BoxModel, goal: Goal) -> None:
        self._model = model
        self._goal = goal

    def merits(self, values: FloatArray) -> FloatArray:
        return np.where(np.isnan(values), np.inf, self._goal.merit(values))

    def predict(self, points: FloatArray) -> FloatArray:
        return self.merits(self._model.predict(points))

    def gradient(self, points: FloatArray) -> FloatArray:
        return self.predict_with_gradient(points)[1]

    def predict_with_gradient(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        values, slopes = self._model.predict_with_gradient(points)
        failed = np.isnan(values)
        rates = np.where(failed, 0.0, self._goal.slope(values))
        return self.merits(values), rates[:, None] * slopes


class InnerSearch:
    """The best point (R, d) and φ (R,) that were found for one goal; both improve with every start."""

    def __init__(
        self, model: BoxModel, goal: Goal, problems: InnerProblems, settings: SearchSettings, spread: float
    ) -> None:
        self._objective = _Objective(model, goal)
        self._problems = problems
        self._settings = settings
        self._spread = goal.spread(spread)
        self.points = np.full((problems.number, len(problems.numbers)), 0.5)
        self.merits = np.full(problems.number, np.inf)
        self.settled = True

    def begin(self, sample: FloatArray, values: FloatArray) -> None:
        """Start from the best of sampled points (R, k, d) with g (R, k), then from the best point of all problems."""
        merits = self._objective.merits(values)
        chosen = np.argsort(merits, axis=1, kind="stable")[:, : self._settings.starts]
        rows = np.repeat(np.arange(len(chosen)), chosen.shape[1])
        self._improve(rows, sample[rows, chosen.ravel()])
        everywhere = np.arange(len(self.merits))
        best = np.tile(self.points[np.argmin(self.merits)], (len(everywhere), 1))
        self._improve(everywhere, self._problems.held(best, everywhere))
        self._travel(np.isfinite(self.merits))

    def rescue(self, sample: FloatArray, values: FloatArray) -> int:
        """Start from sampled points that are better than what was found; how many of them were so by more than rounding."""
        merits = self._objective.merits(values)
        chosen = np.argmin(merits, axis=1)
        lowest = merits[np.arange(len(merits)), chosen]
        significant = int(np.sum(lowest < self.merits - SIGNIFICANT * self._spread))
        rows = np.flatnonzero(lowest < self.merits)
        self._travel(self._improve(rows, sample[rows, chosen[rows]]))
        return significant

    def _travel(self, changed: NDArray[np.bool_]) -> None:
        """Start the problems beside changed ones (R,) from the solutions of these, until nothing improves."""
        for _ in range(self._settings.sweeps):
            rows, sources = self._problems.neighbours(changed)
            starts = self._problems.held(self.points[sources], rows)
            other = np.abs(starts - self.points[rows]).max(axis=1, initial=0.0) > SAME
            if not other.any():
                return
            changed = self._improve(rows[other], starts[other])
        self.settled = not changed.any()

    def _improve(self, rows: Rows, starts: FloatArray) -> NDArray[np.bool_]:
        """Minimise from starts (k, d) of problems `rows` (k,), keep what is better, and say where (R,) that matters."""
        before, settings = self.merits.copy(), self._settings
        if len(rows):
            lower, upper = self._problems.boxes(rows)
            tolerance = settings.tolerance * self._spread
            points, merits = minimised(self._objective, starts, lower, upper, tolerance, settings.iterations)
            # Of several starts of a problem the last one that is written stays: the best.
            order = np.argsort(-merits, kind="stable")
            order = order[merits[order] < self.merits[rows[order]]]
            self.points[rows[order]], self.merits[rows[order]] = points[order], merits[order]
        return self.merits < before - SIGNIFICANT * self._spread


def solved(
    model: BoxModel,
    problems: InnerProblems,
    goals: Sequence[Goal],
    settings: SearchSettings,
    generator: np.random.Generator,
) -> tuple[list[InnerSearch], GlobalCheck]:
    """Solve all problems for every goal. Raises SimulationError if no evaluation of a whole sample succeeded."""
    sample, values = _sampled(model, problems, settings.sample, generator)
    if not np.isfinite(values).any():
        raise SimulationError(f"all {values.size} evaluations of the first sample failed; check the model and the bounds")
    spread = float(np.nanmax(values) - np.nanmin(values))
    searches = [InnerSearch(model, goal, problems, settings, spread) for goal in goals]
    for search in searches:
        search.begin(sample, values)
    points = rounds = total = rescued = 0
    while settings.check and rounds < settings.rounds:
        sample, values = _sampled(model, problems, settings.check, generator)
        rescued = sum(search.rescue(sample, values) for search in searches)
        points, rounds, total = points + values.size, rounds + 1, total + rescued
        if not rescued:
            break
    held = rounds > 0 and rescued == 0
    return searches, GlobalCheck(points, rounds, total, held, all(search.settled for search in searches))


def _sampled(
    model: BoxModel, problems: InnerProblems, count: int, generator: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """Points (R, count, d) in the boxes of the problems, and g (R, count) there."""
    sample = problems.sampled(count, generator)
    return sample, model.predict(sample.reshape(-1, sample.shape[-1])).reshape(sample.shape[:2])
