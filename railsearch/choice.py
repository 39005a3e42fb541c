"""Choosing among the designs that a search has found, by preferences that are stated afterwards."""

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from railsearch.design_problem import DesignProblem
from railsearch.errors import InputError
from railsearch.interfaces import Evaluation, Quantity
from railsearch.parameters import make_parameters
from railsearch.plugin_manager import Registry
from railsearch.preferences import StatedPreference, quantities_of, scores
from railsearch.result import (
    evaluation_document,
    improvement,
    preference_scores,
    problem_document,
    reference_evaluation,
    values_of,
)
from railsearch.run import front
from railsearch.space import FloatArray
from railsearch.wording import closest

FEWEST_FOR_TRADE_OFF = 3


@dataclass(frozen=True)
class Choice:
    """Candidates ranked by preferences, best first.

    problem: with the raw objectives; scalars (n,): what the scalariser makes of the candidates, lower is better; scores
    (n, k) by the k preferences; pseudo_weights (n, m) of the m objectives, empty where the front has no extent.
    """

    problem: DesignProblem
    scalariser: str
    preferences: Sequence[StatedPreference]
    candidates: Sequence[Evaluation]
    scalars: FloatArray
    scores: FloatArray
    pseudo_weights: FloatArray
    nearest: int | None
    trade_offs: Sequence[int]
    reference: Evaluation | None
    n_evaluations: int


def choose(
    registry: Registry,
    problem: DesignProblem,
    evaluations: Sequence[Evaluation],
    scalariser: str,
    settings: Mapping[str, Any],
) -> Choice:
    """Rank the feasible designs that no other one dominates in the problem's objectives, by a scalariser with preferences.

    Of a scalarised problem the raw objectives count. A preference may also be on a metric; the candidates stay the same.
    Equal scalars are ranked by the weighted mean of the scores.
    Raises InputError for one objective, no candidate, and preferences that do not fit.
    """
    base = problem.simulated
    raw = [_raw(base, evaluation) for evaluation in evaluations]
    members = _candidates(base, raw)
    preferences, scalars, graded = _graded(registry, base, members, scalariser, settings)
    order = np.lexsort((-graded @ [preference.weight for preference in preferences], scalars))
    objectives = np.array([members[row].objectives for row in order])
    pseudo = pseudo_weights(objectives)
    return Choice(
        problem=base,
        scalariser=scalariser,
        preferences=preferences,
        candidates=[members[row] for row in order],
        scalars=scalars[order],
        scores=graded[order],
        pseudo_weights=pseudo,
        nearest=_nearest(pseudo, base.objectives, preferences),
        trade_offs=high_trade_offs(objectives),
        reference=reference_evaluation(base, raw),
        n_evaluations=len(raw),
    )


def pseudo_weights(objectives: FloatArray) -> FloatArray:
    """The pseudo-weights w_i ∝ (f_i^max − f_i)/(f_i^max − f_i^min) (n, m) of a front (n, m), each row adding up to 1.

    They tell which objectives a design of the front serves; empty (0, m) where an objective does not vary. By pymoo.
    Source: Deb 2001.
    """
    n_objectives = objectives.shape[1]
    if not np.all(np.ptp(objectives, axis=0) > 0.0):
        return np.empty((0, n_objectives))
    with warnings.catch_warnings():
        # The module imports from a deprecated place in scipy.
        warnings.simplefilter("ignore", DeprecationWarning)
        from pymoo.mcdm.pseudo_weights import PseudoWeights
    _, weights = PseudoWeights(np.full(n_objectives, 1.0 / n_objectives)).do(objectives, return_pseudo_weights=True)
    found: FloatArray = np.asarray(weights)
    return found


def high_trade_offs(objectives: FloatArray) -> list[int]:
    """The rows of a front (n, m) from which every neighbour costs much and gains little; few or none.

    They are pymoo's `HighTradeoffPoints` of the objectives scaled to 0 … 1 over the front.
    """
    extent = np.ptp(objectives, axis=0)
    if len(objectives) < FEWEST_FOR_TRADE_OFF or not np.all(extent > 0.0):
        return []
    with warnings.catch_warnings():
        # It divides by zero on purpose, changes the filters of the whole process, and imports from a deprecated place.
        warnings.simplefilter("ignore")
        from pymoo.mcdm.high_tradeoff import HighTradeoffPoints

        found: NDArray[np.intp] | None = HighTradeoffPoints().do((objectives - objectives.min(axis=0)) / extent)
    return [] if found is None else [int(row) for row in found]


def choice_document(choice: Choice, top: int | None = None) -> dict[str, Any]:
    """A choice in plain JSON types, values with their natural sign; top: how many candidates, by default all."""
    best, problem = choice.candidates[0], choice.problem
    return {
        "format": "railsearch choice 1",
        "problem": problem_document(problem),
        "scalariser": choice.scalariser,
        "evaluations": choice.n_evaluations,
        "candidates": len(choice.candidates),
        "ranking": [_candidate(choice, row) for row in range(len(choice.candidates))[:top]],
        "preferences": preference_scores(choice.preferences, problem, {"reference": choice.reference, "best": best}),
        "best": evaluation_document(problem, best),
        "reference": choice.reference and evaluation_document(problem, choice.reference),
        "improvement": improvement(problem, choice.reference, best),
    }


def _candidate(choice: Choice, row: int) -> dict[str, Any]:
    names = [objective.name for objective in choice.problem.objectives]
    weights = choice.pseudo_weights
    return {
        "rank": row + 1,
        **evaluation_document(choice.problem, choice.candidates[row]),
        "scalar": float(choice.scalars[row]),
        "scores": choice.scores[row].tolist(),
        "pseudo_weights": dict(zip(names, weights[row].tolist(), strict=True)) if len(weights) else None,
        "nearest_pseudo_weights": row == choice.nearest,
        "high_trade_off": row in choice.trade_offs,
    }


def _candidates(base: DesignProblem, evaluations: Sequence[Evaluation]) -> list[Evaluation]:
    """The front of the evaluations. Raises InputError for one objective and for an empty front."""
    if base.n_obj < 2:
        raise InputError(
            f"DIR: this run has one objective, {base.objectives[0].name}, and so one best design; choose among the designs "
            "of a run with several objectives, scalarised or not"
        )
    members = front(evaluations)
    if not members:
        raise InputError(f"DIR: none of the {len(evaluations)} evaluations is feasible, there is nothing to choose from")
    return members


def _graded(
    registry: Registry,
    base: DesignProblem,
    members: Sequence[Evaluation],
    scalariser: str,
    settings: Mapping[str, Any],
) -> tuple[Sequence[StatedPreference], FloatArray, FloatArray]:
    """The preferences of a scalariser made with these settings, and the scalars (n,) and scores (n, k) of the candidates."""
    quantities = _quantities(base, settings)
    plugin = registry.get("scalariser", scalariser)
    made = plugin(make_parameters(plugin.Parameters, settings, f"scalariser {scalariser}"), quantities, base.worst)
    preferences: Sequence[StatedPreference] = getattr(made, "preferences", ())
    if not preferences:
        raise InputError(f"--scalarise: {scalariser} goes by no preference functions; name one that does")
    values = _values(base, members, quantities)
    scalars = made(np.column_stack([quantity.sign * values[quantity.name] for quantity in quantities]))
    return preferences, scalars, scores(preferences, values)


def _raw(base: DesignProblem, evaluation: Evaluation) -> Evaluation:
    """An evaluation with the objectives of the problem behind a scalarised one."""
    if evaluation.failed or evaluation.objectives.size == base.n_obj:
        return evaluation
    objectives = [evaluation.metrics[objective.name] for objective in base.objectives]
    return replace(evaluation, objectives=np.array(objectives))


def _quantities(base: DesignProblem, settings: Mapping[str, Any]) -> list[Quantity]:
    """The objectives, and the metrics on which there are preferences, in the direction that the first of these likes."""
    objectives = [objective.name for objective in base.objectives]
    metrics = {metric.name: metric for metric in base.metrics}
    found = list(base.objectives)
    for name, functions in quantities_of(settings).items():
        if name in objectives:
            continue
        if name not in metrics:
            known = list(dict.fromkeys([*objectives, *metrics]))
            raise InputError(
                f"preferences: unknown objective '{name}'{closest(name, known)}; objectives and metrics of this run are "
                f"{', '.join(known)}"
            )
        found.append(replace(metrics[name], maximised=functions[0].liking == "larger"))
    return found


def _values(base: DesignProblem, members: Sequence[Evaluation], quantities: Sequence[Quantity]) -> dict[str, FloatArray]:
    """The values (n,) of the candidates by quantity, with their natural sign."""
    rows = [values_of(base, member) for member in members]
    values = {quantity.name: np.array([row[quantity.name] for row in rows]) for quantity in quantities}
    for name, column in values.items():
        if not np.isfinite(column).all():
            number = members[int(np.argmin(np.isfinite(column)))].number + 1
            raise InputError(
                f"preferences.{name}: evaluation {number} has no value of {name}; take the preference on it out"
            )
    return values


def _nearest(pseudo: FloatArray, objectives: Sequence[Quantity], preferences: Sequence[StatedPreference]) -> int | None:
    """The row whose pseudo-weights are nearest to the objectives' shares in the stated weights."""
    total = [sum(p.weight for p in preferences if p.quantity.name == objective.name) for objective in objectives]
    if not len(pseudo) or not any(total):
        return None
    return int(np.argmin(np.abs(pseudo - np.array(total) / sum(total)).sum(axis=1)))
