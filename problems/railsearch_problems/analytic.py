"""Analytic problems whose optimum is known, for tests and demonstrations.

| symbol | meaning | shape |
|---|---|---|
| x | design; the first d − `integers` variables are real, the last ones integer | (d,) |
| l, u | bounds | - |
| p | where the textbook function has its optimum, in every coordinate | - |
| s | `shift` | - |
| g_i | 2 (i φ mod 1) − 1, φ = (√5 − 1)/2: evenly spread in (−1, 1) (Kronecker sequence of the golden ratio) | (d,) |
| x* | optimum, x*_i = p + s g_i min(p − l, u − p), rounded for an integer variable | (d,) |
| z | coordinates of the textbook function, z = x − x* + p | (d,) |

At the optimum a function of one objective has the value 0. `pareto_set()` and `pareto_front()`, as pymoo has them, give
the optimal designs (n, d) and their objectives (n, m).
"""

from __future__ import annotations

import time
from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from railsearch.design_problem import DesignProblem
from railsearch.errors import InputError
from railsearch.hookspecs import hookimpl
from railsearch.interfaces import Host, Outcome, Quantity
from railsearch.parameters import parameter
from railsearch.space import FloatArray, Space, Variable

SECTION = "function"
GOLDEN = (5.0**0.5 - 1.0) / 2.0
FRONT_POINTS = 201


@dataclass(frozen=True)
class FunctionParameters:
    """What can be chosen of an analytic problem."""

    dimension: int = parameter(10, meaning="variables", minimum=2)
    integers: int = parameter(0, meaning="how many of them, the last ones, take whole numbers only", minimum=0)
    shift: float = parameter(
        0.3,
        meaning="how far the optimum is moved at most, in parts of the way to the nearer bound; 0 for the textbook function",
        minimum=0.0,
        maximum=0.8,
    )
    seconds: float = parameter(0.0, unit="s", meaning="how long every evaluation lasts", minimum=0.0)
    computing: bool = parameter(True, meaning="whether these are seconds of a processor's work, or only waited for")

    def __post_init__(self) -> None:
        if self.integers > self.dimension:
            raise InputError(
                f"integers: no more than there are variables can be integer, "
                f"received {self.integers} of dimension {self.dimension}"
            )


class AnalyticProblem(DesignProblem):
    """A textbook function of one or more objectives, moved by a shift; subclasses state the function."""

    function_name: ClassVar[str]
    lower: ClassVar[float]
    upper: ClassVar[float]
    place: ClassVar[float] = 0.0
    available_objectives: ClassVar[Sequence[Quantity]] = (Quantity("f", meaning="value of the function"),)

    def __init__(self, parameters: FunctionParameters | None = None) -> None:
        chosen = parameters or FunctionParameters()
        space = _space(chosen, self.lower, self.upper)
        super().__init__(
            name=self.function_name,
            space=space,
            objectives=self.available_objectives,
            reference=space.rounded(self.lower + 0.75 * (space.upper - space.lower)),
        )
        self.parameters = chosen
        self.optimum = _optimum(space, chosen.shift, self.place)

    @classmethod
    def sections(cls, host: Host) -> Mapping[str, object]:
        """Dimension, kinds of variables, shift and duration."""
        return {SECTION: FunctionParameters()}

    @classmethod
    def make(cls, host: Host, objectives: Sequence[str], sections: Mapping[str, Any]) -> AnalyticProblem:
        """The function for a site's section. Raises InputError for objectives other than its own."""
        super().make(host, objectives, {})
        return cls(sections[SECTION])

    @abstractmethod
    def values(self, z: FloatArray) -> FloatArray:
        """The objectives (m,) at the coordinates z (d,) of the textbook function."""

    def simulate(self, design: FloatArray) -> Outcome:
        """The function at a design (d,), after the seconds that an evaluation is to last."""
        _spend(self.parameters.seconds, self.parameters.computing)
        return Outcome(self.values(design - self.optimum + self.place))

    def _calc_pareto_front(self) -> FloatArray:
        return np.zeros((1, 1))

    def _calc_pareto_set(self) -> FloatArray:
        return self.optimum[None, :]


class Sphere(AnalyticProblem):
    """Sphere: the simplest quadratic bowl, f = Σ z_i² on [−5, 5]^d."""

    function_name = "sphere"
    lower, upper = -5.0, 5.0

    def values(self, z: FloatArray) -> FloatArray:
        """F (1,) at z (d,)."""
        return np.array([np.sum(z**2)])


class Ackley(AnalyticProblem):
    """Ackley: a funnel with waves on it, f = 20 (1 − exp(−0.2 √(Σ z_i²/d))) + e − exp(Σ cos(2π z_i)/d) on [−32, 32]^d.

    Source: Ackley 1987, A Connectionist Machine for Genetic Hillclimbing; in d dimensions Bäck 1996, Evolutionary
    Algorithms in Theory and Practice.
    """

    function_name = "ackley"
    lower, upper = -32.0, 32.0

    def values(self, z: FloatArray) -> FloatArray:
        """F (1,) at z (d,); expm1 keeps it exact near the optimum."""
        funnel = -20.0 * np.expm1(-0.2 * np.sqrt(np.mean(z**2)))
        waves = -np.e * np.expm1(np.mean(np.cos(2.0 * np.pi * z)) - 1.0)
        return np.array([funnel + waves])


class Rastrigin(AnalyticProblem):
    """Rastrigin: a bowl with a lattice of local minima, f = Σ (z_i² + 10 − 10 cos(2π z_i)) on [−5, 5]^d.

    Source: Mühlenbein, Schomisch & Born 1991, Parallel Computing 17, 619-632, function 6.
    """

    function_name = "rastrigin"
    lower, upper = -5.0, 5.0

    def values(self, z: FloatArray) -> FloatArray:
        """F (1,) at z (d,)."""
        return np.array([np.sum(z**2 + 10.0 - 10.0 * np.cos(2.0 * np.pi * z))])


class Rosenbrock(AnalyticProblem):
    """Rosenbrock: a curved narrow valley, f = Σ (100 (z_{i+1} − z_i²)² + (1 − z_i)²) on [−5, 10]^d.

    Source: Rosenbrock 1960, The Computer Journal 3, 175-184; in d dimensions Hansen et al. 2009, INRIA report 6829, f8.
    """

    function_name = "rosenbrock"
    lower, upper, place = -5.0, 10.0, 1.0

    def values(self, z: FloatArray) -> FloatArray:
        """F (1,) at z (d,)."""
        return np.array([np.sum(100.0 * (z[1:] - z[:-1] ** 2) ** 2 + (1.0 - z[:-1]) ** 2)])


class TwoSpheres(AnalyticProblem):
    """Two spheres with centres 1 below and 1 above the optimum in every real variable: f = (|z + e|², |z − e|²) / |2e|².

    e is 1 for real variables and 0 for integer ones. The front is √f_1 + √f_2 = 1, attained on the line between the
    centres: f = (t², (1 − t)²) at z = (2t − 1) e, 0 ≤ t ≤ 1 (the sum of the distances to both centres is least there).
    """

    function_name = "two-spheres"
    lower, upper = -5.0, 5.0
    available_objectives: ClassVar[Sequence[Quantity]] = (
        Quantity("left", meaning="squared distance to the lower centre, relative to that of the centres"),
        Quantity("right", meaning="squared distance to the upper centre, relative to that of the centres"),
    )

    def __init__(self, parameters: FunctionParameters | None = None) -> None:
        super().__init__(parameters)
        if self.space.integer.all():
            raise InputError(
                f"{SECTION}.integers: {self.name} needs a real variable, received {self.space.dimension} integers"
            )
        self.towards = np.where(self.space.integer, 0.0, 1.0)
        for objective, centre in zip(self.objectives, self.optimum + np.array([[-1.0], [1.0]]) * self.towards, strict=True):
            farthest = np.maximum(self.space.upper - centre, centre - self.space.lower)
            self.worst[objective.name] = float(np.sum(farthest**2)) / self._scale

    @property
    def _scale(self) -> float:
        return 4.0 * float(np.sum(self.towards**2))

    def values(self, z: FloatArray) -> FloatArray:
        """(left, right) at z (d,)."""
        return np.array([np.sum((z + self.towards) ** 2), np.sum((z - self.towards) ** 2)]) / self._scale

    def _calc_pareto_front(self) -> FloatArray:
        t = np.linspace(0.0, 1.0, FRONT_POINTS)
        return np.column_stack([t**2, (1.0 - t) ** 2])

    def _calc_pareto_set(self) -> FloatArray:
        t = np.linspace(0.0, 1.0, FRONT_POINTS)
        designs: FloatArray = self.optimum + (2.0 * t[:, None] - 1.0) * self.towards
        return designs


def _space(parameters: FunctionParameters, lower: float, upper: float) -> Space:
    real = parameters.dimension - parameters.integers
    return Space(tuple(Variable(f"x{k + 1}", lower, upper, integer=k >= real) for k in range(parameters.dimension)))


def _optimum(space: Space, shift: float, place: float) -> FloatArray:
    spread = 2.0 * np.mod(np.arange(1, space.dimension + 1) * GOLDEN, 1.0) - 1.0
    return space.rounded(place + shift * spread * np.minimum(place - space.lower, space.upper - place))


def _spend(seconds: float, computing: bool) -> None:
    """Work for so many seconds of this thread's processor time, or sleep: work shows what sharing a processor costs."""
    if not computing:
        time.sleep(seconds)
        return
    end = time.thread_time() + seconds
    while time.thread_time() < end:
        sum(range(1000))


@hookimpl
def railsearch_problems(register: Callable[[str, Any], None]) -> None:
    """Register the analytic problems."""
    for problem in (Sphere, Ackley, Rastrigin, Rosenbrock, TwoSpheres):
        register(problem.function_name, problem)
