"""Reading matrices and tables: MatrixMarket, MATLAB, NumPy and text files."""

import io
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files as resources
from pathlib import Path
from typing import Any

import numpy as np
import scipy.io
import scipy.sparse
from numpy.typing import NDArray

from railsearch.errors import InputError
from railsearch_plugins.track_models.imported_track.parameters import SAMPLE

FloatArray = NDArray[np.float64]

# What scipy.sparse.save_npz writes; where a file has several matrices, each of these follows NAME and a point.
SPARSE_FIELDS = ("format", "shape", "data", "indices", "indptr", "row", "col")


@dataclass(frozen=True)
class Place:
    """A file and the name of an array in it, empty where there is but one."""

    file: Path
    name: str

    def __str__(self) -> str:
        return f"{self.file}#{self.name}" if self.name else str(self.file)


def place_of(text: str) -> Place:
    """The place that FILE or FILE#NAME means; the name is what follows the last #."""
    file, separator, name = text.rpartition("#")
    if not separator:
        file, name = text, ""
    if file.startswith(SAMPLE):
        return Place(Path(str(resources(__package__) / "sample")) / file.removeprefix(SAMPLE), name)
    return Place(Path(file), name)


def stamp(place: Place) -> tuple[int, int]:
    """Time of the last change in ns and size in bytes. Raises InputError if there is no such file."""
    try:
        status = place.file.stat()
    except OSError as error:
        raise InputError(
            f"{place.file}: cannot be read: {error.strerror}; paths in a site file are {{ file = … }}"
        ) from None
    return status.st_mtime_ns, status.st_size


def read_matrix(place: Place, usual_name: str) -> Any:
    """A sparse matrix (n, n) in CSR of float64. Raises InputError if there is none or it is not square, real and finite.

    usual_name: that of the array where the place names none and the file has several.
    """
    found = _read(place, usual_name)
    try:
        matrix = scipy.sparse.csr_array(found)
    except (TypeError, ValueError):
        raise InputError(f"{place}: a matrix of numbers is needed, received {type(found).__name__}") from None
    if matrix.ndim != 2 or matrix.shape[0] != matrix.shape[1] or matrix.shape[0] == 0:
        raise InputError(f"{place}: a square matrix is needed, received shape {matrix.shape}")
    if np.iscomplexobj(matrix.data):
        raise InputError(f"{place}: a real matrix is needed, received a complex one; export M, C and K without loss factors")
    real = matrix.astype(np.float64)
    real.sum_duplicates()
    bad = np.flatnonzero(~np.isfinite(real.data))
    if bad.size:
        row = int(np.searchsorted(real.indptr, bad[0], side="right")) - 1
        raise InputError(
            f"{place}: finite entries are needed, received {real.data[bad[0]]} in row {row}, column "
            f"{real.indices[bad[0]]} (from 0), one of {bad.size}"
        )
    return real


def read_table(place: Place, usual_name: str, columns: tuple[int, int]) -> FloatArray:
    """A table (k, c) with c between both `columns`; empty cells are NaN. Raises InputError."""
    if place.file.suffix in (".npz", ".mat", ".mtx"):
        found = _read(place, usual_name)
        dense = found.toarray() if scipy.sparse.issparse(found) else found
        try:
            table = np.array(dense, dtype=float, ndmin=2)
        except (TypeError, ValueError):
            raise InputError(f"{place}: a table of numbers is needed, received {type(found).__name__}") from None
    else:
        table = _read_text(place)
    if table.ndim != 2 or not columns[0] <= table.shape[1] <= columns[1]:
        raise InputError(f"{place}: a table of {columns[0]} or {columns[1]} columns is needed, received shape {table.shape}")
    return table


def _read_text(place: Place) -> FloatArray:
    """Columns separated by commas, semicolons or blanks; a first line of words is skipped and # begins a comment."""
    try:
        lines = place.file.read_text(encoding="utf-8").replace(";", ",").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{place}: cannot be read: {error}") from None
    lines = [line.split("#")[0].strip() for line in lines]
    lines = [line for line in lines if line]
    if lines and any(character.isalpha() for character in lines[0].replace("nan", "").replace("e", "")):
        lines = lines[1:]
    rows = [[cell.strip() for cell in line.split(",")] if "," in line else line.split() for line in lines]
    try:
        return np.array([[float(cell or "nan") for cell in row] for row in rows], dtype=float, ndmin=2)
    except ValueError as error:
        raise InputError(f"{place}: rows of as many numbers each are needed: {error}") from None


def _read(place: Place, usual_name: str) -> Any:
    readers = {".mtx": _read_matrix_market, ".mat": _read_matlab, ".npz": _read_numpy}
    if place.file.suffix not in readers:
        raise InputError(f"{place}: a file .mtx, .mat or .npz is needed, received '{place.file.suffix}'")
    try:
        return readers[place.file.suffix](place, usual_name)
    except InputError:
        raise
    except NotImplementedError:
        raise InputError(f"{place}: MATLAB files of version 7.3 cannot be read; save with save(…, '-v7')") from None
    except (OSError, ValueError, TypeError, KeyError, zipfile.BadZipFile, scipy.io.matlab.MatReadError) as error:
        raise InputError(f"{place}: cannot be read as {place.file.suffix}: {error}") from None


def _read_matrix_market(place: Place, usual_name: str) -> Any:
    if place.name:
        raise InputError(f"{place}: a .mtx file has one matrix without a name; leave out #{place.name}")
    return scipy.io.mmread(place.file)


def _read_matlab(place: Place, usual_name: str) -> Any:
    content = {name: value for name, value in scipy.io.loadmat(place.file).items() if not name.startswith("__")}
    return _named(place, usual_name, content)


def _read_numpy(place: Place, usual_name: str) -> Any:
    with np.load(io.BytesIO(place.file.read_bytes()), allow_pickle=False) as archive:
        content = {name: archive[name] for name in archive.files}
    return _named(place, usual_name, _gathered(content))


def _gathered(content: Mapping[str, Any]) -> dict[str, Any]:
    """The arrays of a .npz file by name, sparse matrices put together; one of scipy.sparse.save_npz is called ''."""
    prefixes = [name.removesuffix("format") for name in content if name == "format" or name.endswith(".format")]
    fields = {prefix + field for prefix in prefixes for field in SPARSE_FIELDS}
    whole = {name: value for name, value in content.items() if name not in fields}
    return whole | {prefix.removesuffix("."): _sparse(prefix, content) for prefix in prefixes}


def _sparse(prefix: str, content: Mapping[str, Any]) -> Any:
    kind = content[prefix + "format"].item()
    kind = kind.decode() if isinstance(kind, bytes) else kind
    shape, data = tuple(content[prefix + "shape"]), content[prefix + "data"]
    if kind == "coo":
        return scipy.sparse.coo_array((data, (content[prefix + "row"], content[prefix + "col"])), shape=shape)
    if kind not in ("csr", "csc"):
        raise InputError(f"a sparse matrix saved as csr, csc or coo is needed, received {kind}")
    make = scipy.sparse.csr_array if kind == "csr" else scipy.sparse.csc_array
    return make((data, content[prefix + "indices"], content[prefix + "indptr"]), shape=shape)


def _named(place: Place, usual_name: str, content: Mapping[str, Any]) -> Any:
    wanted = place.name or (usual_name if usual_name in content else "")
    if not wanted and len(content) == 1:
        return next(iter(content.values()))
    if wanted not in content:
        raise InputError(
            f"{place}: no array '{wanted or usual_name}'; the file has {', '.join(sorted(content)) or 'none'}, "
            f"name one as {place.file.name}#NAME"
        )
    return content[wanted]
