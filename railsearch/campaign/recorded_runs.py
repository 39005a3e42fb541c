"""Runs of a campaign from a results table: what was carried out on another machine, or is left of a lost record."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from railsearch.campaign.cells import Cell
from railsearch.campaign.coordinator import CellTask
from railsearch.campaign.export.table import CONSTRAINT, FORMAT, QUANTITY, VARIABLE
from railsearch.campaign.identity import campaign_changes
from railsearch.data_table import read_parquet_table
from railsearch.design_problem import DesignProblem
from railsearch.errors import InputError
from railsearch.interfaces import Evaluation, Quantity
from railsearch.space import FloatArray

if TYPE_CHECKING:
    import pyarrow as pa


class RecordedRuns:
    """The runs in a results table that `railsearch campaign` or `railsearch export` wrote.

    `lengths`: the number of evaluations of each run. Raises InputError, naming the file, if it cannot be read or does not
    tell of which campaign it is.
    """

    def __init__(self, path: Path) -> None:
        table = read_parquet_table(path)
        about = {key.decode(): value.decode() for key, value in (table.schema.metadata or {}).items()}
        if about.get("format") != FORMAT or "identity" not in about:
            raise InputError(
                f"{path}: is not a table of results that says of which campaign it is; give the results.parquet in a "
                "campaign's folder, made anew with `railsearch report DIR` if it is old"
            )
        self._path = path
        self._table = table
        self._identity: Mapping[str, Any] = json.loads(about["identity"])
        self._labels = {(kind, name, unit): label for kind, name, unit, label in json.loads(about["described"])}
        self._begins, self.lengths = _runs(table)

    def check(self, identity: Mapping[str, Any]) -> None:
        """Raise InputError, with all differences, unless the runs are of the campaign with that identity."""
        campaign_changes(self._identity, identity).check(str(self._path))

    def evaluations(self, cell: Cell, problem: DesignProblem) -> list[Evaluation]:
        """The evaluations of a run on `problem` in their order; metrics without a value are left out."""
        n = self.lengths[cell]
        rows = self._table.slice(self._begins[cell], n)
        designs = [self._floats(rows, VARIABLE, v.name, v.unit) for v in problem.space.variables]
        objectives = [self._stored(rows, quantity) for quantity in problem.objectives]
        constraints = [self._floats(rows, CONSTRAINT, f"constraint {k + 1}", "") for k in range(problem.n_ieq_constr)]
        metrics = {quantity.name: self._stored(rows, quantity) for quantity in self._metrics(problem)}
        own = rows.select(["origin", "trajectory", "reason", "duration", "overhead"]).to_pylist()
        return [
            Evaluation(
                number=number,
                design=np.array([values[number] for values in designs]),
                objectives=np.array([values[number] for values in objectives]),
                constraints=np.array([values[number] for values in constraints]),
                metrics={name: float(values[number]) for name, values in metrics.items() if not math.isnan(values[number])},
                **{**own[number], "reason": own[number]["reason"] or ""},
            )
            for number in range(n)
        ]

    def _metrics(self, problem: DesignProblem) -> list[Quantity]:
        """The problem's metrics, and those that it does not describe: without a unit, their sign as it is stored."""
        known = {quantity.name for quantity in (*problem.objectives, *problem.metrics)}
        others = [Quantity(name) for kind, name, unit in self._labels if kind == QUANTITY and not unit and name not in known]
        return [*problem.metrics, *others]

    def _stored(self, rows: pa.Table, quantity: Quantity) -> FloatArray:
        """The values of an objective or metric as they are minimised (n,)."""
        natural = self._floats(rows, QUANTITY, quantity.name, quantity.unit)
        return 0.0 - natural if quantity.maximised else natural

    def _floats(self, rows: pa.Table, kind: str, name: str, unit: str) -> FloatArray:
        """A column (n,), NaN where it has no value."""
        label = self._labels.get((kind, name, unit))
        if label is None:
            return np.full(rows.num_rows, np.nan)
        values: FloatArray = rows.column(label).to_numpy().astype(float)
        return values


def complete_runs(paths: Iterable[Path], tasks: Sequence[CellTask], identity: Mapping[str, Any]) -> dict[Cell, RecordedRuns]:
    """Which table has the complete run of a cell, the first of several, for the campaign with that identity.

    Raises InputError, naming the file, if one cannot be read or has the runs of another campaign.
    """
    found: dict[Cell, RecordedRuns] = {}
    for path in paths:
        runs = RecordedRuns(path)
        runs.check(identity)
        complete = [task.cell for task in tasks if runs.lengths.get(task.cell, 0) >= task.evaluations]
        found = dict.fromkeys(complete, runs) | found
    return found


def _runs(table: pa.Table) -> tuple[dict[Cell, int], dict[Cell, int]]:
    """Where each run begins and how many rows it has: they are one after the other."""
    begins: dict[Cell, int] = {}
    lengths: dict[Cell, int] = {}
    columns = (table.column(name).to_pylist() for name in ("problem", "strategy", "repetition"))
    for row, place in enumerate(zip(*columns, strict=True)):
        cell = Cell(*place)
        begins.setdefault(cell, row)
        lengths[cell] = lengths.get(cell, 0) + 1
    return begins, lengths
