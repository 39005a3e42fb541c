"""Samples as a table in a file: a row per sample, units in the columns, and what the samples are in the metadata.

Columns: the number, from 1; the variables; objectives and metrics with their natural sign; constraints; the reason of a
failure; the seconds of the simulation. A name that another column has already gets its kind before it.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from railsearch.data_table import Column, data_table, write_csv_table, write_parquet_table
from railsearch.design_problem import DesignProblem
from railsearch.errors import InputError
from railsearch.interfaces import Evaluation, Quantity
from railsearch.result import quantities
from railsearch.space import FloatArray

if TYPE_CHECKING:
    import pyarrow as pa

FORMAT = "railsearch samples 1"
ABOUT = "about"
NUMBER, REASON, SECONDS = OWN_COLUMNS = ("number", "reason", "seconds")
VARIABLE, QUANTITY, CONSTRAINT = ("variable", "quantity", "constraint")
PARQUET, CSV = ".parquet", ".csv"


@dataclass(frozen=True)
class Layout:
    """What a column holds, and the label that it has in the file."""

    kind: str
    name: str
    unit: str = ""
    meaning: str = ""
    integer: bool = False
    label: str = ""


def check_suffix(path: Path) -> None:
    """Raise InputError for a name that ends with none of the formats."""
    if path.suffix not in (PARQUET, CSV):
        raise InputError(f"--out: a file name that ends with {PARQUET} or {CSV} is needed, received {path}")


def write_samples(
    path: Path, problem: DesignProblem, evaluations: Sequence[Evaluation], document: Mapping[str, Any]
) -> None:
    """Write evaluations as Parquet or CSV, whole or not at all; `document` says what they are. Raises StorageError."""
    layout = list(_labelled(_layout(problem, evaluations)))
    about = json.dumps({**document, "columns": [asdict(column) for column in layout]}, ensure_ascii=False)
    columns = [_column(column, problem, evaluations) for column in layout]
    table = data_table(columns, {"format": FORMAT, ABOUT: about})
    if path.suffix == PARQUET:
        write_parquet_table(table, path)
    else:
        write_csv_table(table, path, f"{FORMAT} {about}")


def layout_of(about: Mapping[str, Any]) -> list[Layout]:
    """The columns of a file, from what it says about itself."""
    return [Layout(**column) for column in about["columns"]]


def evaluations_in(table: pa.Table, about: Mapping[str, Any], problem: DesignProblem) -> list[Evaluation]:
    """The evaluations that a table of `write_samples` holds."""
    layout = layout_of(about)
    entries = {own: table.column(own).to_pylist() for own in OWN_COLUMNS}
    designs, constraints = (_matrix(table, layout, kind) for kind in (VARIABLE, CONSTRAINT))
    signs = {quantity.name: quantity.sign for quantity in quantities(problem)}
    names = [column.name for column in layout if column.kind == QUANTITY]
    stored = _matrix(table, layout, QUANTITY) * [signs.get(name, 1.0) for name in names]
    places = [names.index(objective.name) for objective in problem.objectives]
    return [
        Evaluation(
            number=entries[NUMBER][row] - 1,
            design=designs[row],
            objectives=stored[row, places],
            constraints=constraints[row],
            metrics=dict(zip(names, stored[row].tolist(), strict=True)),
            origin=about["identity"]["design"],
            reason=entries[REASON][row] or "",
            duration=entries[SECONDS][row],
        )
        for row in range(table.num_rows)
    ]


def _layout(problem: DesignProblem, evaluations: Sequence[Evaluation]) -> Iterator[Layout]:
    yield Layout(NUMBER, NUMBER, meaning="from 1", integer=True)
    for variable in problem.space.variables:
        yield Layout(VARIABLE, variable.name, variable.unit, variable.meaning, variable.integer)
    known = {quantity.name: quantity for quantity in quantities(problem)}
    found = dict.fromkeys(name for evaluation in evaluations for name in evaluation.metrics)
    for name in dict.fromkeys([*known, *found]):
        quantity = known.get(name, Quantity(name))
        yield Layout(QUANTITY, name, quantity.unit, quantity.meaning)
    for number in range(1, problem.n_ieq_constr + 1):
        yield Layout(CONSTRAINT, f"constraint {number}", meaning="kept when ≤ 0")
    yield Layout(REASON, REASON, meaning="why the sample failed")
    yield Layout(SECONDS, SECONDS, "s", "time inside the simulation")


def _labelled(layout: Iterator[Layout]) -> Iterator[Layout]:
    """The columns with labels that are all different; the file's own columns keep theirs."""
    taken = set(OWN_COLUMNS)
    for column in layout:
        label = column.name
        while column.kind not in OWN_COLUMNS and label in taken:
            label = f"{column.kind} {label}"
        taken.add(label)
        yield replace(column, label=label)


def _column(layout: Layout, problem: DesignProblem, evaluations: Sequence[Evaluation]) -> Column:
    import pyarrow as pa

    if layout.kind == REASON:
        values = pa.array([evaluation.reason or None for evaluation in evaluations], pa.string())
    else:
        values = pa.array(_numbers(layout, problem, evaluations), from_pandas=True)
        values = values.cast(pa.int64()) if layout.integer else values
    return Column(layout.label, values, layout.unit, layout.meaning)


def _numbers(layout: Layout, problem: DesignProblem, evaluations: Sequence[Evaluation]) -> FloatArray:
    """The numbers (n,) of a column, NaN where there is none."""
    if layout.kind == QUANTITY:
        return natural_values(problem, evaluations, layout.name)
    if layout.kind == VARIABLE:
        place = problem.space.names.index(layout.name)
        return np.array([evaluation.design[place] for evaluation in evaluations])
    if layout.kind == CONSTRAINT:
        place = int(layout.name.split()[-1]) - 1
        return np.array([evaluation.constraints[place] for evaluation in evaluations])
    if layout.kind == NUMBER:
        return np.array([evaluation.number + 1.0 for evaluation in evaluations])
    return np.array([evaluation.duration for evaluation in evaluations])


def natural_values(problem: DesignProblem, evaluations: Sequence[Evaluation], name: str) -> FloatArray:
    """The values (n,) of an objective or metric with their natural sign, NaN where there is none."""
    names = [objective.name for objective in problem.objectives]
    known = {quantity.name: quantity for quantity in quantities(problem)}
    if name in names:
        stored = np.array([evaluation.objectives[names.index(name)] for evaluation in evaluations], dtype=float)
    else:
        stored = np.array([evaluation.metrics.get(name, np.nan) for evaluation in evaluations], dtype=float)
    natural: FloatArray = known.get(name, Quantity(name)).sign * stored + 0.0
    return natural


def column_numbers(column: pa.ChunkedArray) -> FloatArray:
    """The numbers (n,) of a column of a file, NaN where there is none."""
    import pyarrow as pa

    return np.array(column.cast(pa.float64()).to_numpy(), dtype=float)


def _matrix(table: pa.Table, layout: Sequence[Layout], kind: str) -> FloatArray:
    """The columns (n, k) of one kind."""
    columns = [column_numbers(table.column(column.label)) for column in layout if column.kind == kind]
    return np.array(columns).reshape(len(columns), table.num_rows).T
