"""Where things stand on a level crossing: mesh, sleepers, pads, strip, and the numbering of the unknowns."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from railsearch_plugins.dynamics.numbering import number_along
from railsearch_plugins.track_models.level_crossing.parameters import LevelCrossingParameters, Zone

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

# Lengths that differ by less are the same: sleepers do not stand on the pinned ends, nor on an interface.
SAME_PLACE = 1e-9


@dataclass(frozen=True)
class Sleepers:
    """Sleepers of both sides, ascending: position (s,) in m, mass (s,) in kg, pad stiffness (s,) in N/m as given."""

    position: FloatArray
    mass: FloatArray
    pad_stiffness: FloatArray


@dataclass(frozen=True)
class Mesh:
    """Edges of the rail elements (m + 1,) in m, and the range of rail elements on each slab."""

    nodes: FloatArray
    slabs: tuple[slice, ...]


@dataclass(frozen=True)
class Numbering:
    """Unknowns in natural order along the track: rail (m + 1, 2), slabs (k + 1, 2) each, sleepers (s,); −1 is held."""

    rail: IntArray
    slabs: tuple[IntArray, ...]
    sleepers: IntArray
    size: int


def sleeper_distances_from_crossing(zone: Zone, spacing: float, side_length: float) -> FloatArray:
    """Distances of the sleepers of one side from its interface, in m, outwards; the last stands before the track's end."""
    near = np.cumsum(zone.sleeper_distances[::-1])
    regular = int(np.floor((side_length - near[-1]) / spacing - SAME_PLACE)) if near[-1] < side_length else 0
    distances = np.concatenate([near, near[-1] + spacing * np.arange(1, regular + 1)])
    return np.asarray(distances[distances < side_length - SAME_PLACE])


def place_sleepers(parameters: LevelCrossingParameters) -> Sleepers:
    """The sleepers of both sides; spacings, pads and strengthened sleepers of the far side mirror the approach."""
    geometry, zone = parameters.geometry, parameters.zone
    approach = sleeper_distances_from_crossing(zone, parameters.sleeper.spacing, geometry.approach_length)
    departure = sleeper_distances_from_crossing(zone, parameters.sleeper.spacing, geometry.departure_length)
    rank = np.concatenate([np.arange(approach.size)[::-1], np.arange(departure.size)])
    pads = np.concatenate([zone.pad_stiffness[::-1], np.full(rank.size, parameters.railpad.stiffness)])
    strengthened = rank < zone.strengthened_sleepers
    return Sleepers(
        np.concatenate([geometry.approach_length - approach[::-1], geometry.crossing_end + departure]),
        np.where(strengthened, parameters.sleeper.strengthened_mass, parameters.sleeper.mass),
        pads[rank],
    )


def make_mesh(parameters: LevelCrossingParameters) -> Mesh:
    """Rail elements no longer than asked for, with edges on the interfaces and the joints of the slabs."""
    geometry = parameters.geometry
    ends = [
        0.0,
        *(geometry.approach_length + geometry.slab_length * np.arange(geometry.slab_count + 1)),
        geometry.total_length,
    ]
    counts = [int(np.ceil(length / parameters.passage.element_length - SAME_PLACE)) for length in np.diff(ends)]
    parts = [np.linspace(a, b, n, endpoint=False) for a, b, n in zip(ends[:-1], ends[1:], counts, strict=True)]
    first = np.cumsum([0, *counts])
    slabs = tuple(slice(int(first[i]), int(first[i + 1])) for i in range(1, geometry.slab_count + 1))
    return Mesh(np.concatenate([*parts, [geometry.total_length]]), slabs)


def number_unknowns(mesh: Mesh, sleepers: Sleepers) -> Numbering:
    """Number sleepers, slab nodes and rail nodes by their position; a sleeper comes just before the rail node it is next to.

    The order keeps the half-bandwidth at 4 on ballast track and 9 over the joint of two slabs. Both rail ends are pinned.
    """
    slab_nodes = [mesh.nodes[part.start : part.stop + 1] for part in mesh.slabs]
    at_node = mesh.nodes[np.searchsorted(mesh.nodes, sleepers.position - SAME_PLACE)]
    rail_counts = np.full(mesh.nodes.size, 2)
    rail_counts[[0, -1]] = 1
    groups = [(at_node, np.ones(at_node.size, dtype=np.int64))]
    groups += [(nodes, np.full(nodes.size, 2)) for nodes in slab_nodes]
    (sleeper, *slabs, rail), size = number_along([*groups, (mesh.nodes, rail_counts)])
    rail_unknowns = np.stack([rail, rail + 1], axis=1)
    rail_unknowns[[0, -1]] = [[-1, rail[0]], [-1, rail[-1]]]
    return Numbering(rail_unknowns, tuple(np.stack([slab, slab + 1], axis=1) for slab in slabs), sleeper, size)
