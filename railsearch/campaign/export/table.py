"""All evaluations of a campaign in one tidy table: a row per evaluation, units in the metadata of the columns.

Variables, quantities (objectives and metrics) and constraints have columns under their own names; a problem that lacks one
has nulls in it, and so has an evaluation without a value. Where a name stands for two things, its kind and unit are added.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from railsearch.campaign.cells import CampaignProblem
from railsearch.campaign.export.recorded import Recorded, recorded_cells
from railsearch.campaign.measure import HYPERVOLUME, Box, Measure, measure_of
from railsearch.campaign.results import CampaignResults, CellRecord
from railsearch.data_table import Column, data_table, with_unit, write_csv_table, write_parquet_table
from railsearch.design_problem import DesignProblem
from railsearch.interfaces import Quantity
from railsearch.result import quantities
from railsearch.space import FloatArray

if TYPE_CHECKING:
    import pyarrow as pa

FORMAT = "railsearch results 1"
VARIABLE, QUANTITY, CONSTRAINT = KINDS = ("variable", "quantity", "constraint")
OWN_COLUMNS = (
    *("campaign", "problem", "strategy", "repetition", "evaluation"),
    *("feasible", "best_so_far", "hypervolume_so_far", "origin", "trajectory", "reason", "duration", "overhead"),
)


@dataclass(frozen=True)
class Described:
    """What a problem gives a column for: a variable, quantity or constraint. Equal ones share it."""

    kind: str
    name: str
    unit: str = ""
    meaning: str = field(default="", compare=False)


def results_table(results: CampaignResults, identity: Mapping[str, Any] | None = None) -> pa.Table:
    """The table: campaign, problem, strategy, repetition, evaluation (from 1), what was evaluated and what became of it.

    identity: that of the campaign, with which a table can be read back (`recorded_runs`).

    Objectives and metrics have their natural sign; `best_so_far` is that of a problem with one objective,
    `hypervolume_so_far` that of one with more, between the ideal and the reference point that the table's metadata state;
    `reason` is null unless the evaluation failed.
    """
    rows = recorded_cells(results)
    measures = {asked.label: _measure(results, asked) for asked in results.campaign.problems}
    described = dict(_described(results, rows))
    columns = [*_places(results, rows), *described.values(), *_measured(measures, rows), *_circumstances(rows)]
    boxes = json.dumps({label: _box(results.problems[label], m.box) for label, m in measures.items() if m.box is not None})
    kinds = json.dumps([(d.kind, d.name, d.unit, column.label) for d, column in described.items()])
    about = {"format": FORMAT, "campaign": results.campaign.name, "hypervolume_boxes": boxes, "described": kinds}
    return data_table(columns, about if identity is None else {**about, "identity": json.dumps(identity)})


def write_parquet(results: CampaignResults, path: Path, identity: Mapping[str, Any] | None = None) -> None:
    """Write the table as a Parquet file, whole or not at all. Raises StorageError if it cannot be written."""
    write_parquet_table(results_table(results, identity), path)


def write_csv(results: CampaignResults, path: Path) -> None:
    """Write the table as a CSV file with units in the header, whole or not at all. Raises StorageError."""
    write_csv_table(results_table(results), path)


def _places(results: CampaignResults, rows: Recorded) -> Iterator[Column]:
    """Which evaluation of which cell a row is."""
    import pyarrow as pa

    lengths = [len(record.objectives) for _, record in rows]
    cell = pa.array(np.repeat(np.arange(len(rows)), lengths))
    for label, names in (
        ("campaign", [results.campaign.name for _ in rows]),
        ("problem", [cell.problem for cell, _ in rows]),
        ("strategy", [cell.strategy for cell, _ in rows]),
    ):
        yield Column(label, pa.array(names, pa.string()).take(cell))
    yield Column("repetition", pa.array([cell.repetition for cell, _ in rows], pa.int64()).take(cell), meaning="from 1")
    numbers = [np.arange(1, length + 1) for length in lengths]
    yield Column("evaluation", pa.array(np.concatenate([np.empty(0, int), *numbers])), meaning="from 1")


def _described(results: CampaignResults, rows: Recorded) -> Iterator[tuple[Described, Column]]:
    """What problems describe with its columns: variables, then quantities, then constraints."""
    import pyarrow as pa

    cells = [_values(results.problems[cell.problem], record) for cell, record in rows]
    ordered = sorted(dict.fromkeys(chain.from_iterable(cells)), key=lambda described: KINDS.index(described.kind))
    for described in ordered:
        chunks = [
            values.get(described, np.full(len(record.objectives), np.nan))
            for values, (_, record) in zip(cells, rows, strict=True)
        ]
        values = pa.array(np.concatenate(chunks), from_pandas=True)
        whole = described.kind == VARIABLE and _whole(results, described)
        values = values.cast(pa.int64()) if whole else values
        yield described, Column(_label(described, ordered), values, described.unit, described.meaning)


def _values(problem: DesignProblem, record: CellRecord) -> dict[Described, FloatArray]:
    """The values (n,) of everything that a problem describes, quantities with their natural sign."""
    variables = {
        Described(VARIABLE, variable.name, variable.unit, variable.meaning): values
        for variable, values in zip(problem.space.variables, record.designs.T, strict=True)
    }
    known = {quantity.name: quantity for quantity in quantities(problem)}
    objectives = {q.name: values for q, values in zip(problem.objectives, record.objectives.T, strict=True)}
    stored = objectives | {name: values for name, values in record.metrics.items() if name not in objectives}
    described = [(known.get(name, Quantity(name)), values) for name, values in stored.items()]
    named = {Described(QUANTITY, q.name, q.unit, q.meaning): 0.0 - v if q.maximised else v for q, v in described}
    constraints = {
        Described(CONSTRAINT, f"constraint {number}", meaning="kept when ≤ 0"): values
        for number, values in enumerate(record.constraints.T, 1)
    }
    return variables | named | constraints


def _whole(results: CampaignResults, described: Described) -> bool:
    """Whether a variable is an integer in every problem that has it."""
    variables = chain.from_iterable(problem.space.variables for problem in results.problems.values())
    return all(v.integer for v in variables if (v.name, v.unit) == (described.name, described.unit))


def _label(described: Described, all_described: Collection[Described]) -> str:
    """The name, with kind and unit where it alone could be mistaken for something else."""
    alone = sum(other.name == described.name for other in all_described) == 1 and described.name not in OWN_COLUMNS
    return described.name if alone else with_unit(f"{described.kind} {described.name}", described.unit)


def _measured(measures: Mapping[str, Measure], rows: Recorded) -> Iterator[Column]:
    """Feasibility, and the measure by which each problem compares its runs, so far."""
    import pyarrow as pa

    feasible = [record.feasible for _, record in rows]
    yield Column("feasible", pa.array(np.concatenate([np.empty(0, bool), *feasible])), meaning="kept all constraints")
    own = [measures[cell.problem] for cell, _ in rows]
    curves = [m.natural(m.curve(record, len(record.objectives))) for m, (_, record) in zip(own, rows, strict=True)]
    units = {measure.quantity.unit for measure in measures.values() if measure.box is None}
    for label, several, unit, meaning in (
        ("best_so_far", False, units.pop() if len(units) == 1 else "", "best objective so far, feasible designs only"),
        ("hypervolume_so_far", True, "", HYPERVOLUME.meaning),
    ):
        chunks = [
            curve if (measure.box is not None) == several else np.full(len(curve), np.nan)
            for measure, curve in zip(own, curves, strict=True)
        ]
        yield Column(label, pa.array(np.concatenate([np.empty(0), *chunks]), from_pandas=True), unit, meaning)


def _measure(results: CampaignResults, asked: CampaignProblem) -> Measure:
    records = [record for cell, record in results.records.items() if cell.problem == asked.label]
    return measure_of(results.problems[asked.label], asked, records)


def _box(problem: DesignProblem, box: Box) -> dict[str, Any]:
    """The ideal and the reference point by objective, with their natural sign."""
    signs = np.array([-1.0 if quantity.maximised else 1.0 for quantity in problem.objectives])
    names = [quantity.name for quantity in problem.objectives]
    ideal, reference = (dict(zip(names, (signs * point).tolist(), strict=True)) for point in (box.ideal, box.reference))
    return {"ideal": ideal, "reference": reference, "source": box.source}


def _circumstances(rows: Recorded) -> Iterator[Column]:
    """How an evaluation came about, whether it failed, and what it took."""
    import pyarrow as pa

    records = [record for _, record in rows]
    origins = chain.from_iterable(record.origins for record in records)
    reasons = chain.from_iterable(record.reasons for record in records)
    yield Column("origin", pa.array(list(origins), pa.string()), meaning="how the design came about")
    trajectories = [np.empty(0, np.int64), *(record.trajectories for record in records)]
    yield Column("trajectory", pa.array(np.concatenate(trajectories)), meaning="restarts before it")
    yield Column("reason", pa.array([reason or None for reason in reasons], pa.string()), meaning="why it failed")
    durations = [np.empty(0), *(record.durations for record in records)]
    yield Column("duration", pa.array(np.concatenate(durations)), "s", "time inside the evaluation")
    overheads = [np.empty(0), *(record.overheads for record in records)]
    yield Column("overhead", pa.array(np.concatenate(overheads)), "s", "time inside the strategy before it")
