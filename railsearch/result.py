"""What a run found, as one plain document: the content of result.json and of every table and report."""

import dataclasses
import importlib.metadata
import math
import platform
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from railsearch.design_problem import DesignProblem
from railsearch.interfaces import Evaluation, Quantity
from railsearch.plugin_manager import Registry
from railsearch.preferences import StatedPreference, described, scores
from railsearch.run import RunResult, best, front
from railsearch.wording import readable

# A search is told to start without a slope when more than half of so many evaluations are alike.
START = 20
FEWEST_AT_START = 10
LIBRARIES = ("railsearch", "numpy", "scipy", "numba", "pymoo", "optuna", "pluggy")


@dataclass(frozen=True)
class RunCommand:
    """How a run was asked for: the command line, and what identifies the run."""

    line: str
    identity: Mapping[str, Any]


def result_document(registry: Registry, problem: DesignProblem, command: RunCommand, result: RunResult) -> dict[str, Any]:
    """Everything about a run in plain JSON types, objectives and metrics with their natural sign."""
    reference = reference_evaluation(problem, result.evaluations)
    found = best(result.evaluations, None if reference is None else reference.objectives)
    identity = command.identity
    done = len(result.evaluations) >= min(identity["budget"], problem.space.size)
    return {
        "format": "railsearch result 1",
        "status": "complete" if done else "incomplete",
        "command": command.line,
        "problem": problem_document(problem) | {"sections": identity["sections"]},
        "strategy": identity["strategy"],
        "scalariser": identity["scalariser"] and identity["scalariser"] | _scalariser(problem),
        "budget": identity["budget"],
        "seed": identity["seed"],
        "evaluations": [evaluation_document(problem, evaluation) for evaluation in result.evaluations],
        "failed": len(result.failures),
        "repeats": result.repeats,
        "best": found and evaluation_document(problem, found),
        "reference": reference and evaluation_document(problem, reference),
        "front": [evaluation_document(problem, evaluation) for evaluation in front(result.evaluations)],
        "improvement": improvement(problem, reference, found),
        "warnings": [warning] if (warning := flat_start(problem, result.evaluations)) else [],
        "preferences": preference_scores(stated_preferences(problem), problem, {"reference": reference, "best": found}),
        "findings": [dataclasses.asdict(finding) | {"value": _finite(finding.value)} for finding in result.findings],
        "versions": versions(),
        "plugins": plugins_used(registry, identity),
        "seconds": sum(evaluation.duration + evaluation.overhead for evaluation in result.evaluations),
    }


def reference_evaluation(problem: DesignProblem, evaluations: Sequence[Evaluation]) -> Evaluation | None:
    """The successful evaluation of the reference design, if there is one."""
    if problem.reference is None:
        return None
    same = (e for e in evaluations if not e.failed and np.array_equal(e.design, problem.reference))
    return next(same, None)


def quantities(problem: DesignProblem) -> list[Quantity]:
    """Objectives and metrics, each name once."""
    return list({quantity.name: quantity for quantity in (*problem.objectives, *problem.metrics)}.values())


def values_of(problem: DesignProblem, evaluation: Evaluation) -> dict[str, float]:
    """Objectives and metrics of an evaluation by name, with their natural sign."""
    stored = {q.name: float(v) for q, v in zip(problem.objectives, evaluation.objectives, strict=True)}
    return {
        quantity.name: _natural(quantity, stored.get(quantity.name, evaluation.metrics.get(quantity.name, math.nan)))
        for quantity in quantities(problem)
    }


def improvement(problem: DesignProblem, reference: Evaluation | None, found: Evaluation | None) -> dict[str, float | None]:
    """How much better than the reference the found design is, by quantity, in per cent of the reference's value.

    A reduction counts as positive, for a maximised quantity an increase. The scalar of a scalarised problem is left out.
    """
    if reference is None or found is None:
        return {}
    before, after = values_of(problem, reference), values_of(problem, found)
    percent = {}
    for quantity in quantities(problem.simulated):
        start = before[quantity.name]
        gain = (start - after[quantity.name]) * (-1.0 if quantity.maximised else 1.0)
        percent[quantity.name] = _finite(100.0 * gain / abs(start)) if start else None
    return percent


def problem_document(problem: DesignProblem) -> dict[str, Any]:
    """Name, quantities and variables of a problem in plain JSON types."""
    return {
        "name": problem.name,
        "label": problem.label,
        "objectives": [dataclasses.asdict(quantity) for quantity in problem.objectives],
        "metrics": [dataclasses.asdict(quantity) for quantity in problem.metrics],
        "variables": [dataclasses.asdict(variable) for variable in problem.space.variables],
    }


def evaluation_document(problem: DesignProblem, evaluation: Evaluation) -> dict[str, Any]:
    """An evaluation in plain JSON types; what is not a finite number is null."""
    objectives = zip(problem.objectives, evaluation.objectives, strict=True)
    kinds = {quantity.name: quantity for quantity in problem.metrics}
    return {
        "number": evaluation.number + 1,
        "design": problem.space.named(evaluation.design),
        "objectives": {quantity.name: _finite(_natural(quantity, float(value))) for quantity, value in objectives},
        "metrics": {
            name: _finite(_natural(kinds.get(name, Quantity(name)), value)) for name, value in evaluation.metrics.items()
        },
        "violation": _finite(evaluation.violation),
        "origin": evaluation.origin,
        "trajectory": evaluation.trajectory,
        "reason": evaluation.reason,
        "duration": evaluation.duration,
        "overhead": evaluation.overhead,
    }


def scalariser_values(problem: DesignProblem) -> dict[str, Any]:
    """The numbers that a scalariser works with, once it knows them."""
    scalariser = getattr(problem, "scalariser", None)
    return dict(scalariser.values) if scalariser is not None and scalariser.ready else {}


def stated_preferences(problem: DesignProblem) -> Sequence[StatedPreference]:
    """The preferences that a problem is scalarised by; empty if it is not."""
    stated: Sequence[StatedPreference] = getattr(getattr(problem, "scalariser", None), "preferences", ())
    return stated


def preference_scores(
    preferences: Sequence[StatedPreference], problem: DesignProblem, evaluations: Mapping[str, Evaluation | None]
) -> list[dict[str, Any]]:
    """Every preference in plain JSON types with the scores, 0 to 100, of labelled evaluations; null where there is none."""
    rows = [described(preference) | {"scores": dict.fromkeys(evaluations)} for preference in preferences]
    for label, evaluation in evaluations.items():
        if evaluation is not None and preferences:
            values = {name: np.array([value]) for name, value in values_of(problem, evaluation).items()}
            for row, score in zip(rows, scores(preferences, values)[0], strict=True):
                row["scores"][label] = _finite(float(score))
    return rows


def flat_start(problem: DesignProblem, evaluations: Sequence[Evaluation]) -> str:
    """A warning if more than half of the first evaluations of a scalarised problem have exactly the same scalar, else empty.

    It names the quantities whose scores are clipped there, for at least half of these designs or else for any.
    """
    made = [evaluation for evaluation in evaluations[:START] if not evaluation.failed]
    if problem.simulated is problem or problem.n_obj > 1 or len(made) < FEWEST_AT_START:
        return ""
    scalar, count = Counter(float(evaluation.objectives[0]) for evaluation in made).most_common(1)[0]
    if 2 * count <= len(made):
        return ""
    told = (
        f"{count} of the first {len(made)} evaluations have exactly the same {problem.objectives[0].name}, "
        f"{readable(scalar)}: there the search has nothing to go by"
    )
    names = _clipped(problem, [evaluation for evaluation in made if evaluation.objectives[0] == scalar])
    remedy = "set extended = true in its preference function, or give it a wider range"
    return f"{told}. The score of {', '.join(names)} is clipped; {remedy}" if names else told


def _clipped(problem: DesignProblem, evaluations: Sequence[Evaluation]) -> list[str]:
    """The quantities whose scores are clipped, for at least half of the evaluations or else for any."""
    values = [values_of(problem, evaluation) for evaluation in evaluations]
    share: dict[str, float] = {}
    for preference in stated_preferences(problem):
        name, knots = preference.quantity.name, preference.function.knots
        inside = [min(knots) <= row[name] <= max(knots) for row in values]
        clipped = 0.0 if preference.function.extended else 1.0 - float(np.mean(inside))
        share[name] = max(share.get(name, 0.0), clipped)
    return [name for name in share if share[name] >= 0.5] or [name for name in share if share[name] > 0.0]


def versions() -> dict[str, str]:
    """Versions of Python and of the libraries that results depend on."""
    return {"python": platform.python_version()} | {name: importlib.metadata.version(name) for name in LIBRARIES}


def plugins_used(registry: Registry, identity: Mapping[str, Any]) -> list[dict[str, str]]:
    """Where the plugins of a run or sample come from: those that it names, and all track models and surrogates."""
    names = {("problem", identity["problem"])}
    names |= {(kind, identity[kind]["name"]) for kind in ("strategy", "scalariser") if identity.get(kind)}
    return [
        {"kind": entry.kind, "name": entry.name, **dataclasses.asdict(entry.provenance)}
        for entry in registry.entries()
        if (entry.kind, entry.name) in names or entry.kind in ("track-model", "surrogate")
    ]


def _scalariser(problem: DesignProblem) -> dict[str, Any]:
    objectives = [objective.name for objective in problem.simulated.objectives]
    return {"objectives": objectives, "values": scalariser_values(problem)}


def _natural(quantity: Quantity, value: float) -> float:
    return quantity.sign * value


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
