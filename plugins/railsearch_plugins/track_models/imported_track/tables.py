"""The tables of rail nodes and supports: what they must hold, and their unknowns in the order of the matrices."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from railsearch.errors import InputError
from railsearch_plugins.track_models.imported_track.files import Place

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

HELD = -1


@dataclass(frozen=True)
class RailTable:
    """Rail nodes ascending: position (k,) in m, vertical unknown and rotation (k,); −1 is held, or no rotation at all."""

    position: FloatArray
    vertical: IntArray
    rotation: IntArray
    has_rotations: bool

    def renumbered(self, place: IntArray) -> "RailTable":
        """The same with unknowns at their new `place` (n,)."""
        return replace(self, vertical=_renumbered(self.vertical, place), rotation=_renumbered(self.rotation, place))


@dataclass(frozen=True)
class SupportTable:
    """Supports ascending: position (s,) in m, unknown (s,), damping (s,) in N s/m, unknown at the other end, −1 ground."""

    position: FloatArray
    unknown: IntArray
    damping: FloatArray
    other: IntArray

    def renumbered(self, place: IntArray) -> "SupportTable":
        """The same with unknowns at their new `place` (n,)."""
        return replace(self, unknown=_renumbered(self.unknown, place), other=_renumbered(self.other, place))


def rail_table(place: Place, table: FloatArray, size: int, first_unknown: int) -> RailTable:
    """Rail nodes from a table (k, 2 or 3). Raises InputError for positions and unknowns that cannot be."""
    position = table[:, 0]
    if position.size < 2:
        raise InputError(f"{place}: two or more rail nodes are needed, received {position.size}")
    _check_positions(place, position, "rail nodes", repeated=False)
    vertical = _unknowns(place, table[:, 1], "vertical unknown", position, size, first_unknown)
    rotations = table.shape[1] == 3
    rotation = (
        _unknowns(place, table[:, 2], "rotation", position, size, first_unknown)
        if rotations
        else np.full(position.size, HELD)
    )
    used = np.concatenate([vertical, rotation])
    used = np.sort(used[used >= 0])
    if used.size == 0:
        raise InputError(f"{place}: all unknowns of the rail are held; number them from {first_unknown}")
    twice = np.flatnonzero(np.diff(used) == 0)
    if twice.size:
        raise InputError(
            f"{place}: every unknown belongs to one rail node, received {used[twice[0]] + first_unknown} twice; "
            "check the columns of vertical unknowns and rotations"
        )
    return RailTable(position, vertical, rotation, rotations and bool((rotation >= 0).any()))


def support_table(place: Place, table: FloatArray, size: int, first_unknown: int) -> SupportTable:
    """Supports from a table (s, 3 or 4). Raises InputError for positions, unknowns and dampings that cannot be."""
    position, damping = table[:, 0], table[:, 2]
    if position.size < 2:
        raise InputError(f"{place}: two or more supports are needed, received {position.size}")
    _check_positions(place, position, "supports", repeated=True)
    bad = np.flatnonzero(~(np.isfinite(damping) & (damping >= 0.0)))
    if bad.size:
        raise InputError(
            f"{place}: a damping ≥ 0 N s/m is needed, received {damping[bad[0]]:g} at {position[bad[0]]:g} m; correct it"
        )
    unknown = _unknowns(place, table[:, 1], "unknown", position, size, first_unknown)
    if (unknown < 0).any():
        held = position[int(np.argmin(unknown))]
        raise InputError(f"{place}: a support moves, received a held unknown at {held:g} m; leave it out")
    other = (
        _unknowns(place, table[:, 3], "unknown at the other end", position, size, first_unknown)
        if table.shape[1] == 4
        else np.full(position.size, HELD)
    )
    return SupportTable(position, unknown, damping, other)


def _check_positions(place: Place, position: FloatArray, what: str, repeated: bool) -> None:
    bad = np.flatnonzero(~np.isfinite(position))
    if bad.size:
        raise InputError(f"{place}: finite positions of {what} are needed, received {position[bad[0]]} in row {bad[0] + 1}")
    steps = np.diff(position)
    wrong = np.flatnonzero(steps < 0.0 if repeated else steps <= 0.0)
    if wrong.size:
        row = int(wrong[0])
        fault = "again" if steps[row] == 0.0 else f"after {position[row]:g} m"
        raise InputError(
            f"{place}: positions of {what} must ascend, received {position[row + 1]:g} m {fault} in row {row + 2}; "
            "sort the rows and name every node once"
        )


def _unknowns(place: Place, column: FloatArray, what: str, position: FloatArray, size: int, first_unknown: int) -> IntArray:
    """Unknowns from 0 (k,), −1 where the column is empty or negative."""
    given = np.where(np.isnan(column), -1.0, column)
    held = given < 0.0
    numbers = given - first_unknown
    bad = np.flatnonzero(~held & ((numbers != np.round(numbers)) | (numbers < 0.0) | (numbers >= size)))
    if bad.size:
        row = int(bad[0])
        raise InputError(
            f"{place}: a {what} is a row of the matrices, {first_unknown} to {size - 1 + first_unknown}, or −1 where it is "
            f"held, received {given[row]:g} at {position[row]:g} m; files.first_unknown is {first_unknown}"
        )
    return np.where(held, HELD, numbers).astype(np.int64)


def _renumbered(unknowns: IntArray, place: IntArray) -> IntArray:
    return np.where(unknowns >= 0, place[unknowns], HELD)
