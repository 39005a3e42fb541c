"""Tables of samples as they come out of Parquet and CSV files, a user's own ones too."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from railsearch.data_table import read_parquet_table, with_unit
from railsearch.errors import InputError
from railsearch.samples.table import ABOUT, CSV, FORMAT, PARQUET, REASON, Layout, layout_of

if TYPE_CHECKING:
    import pyarrow as pa

COMMENT = "#"
OWN_COMMENT = f"{COMMENT} {FORMAT} "
LARGEST_BLOCK = 2**31 - 1
SEPARATORS = (",", ";", "\t")


@dataclass(frozen=True)
class FileTable:
    """The columns of a file, and what it says about itself; `about` is empty for a file that railsearch did not write."""

    table: pa.Table
    about: Mapping[str, Any]


def read_table(path: Path) -> FileTable:
    """Read a table. Raises InputError, naming the file, if it cannot be read or is not a table with different columns."""
    import pyarrow as pa

    if path.suffix not in (PARQUET, CSV):
        raise InputError(f"{path}: a file whose name ends with {PARQUET} or {CSV} is needed")
    try:
        found = _read_parquet(path) if path.suffix == PARQUET else _read_csv(path)
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror or error}") from None
    except (pa.ArrowException, UnicodeDecodeError, ValueError) as error:
        raise InputError(f"{path}: is not a {path.suffix.removeprefix('.')} table: {error}") from None
    twice = [name for name, times in Counter(found.table.column_names).items() if times > 1]
    if twice:
        raise InputError(f"{path}: there are several columns {', '.join(map(repr, twice))}; give each a name of its own")
    return found


def _read_parquet(path: Path) -> FileTable:
    table = read_parquet_table(path)
    metadata = table.schema.metadata or {}
    return FileTable(table, json.loads(metadata[ABOUT.encode()]) if metadata.get(b"format") == FORMAT.encode() else {})


def _read_csv(path: Path) -> FileTable:
    """A table after lines of comment; what railsearch wrote has its types and labels from the first of them."""
    import pyarrow.csv as pc

    comments, header = _begin(path)
    about = json.loads(comments[0].removeprefix(OWN_COMMENT)) if comments and comments[0].startswith(OWN_COMMENT) else {}
    layout = layout_of(about) if about else []
    table = pc.read_csv(
        path,
        # One block: the lines to skip must fit into the first one, and a site with long lists makes a long line.
        pc.ReadOptions(skip_rows=len(comments), block_size=min(path.stat().st_size, LARGEST_BLOCK)),
        pc.ParseOptions(delimiter=max(SEPARATORS, key=header.count), newlines_in_values=True),
        pc.ConvertOptions(column_types=_types(layout), strings_can_be_null=True),
    )
    return FileTable(table.rename_columns([column.label for column in layout]) if layout else table, about)


def _begin(path: Path) -> tuple[list[str], str]:
    """The lines of comment with which a file begins, and the line after them."""
    comments: list[str] = []
    with path.open(encoding="utf-8-sig") as file:
        for line in file:
            if not line.startswith(COMMENT):
                return comments, line
            comments.append(line.rstrip("\n"))
    raise ValueError("it has no header")


def _types(layout: Sequence[Layout]) -> dict[str, Any]:
    """The types of the columns of a file of railsearch, by its header."""
    import pyarrow as pa

    own = {column: pa.string() if column.kind == REASON else pa.float64() for column in layout}
    own |= {column: pa.int64() for column in layout if column.integer}
    return {with_unit(column.label, column.unit): kind for column, kind in own.items()}
