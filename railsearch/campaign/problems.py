"""The problems of a campaign: from a table of its file, and the site file that it may name, to a checked problem."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from railsearch.campaign.cells import Campaign, CampaignProblem
from railsearch.campaign.faults import Faults
from railsearch.design_problem import DesignProblem, ScalarisedProblem
from railsearch.errors import InputError
from railsearch.objective_values import check_finite
from railsearch.plugin_manager import Registry
from railsearch.problem_factory import (
    ProblemSettings,
    amended_design,
    checked_sections,
    make_problem,
    natural_worst,
)
from railsearch.run_identity import all_settings
from railsearch.site import Site, named_faults, preference_settings, read_site


@dataclass(frozen=True)
class ProblemTable:
    """A table [[problem]] of a campaign file."""

    name: str = ""
    label: str | None = None
    objectives: tuple[str, ...] = ()
    scalarise: str | None = None
    scalariser_settings: dict[str, Any] | None = None
    preferences: str | None = None
    parameters: str | None = None
    sections: dict[str, Any] | None = None
    worst: dict[str, Any] | None = None
    given: tuple[dict[str, Any], ...] = ()
    reference_point: dict[str, Any] | None = None


def make_problems(registry: Registry, campaign: Campaign) -> dict[str, DesignProblem]:
    """The problems of a campaign as objects by label. Raises PluginError, InputError or CapabilityError."""
    return {
        problem.label: make_problem(registry, problem.settings, f"problem {problem.label}") for problem in campaign.problems
    }


def read_problem(
    registry: Registry, table: ProblemTable, label: str, folder: Path, strategies: Sequence[str], faults: Faults
) -> CampaignProblem | None:
    """The problem of a table under a label, or None when it has faults, which are noted.

    folder: where the paths of site and preference file begin; strategies: by which the problem is searched.
    """
    where, before = f"problem {label}", len(faults.messages)
    with faults.gathered(where):
        registry.entry("problem", table.name)
        site = read_site(folder / table.parameters, registry, table.name) if table.parameters else Site(table.name)
        _check_site_strategies(registry, site, strategies)
        file = folder / table.preferences if table.preferences else None
        preferences = preference_settings(registry, table.scalarise, file)
        settings = _settings(table, site, preferences)
        _check_parts(registry, settings, table.reference_point or {}, where, faults)
        if len(faults.messages) == before:
            with named_faults(table.scalarise, file, site):
                problem = make_problem(registry, settings)
            given = (*site.given, *table.given)
            reference_point = _reference_point(problem, table.reference_point or {})
            _check_first_designs(problem, given, where, faults)
            return CampaignProblem(label, settings, given, reference_point)
    return None


def _settings(table: ProblemTable, site: Site, preferences: Mapping[str, Any]) -> ProblemSettings:
    """What the site file says, overlaid with the preference file and with what the campaign file says."""
    if table.scalariser_settings and table.scalarise is None:
        raise InputError('scalariser_settings: there is no scalariser; name one, for instance scalarise = "asf"')
    return ProblemSettings(
        table.name,
        table.objectives,
        _overlaid(site.sections, table.sections or {}),
        table.scalarise,
        _overlaid({**site.scalarisers.get(table.scalarise or "", {}), **preferences}, table.scalariser_settings or {}),
        _overlaid(site.worst, table.worst or {}),
    )


def _overlaid(below: Mapping[str, Any], above: Mapping[str, Any]) -> dict[str, Any]:
    """Nested tables, the values of `above` replacing those of `below`."""
    tables = {
        key: _overlaid(below[key], value)
        for key, value in above.items()
        if isinstance(value, Mapping) and isinstance(below.get(key), Mapping)
    }
    return {**below, **above, **tables}


def _check_site_strategies(registry: Registry, site: Site, strategies: Sequence[str]) -> None:
    """Refuse settings of the campaign's strategies that a site file changes: every problem must see the same strategy."""
    changed = []
    for name in dict.fromkeys(strategies):
        if name in site.strategies:
            defaults = all_settings(registry, "strategy", name, {})
            settings = all_settings(registry, "strategy", name, site.strategies[name])
            changed += [f"{name}.{key} = {value}" for key, value in settings.items() if value != defaults[key]]
    if changed:
        raise InputError(
            f"the site file changes {', '.join(changed)}; in a campaign the settings of strategies come from the campaign "
            "file, the same for every problem: put them in a table [[strategy]] and take them out of the site file"
        )


def _check_parts(
    registry: Registry, settings: ProblemSettings, reference_point: Mapping[str, Any], where: str, faults: Faults
) -> None:
    """Note every section, name of an objective and setting of the scalariser that is not allowed."""
    sound: dict[str, Any] = {}
    for section, values in settings.sections.items():
        with faults.gathered(where):
            checked_sections(registry, settings.name, {section: values}, "sections")
            sound[section] = values
    if settings.scalariser is not None:
        with faults.gathered(where):
            all_settings(registry, "scalariser", settings.scalariser, settings.scalariser_settings)
    plain = make_problem(registry, ProblemSettings(settings.name, sections=sound))
    known = [quantity.name for quantity in plain.available_objectives or plain.objectives]
    fields = {"objectives": settings.objectives, "worst": settings.worst, "reference_point": reference_point}
    for field, names in fields.items():
        unknown = [f"'{name}'" for name in names if name not in known]
        if unknown:
            faults.add(f"{where}: {field}: unknown {', '.join(unknown)}; there are {', '.join(known)}")


def _reference_point(problem: DesignProblem, asked: Mapping[str, Any]) -> dict[str, float]:
    """The reference point of hypervolume by objective with its natural sign; empty where the worst values serve as it."""
    names = [objective.name for objective in problem.objectives]
    if problem.n_obj < 2:
        if asked:
            raise InputError(f"reference_point: it serves two objectives or more, this problem has {names[0]}; leave it out")
        return {}
    others = [name for name in asked if name not in names]
    if others:
        raise InputError(f"reference_point: {', '.join(others)} is not minimised here; this problem has {', '.join(names)}")
    point: dict[str, Any] = {**natural_worst(problem), **asked}
    missing = [name for name in names if name not in point]
    if missing:
        raise InputError(
            f"reference_point: values of {', '.join(missing)} are needed that good designs do not exceed; hypervolume is "
            "measured from there, the same for all runs"
        )
    for name in names:
        check_finite(point[name], f"reference_point.{name}")
    return {name: float(point[name]) for name in names if asked}


def _check_first_designs(problem: DesignProblem, given: Sequence[Mapping[str, Any]], where: str, faults: Faults) -> None:
    """Note every given design that is not allowed, and a scalariser that waits for a reference design in vain."""
    for number, changes in enumerate(given, start=1):
        with faults.gathered(f"{where}: given design {number}"):
            amended_design(problem, changes)
    waiting = isinstance(problem, ScalarisedProblem) and not problem.scalariser.ready
    if waiting and problem.reference is None:
        faults.add(
            f"{where}: {problem.objectives[0].name} needs the objectives of a reference design, which this problem does not "
            "have; give aspiration values in scalariser_settings"
        )
