"""Tables in files: columns with units and meanings, written as Parquet or CSV, whole or not at all."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

from railsearch.errors import InputError
from railsearch.run_directory import write_whole, writing

if TYPE_CHECKING:
    import pyarrow as pa


@dataclass(frozen=True)
class Column:
    """A column of a table."""

    label: str
    values: pa.Array
    unit: str = ""
    meaning: str = ""


def data_table(columns: Sequence[Column], about: Mapping[str, str]) -> pa.Table:
    """The table of columns, units and meanings in the metadata of its fields, `about` in its own."""
    import pyarrow as pa

    fields = [
        pa.field(column.label, column.values.type, metadata={"unit": column.unit, "meaning": column.meaning})
        for column in columns
    ]
    return pa.Table.from_arrays([column.values for column in columns], schema=pa.schema(fields, metadata=dict(about)))


def write_parquet_table(table: pa.Table, path: Path) -> None:
    """Write a table as a Parquet file. Raises StorageError if it cannot be written."""
    import pyarrow.parquet

    buffer = BytesIO()
    pyarrow.parquet.write_table(table, buffer, compression="zstd")
    _write(path, buffer.getvalue())


def read_parquet_table(path: Path) -> pa.Table:
    """Read a Parquet file. Raises InputError, naming the file, if it cannot be read or is none."""
    import pyarrow.parquet

    try:
        with path.open("rb") as file:
            return pyarrow.parquet.read_table(file)
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror or error}") from None
    except pyarrow.ArrowException as error:
        raise InputError(f"{path}: is not a parquet table: {error}") from None


def write_csv_table(table: pa.Table, path: Path, comment: str = "") -> None:
    """Write a table as a CSV file with units in the header, after a line of comment. Raises StorageError."""
    import pyarrow.csv

    buffer = BytesIO(f"# {comment}\n".encode() if comment else b"")
    buffer.seek(0, 2)
    header = [with_unit(column.name, column.metadata[b"unit"].decode()) for column in table.schema]
    pyarrow.csv.write_csv(table.rename_columns(header), buffer)
    _write(path, buffer.getvalue())


def with_unit(name: str, unit: str) -> str:
    """A name with its unit in brackets, unless they are there already."""
    return f"{name} [{unit}]" if unit and not name.endswith(f"[{unit}]") else name


def _write(path: Path, content: bytes) -> None:
    with writing(path):
        path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, content)
