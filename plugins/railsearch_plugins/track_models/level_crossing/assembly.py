"""Mass, damping and stiffness of the track, element by element, and of the vehicle."""

from dataclasses import dataclass

import numpy as np

from railsearch_plugins.dynamics.beam import bending_matrices, coupled, gram_matrices, layer_matrices, locate, outer
from railsearch_plugins.track_models.level_crossing.layout import (
    FloatArray,
    IntArray,
    Mesh,
    Numbering,
    Sleepers,
    make_mesh,
    number_unknowns,
    place_sleepers,
)
from railsearch_plugins.track_models.level_crossing.parameters import LevelCrossingParameters

Elements = tuple[IntArray, FloatArray]


@dataclass(frozen=True)
class TrackElements:
    """Element matrices of a level crossing with their unknowns, and what they were made of."""

    mesh: Mesh
    sleepers: Sleepers
    numbering: Numbering
    mass: list[Elements]
    damping: list[Elements]
    stiffness: list[Elements]


def assemble_track(parameters: LevelCrossingParameters, sleepers: Sleepers | None = None) -> TrackElements:
    """Lay out the level crossing, with these sleepers in place of its own, and make the matrices of all its elements."""
    mesh, sleepers = make_mesh(parameters), sleepers or place_sleepers(parameters)
    numbering = number_unknowns(mesh, sleepers)
    parts = (
        _rail(parameters, mesh, numbering),
        _ballast_track(parameters, mesh, sleepers, numbering),
        *(
            _slab(parameters, mesh.nodes[part.start : part.stop + 1], unknowns)
            for part, unknowns in zip(mesh.slabs, numbering.slabs, strict=True)
        ),
        *(_strip(parameters, mesh, numbering, index) for index in range(len(mesh.slabs))),
    )
    mass, damping, stiffness = ([element for part in parts for element in part[kind]] for kind in range(3))
    return TrackElements(mesh, sleepers, numbering, mass, damping, stiffness)


def pad_values(parameters: LevelCrossingParameters, sleepers: Sleepers) -> tuple[FloatArray, FloatArray]:
    """Stiffness and damping (s,) of all pads in the model: damping in proportion to stiffness, both halved if so read."""
    railpad = parameters.railpad
    share = 0.5 if railpad.reading == "full-track" else 1.0
    stiffness = share * sleepers.pad_stiffness
    return stiffness, railpad.damping / railpad.stiffness * stiffness


def proportional_damping(parameters: LevelCrossingParameters, elements: TrackElements) -> FloatArray:
    """α in 1/s and β = 0 (2, n): layers damp in proportion to the mass of the beams on them; elsewhere both are zero."""
    mesh, numbering, factors = elements.mesh, elements.numbering, np.zeros((2, elements.numbering.size))
    (type_2, type_1), boundary = _strip_damping(parameters), _strip_boundary(parameters)
    for part, slab in zip(mesh.slabs, numbering.slabs, strict=True):
        nodes = slice(part.start, part.stop + 1)
        strip = np.where(mesh.nodes[nodes] < boundary, type_2, type_1)[:, None]
        alpha = strip / parameters.rail.mass_per_length
        beneath = (strip + parameters.slab.subgrade_damping) / parameters.slab.mass_per_length
        for unknowns, values in ((numbering.rail[nodes], alpha), (slab, beneath)):
            free = unknowns >= 0
            factors[0, unknowns[free]] = np.broadcast_to(values, unknowns.shape)[free]
    return factors


Part = tuple[list[Elements], list[Elements], list[Elements]]


def _element_unknowns(nodes: IntArray) -> IntArray:
    return np.concatenate([nodes[:-1], nodes[1:]], axis=1)


def _rail(parameters: LevelCrossingParameters, mesh: Mesh, numbering: Numbering) -> Part:
    unknowns, length = _element_unknowns(numbering.rail), np.diff(mesh.nodes)
    mass = parameters.rail.mass_per_length * gram_matrices(length, 0.0, length)
    return [(unknowns, mass)], [], [(unknowns, bending_matrices(length, parameters.rail.bending_stiffness))]


def pad_elements(
    parameters: LevelCrossingParameters, mesh: Mesh, sleepers: Sleepers, numbering: Numbering
) -> tuple[Elements, Elements]:
    """Damping and stiffness of the pads."""
    element, rows = locate(mesh.nodes, sleepers.position)
    pads = np.concatenate([_element_unknowns(numbering.rail)[element], numbering.sleepers[:, None]], axis=1)
    elongation = np.concatenate([rows, np.full((rows.shape[0], 1), -1.0)], axis=1)
    stiffness, damping = pad_values(parameters, sleepers)
    return (pads, outer(elongation, damping)), (pads, outer(elongation, stiffness))


def _ballast_track(parameters: LevelCrossingParameters, mesh: Mesh, sleepers: Sleepers, numbering: Numbering) -> Part:
    damping, stiffness = pad_elements(parameters, mesh, sleepers, numbering)
    under, one = numbering.sleepers[:, None], np.ones((sleepers.mass.size, 1))
    return (
        [(under, outer(one, sleepers.mass))],
        [damping, (under, outer(one, parameters.ballast.damping))],
        [stiffness, (under, outer(one, parameters.ballast.stiffness))],
    )


def _slab(parameters: LevelCrossingParameters, nodes: FloatArray, numbering: IntArray) -> Part:
    slab, unknowns, length = parameters.slab, _element_unknowns(numbering), np.diff(nodes)
    gram = gram_matrices(length, 0.0, length)
    bending = bending_matrices(length, slab.bending_stiffness)
    return (
        [(unknowns, slab.mass_per_length * gram)],
        [(unknowns, slab.subgrade_damping * gram)],
        [(unknowns, bending + slab.subgrade_stiffness * gram)],
    )


def _strip(parameters: LevelCrossingParameters, mesh: Mesh, numbering: Numbering, index: int) -> Part:
    strip, part = parameters.strip, mesh.slabs[index]
    edges = mesh.nodes[part.start : part.stop + 1]
    rail = _element_unknowns(numbering.rail[part.start : part.stop + 1])
    unknowns = np.concatenate([rail, _element_unknowns(numbering.slabs[index])], axis=1)
    boundary, damping = _strip_boundary(parameters), _strip_damping(parameters)
    return (
        [],
        [(unknowns, coupled(layer_matrices(edges, boundary, *damping)))],
        [(unknowns, coupled(layer_matrices(edges, boundary, strip.type_2_stiffness, strip.type_1_stiffness)))],
    )


def _strip_boundary(parameters: LevelCrossingParameters) -> float:
    """Where the strips of type 2 end, in m."""
    return parameters.geometry.approach_length + parameters.zone.type_2_strip_length


def _strip_damping(parameters: LevelCrossingParameters) -> FloatArray:
    """Of the strips of type 2 and 1 (2,), in N s/m²."""
    strip = parameters.strip
    stiffness = np.array([strip.type_2_stiffness, strip.type_1_stiffness])
    return np.asarray(2.0 * strip.damping_ratio * np.sqrt(stiffness * parameters.rail.mass_per_length))
