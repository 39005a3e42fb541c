"""Extreme surfaces of the true model, every inner problem searched by a strategy on a budget of its own.

An inner problem is the design problem with one variable held, searched through the ordinary loop: each new design is
charged, failed evaluations are results. From the second grid value on a curve may begin with the solution beside it.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from railsearch.design_problem import DesignProblem
from railsearch.errors import InputError
from railsearch.interfaces import Outcome, Quantity
from railsearch.plugin_manager import Registry
from railsearch.run import RunSettings, best, run_search
from railsearch.seeding import checked_seed
from railsearch.simulation import check_timeout
from railsearch.space import FloatArray, Space

from .extremes import MAXIMUM, SENSES, SIGNS, Curve, Effort, ExtremeSurfaces, check_senses
from .factors import Factors
from .models import natural_value, quantity_of

Progress = Callable[[int, int], None]
"""Called with the number of finished pieces of work and of all."""


def silent(done: int, total: int) -> None:
    """No progress is shown."""


@dataclass(frozen=True)
class StrategySettings:
    """How a strategy solves the inner problems: its name and settings, evaluations of each, seed, and which extremes.

    warm_starts: whether a search begins with the solution at the grid value before, which spares evaluations but may keep a
    strategy that searches locally on a branch that is no longer the best; timeout: seconds per evaluation.
    Raises InputError for a budget below 1, another extreme, or no extreme.
    """

    strategy: str
    budget: int
    seed: int
    strategy_settings: Mapping[str, object] = field(default_factory=dict)
    senses: Sequence[str] = SENSES
    warm_starts: bool = True
    timeout: float | None = None

    def __post_init__(self) -> None:
        RunSettings(self.strategy, self.budget, checked_seed(self.seed), self.strategy_settings, timeout=self.timeout)
        check_timeout(self.timeout)
        check_senses(self.senses)


class HeldProblem(DesignProblem):
    """A design problem with one variable held and one quantity, with a sign, as its objective; constraints are left out."""

    def __init__(self, base: DesignProblem, factors: Factors, held: int, value: float, sign: float, name: str) -> None:
        self._base = base
        self._held = held
        self._value = value
        self._sign = sign
        self._quantity = quantity_of(base, name)
        others = tuple(variable for place, variable in enumerate(factors.space.variables) if place != held)
        super().__init__(f"{base.name} with {factors.names[held]} held", Space(others), [Quantity(name)])

    def simulate(self, design: FloatArray) -> Outcome:
        """The quantity at a design (d − 1,), with a sign that makes it one to be minimised."""
        whole = self.whole(design)
        outcome = self._base.simulate(whole)
        return Outcome(np.array([self._sign * natural_value(self._base, self._quantity, whole, outcome)]))

    def warm_up(self) -> None:
        """Warm the base problem up."""
        self._base.warm_up()

    def whole(self, design: FloatArray) -> FloatArray:
        """The design (d,) of the base problem that belongs to one (d − 1,) of this."""
        return np.insert(design, self._held, self._value)


def strategy_surfaces(
    registry: Registry,
    problem: DesignProblem,
    name: str,
    factors: Factors,
    settings: StrategySettings,
    progress: Progress = silent,
) -> ExtremeSurfaces:
    """Find the extreme surfaces of a quantity of a problem with a registered strategy, evaluating the problem itself.

    name: an objective or metric, which has its natural sign; factors: all variables of the problem in their order; progress:
    called after every inner problem. `effort.asked` counts the true evaluations, `effort.failures` the failed ones. An inner
    problem whose evaluations all failed has no extreme. Raises InputError, PluginError or CapabilityError as a run does.
    """
    quantity = quantity_of(problem, name)
    if factors.names != problem.space.names or factors.dimension < 2:
        raise InputError(
            f"factors: all variables of {problem.name} are needed, two or more and in this order "
            f"({', '.join(problem.space.names)}), received {', '.join(factors.names)}"
        )
    work = _Work(registry, problem, name, factors, settings, progress)
    curves = {sense: tuple(work.curve(held, sense) for held in range(factors.dimension)) for sense in settings.senses}
    effort = Effort(work.asked, work.failures, True, None, f"strategy {settings.strategy}")
    return ExtremeSurfaces(factors, quantity, curves, effort)


@dataclass
class _Work:
    """The inner problems one after the other, and what they have spent."""

    registry: Registry
    problem: DesignProblem
    name: str
    factors: Factors
    settings: StrategySettings
    progress: Progress
    asked: int = 0
    failures: int = 0
    done: int = 0

    def curve(self, held: int, sense: str) -> Curve:
        """The extreme surface of the factor in place `held`."""
        values, points, beside = [], [], None
        for place in range(len(self.factors.grids[held])):
            value, point = self._solved(held, place, sense, beside)
            beside = beside if point is None else np.delete(point, held)
            values.append(value)
            points.append(np.full(self.factors.dimension, np.nan) if point is None else point)
            self.done += 1
            self.progress(self.done, self.factors.number_of_values * len(self.settings.senses))
        return Curve(np.array(values), np.array(points))

    def _solved(self, held: int, place: int, sense: str, beside: FloatArray | None) -> tuple[float, FloatArray | None]:
        """The extreme of one inner problem and where it is, (d,); NaN and None where every evaluation failed."""
        settings, sign = self.settings, SIGNS[sense]
        inner = HeldProblem(self.problem, self.factors, held, float(self.factors.grids[held][place]), sign, self.name)
        # Each inner problem has a seed of its own, whatever the order in which they are solved.
        words = (settings.seed, held, place, int(sense == MAXIMUM))
        seed = int(np.random.SeedSequence(words).generate_state(1)[0])
        run = RunSettings(settings.strategy, settings.budget, seed, settings.strategy_settings, timeout=settings.timeout)
        result = run_search(self.registry, inner, run, [beside] if beside is not None and settings.warm_starts else [])
        self.asked += len(result.evaluations)
        self.failures += len(result.failures)
        found = best(result.evaluations)
        if found is None:
            return float("nan"), None
        return sign * float(found.objectives[0]), inner.whole(found.design)
