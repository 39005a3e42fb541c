"""Mass, damping and stiffness of track and bridge, element by element, and of the train.

symbol   meaning                                                    unit         source
f₁, f₂   frequencies of the bare bridge, n² π/(2 L²) √(EI/m)        Hz           Frýba (1996), Dynamics of Railway Bridges
α, β     C = α M + β K, with the damping ratio at f₁ and f₂         1/s, s       Rayleigh
"""

from dataclasses import dataclass

import numpy as np

from railsearch_plugins.dynamics.banded import Elements, assemble, half_bandwidth
from railsearch_plugins.dynamics.beam import bending_matrices, gram_matrices, outer
from railsearch_plugins.dynamics.moving_contact import Track
from railsearch_plugins.dynamics.vehicles import RIGID, multibody, train
from railsearch_plugins.dynamics.vehicles import Vehicle as Train
from railsearch_plugins.track_models.train_track_bridge.ballast import ballast_values
from railsearch_plugins.track_models.train_track_bridge.layout import (
    FloatArray,
    IntArray,
    Layout,
    Numbering,
    make_layout,
    meshed_span,
    number_unknowns,
)
from railsearch_plugins.track_models.train_track_bridge.parameters import TrainTrackBridgeParameters

Part = tuple[list[Elements], list[Elements], list[Elements]]

SPRING = np.array([[1.0, -1.0]])


@dataclass(frozen=True)
class TrackElements:
    """Element matrices of track and bridge with their unknowns, and what they were made of."""

    layout: Layout
    numbering: Numbering
    mass: list[Elements]
    damping: list[Elements]
    stiffness: list[Elements]
    rayleigh: FloatArray


def assemble_track(parameters: TrainTrackBridgeParameters) -> TrackElements:
    """Lay out track and bridge and make the matrices of all their elements."""
    layout = make_layout(parameters)
    numbering = number_unknowns(layout)
    parts = (
        _rail(parameters, layout, numbering),
        _bridge(parameters, layout, numbering),
        _sleepers(parameters, layout, numbering),
        _subballast(parameters, layout, numbering),
    )
    mass, damping, stiffness = ([element for part in parts for element in part[kind]] for kind in range(3))
    return TrackElements(layout, numbering, mass, damping, stiffness, _rayleigh(parameters, numbering))


def track_matrices(elements: TrackElements) -> Track:
    """The matrices by lower diagonals."""
    width, size = half_bandwidth([*elements.stiffness, *elements.damping]), elements.numbering.size
    return Track(
        assemble(elements.mass, size, width),
        assemble(elements.damping, size, width),
        assemble(elements.stiffness, size, width),
        elements.rayleigh,
    )


def bridge_frequencies(parameters: TrainTrackBridgeParameters, count: int = 2) -> FloatArray:
    """The first frequencies (count,) in Hz of the bare bridge with its meshed span."""
    stiffness = parameters.bridge_modulus * parameters.bridge_inertia
    number, span = np.arange(1, count + 1), meshed_span(parameters)
    return np.asarray(0.5 * np.pi * (number / span) ** 2 * np.sqrt(stiffness / parameters.bridge_mass))


def rayleigh_factors(ratio: float, frequencies: FloatArray) -> tuple[float, float]:
    """α in 1/s and β in s that give a damping `ratio` at two frequencies (2,) in Hz: ratio = (α/ω + β ω)/2."""
    first, second = 2.0 * np.pi * frequencies
    return float(2.0 * ratio * first * second / (first + second)), float(2.0 * ratio / (first + second))


def make_train(parameters: TrainTrackBridgeParameters) -> Train:
    """All vehicles; of each carbody and bogies with their pitch, then the wheelsets, front to back."""
    vehicle, contact = parameters.vehicle, parameters.contact_stiffness
    carbody = parameters.carbody_mass_factor * vehicle.carbody_mass
    bogie = [vehicle.bogie_mass, vehicle.bogie_inertia]
    masses = np.array([carbody, vehicle.carbody_inertia, *bogie, *bogie, *([vehicle.wheelset_mass] * 4)])
    primary = parameters.primary_stiffness_factor * vehicle.primary_stiffness
    secondary = parameters.secondary_stiffness_factor * vehicle.secondary_stiffness
    matrices = multibody(
        masses,
        _elongations(vehicle.bogie_distance, vehicle.axle_distance),
        np.array([secondary] * 2 + [primary] * 4),
        np.array([vehicle.secondary_damping] * 2 + [vehicle.primary_damping] * 4),
    )
    weight = vehicle.gravity * (carbody + 2.0 * vehicle.bogie_mass + 4.0 * vehicle.wheelset_mass)
    spring = RIGID if isinstance(contact, str) else contact
    return train(Train(*matrices, np.full(4, weight / 4.0), spring), parameters.vehicles)


def _elongations(bogie_distance: float, axle_distance: float) -> FloatArray:
    """Rows (6, 10) of two secondary and four primary suspensions; pitch is positive with the front down."""
    rows = np.zeros((6, 10))
    for bogie, side in enumerate((1.0, -1.0)):
        rows[bogie, [0, 1, 2 + 2 * bogie]] = 1.0, side * bogie_distance, -1.0
        for axle, end in enumerate((1.0, -1.0)):
            number = 2 * bogie + axle
            rows[2 + number, [2 + 2 * bogie, 3 + 2 * bogie, 6 + number]] = 1.0, end * axle_distance, -1.0
    return rows


def _beam(nodes: IntArray, length: float, mass: float, stiffness: float, rayleigh: tuple[float, float]) -> Part:
    unknowns = np.concatenate([nodes[:-1], nodes[1:]], axis=1)
    lengths = np.full(unknowns.shape[0], length)
    inertia, bending = mass * gram_matrices(lengths, 0.0, lengths), bending_matrices(lengths, stiffness)
    return [(unknowns, inertia)], [(unknowns, rayleigh[0] * inertia + rayleigh[1] * bending)], [(unknowns, bending)]


def _rayleigh(parameters: TrainTrackBridgeParameters, numbering: Numbering) -> FloatArray:
    """α and β (2, n) of the beam that an unknown belongs to, zero for sleepers and ballast."""
    frequencies, factors = bridge_frequencies(parameters), np.zeros((2, numbering.size))
    for unknowns, ratio in ((numbering.rail, parameters.rail.damping), (numbering.bridge, parameters.bridge_damping)):
        factors[:, unknowns[unknowns >= 0]] = np.array(rayleigh_factors(ratio, frequencies))[:, None]
    return factors


def _rail(parameters: TrainTrackBridgeParameters, layout: Layout, numbering: Numbering) -> Part:
    rail = parameters.rail
    rayleigh = rayleigh_factors(rail.damping, bridge_frequencies(parameters))
    return _beam(numbering.rail, layout.element, rail.mass_per_length, rail.bending_stiffness, rayleigh)


def _bridge(parameters: TrainTrackBridgeParameters, layout: Layout, numbering: Numbering) -> Part:
    rayleigh = rayleigh_factors(parameters.bridge_damping, bridge_frequencies(parameters))
    stiffness = parameters.bridge_modulus * parameters.bridge_inertia
    return _beam(numbering.bridge, layout.element, parameters.bridge_mass, stiffness, rayleigh)


def _sleepers(parameters: TrainTrackBridgeParameters, layout: Layout, numbering: Numbering) -> Part:
    """Sleepers with their pads, and the ballast between them and the ballast masses or the bridge."""
    mass, stiffness = ballast_values(parameters)
    sleepers, ballast = numbering.sleepers[:, None], numbering.ballast[:, None]
    pads = np.concatenate([numbering.rail[layout.sleeper_nodes, :1], sleepers], axis=1)
    under = np.concatenate([sleepers, ballast], axis=1)
    return (
        [_alike(sleepers, parameters.sleeper_mass), _alike(ballast, mass)],
        [_alike(pads, parameters.pad_damping), _alike(under, parameters.ballast_damping)],
        [_alike(pads, parameters.pad_stiffness), _alike(under, stiffness)],
    )


def _subballast(parameters: TrainTrackBridgeParameters, layout: Layout, numbering: Numbering) -> Part:
    """Ballast masses on the ground and, if they are coupled, to their neighbours off the bridge."""
    off = ~layout.on_bridge
    ground = numbering.ballast[off][:, None]
    both = off[:-1] & off[1:]
    neighbours = np.stack([numbering.ballast[:-1], numbering.ballast[1:]], axis=1)[both]
    return (
        [],
        [_alike(ground, parameters.subballast_damping), _alike(neighbours, parameters.ballast_shear_damping)],
        [_alike(ground, parameters.subballast_stiffness), _alike(neighbours, parameters.ballast_shear_stiffness)],
    )


def _alike(unknowns: IntArray, value: float) -> Elements:
    """Masses or springs to ground (m, 1), or springs between two unknowns (m, 2), all of the same value."""
    return unknowns, outer(np.broadcast_to(SPRING[:, : unknowns.shape[1]], unknowns.shape), value)
