"""What the analytic problems have in common: their settings, and a textbook function moved to another optimum.

| symbol | meaning | shape |
|---|---|---|
| x | design; the first variables are real, the last ones integer | (d,) |
| l, u | bounds | - |
| p | where the textbook function has its optimum | (d,) |
| s | `shift` | - |
| γ_i | direction of the shift in (−1, 1), drawn from `shift_seed` or evenly spread: 2 (i φ mod 1) − 1, φ = (√5−1)/2 | (d,) |
| x* | optimum, x*_i = p_i + s γ_i min(p_i − l, u − p_i), rounded for an integer variable; or `optimum` | (d,) |
| z | coordinates of the textbook function, z = x − x* + p | (d,) |
"""

from __future__ import annotations

import time
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from railsearch.design_problem import DesignProblem, check_own_objectives
from railsearch.errors import InputError
from railsearch.interfaces import Host, Outcome, Quantity
from railsearch.parameters import parameter
from railsearch.space import FloatArray, Space, Variable

SECTION = "function"
HALF = "half"
GOLDEN = (5.0**0.5 - 1.0) / 2.0
FRONT_POINTS = 201


@dataclass(frozen=True)
class FunctionParameters:
    """What can be chosen of an analytic problem."""

    dimension: int = parameter(10, meaning="variables", minimum=2, maximum=10_000)
    integers: int | str = parameter(
        0, meaning='how many of them, the last ones, take whole numbers only; "half" for half of them', minimum=0
    )
    shift: float = parameter(
        0.3,
        meaning="how far the optimum is moved at most, in parts of the way to the nearer bound; 0 for the textbook function",
        minimum=0.0,
        maximum=0.8,
    )
    shift_seed: int | None = parameter(None, meaning="from which the shift's directions are drawn", minimum=0)
    optimum: tuple[float, ...] = parameter(
        (), meaning="where the optimum is to be, in place of a shift: a value per variable"
    )
    seconds: float = parameter(0.0, unit="s", meaning="how long every evaluation lasts", minimum=0.0)
    computing: bool = parameter(True, meaning="whether these are seconds of a processor's work, or only waited for")

    def __post_init__(self) -> None:
        if self.integers != HALF and (isinstance(self.integers, str) or self.integers > self.dimension):
            raise InputError(
                f"integers: a number up to that of the variables or {HALF!r} is needed, "
                f"received {self.integers!r} of dimension {self.dimension}"
            )

    @property
    def whole(self) -> int:
        """How many variables take whole numbers only."""
        return self.dimension // 2 if isinstance(self.integers, str) else self.integers


class AnalyticProblem(DesignProblem):
    """A textbook function of one or more objectives, moved to another optimum; subclasses state the function.

    With one objective the value at `optimum` (d,) is 0, and higher at every other feasible design.
    """

    function_name: ClassVar[str]
    lower: ClassVar[float]
    upper: ClassVar[float]
    place: ClassVar[float] = 0.0
    defaults: ClassVar[FunctionParameters] = FunctionParameters()
    available_objectives: ClassVar[Sequence[Quantity]] = (Quantity("f", meaning="value of the function"),)
    constrained: ClassVar[int] = 0

    def __init__(self, parameters: FunctionParameters | None = None) -> None:
        chosen = parameters or self.defaults
        space = _space(chosen, self.lower, self.upper)
        super().__init__(
            name=self.function_name,
            space=space,
            objectives=self.available_objectives,
            reference=space.rounded(self.lower + 0.75 * (space.upper - space.lower)),
            n_constraints=self.constrained,
        )
        self.parameters = chosen
        self.textbook_optimum = self._textbook_optimum()
        self.optimum = _optimum(space, chosen, self.textbook_optimum)

    @classmethod
    def sections(cls, host: Host) -> Mapping[str, object]:
        """Dimension, kinds of variables, shift and duration."""
        return {SECTION: cls.defaults}

    @classmethod
    def make(cls, host: Host, objectives: Sequence[str], sections: Mapping[str, Any]) -> AnalyticProblem:
        """The function for a site's section. Raises InputError for objectives other than its own."""
        made = cls(sections[SECTION])
        check_own_objectives(made, objectives)
        return made

    @abstractmethod
    def values(self, z: FloatArray) -> FloatArray:
        """The objectives (m,) at the coordinates z (d,) of the textbook function."""

    def limits(self, z: FloatArray) -> FloatArray:
        """The constraints (k,), ≤ 0 where z (d,) is feasible."""
        return np.empty(0)

    def front(self, n: int = FRONT_POINTS) -> FloatArray:
        """The objectives (at most n, m) of optimal designs spread over the front."""
        return np.zeros((1, 1))

    def simulate(self, design: FloatArray) -> Outcome:
        """The function at a design (d,), after the seconds that an evaluation is to last."""
        _spend(self.parameters.seconds, self.parameters.computing)
        z = design - self.optimum + self.textbook_optimum
        return Outcome(self.values(z), constraints=self.limits(z))

    def _textbook_optimum(self) -> FloatArray:
        return np.full(self.space.dimension, self.place)

    def _calc_pareto_front(self) -> FloatArray:
        return self.front()

    def _calc_pareto_set(self) -> FloatArray:
        return self.optimum[None, :]


def _space(parameters: FunctionParameters, lower: float, upper: float) -> Space:
    real = parameters.dimension - parameters.whole
    return Space(tuple(Variable(f"x{k + 1}", lower, upper, integer=k >= real) for k in range(parameters.dimension)))


def _optimum(space: Space, chosen: FunctionParameters, place: FloatArray) -> FloatArray:
    if chosen.optimum:
        try:
            return space.checked(chosen.optimum)
        except InputError as error:
            raise InputError(f"{SECTION}.optimum: {error}") from None
    if chosen.shift_seed is None:
        spread = 2.0 * np.mod(np.arange(1, space.dimension + 1) * GOLDEN, 1.0) - 1.0
    else:
        spread = np.random.default_rng(chosen.shift_seed).uniform(-1.0, 1.0, space.dimension)
    return space.rounded(place + chosen.shift * spread * np.minimum(place - space.lower, space.upper - place))


def _spend(seconds: float, computing: bool) -> None:
    """Work for so many seconds of this thread's processor time, or sleep: work shows what sharing a processor costs."""
    if not computing:
        time.sleep(seconds)
        return
    end = time.thread_time() + seconds
    while time.thread_time() < end:
        sum(range(1000))
