"""One passage of the vehicle over a level crossing, from parameters to histories."""

from dataclasses import dataclass

import numpy as np

from railsearch_plugins.dynamics.banded import assemble, half_bandwidth
from railsearch_plugins.dynamics.moving_contact import NONE, Contact, Observation, Passage, Track, make_contact, pass_over
from railsearch_plugins.dynamics.vehicles import Vehicle
from railsearch_plugins.single_wheel import irregularity_at, vehicle_matrices
from railsearch_plugins.track_models.level_crossing.assembly import (
    TrackElements,
    assemble_track,
    proportional_damping,
)
from railsearch_plugins.track_models.level_crossing.layout import FloatArray, IntArray
from railsearch_plugins.track_models.level_crossing.parameters import LevelCrossingParameters


@dataclass(frozen=True)
class Simulated:
    """A passage with the track it went over and the wheel's positions (t,) in m."""

    elements: TrackElements
    track: Track
    vehicle: Vehicle
    contact: Contact
    position: FloatArray
    passage: Passage


def simulate_passage(
    parameters: LevelCrossingParameters, positions: FloatArray | None = None, kept: IntArray = NONE
) -> Simulated:
    """Assemble and run; `positions` (t,) in m replace the run from x = 0; track states are kept at steps `kept` (k,)."""
    elements = assemble_track(parameters)
    width, size = half_bandwidth(elements.stiffness), elements.numbering.size
    track = Track(
        assemble(elements.mass, size, width),
        assemble(elements.damping, size, width),
        assemble(elements.stiffness, size, width),
        proportional_damping(parameters, elements),
    )
    wheel = wheel_positions(parameters) if positions is None else positions
    irregularity = irregularity_at(parameters.irregularity, wheel)[:, None, None]
    contact = make_contact(elements.mesh.nodes, elements.numbering.rail, wheel[:, None], irregularity)
    vehicle = vehicle_matrices(parameters.vehicle)
    observation = Observation(supports=elements.numbering.sleepers, kept=kept)
    passage = pass_over(track, vehicle, contact, parameters.passage.time_step, observation)
    return Simulated(elements, track, vehicle, contact, wheel, passage)


def wheel_positions(parameters: LevelCrossingParameters) -> FloatArray:
    """Wheel at n v dt from x = 0, floor(L/(v dt)) steps."""
    advance = parameters.passage.speed * parameters.passage.time_step
    steps = int(np.floor(parameters.geometry.total_length / advance))
    return np.asarray(advance * np.arange(steps + 1))
