"""An imported track, read and checked once: matrices on one pattern, those of parts, rail and supports."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import scipy.sparse
from numpy.typing import NDArray

from railsearch.errors import InputError
from railsearch_plugins.track_models.imported_track.files import Place, place_of, read_matrix, read_table, stamp
from railsearch_plugins.track_models.imported_track.parameters import MATRICES, ImportedTrackParameters
from railsearch_plugins.track_models.imported_track.pattern import (
    Pattern,
    check_semidefinite,
    make_pattern,
    on_pattern,
    whole_matrix,
)
from railsearch_plugins.track_models.imported_track.tables import RailTable, SupportTable, rail_table, support_table

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

# Differences between the halves of a matrix, relative to its largest entry, that rounding in an export may leave.
ROUNDING = 1e-9
# Tracks that are kept between simulations.
KEPT = 4


@dataclass(frozen=True)
class ImportedMatrices:
    """Values (m,) of M, C and K on the pattern, those of parts at factor 1, and the tables with unknowns in its order."""

    pattern: Pattern
    whole: dict[str, FloatArray]
    parts: dict[str, dict[str, FloatArray]]
    rail: RailTable
    supports: SupportTable

    def assembled(self, factors: dict[str, float]) -> dict[str, FloatArray]:
        """Values (m,) of M, C and K, parts added with their factors."""
        total = {kind: values.copy() for kind, values in self.whole.items()}
        for name, matrices in self.parts.items():
            for kind, values in matrices.items():
                total[kind] += factors[name] * values
        return total


def imported(parameters: ImportedTrackParameters) -> ImportedMatrices:
    """The track that the parameters name. Raises InputError for files that cannot be read and for unsound matrices.

    It is kept until a file changes, for designs that differ in factors alone.
    """
    files = parameters.files
    whole = tuple((kind, place_of(getattr(files, kind))) for kind in MATRICES)
    parts = tuple(
        (name, tuple((kind, place_of(getattr(part, kind))) for kind in MATRICES if getattr(part, kind)))
        for name, part in parameters.part_files().items()
    )
    tables = place_of(files.rail), place_of(files.supports)
    places = [place for _, place in whole] + [place for _, part in parts for _, place in part] + list(tables)
    return _read(whole, parts, tables, files.first_unknown, parameters.rail.rotation, tuple(map(stamp, places)))


Named = tuple[tuple[str, Place], ...]


@lru_cache(maxsize=KEPT)
def _read(
    whole: Named,
    parts: tuple[tuple[str, Named], ...],
    tables: tuple[Place, Place],
    first_unknown: int,
    rotation: str,
    stamps: tuple[tuple[int, int], ...],
) -> ImportedMatrices:
    """`stamps` are there to be compared: another content of a file is another track."""
    matrices = {kind: read_matrix(place, kind) for kind, place in whole}
    added = {name: {kind: read_matrix(place, kind) for kind, place in part} for name, part in parts}
    size = matrices["stiffness"].shape[0]
    everything = [(place, matrices[kind]) for kind, place in whole]
    everything += [(place, added[name][kind]) for name, part in parts for kind, place in part]
    for place, matrix in everything:
        _check_shape(place, matrix, size, whole[2][1])
        _check_symmetry(place, matrix)
    pattern = make_pattern([matrix for _, matrix in everything])
    values = [on_pattern(matrix, pattern) for _, matrix in everything]
    for (place, _), checked in zip(everything, values, strict=True):
        check_semidefinite(str(place), checked, pattern)
    rail = rail_table(tables[0], read_table(tables[0], "rail", (2, 3)), size, first_unknown)
    supports = support_table(tables[1], read_table(tables[1], "supports", (3, 4)), size, first_unknown)
    rail = rail.renumbered(pattern.place)
    if rail.has_rotations:
        _check_rotation(tables[0], rail, whole_matrix(values[2], pattern), rotation)
    following = iter(values)
    return ImportedMatrices(
        pattern,
        {kind: next(following) for kind, _ in whole},
        {name: {kind: next(following) for kind, _ in part} for name, part in parts},
        rail,
        supports.renumbered(pattern.place),
    )


def _check_shape(place: Place, matrix: Any, size: int, other: Place) -> None:
    if matrix.shape[0] != size:
        raise InputError(
            f"{place}: as many rows as the stiffness matrix has are needed, {size} as in {other}, received "
            f"{matrix.shape[0]}; export all matrices with the same boundary conditions"
        )


def _check_symmetry(place: Place, matrix: Any) -> None:
    difference = scipy.sparse.coo_array(matrix - matrix.T)
    if not difference.nnz:
        return
    worst, largest = int(np.argmax(np.abs(difference.data))), float(np.abs(matrix.data).max())
    if abs(difference.data[worst]) <= ROUNDING * largest:
        return
    row, column = int(difference.row[worst]), int(difference.col[worst])
    triangle = not scipy.sparse.triu(matrix, 1).nnz or not scipy.sparse.tril(matrix, -1).nnz
    remedy = (
        "only one triangle is there: export the whole matrix, or say `symmetric` in the header of a .mtx file"
        if triangle
        else "couplings by follower forces or contact with friction have no place here"
    )
    raise InputError(
        f"{place}: a symmetric matrix is needed, received {matrix[row, column]:g} in row {row}, column {column} (from 0) "
        f"and {matrix[column, row]:g} across the diagonal; {remedy}"
    )


def _check_rotation(place: Place, rail: RailTable, stiffness: Any, rotation: str) -> None:
    """A beam that is tilted as a whole is not bent: the rotations' share of K x balances that of the slopes."""
    held = (rail.vertical < 0) | (rail.rotation < 0)
    vertical, turned, x = rail.vertical[~held], rail.rotation[~held], rail.position[~held]
    coupling = stiffness[turned][:, vertical]
    moment = float((coupling @ x - x * (coupling @ np.ones_like(x))).sum())
    if rotation == "minus slope":
        moment = -moment
    if moment > 0.0:
        other = "minus slope" if rotation == "slope" else "slope"
        raise InputError(
            f"imported-track.rail.rotation: the rotations in {place} have the other sense: a tilt of the rail bends it, "
            f"received '{rotation}'; use '{other}'"
        )
