"""One passage of the train over the bridge, from parameters to what the kernel returns."""

from dataclasses import dataclass

import numpy as np

from railsearch_plugins.dynamics.beam import locate
from railsearch_plugins.dynamics.moving_contact import NONE, Contact, Observation, Passage, Track, make_contact, pass_over
from railsearch_plugins.dynamics.vehicles import Vehicle
from railsearch_plugins.track_models.train_track_bridge.assembly import (
    TrackElements,
    assemble_track,
    make_train,
    track_matrices,
)
from railsearch_plugins.track_models.train_track_bridge.layout import (
    FloatArray,
    IntArray,
    axle_offsets,
    first_axle,
    snapshot_step,
)
from railsearch_plugins.track_models.train_track_bridge.parameters import ALL, TrainTrackBridgeParameters
from railsearch_plugins.track_models.train_track_bridge.profile import make_profile


@dataclass(frozen=True)
class Simulated:
    """A passage with what passed over what.

    axles: positions (t, w) in m; measured_from: the first step that is measured; deck_row: u of the passage's points
    into the deflection at midspan (4,); kept: steps (k,) whose track states are in the passage; snapshot: one of them.
    """

    elements: TrackElements
    track: Track
    train: Vehicle
    contact: Contact
    axles: FloatArray
    time_step: float
    measured_from: int
    deck_row: FloatArray
    kept: IntArray
    snapshot: int
    passage: Passage


def simulate_passage(
    parameters: TrainTrackBridgeParameters, irregularity: FloatArray | None = None, kept: IntArray = NONE
) -> Simulated:
    """Assemble and run; `irregularity` r, ṙ, r̈ (t, w, 3), downward, replaces the profile's.

    Track states are kept at the steps `kept` (k,) and at that of the snapshot.
    """
    elements = assemble_track(parameters)
    track, train = track_matrices(elements), make_train(parameters)
    front, time_step = first_axle(parameters)
    axles = front[:, None] - axle_offsets(parameters.vehicle, parameters.vehicles)
    if irregularity is None:
        irregularity = irregularity_under(parameters, axles)
    orders = 3 if np.isinf(train.contact_stiffness) else 1
    contact = make_contact(
        elements.layout.nodes, elements.numbering.rail, axles, irregularity[:, :, :orders], parameters.speed
    )
    measured_from = first_measured(parameters, front)
    points, deck_row = _deck(parameters, elements)
    snapshot = snapshot_step(parameters)
    observation = Observation(
        points=points,
        extremes_from=0 if parameters.sleeper_range == ALL else measured_from,
        kept=np.union1d(kept, np.array([snapshot])),
    )
    passage = pass_over(track, train, contact, time_step, observation)
    return Simulated(
        elements, track, train, contact, axles, time_step, measured_from, deck_row, observation.kept, snapshot, passage
    )


def irregularity_under(parameters: TrainTrackBridgeParameters, axles: FloatArray) -> FloatArray:
    """r, ṙ, r̈ (t, w, 3) under axles at positions (t, w) in m, positive downward."""
    profile = make_profile(parameters)(axles.ravel())
    in_time = -profile * parameters.speed ** np.arange(3)[:, None]
    return np.ascontiguousarray(in_time.T).reshape(*axles.shape, 3)


def first_measured(parameters: TrainTrackBridgeParameters, front: FloatArray) -> int:
    """The first step at which the first axle, at `front` (t,) in m, is on the measured approach."""
    return int(np.searchsorted(front, -parameters.approach_length - 1e-9))


def _deck(parameters: TrainTrackBridgeParameters, elements: TrackElements) -> tuple[IntArray, FloatArray]:
    """Unknowns (4,) of the bridge around the middle of the given span, and the row (4,) that evaluates it there."""
    element, rows = locate(elements.layout.bridge_nodes, 0.5 * parameters.bridge_length)
    unknowns = elements.numbering.bridge[element[0] : element[0] + 2].ravel()
    return np.maximum(unknowns, 0), np.where(unknowns < 0, 0.0, rows[0])
