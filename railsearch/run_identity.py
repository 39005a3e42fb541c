"""What identifies a run, in plain JSON types: enough to make its problem, settings and given designs again."""

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from railsearch.design_problem import DesignProblem
from railsearch.parameters import make_parameters
from railsearch.plugin_manager import Registry
from railsearch.problem_factory import ProblemSettings, checked_sections, make_problem, natural_worst
from railsearch.run import RunSettings
from railsearch.space import FloatArray


def run_identity(
    registry: Registry,
    asked: ProblemSettings,
    problem: DesignProblem,
    settings: RunSettings,
    given: Sequence[FloatArray],
) -> dict[str, Any]:
    """The identity of a run of `problem`, which `asked` made; every default is spelt out."""
    identity = problem_identity(registry, asked, problem, given) | {
        "strategy": {
            "name": settings.strategy,
            "settings": all_settings(registry, "strategy", settings.strategy, settings.strategy_settings),
        },
        "budget": settings.budget,
        "seed": settings.seed,
        "batch": settings.batch_size,
    }
    if settings.initial_seed is not None:
        identity["initial_seed"] = settings.initial_seed
    return identity


def problem_identity(
    registry: Registry, asked: ProblemSettings, problem: DesignProblem, given: Sequence[FloatArray]
) -> dict[str, Any]:
    """The part of a run's identity that says what is searched."""
    sections = checked_sections(registry, asked.name, asked.sections, "parameters")
    return {
        "problem": asked.name,
        "objectives": [objective.name for objective in problem.simulated.objectives],
        "scalariser": _scalariser(registry, asked),
        "given": [problem.space.named(design) for design in given],
        "worst": natural_worst(problem.simulated),
        "sections": {section: dataclasses.asdict(values) for section, values in sections.items()},
    }


def all_settings(registry: Registry, kind: str, name: str, settings: Mapping[str, object]) -> dict[str, Any]:
    """The settings of a plugin with its defaults. Raises InputError for one that is unknown or not allowed."""
    parameters = make_parameters(registry.get(kind, name).Parameters, settings, f"{kind} {name}")
    return dataclasses.asdict(parameters)


def problem_of(registry: Registry, identity: Mapping[str, Any], where: str) -> DesignProblem:
    """The problem of a run; `where` names the identity's place in errors."""
    return make_problem(registry, problem_settings_of(identity), where)


def problem_settings_of(identity: Mapping[str, Any]) -> ProblemSettings:
    """What makes the problem of a run."""
    scalariser = identity["scalariser"] or {"name": None, "settings": {}}
    return ProblemSettings(
        identity["problem"],
        tuple(identity["objectives"]),
        identity["sections"],
        scalariser["name"],
        scalariser["settings"],
        identity["worst"],
    )


def settings_of(identity: Mapping[str, Any], timeout: float | None = None, workers: int = 1) -> RunSettings:
    """The settings of a run; the time limit of an evaluation and the workers on a batch do not identify it."""
    strategy = identity["strategy"]
    return RunSettings(
        strategy["name"],
        identity["budget"],
        identity["seed"],
        strategy["settings"],
        identity["batch"],
        timeout,
        identity.get("initial_seed"),
        workers,
    )


def given_of(problem: DesignProblem, identity: Mapping[str, Any]) -> list[FloatArray]:
    """The given designs of a run."""
    return [np.array([design[name] for name in problem.space.names], dtype=float) for design in identity["given"]]


def _scalariser(registry: Registry, asked: ProblemSettings) -> dict[str, Any] | None:
    if asked.scalariser is None:
        return None
    settings = all_settings(registry, "scalariser", asked.scalariser, asked.scalariser_settings)
    return {"name": asked.scalariser, "settings": settings}
