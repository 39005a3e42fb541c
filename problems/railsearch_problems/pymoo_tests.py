"""The static test problems of pymoo by name: `pymoo:zdt1` is pymoo's class ZDT1; case, `_` and `-` do not count.

The section [pymoo] holds what the class takes, for instance n_var. Bounds, objectives, inequality constraints and the known
optimum or front are pymoo's. Hypervolume is measured from the worst values of a fixed random sample and of the known front.
"""

from __future__ import annotations

import dataclasses
import difflib
import importlib
import inspect
import itertools
import pkgutil
import typing
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import cache
from importlib.metadata import version
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pymoo.core.problem import ElementwiseProblem, Problem

from railsearch.design_problem import DesignProblem, check_own_objectives
from railsearch.errors import InputError, PluginError
from railsearch.hookspecs import hookimpl
from railsearch.interfaces import Host, Outcome, Quantity
from railsearch.parameters import parameter
from railsearch.sampling import random_designs
from railsearch.space import FloatArray, Space, Variable

SECTION = "pymoo"
PREFIX = "pymoo:"
GROUPS = ("single", "multi", "many", "dynamic")
# Names in `pymoo.problems.get_problem` that differ from those of the classes.
OTHER_NAMES = {"dtlz1^1": "inverteddtlz1", "sdtlz1": "scaleddtlz1", "knp": "knapsack"}
# What pymoo wants to be given.
DEFAULTS = {"n_var": 10, "n_obj": 2, "difficulty": 1, "difficulty_factors": 1}
WORST_OF = 400
MEANINGS = {"n_var": "variables", "n_obj": "objectives"}
# Variables that are whole by the definition of the problem, and by the optimum that pymoo states, but not declared so.
WHOLE = {"zdt5": slice(None), "pressurevessel": slice(0, 2)}


class PymooTests:
    """Test problems of pymoo by name, for instance pymoo:zdt1 or pymoo:g6."""

    @staticmethod
    def members() -> Sequence[str]:
        """The names that can stand after `pymoo:`."""
        return _usable()

    @staticmethod
    def member(name: str) -> PymooTest:
        """The test problem of that name. Raises PluginError for a name that pymoo does not have or that needs more."""
        known, key = _classes(), _key(name)
        if key not in known:
            close = [PREFIX + other for other in difflib.get_close_matches(key, PymooTests.members(), n=3)]
            hint = f", did you mean {' or '.join(close)}?" if close else ";"
            raise PluginError(
                f"unknown problem '{PREFIX}{name}'{hint} `railsearch describe {PREFIX}NAME` lists pymoo's names"
            )
        reason = _reason_against(known[key])
        if reason:
            raise PluginError(f"problem '{PREFIX}{name}' {reason}")
        return PymooTest(PREFIX + name, known[key])


class PymooTest:
    """One test problem as a plugin: makes it with other arguments than pymoo's defaults."""

    available_objectives: Sequence[Quantity] = ()

    def __init__(self, name: str, problem_class: type[Problem]) -> None:
        self.name = name
        self.problem_class = problem_class
        own = inspect.cleandoc(vars(problem_class).get("__doc__") or "")
        self.__doc__ = f"pymoo's test problem {problem_class.__name__}.\n\n{own}".strip()

    def sections(self, host: Host) -> Mapping[str, object]:
        """What pymoo's class takes."""
        return {SECTION: _parameters(self.problem_class)()}

    def make(self, host: Host, objectives: Sequence[str], sections: Mapping[str, Any]) -> DesignProblem:
        """The problem. Raises InputError for arguments that pymoo does not accept, and for equality constraints."""
        made = _evaluable(self.name, self.problem_class, _given(self.problem_class, sections[SECTION]))
        check_own_objectives(made, objectives)
        made.worst.update(_worst(made))
        return made


class PymooProblem(DesignProblem):
    """A test problem of pymoo under its name here; there is no reference design."""

    def __init__(self, name: str, inner: Problem) -> None:
        whole = _whole(inner)
        variables = [
            Variable(f"x{k + 1}", float(inner.xl[k]), float(inner.xu[k]), integer=bool(whole[k])) for k in range(inner.n_var)
        ]
        names = ["f"] if inner.n_obj == 1 else [f"f{k + 1}" for k in range(inner.n_obj)]
        super().__init__(
            name, Space(tuple(variables)), [Quantity(label) for label in names], n_constraints=inner.n_ieq_constr
        )
        self.inner = inner

    def simulate(self, design: FloatArray) -> Outcome:
        """Objectives and constraints at a design (d,)."""
        found = self.inner.evaluate(design.astype(int) if self.space.integer.all() else design, return_as_dictionary=True)
        constraints = np.asarray(found["G"], dtype=float) if self.n_ieq_constr else np.empty(0)
        return Outcome(np.asarray(found["F"], dtype=float), constraints=constraints)

    def _calc_pareto_set(self) -> FloatArray | None:
        stated = _stated(self.inner, "pareto_set")
        return None if stated is None else stated.reshape(-1, self.n_var)

    def _calc_pareto_front(self) -> FloatArray | None:
        """With one objective the value at the stated optimum, which is more exact than the stated value."""
        optima = self.pareto_set()
        if self.n_obj == 1 and optima is not None:
            best: FloatArray = np.min([self.simulate(design).objectives for design in optima], axis=0, keepdims=True)
            return best
        stated = _stated(self.inner, "pareto_front")
        return None if stated is None else stated.reshape(-1, self.n_obj)


def _evaluable(name: str, problem_class: type[Problem], chosen: Mapping[str, Any]) -> PymooProblem:
    """A problem that has been evaluated once. Raises InputError for what pymoo cannot do, and for equality constraints."""
    try:
        made = PymooProblem(name, problem_class(**chosen))
        made.simulate(made.space.from_unit(np.full(made.n_var, 0.5)))
    except Exception as error:
        # pymoo's problems raise anything for arguments that they cannot take.
        if chosen:
            raise InputError(f"{SECTION}: {problem_class.__name__} of pymoo cannot take {chosen}: {_told(error)}") from error
        raise InputError(f"problem '{name}': pymoo {version('pymoo')} cannot evaluate it: {_told(error)}") from error
    if made.inner.n_eq_constr:
        raise InputError(
            f"problem '{name}': strategies here know inequality constraints only, received {made.inner.n_eq_constr} "
            "equalities; take a problem without them"
        )
    return made


def _told(error: Exception) -> str:
    """What an error says; pymoo's own ones have the words first and then what caused them."""
    if type(error) is Exception and error.args:
        return str(error.args[0])
    return f"{type(error).__name__}: {error}"


@cache
def _usable() -> Sequence[str]:
    """The names of the problems that can be made as they are."""
    names = []
    for key, problem_class in _classes().items():
        if not _reason_against(problem_class):
            with suppress(InputError), np.errstate(all="ignore"):
                _evaluable(key, problem_class, _given(problem_class, _parameters(problem_class)()))
                names.append(key)
    return sorted(names)


def _stated(inner: Problem, what: str) -> FloatArray | None:
    """What pymoo states without a download and the same each time; None where it states nothing or fails to."""
    if "Remote" in getattr(type(inner), f"_calc_{what}").__code__.co_names:
        return None
    try:
        stated, again = (np.array(getattr(inner, what)(use_cache=False), dtype=float) for _ in range(2))
    except Exception:  # noqa: BLE001 - several of pymoo's problems fail here, each in its own way
        return None
    return stated if stated.size and np.isfinite(stated).all() and np.array_equal(stated, again) else None


def _worst(problem: PymooProblem) -> dict[str, float]:
    """The worst values of several objectives in a fixed sample and on the known front, to three digits."""
    if problem.n_obj == 1:
        return {}
    designs = random_designs(problem.space, WORST_OF, np.random.default_rng(0))
    front = problem.pareto_front()
    values = np.vstack([problem.evaluate(designs, return_values_of=["F"]), *([] if front is None else [front])])
    finite = np.isfinite(values).all(axis=1)
    if not finite.any():
        raise InputError(
            f"{SECTION}: {type(problem.inner).__name__} of pymoo has no finite values with these arguments; choose others"
        )
    worst = values[finite].max(axis=0)
    return {objective.name: float(f"{value:.3g}") for objective, value in zip(problem.objectives, worst, strict=True)}


def _whole(inner: Problem) -> NDArray[np.bool_]:
    """Which variables (d,) take whole numbers."""
    whole = np.full(inner.n_var, inner.vtype in (int, bool))
    whole[WHOLE.get(_key(type(inner).__name__), slice(0))] = True
    return whole


def _key(name: str) -> str:
    key = name.lower().replace("_", "").replace("-", "")
    return OTHER_NAMES.get(key, key)


@cache
def _classes() -> Mapping[str, type[Problem]]:
    """The problem classes of pymoo by lower-case name; common bases of several problems, which compute nothing, left out."""
    found: dict[str, type[Problem]] = {}
    for module in _modules():
        for name, value in vars(module).items():
            own = inspect.isclass(value) and issubclass(value, Problem) and value.__module__ == module.__name__
            if own and value._evaluate not in (Problem._evaluate, ElementwiseProblem._evaluate):
                found.setdefault(_key(name), value)
    return found


def _modules() -> Iterator[Any]:
    for group in GROUPS:
        package = importlib.import_module(f"pymoo.problems.{group}")
        for info in pkgutil.iter_modules(package.__path__, f"{package.__name__}."):
            yield importlib.import_module(info.name)


def _reason_against(problem_class: type[Problem]) -> str:
    """Why a problem cannot be made by name; empty where it can."""
    if problem_class.__module__.startswith("pymoo.problems.dynamic"):
        return "changes with time; a search here takes a problem that stands still"
    arguments, _ = _arguments(problem_class)
    wanted = [a.name for a in arguments if a.default is a.empty and a.name not in DEFAULTS]
    needs = " and ".join(wanted)
    return (
        f"needs {needs}, which a file of settings cannot give; register a problem of your own that makes it" if needs else ""
    )


def _arguments(problem_class: type[Problem]) -> tuple[list[inspect.Parameter], Mapping[str, Any]]:
    """The arguments of the first constructor in line that names any, and their types.

    Where a subclass passes arguments on without naming them, it gives those that must be given.
    """
    passed_on = False
    line = itertools.takewhile(lambda owner: owner not in (ElementwiseProblem, Problem), problem_class.__mro__)
    for owner in (owner for owner in line if "__init__" in vars(owner)):
        signature = list(inspect.signature(vars(owner)["__init__"]).parameters.values())[1:]
        named = [a for a in signature if a.kind in (a.POSITIONAL_OR_KEYWORD, a.KEYWORD_ONLY)]
        if named or not signature:
            return [a for a in named if not passed_on or a.default is not a.empty], _hints(owner)
        passed_on = True
    return [], {}


def _hints(owner: type) -> Mapping[str, Any]:
    try:
        return typing.get_type_hints(vars(owner)["__init__"])
    except NameError:
        return {}


def _parameters(problem_class: type[Problem]) -> Callable[[], Any]:
    """The section's dataclass: the numbers, texts and switches that pymoo's class takes."""
    arguments, hints = _arguments(problem_class)
    fields = []
    for argument in arguments:
        kind = _kind(argument, hints.get(argument.name))
        if kind is not None:
            default = DEFAULTS[argument.name] if argument.default is argument.empty else argument.default
            meaning = MEANINGS.get(argument.name, f"as pymoo's {problem_class.__name__} has it")
            fields.append((argument.name, kind if default is not None else kind | None, parameter(default, meaning=meaning)))
    return dataclasses.make_dataclass("PymooParameters", fields, frozen=True)


def _kind(argument: inspect.Parameter, hint: Any) -> Any:
    """The type of a setting; None for what a file of settings cannot give."""
    options = typing.get_args(hint) or (hint, type(argument.default))
    return next((option for option in options if option in (bool, int, float, str)), None)


def _given(problem_class: type[Problem], chosen: Any) -> dict[str, Any]:
    """What is handed to pymoo's class: where it has a default of its own, only what differs from it."""
    defaults = {argument.name: argument.default for argument in _arguments(problem_class)[0]}
    return {name: value for name, value in dataclasses.asdict(chosen).items() if value != defaults[name]}


@hookimpl
def railsearch_problems(register: Callable[[str, Any], None]) -> None:
    """Register the family."""
    register(f"{PREFIX}NAME", PymooTests)
