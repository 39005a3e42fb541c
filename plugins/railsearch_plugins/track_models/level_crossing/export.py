"""A level crossing in the form of an imported track."""

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np
import scipy.sparse

from railsearch.interfaces import TrackExport
from railsearch_plugins.track_models.level_crossing.assembly import Elements, assemble_track, pad_elements
from railsearch_plugins.track_models.level_crossing.layout import FloatArray, IntArray, Sleepers, place_sleepers
from railsearch_plugins.track_models.level_crossing.parameters import LevelCrossingParameters

MEGA = 1e6


def exported(parameters: LevelCrossingParameters, parts: bool) -> TrackExport:
    """Matrices of all elements; with `parts`, pads of equal place next to the crossing apart, at 1 MN/m, pad_1 the last.

    The names are those of the design problem: pad_3 is adjacent to the crossing when there are three.
    """
    sleepers = place_sleepers(parameters)
    rank = _ranks(parameters, sleepers)
    designed = len(parameters.zone.pad_stiffness) if parts else 0
    rest = dataclasses.replace(sleepers, pad_stiffness=np.where(rank < designed, 0.0, sleepers.pad_stiffness))
    track = assemble_track(parameters, rest)
    size, numbering = track.numbering.size, track.numbering
    pads, factors = {}, {}
    for place in range(designed):
        alone = dataclasses.replace(sleepers, pad_stiffness=np.where(rank == place, MEGA, 0.0))
        damping, stiffness = pad_elements(parameters, track.mesh, alone, numbering)
        name = f"pad_{designed - place}"
        pads[name] = {"damping": _matrix([damping], size), "stiffness": _matrix([stiffness], size)}
        factors[name] = parameters.zone.pad_stiffness[::-1][place] / MEGA
    under = np.full(sleepers.position.size, parameters.ballast.damping)
    return TrackExport(
        {kind: _matrix(getattr(track, kind), size) for kind in ("mass", "damping", "stiffness")},
        np.column_stack([track.mesh.nodes, numbering.rail]),
        np.column_stack([sleepers.position, numbering.sleepers, under]),
        _settings(parameters, sleepers),
        dict(sorted(pads.items())),
        dict(sorted(factors.items())),
    )


def _ranks(parameters: LevelCrossingParameters, sleepers: Sleepers) -> IntArray:
    """Place of every sleeper (s,) counted from the crossing, from 0."""
    before = int(np.count_nonzero(sleepers.position < parameters.geometry.approach_length))
    return np.concatenate([np.arange(before)[::-1], np.arange(sleepers.position.size - before)])


def _settings(parameters: LevelCrossingParameters, sleepers: Sleepers) -> dict[str, dict[str, object]]:
    geometry, windows, passage = parameters.geometry, parameters.windows, parameters.passage
    after = geometry.crossing_length if windows.force_after is None else windows.force_after
    before: FloatArray = sleepers.position[sleepers.position < geometry.approach_length]
    return {
        "rail": {"interpolation": "hermite", "rotation": "slope"},
        "vehicle": dataclasses.asdict(parameters.vehicle),
        "passage": {"speed": passage.speed, "time_step": passage.time_step, "start": 0.0, "end": geometry.total_length},
        "irregularity": dataclasses.asdict(parameters.irregularity),
        "windows": {
            "force_from": geometry.approach_length - windows.force_before,
            "force_to": geometry.approach_length + after,
            "energy_from": float(before[-windows.energy_sleepers]),
            "energy_to": float(before[-1]),
        },
    }


def _matrix(elements: Sequence[Elements], size: int) -> Any:
    """The sparse sum (n, n) of element matrices; an unknown of −1 is held."""
    rows, columns, values = [], [], []
    for unknowns, matrices in elements:
        row, column = np.broadcast_arrays(unknowns[:, :, None], unknowns[:, None, :])
        kept = (row >= 0) & (column >= 0) & (matrices != 0.0)
        rows.append(row[kept])
        columns.append(column[kept])
        values.append(matrices[kept])
    places = np.concatenate(rows), np.concatenate(columns)
    return scipy.sparse.coo_array((np.concatenate(values), places), shape=(size, size)).tocsr()
