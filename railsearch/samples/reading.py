"""Samples for an analysis: inputs and outputs by name, from a file of `railsearch sample` or a user's own."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from railsearch.errors import InputError
from railsearch.samples.file_table import FileTable, read_table
from railsearch.samples.table import CONSTRAINT, QUANTITY, REASON, VARIABLE, column_numbers, layout_of
from railsearch.space import FloatArray
from railsearch.wording import closest

if TYPE_CHECKING:
    import pyarrow as pa

INDEX = re.compile(r"__index_level_\d+__")
"""What pandas calls an index without a name in a Parquet file; in a CSV file it has no name at all."""

UNIT = re.compile(r"(.*\S)\s*\[([^\[\]]*)\]")


@dataclass(frozen=True)
class Samples:
    """n samples by column: inputs and outputs with values (n,), NaN where there is none, and with units.

    reasons: why a sample failed, empty if it did not; unusable: columns without numbers, with what stands there; about: what
    the file says of itself (command, identity, problem, versions), empty for a user's own.
    """

    source: Path
    inputs: Mapping[str, FloatArray]
    outputs: Mapping[str, FloatArray]
    input_units: Mapping[str, str]
    output_units: Mapping[str, str]
    reasons: tuple[str, ...]
    unusable: Mapping[str, str] = field(default_factory=dict)
    about: Mapping[str, Any] = field(default_factory=dict)

    @property
    def number(self) -> int:
        """n."""
        return len(self.reasons)

    def input_matrix(self, names: Sequence[str] | None = None) -> FloatArray:
        """Inputs (n, d) in the order of `names`, or as the file has them. Raises InputError for one that it lacks."""
        return self._matrix(self.inputs, list(self.inputs) if names is None else names, "input")

    def output(self, name: str) -> FloatArray:
        """Values (n,) of an output. Raises InputError for one that the file lacks."""
        return self._matrix(self.outputs, [name], "output")[:, 0]

    def _matrix(self, columns: Mapping[str, FloatArray], names: Sequence[str], kind: str) -> FloatArray:
        for name in names:
            if name in self.unusable:
                raise InputError(f"{self.source}: column '{name}' is not one of numbers: {self.unusable[name]}")
            if name not in columns:
                raise InputError(f"{self.source}: there is no {kind} '{name}'{_hint(name, columns)}")
        return np.column_stack([columns[name] for name in names]) if names else np.empty((self.number, 0))


def read_samples(path: Path, inputs: Sequence[str] = ()) -> Samples:
    """Read samples from Parquet or CSV (comma, semicolon or tab; lines beginning with # on top are left out).

    A file of `railsearch sample` says itself what is what. Of any other, `inputs` names the inputs; all other columns of
    numbers are outputs, `NAME [UNIT]` in the header giving the unit, and empty cells are values that are not there; columns
    without a name, such as an index, are left out.
    Raises InputError for a file that is no such table, has no rows, or lacks one of the inputs.
    """
    found = read_table(path)
    if not found.table.num_rows:
        raise InputError(f"{path}: there are no samples, only a header")
    return _own(path, found, inputs) if found.about else _users(path, found.table, inputs)


def _own(path: Path, found: FileTable, inputs: Sequence[str]) -> Samples:
    layout = layout_of(found.about)
    variables = [column for column in layout if column.kind == VARIABLE]
    outputs = [column for column in layout if column.kind in (QUANTITY, CONSTRAINT)]
    (reasons,) = (found.table.column(column.label).to_pylist() for column in layout if column.kind == REASON)
    samples = Samples(
        path,
        {column.name: column_numbers(found.table.column(column.label)) for column in variables},
        {column.name: column_numbers(found.table.column(column.label)) for column in outputs},
        {column.name: column.unit for column in variables},
        {column.name: column.unit for column in outputs},
        tuple(reason or "" for reason in reasons),
        about=found.about,
    )
    samples.input_matrix(inputs)
    return samples


def _users(path: Path, table: pa.Table, inputs: Sequence[str]) -> Samples:
    labels = [label for label in table.column_names if label.strip() and not INDEX.fullmatch(label)]
    matches = {label: UNIT.fullmatch(label) for label in labels}
    names = {label: match[1] if match else label for label, match in matches.items()}
    if len(set(names.values())) < len(names):
        raise InputError(f"{path}: columns have the same name and differ in their unit only; give each a name of its own")
    units = {names[label]: match[2] if match else "" for label, match in matches.items()}
    numeric = {label for label in names if _is_numeric(table.column(label))}
    values = {names[label]: column_numbers(table.column(label)) for label in labels if label in numeric}
    samples = Samples(
        path,
        {name: values[name] for name in inputs if name in values},
        {name: column for name, column in values.items() if name not in inputs},
        {name: units[name] for name in inputs if name in values},
        {name: units[name] for name in values if name not in inputs},
        ("",) * table.num_rows,
        {names[label]: _text(table.column(label)) for label in names if label not in numeric},
    )
    if not set(inputs) <= set(values):
        missing = next(name for name in inputs if name not in values)
        where = samples.unusable.get(missing)
        fault = f"is not one of numbers: {where}" if where else f"is missing{_hint(missing, values)}"
        raise InputError(f"{path}: column '{missing}' {fault}")
    return samples


def _is_numeric(column: pa.ChunkedArray) -> bool:
    from pyarrow import types

    kind = column.type
    return bool(types.is_integer(kind) or types.is_floating(kind) or types.is_decimal(kind) or types.is_null(kind))


def _text(column: pa.ChunkedArray) -> str:
    """The first entry of a column that is no number, with its row."""
    for row, entry in enumerate(column.to_pylist(), 1):
        if entry is not None and not _is_number(entry):
            return f"row {row} has {entry!r}; numbers with a decimal point are needed, or nothing"
    return f"its entries are of the type {column.type}; numbers are needed"


def _is_number(entry: object) -> bool:
    try:
        float(str(entry))
    except ValueError:
        return False
    return True


def _hint(name: str, known: Iterable[str]) -> str:
    names = list(known)
    return f"{closest(name, names)}; there are {', '.join(names) or 'none'}"
