"""Make registered problems, with a site's parameters and, if wanted, a scalariser."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, cast

from railsearch.design_problem import DesignProblem, ScalarisedProblem
from railsearch.errors import CapabilityError, InputError, located
from railsearch.interfaces import Quantity, Scalariser
from railsearch.objective_values import minimised, natural
from railsearch.parameters import amend_parameters, check_table, make_parameters
from railsearch.plugin_manager import Registry
from railsearch.preferences import PreferenceParameters, quantities_of
from railsearch.space import FloatArray

GENERAL_SECTIONS = ("worst", "given", "strategy.NAME", "scalariser.NAME")


@dataclass(frozen=True)
class ProblemSettings:
    """Which problem: its name, objectives (empty: its default ones), site sections, scalariser and its settings.

    worst: worst known values by objective, with their natural sign, in place of the problem's own.
    """

    name: str
    objectives: tuple[str, ...] = ()
    sections: Mapping[str, Any] = field(default_factory=dict)
    scalariser: str | None = None
    scalariser_settings: Mapping[str, object] = field(default_factory=dict)
    worst: Mapping[str, Any] = field(default_factory=dict)


def checked_sections(registry: Registry, name: str, values: Mapping[str, Any], where: str) -> dict[str, Any]:
    """The sections of a problem as parameters, `values` replacing defaults. Raises InputError."""
    defaults = registry.get("problem", name).sections(registry)
    check_table(values, where)
    for section, value in values.items():
        if section not in defaults:
            known = ", ".join([*defaults, *GENERAL_SECTIONS])
            raise InputError(f"{where}: unknown section [{section}]; for problem {name} there are {known}")
        check_table(value, f"{where}.{section}")
    return {
        section: amend_parameters(start, values.get(section, {}), f"{where}.{section}")
        for section, start in defaults.items()
    }


def make_problem(registry: Registry, settings: ProblemSettings, where: str = "parameters") -> DesignProblem:
    """The problem, scalarised if asked for. Raises PluginError, InputError or CapabilityError."""
    plugin = registry.get("problem", settings.name)
    sections = checked_sections(registry, settings.name, settings.sections, where)
    base = cast(DesignProblem, plugin.make(registry, settings.objectives, sections))
    base.worst.update(minimised(settings.worst, _known_objectives(base), f"{where}.worst"))
    if settings.scalariser is None:
        return base
    scalariser = registry.get("scalariser", settings.scalariser)
    if base.n_obj < 2:
        raise CapabilityError(
            f"scalariser {settings.scalariser}: two objectives or more are needed, received {base.objectives[0].name} alone"
        )
    parameters = make_parameters(scalariser.Parameters, settings.scalariser_settings, f"scalariser {settings.scalariser}")
    _check_metrics(base, settings.scalariser, parameters)
    made = cast(Scalariser, scalariser(parameters, base.objectives, base.worst))
    return ScalarisedProblem(base, settings.scalariser, made)


def amended_design(problem: DesignProblem, changes: Mapping[str, Any]) -> FloatArray:
    """The reference design with variables changed by name; all of them where there is no reference design."""
    for name, value in changes.items():
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise InputError(f"variable {name}: a number is needed, received {value!r}")
    if problem.reference is not None:
        return problem.space.amended(problem.reference, changes)
    missing = [name for name in problem.space.names if name not in changes]
    if missing:
        raise InputError(f"design: {problem.name} has no reference design; give values for {', '.join(missing)} as well")
    return problem.space.amended(problem.space.lower, changes)


def given_designs(
    problem: DesignProblem, given: Sequence[Mapping[str, Any]] = (), where: str = "given design"
) -> list[FloatArray]:
    """The designs that a run evaluates first: the reference design, then amendments of it, each once.

    Raises InputError for an amendment that is not allowed, by its number and `where` it stands.
    """
    designs = [] if problem.reference is None else [problem.reference]
    for number, changes in enumerate(given, start=1):
        with located(f"{where} {number}"):
            designs.append(amended_design(problem, changes))
    return list({problem.space.key(design): design for design in designs}.values())


def natural_worst(problem: DesignProblem) -> dict[str, float]:
    """The worst known values of a problem by objective, with their natural sign."""
    return natural(problem.worst, _known_objectives(problem))


def _check_metrics(base: DesignProblem, scalariser: str, parameters: object) -> None:
    """Raise InputError for a preference on a metric that is no objective of the search."""
    if not isinstance(parameters, PreferenceParameters):
        return
    stated = {"preferences": parameters.preferences, "stakeholders": getattr(parameters, "stakeholders", None)}
    objectives = [quantity.name for quantity in base.objectives]
    selectable = [quantity.name for quantity in base.available_objectives]
    for metric in base.metrics:
        if metric.name in quantities_of(stated) and metric.name not in objectives:
            more = "; name it with --objectives, or rank" if metric.name in selectable else ": rank"
            raise InputError(
                f"{scalariser}.preferences.{metric.name}: {metric.name} is a metric of {base.name}, not one of its "
                f"objectives ({', '.join(objectives)}){more} the designs of a run by it afterwards with `railsearch choose`"
            )


def _known_objectives(problem: DesignProblem) -> Sequence[Quantity]:
    return problem.available_objectives or problem.objectives
