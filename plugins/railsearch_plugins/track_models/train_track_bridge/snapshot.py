"""Train, track and bridge at the step of the snapshot: displacements downward, pitch positive with the front down.

Displacements of the vehicles are from where they would stand on a track that is level and does not yield.
"""

import numpy as np

from railsearch_plugins.track_models.train_track_bridge.layout import FloatArray, IntArray
from railsearch_plugins.track_models.train_track_bridge.passage import Simulated

CARBODY, FIRST_BOGIE, SECOND_BOGIE, BODIES = 0, 2, 4, 6
"""Places of displacement and then pitch among the unknowns of a vehicle, and how many these are."""


def snapshot_histories(simulated: Simulated) -> dict[str, FloatArray]:
    """The state of a passage at the step of the snapshot, by name."""
    step, numbering = simulated.snapshot, simulated.elements.numbering
    track = simulated.passage.track_displacement[int(np.searchsorted(simulated.kept, step))]
    bodies = _bodies(simulated)
    bogies = bodies[:, [FIRST_BOGIE, SECOND_BOGIE]].ravel(), bodies[:, [FIRST_BOGIE + 1, SECOND_BOGIE + 1]].ravel()
    return {
        "snapshot_time": np.array([simulated.time_step * step]),
        "snapshot_rail_displacement": track[numbering.rail[:, 0]],
        "snapshot_sleeper_displacement": track[numbering.sleepers],
        "snapshot_ballast_displacement": _free(track, numbering.ballast),
        "snapshot_bridge_deflection": _free(track, numbering.bridge[:, 0]),
        "snapshot_carbody_displacement": bodies[:, CARBODY],
        "snapshot_carbody_pitch": bodies[:, CARBODY + 1],
        "snapshot_bogie_displacement": bogies[0],
        "snapshot_bogie_pitch": bogies[1],
        "snapshot_wheel_displacement": _wheels(simulated),
    }


def _bodies(simulated: Simulated) -> FloatArray:
    """Displacements and pitches (v, BODIES) of the vehicles without their wheels."""
    vehicles = simulated.train.static_load.size // 4
    state = simulated.passage.vehicle_displacement[simulated.snapshot]
    return np.asarray(state[: BODIES * vehicles].reshape(vehicles, BODIES))


def _wheels(simulated: Simulated) -> FloatArray:
    """Displacements (w,) of the wheels: unknowns of their own on a Hertz spring, else those of the rail below."""
    if np.isinf(simulated.train.contact_stiffness):
        return np.asarray(simulated.passage.motion[simulated.snapshot, :, 0])
    return np.asarray(simulated.passage.vehicle_displacement[simulated.snapshot, -simulated.train.static_load.size :])


def _free(displacement: FloatArray, unknowns: IntArray) -> FloatArray:
    """Displacements (k,) of unknowns (k,), zero for those that are held."""
    return np.where(unknowns < 0, 0.0, displacement[unknowns])
