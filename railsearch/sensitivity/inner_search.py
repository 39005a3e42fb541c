"""All inner problems solved together: projected gradients from many starts, warm starts along the curves, a global check.

| symbol | meaning | shape | unit |
|---|---|---|---|
| R, d | number of problems, of factors | scalar | - |
| u | point of the unit box | (d,) | - |
| g | output | scalar | of the output |
| φ | what is minimised: g, −g, or (g − t)² | scalar | of the output or its square |

Every problem starts from its best sampled points, then from the best of the different solutions of all problems, with its
own coordinate held; at last solutions travel to the problems beside them on the curve until none becomes better. Then a new
sample, and mixtures of it with the solutions, are compared with these: a point that is more extreme is a new start, its
solution travels, and another sample is drawn.
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

NEAR, DISTINCT = 0.02, 0.1
"""Another problem's solution is no start if it is so near to one's own; solutions farther apart than this are different."""

FROM_OTHERS = 2
"""Solutions of others from which a problem starts in an exchange."""

KEPT = 0.8
"""The share of coordinates that a mixture of a solution and a sampled point has from the solution."""

SIGNIFICANT = 1e-8
"""An improvement below this fraction of the spread of φ is rounding: it is kept, but nothing else is done about it."""


@dataclass(frozen=True)
class SearchSettings:
    """How much work the inner problems may be.

    starts: sampled points from which each problem starts; sample: points from which these are chosen; exchanges: how often
    problems start from others' solutions; pool: the most solutions that are offered then; sweeps: the most times that
    solutions travel by one grid value; check: sampled points, and as many mixtures, that each problem is compared with in a
    round of the global check, 0 for no check; rounds: the most rounds; iterations: the most steps of a descent; tolerance:
    decrease at which a descent ends, as a fraction of the spread of φ. Raises InputError for numbers that are too small.
    """

    starts: int = 1
    sample: int = 64
    exchanges: int = 2
    pool: int = 64
    sweeps: int = 200
    check: int = 64
    rounds: int = 10
    iterations: int = 200
    tolerance: float = 1e-10

    def __post_init__(self) -> None:
        least = {"starts": 1, "sample": self.starts, "exchanges": 0, "pool": 1, "sweeps": 0}
        least |= {"check": 0, "rounds": 1, "iterations": 1}
        for name, minimum in least.items():
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, int) or value < minimum:
                raise InputError(f"{name}: an integer ≥ {minimum} is needed, received {value!r}")
        if not 0.0 < self.tolerance < 1.0:
            raise InputError(f"tolerance: a number between 0 and 1 is needed, received {self.tolerance!r}")


FRUGAL = SearchSettings(sample=4, exchanges=1, pool=8, check=8)
"""For a true model, of which every evaluation costs."""


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
        """Start from the best of sampled points (R, k, d) with g (R, k), then from one another's solutions."""
        merits = self._objective.merits(values)
        self._improve(*_lowest(sample, merits, self._settings.starts))
        for _ in range(self._settings.exchanges):
            self._exchange()
        self._travel(np.isfinite(self.merits))

    def rescue(self, sample: FloatArray, values: FloatArray, generator: np.random.Generator) -> tuple[int, int]:
        """Start from points that are better than what was found: sampled (R, k, d) with g (R, k), and mixtures with it.

        Returns the number of points compared, and how many problems had one that was better by more than rounding.
        """
        kept = generator.random(sample.shape) < KEPT
        mixtures = np.where(kept, self.points[:, None, :], sample)
        mixed = self._objective.predict(mixtures.reshape(-1, sample.shape[-1])).reshape(values.shape)
        merits = np.concatenate([self._objective.merits(values), mixed], axis=1)
        significant = int(np.sum(merits.min(axis=1) < self.merits - SIGNIFICANT * self._spread))
        merits[merits >= self.merits[:, None]] = np.inf
        self._travel(self._improve(*_lowest(np.concatenate([sample, mixtures], axis=1), merits, 1)))
        return merits.size, significant

    def _exchange(self) -> None:
        """Start every problem from the best solutions of others that differ, with its own coordinate held."""
        pool = self._distinct()
        everywhere = np.arange(len(self.merits))
        starts = np.stack([self._problems.held(np.tile(point, (len(everywhere), 1)), everywhere) for point in pool], axis=1)
        merits = self._objective.predict(starts.reshape(-1, starts.shape[-1])).reshape(starts.shape[:2])
        merits[np.abs(starts - self.points[:, None, :]).max(axis=2) < NEAR] = np.inf
        rows, chosen = _lowest(starts, merits, FROM_OTHERS)
        self._improve(rows, chosen)

    def _distinct(self) -> FloatArray:
        """The best solutions (k, d) of all problems, none near another where neither of both is held."""
        rows = np.argsort(self.merits, kind="stable")
        found: list[FloatArray] = []
        while len(rows) and len(found) < self._settings.pool:
            found.append(self.points[rows[0]])
            apart = np.abs(self.points[rows] - found[-1])
            apart[np.arange(len(rows)), self._problems.factor[rows]] = 0.0
            apart[:, self._problems.factor[rows[0]]] = 0.0
            rows = rows[apart.max(axis=1) > DISTINCT]
        return np.array(found)

    def _travel(self, changed: NDArray[np.bool_]) -> None:
        """Start the problems beside changed ones (R,) from the solutions of these, until nothing improves."""
        for _ in range(self._settings.sweeps):
            rows, sources = self._problems.neighbours(changed)
            starts = self._problems.held(self.points[sources], rows)
            other = np.abs(starts - self.points[rows]).max(axis=1, initial=0.0) > SAME
            if not other.any():
                return
            changed = self._improve(rows[other], starts[other])
        self.settled = self.settled and not changed.any()

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
    check = _checked(model, problems, searches, settings, generator)
    return searches, check


def _checked(
    model: BoxModel,
    problems: InnerProblems,
    searches: Sequence[InnerSearch],
    settings: SearchSettings,
    generator: np.random.Generator,
) -> GlobalCheck:
    """Compare with fresh samples until one of them has nothing more extreme, and solve again where one has."""
    points = rounds = total = 0
    held = False
    while settings.check and rounds < settings.rounds and not held:
        sample, values = _sampled(model, problems, settings.check, generator)
        compared, rescued = zip(*(search.rescue(sample, values, generator) for search in searches), strict=True)
        points, rounds, total = points + sum(compared), rounds + 1, total + sum(rescued)
        held = not any(rescued)
    return GlobalCheck(points, rounds, total, held, all(search.settled for search in searches))


def _lowest(points: FloatArray, merits: FloatArray, count: int) -> tuple[Rows, FloatArray]:
    """The `count` points of lowest φ of every problem, none with an infinite φ: problems (m,) and points (m, d).

    They are chosen from points (R, k, d) with φ (R, k).
    """
    chosen = np.argsort(merits, axis=1, kind="stable")[:, :count]
    rows, places = np.repeat(np.arange(len(merits)), chosen.shape[1]), chosen.ravel()
    finite = np.isfinite(merits[rows, places])
    return rows[finite], points[rows[finite], places[finite]]


def _sampled(
    model: BoxModel, problems: InnerProblems, count: int, generator: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """Points (R, count, d) in the boxes of the problems, and g (R, count) there."""
    sample = problems.sampled(count, generator)
    return sample, model.predict(sample.reshape(-1, sample.shape[-1])).reshape(sample.shape[:2])
