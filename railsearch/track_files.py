"""Writing a track to files: matrices, tables of rail nodes and supports, and the site file that reads them again."""

import io
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from railsearch.errors import InputError
from railsearch.interfaces import TrackExport
from railsearch.run_directory import write_whole
from railsearch.site import toml_value
from railsearch.space import FloatArray

FORMATS = ("npz", "mtx")
IMPORTED = "imported-track"
SITE, ARCHIVE = "site.toml", "track.npz"
# Digits with which a float64 is read again to the last bit.
DIGITS = 17
MATRICES = ("mass", "damping", "stiffness")


def write_track(folder: Path, export: TrackExport, kind: str, variables: bool = True) -> list[Path]:
    """Write an exported track and its site file to a folder that has no site file yet; gives what was written.

    kind: `npz` puts all matrices in one file, `mtx` each in a MatrixMarket file of its own; variables: whether the site file
    makes a design variable of every part. Raises InputError, StorageError.
    """
    if kind not in FORMATS:
        raise InputError(f"--format: one of {', '.join(FORMATS)} is needed, received '{kind}'")
    if (folder / SITE).exists():
        raise InputError(f"--out: {folder / SITE} exists and is not overwritten; choose another folder")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"--out: {folder} cannot be made: {error.strerror}; choose another folder") from None
    contents = {"rail.csv": _rail(export.rail), "supports.csv": _supports(export.supports)}
    named = _named_matrices(export)
    if kind == "npz":
        contents[ARCHIVE] = _archive(named)
        places = {name: f"{ARCHIVE}#{name}" for name in named}
    else:
        contents |= {f"{name}.mtx": _matrix_market(matrix) for name, matrix in named.items()}
        places = {name: f"{name}.mtx" for name in named}
    contents[SITE] = "\n".join(_site(export, places, variables)).encode("utf-8")
    for name, content in contents.items():
        write_whole(folder / name, content)
    return [folder / name for name in contents]


def _named_matrices(export: TrackExport) -> dict[str, Any]:
    """All matrices by name; those of parts are PART.KIND."""
    parts = {f"{part}.{kind}": matrix for part, own in export.parts.items() for kind, matrix in own.items()}
    return {name: export.matrices[name] for name in MATRICES} | parts


def _archive(matrices: Mapping[str, Any]) -> bytes:
    """Sparse matrices in one .npz file, each as scipy.sparse.save_npz would, its fields after its name and a point."""
    arrays: dict[str, Any] = {}
    for name, matrix in matrices.items():
        rows = matrix.tocsr()
        arrays |= {f"{name}.format": np.array("csr"), f"{name}.shape": np.array(rows.shape)}
        arrays |= {f"{name}.{field}": getattr(rows, field) for field in ("data", "indices", "indptr")}
    content = io.BytesIO()
    np.savez_compressed(content, **arrays)
    return content.getvalue()


def _matrix_market(matrix: Any) -> bytes:
    from scipy.io import mmwrite

    content = io.BytesIO()
    mmwrite(content, matrix.tocoo(), symmetry="symmetric", precision=DIGITS)
    return content.getvalue()


def _rail(table: FloatArray) -> bytes:
    rows = [f"{position!r},{int(vertical)},{int(rotation)}" for position, vertical, rotation in table.tolist()]
    return "\n".join(["# position [m], vertical unknown, rotation; -1 is held", *rows, ""]).encode()


def _supports(table: FloatArray) -> bytes:
    rows = [
        ",".join([repr(position), str(int(unknown)), repr(damping), *(str(int(end)) for end in other)])
        for position, unknown, damping, *other in table.tolist()
    ]
    return "\n".join(
        ["# position [m], unknown, damping [N s/m], unknown at the other end if not ground", *rows, ""]
    ).encode()


def _site(export: TrackExport, places: Mapping[str, str], variables: bool) -> Iterator[str]:
    """The lines of a site file of the problem `imported-track`."""
    yield "# A track exported by railsearch. Unknowns are counted from 0, displacements are downward, SI units."
    yield f'problem = "{IMPORTED}"'
    yield from ("", "[track.files]")
    files = {name: places[name] for name in MATRICES} | {"rail": "rail.csv", "supports": "supports.csv"}
    yield from (f"{name} = {{ file = {toml_value(place)} }}" for name, place in files.items())
    yield "first_unknown = 0"
    for part, own in export.parts.items():
        yield from ("", f"[track.parts.{part}]")
        yield from (f"{kind} = {{ file = {toml_value(places[f'{part}.{kind}'])} }}" for kind in own)
    if export.factors:
        yield from ("", "[track.factors]", *(f"{part} = {factor!r}" for part, factor in export.factors.items()))
    if export.factors and variables:
        yield from ("", "# What a search may change, from a tenth of its value up to it; the bounds are yours to set.")
        for part, factor in export.factors.items():
            bounds = (f"lower = {toml_value(0.1 * factor)}", f"upper = {toml_value(factor)}")
            yield from (f"[design.variables.{part}]", *bounds)
    for section, values in export.settings.items():
        yield from ("", f"[track.{section}]")
        yield from (f"{name} = {toml_value(value)}" for name, value in values.items() if value is not None)
    yield ""
