"""Make registered problems, with a site's parameters and, if wanted, a scalariser."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, cast

from railsearch.design_problem import DesignProblem, ScalarisedProblem
from railsearch.errors import CapabilityError, InputError
from railsearch.interfaces import Scalariser
from railsearch.parameters import amend_parameters, make_parameters
from railsearch.plugin_manager import Registry


@dataclass(frozen=True)
class ProblemSettings:
    """Which problem: its name, objectives (empty: its default ones), site sections, scalariser and its settings."""

    name: str
    objectives: tuple[str, ...] = ()
    sections: Mapping[str, Any] = field(default_factory=dict)
    scalariser: str | None = None
    scalariser_settings: Mapping[str, object] = field(default_factory=dict)


def checked_sections(registry: Registry, name: str, values: Mapping[str, Any], where: str) -> dict[str, Any]:
    """The sections of a problem as parameters, `values` replacing defaults. Raises InputError."""
    defaults = registry.get("problem", name).sections(registry)
    for section, value in values.items():
        if section not in defaults:
            raise InputError(f"{where}: unknown section [{section}]; problem {name} has {', '.join(defaults) or 'none'}")
        if not isinstance(value, Mapping):
            raise InputError(f"{where}.{section}: a table is needed, received {value!r}")
    return {
        section: amend_parameters(start, values.get(section, {}), f"{where}.{section}")
        for section, start in defaults.items()
    }


def make_problem(registry: Registry, settings: ProblemSettings, where: str = "parameters") -> DesignProblem:
    """The problem, scalarised if asked for. Raises PluginError, InputError or CapabilityError."""
    plugin = registry.get("problem", settings.name)
    sections = checked_sections(registry, settings.name, settings.sections, where)
    base = cast(DesignProblem, plugin.make(registry, settings.objectives, sections))
    if settings.scalariser is None:
        return base
    if base.n_obj < 2:
        raise CapabilityError(
            f"scalariser {settings.scalariser}: two objectives or more are needed, received {base.objectives[0].name} alone"
        )
    scalariser = registry.get("scalariser", settings.scalariser)
    parameters = make_parameters(scalariser.Parameters, settings.scalariser_settings, f"scalariser {settings.scalariser}")
    made = cast(Scalariser, scalariser(parameters, base.objectives, base.worst))
    return ScalarisedProblem(base, settings.scalariser, made)
