"""The best design that a campaign has found for a problem, beside the reference design."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from railsearch.campaign.cells import Cell
from railsearch.campaign.results import CellRecord
from railsearch.design_problem import DesignProblem
from railsearch.indicators import non_dominated
from railsearch.interfaces import Evaluation
from railsearch.result import evaluation_document, improvement, problem_document
from railsearch.run import best
from railsearch.space import FloatArray

Place = tuple[Cell, int]


def best_design_document(problem: DesignProblem, records: Mapping[Cell, CellRecord]) -> dict[str, Any]:
    """Problem, reference design, best design of all cells, improvement in per cent, and which cell found it.

    searched: the names of the objectives, those behind a scalar too.
    """
    places = front_places(records)
    members = {place: evaluation_at(records, place) for place in places}
    reference = reference_among(problem, records)
    found = best(list(members.values()), None if reference is None else reference.objectives)
    cell = next((place[0] for place, evaluation in members.items() if evaluation is found), None)
    searched = [quantity.name for quantity in (*problem.objectives, *problem.simulated.objectives)]
    return {
        "problem": problem_document(problem),
        "searched": list(dict.fromkeys(searched)),
        "reference": reference and evaluation_document(problem, reference),
        "best": found and evaluation_document(problem, found),
        "found_by": cell and {"strategy": cell.strategy, "repetition": cell.repetition},
        "front_size": len(places),
        "improvement": improvement(problem, reference, found),
    }


def front_places(records: Mapping[Cell, CellRecord]) -> list[Place]:
    """Where the evaluations are that no other one of all cells dominates; with one objective the first best one."""
    places: list[Place] = []
    values: FloatArray | None = None
    for cell, record in records.items():
        rows = np.flatnonzero(record.feasible)
        new = record.objectives[rows]
        joined = new if values is None else np.concatenate([values, new])
        kept = non_dominated(joined)
        candidates = places + [(cell, int(row)) for row in rows]
        places, values = [candidates[place] for place in kept], joined[kept]
    return places


def evaluation_at(records: Mapping[Cell, CellRecord], place: Place) -> Evaluation:
    """One row of a record as an evaluation."""
    cell, row = place
    record = records[cell]
    return Evaluation(
        number=row,
        design=record.designs[row],
        objectives=record.objectives[row],
        constraints=record.constraints[row],
        metrics={name: float(column[row]) for name, column in record.metrics.items() if not np.isnan(column[row])},
        origin=record.origins[row],
        trajectory=int(record.trajectories[row]),
        reason=record.reasons[row],
        duration=float(record.durations[row]),
        overhead=float(record.overheads[row]),
    )


def reference_among(problem: DesignProblem, records: Mapping[Cell, CellRecord]) -> Evaluation | None:
    """The first successful evaluation of the reference design, if there is one."""
    if problem.reference is None:
        return None
    for cell, record in records.items():
        rows = np.flatnonzero(np.all(record.designs == problem.reference, axis=1) & ~record.failed)
        if rows.size:
            return evaluation_at(records, (cell, int(rows[0])))
    return None
