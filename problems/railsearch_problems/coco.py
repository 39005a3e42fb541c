"""Problems of COCO, the benchmark of the black-box optimisation community, through the optional package coco-experiment.

| symbol | meaning | shape |
|---|---|---|
| y | where a function of the suite `bbob` has its optimum; within [−5, 5] | (d,) |
| k_i | how many values the integer variable i of `bbob-mixint` takes: 0 … k_i − 1 | (d,) |
| x* | optimum: y, in an integer variable the value nearest to (y_i + 4) (k_i + 1)/8 − 1, which COCO moves onto y_i | (d,) |
| y1, y2 | optima of the two `bbob` functions that a problem of `bbob-biobj` stacks | (d,) |
| ideal, nadir | (f1(y1), f2(y2)) and (f1(y2), f2(y1)): the ends of the front | (2,) |

Values are those of cocoex itself at these points. Nothing is logged: no observer is attached, no file is written.

Sources: Hansen, Finck, Ros and Auger 2009, INRIA report 6829 (bbob); Tušar, Brockhoff and Hansen 2019, GECCO '19, 718-726
(bbob-mixint); Brockhoff, Auger, Hansen and Tušar 2022, Evolutionary Computation 30, 165-193 (bbob-biobj).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, ClassVar

import numpy as np

from railsearch.design_problem import DesignProblem
from railsearch.errors import InputError, PluginError
from railsearch.hookspecs import hookimpl
from railsearch.interfaces import Host, Outcome, Quantity
from railsearch.parameters import parameter
from railsearch.space import FloatArray, Space, Variable
from railsearch.wording import install_remedy

SECTION = "coco"
STACKED = re.compile(r"bbob_f(\d+)_i(\d+)_d\d+")


@dataclass(frozen=True)
class BbobParameters:
    """Which problem of the suite `bbob`."""

    dimensions: ClassVar[tuple[int, ...]] = (2, 3, 5, 10, 20, 40)
    function: int = parameter(1, meaning="number of the function", minimum=1, maximum=24)
    instance: int = parameter(1, meaning="which shift, rotation and offset of it", minimum=1, maximum=10_000)
    dimension: int = parameter(10, meaning="variables: 2, 3, 5, 10, 20 or 40")

    def __post_init__(self) -> None:
        if self.dimension not in self.dimensions:
            known = ", ".join(map(str, self.dimensions))
            raise InputError(f"dimension: the suite has {known}, received {self.dimension}")


@dataclass(frozen=True)
class MixintParameters(BbobParameters):
    """Which problem of the suite `bbob-mixint`; its large ones, 80 and 160, do not tell where their optimum is."""

    dimensions: ClassVar[tuple[int, ...]] = (5, 10, 20, 40)
    dimension: int = parameter(10, meaning="variables: 5, 10, 20 or 40; four fifths of them, the first, are integer")


@dataclass(frozen=True)
class BiobjParameters(BbobParameters):
    """Which problem of the suite `bbob-biobj`."""

    function: int = parameter(1, meaning="number of the function, which stands for a pair of bbob's", minimum=1, maximum=55)
    instance: int = parameter(1, meaning="which shifts, rotations and offsets of it", minimum=1, maximum=15)


class CocoProblem(DesignProblem):
    """A problem of a suite of COCO, which begins where COCO proposes to; subclasses name the suite.

    The object holds numbers only and travels to other processes; each process opens COCO's own object for itself.
    Raises PluginError where coco-experiment is not installed.
    """

    suite: ClassVar[str]
    choices: ClassVar[BbobParameters]
    available_objectives: ClassVar[Sequence[Quantity]] = (Quantity("f", meaning="value of the function"),)

    def __init__(self, parameters: BbobParameters | None = None) -> None:
        self.parameters = parameters or self.choices
        coco = self._opened
        variables = tuple(
            Variable(f"x{k + 1}", float(lower), float(upper), integer=k < coco.number_of_integer_variables)
            for k, (lower, upper) in enumerate(zip(coco.lower_bounds, coco.upper_bounds, strict=True))
        )
        super().__init__(self.suite, Space(variables), self.available_objectives, reference=coco.initial_solution)

    @classmethod
    def sections(cls, host: Host) -> Mapping[str, object]:
        """Function, instance and dimension."""
        return {SECTION: cls.choices}

    @classmethod
    def make(cls, host: Host, objectives: Sequence[str], sections: Mapping[str, Any]) -> CocoProblem:
        """The problem for a site's section. Raises InputError for objectives other than its own."""
        super().make(host, objectives, {})
        return cls(sections[SECTION])

    @property
    def label(self) -> str:
        """Suite, function, instance, dimension."""
        chosen = self.parameters
        return f"{self.name} f{chosen.function}, instance {chosen.instance}, {chosen.dimension} variables"

    def simulate(self, design: FloatArray) -> Outcome:
        """COCO's function at a design (d,)."""
        return Outcome(np.atleast_1d(self._opened(design)))

    @property
    def _opened(self) -> Any:
        chosen = self.parameters
        return _opened(self.suite, chosen.function, chosen.instance, chosen.dimension)


class Bbob(CocoProblem):
    """COCO's suite bbob: 24 functions of real variables on [−5, 5]^d, shifted and rotated, optimum known.

    `optimum` (d,) is where the least value is; `pareto_front()`, as pymoo has it, gives this value.
    """

    suite = "bbob"
    choices = BbobParameters()

    def __init__(self, parameters: BbobParameters | None = None) -> None:
        super().__init__(parameters)
        self.optimum = self._on_grid(_bbob_optimum(self.parameters.function, self.parameters.instance, self.n_var))

    def _on_grid(self, continuous: FloatArray) -> FloatArray:
        values = self.space.upper - self.space.lower + 1.0
        whole = np.clip(np.floor((continuous + 4.0) * (values + 1.0) / 8.0 - 0.5), self.space.lower, self.space.upper)
        return np.where(self.space.integer, whole, continuous)

    def _calc_pareto_front(self) -> FloatArray:
        return self.simulate(self.optimum).objectives[None, :]

    def _calc_pareto_set(self) -> FloatArray:
        return self.optimum[None, :]


class BbobMixint(Bbob):
    """COCO's suite bbob-mixint: bbob's 24 functions with four fifths of the variables integer, optimum known.

    A fifth of the variables each has 2, 4, 8 and 16 values, from 0; the last fifth is real in [−5, 5]. `optimum` (d,) is
    where the least value is; `pareto_front()`, as pymoo has it, gives this value.
    """

    suite = "bbob-mixint"
    choices = MixintParameters()


class BbobBiobj(CocoProblem):
    """COCO's suite bbob-biobj: 55 pairs of bbob's functions on [−100, 100]^d, both ends of the front known.

    `ideal_point()` and `nadir_point()`, as pymoo has them, are opposite corners of the smallest box around the front; the
    nadir point is COCO's reference point of hypervolume, and this problem's worst values. The front itself is not known.
    """

    suite = "bbob-biobj"
    choices = BiobjParameters()
    available_objectives: ClassVar[Sequence[Quantity]] = (
        Quantity("f1", meaning="value of the first function"),
        Quantity("f2", meaning="value of the second function"),
    )

    def __init__(self, parameters: BbobParameters | None = None) -> None:
        super().__init__(parameters)
        self._ends = self._at_both_optima()
        self.worst.update(zip(("f1", "f2"), self._ends.max(axis=0).tolist(), strict=True))

    def ideal_point(self) -> FloatArray:
        """The least value (2,) of either objective."""
        return np.asarray(self._ends.min(axis=0))

    def nadir_point(self) -> FloatArray:
        """The value (2,) of either objective where the other one is least."""
        return np.asarray(self._ends.max(axis=0))

    def _at_both_optima(self) -> FloatArray:
        pair = STACKED.findall(self._opened.name)
        optima = [_bbob_optimum(int(function), int(instance), self.n_var) for function, instance in pair]
        return np.array([self.simulate(optimum).objectives for optimum in optima])


@lru_cache(maxsize=256)
def _opened(suite: str, function: int, instance: int, dimension: int) -> Any:
    """COCO's own object, one per process: it cannot be copied or pickled, and holds nothing but the function."""
    chosen = f"dimensions: {dimension} function_indices: {function}"
    return _cocoex().Suite(suite, f"instances: {instance}", chosen)[0]


def _bbob_optimum(function: int, instance: int, dimension: int) -> FloatArray:
    """Where a function of the suite `bbob` has its optimum (d,)."""
    return np.array(_cocoex().BareProblem("bbob", function, dimension, instance).best_parameter())


def _cocoex() -> Any:
    try:
        import cocoex
    except ImportError as error:
        raise PluginError(
            f"the problems of COCO need the package coco-experiment, which cannot be imported here ({error}): "
            f"{install_remedy('coco')}"
        ) from error
    return cocoex


@hookimpl
def railsearch_problems(register: Callable[[str, Any], None]) -> None:
    """Register the suites of COCO."""
    for problem in (Bbob, BbobMixint, BbobBiobj):
        register(problem.suite, problem)
