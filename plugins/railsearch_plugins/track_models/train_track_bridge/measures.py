"""Measures of a passage over a bridge.

symbol  meaning                                                                 shape   unit    source
W_z     Sperling's index of the carbody acceleration, largest over vehicles     scalar  -       Shang et al. (2024)
U_r     largest downward displacement of the rail                               scalar  m       Shang et al. (2024)
A_s     largest vertical acceleration of a sleeper                              scalar  m/s²    Shang et al. (2024)
U_d     largest downward deflection of the deck in the middle of its span       scalar  m       Shang et al. (2024)
a_c     acceleration of the carbodies at their centres                          (t, v)  m/s²
"""

from collections.abc import Mapping

import numpy as np

from railsearch.errors import SimulationError
from railsearch_plugins.track_models.train_track_bridge.assembly import bridge_frequencies
from railsearch_plugins.track_models.train_track_bridge.layout import ROUNDING, FloatArray
from railsearch_plugins.track_models.train_track_bridge.parameters import ALL, TrainTrackBridgeParameters
from railsearch_plugins.track_models.train_track_bridge.passage import Simulated
from railsearch_plugins.track_models.train_track_bridge.ride_comfort import ride_comfort_index
from railsearch_plugins.track_models.train_track_bridge.snapshot import BODIES, snapshot_histories


def make_histories(simulated: Simulated) -> dict[str, FloatArray]:
    """The histories of a passage by name. Raises SimulationError if one of them is not finite."""
    passage, layout, numbering = simulated.passage, simulated.elements.layout, simulated.elements.numbering
    under_wheels = passage.motion[:, :, 0] - simulated.contact.irregularity[:, :, 0]
    rail, bridge = numbering.rail[:, 0], numbering.bridge[:, 0]
    histories: dict[str, FloatArray] = {
        "time": simulated.time_step * np.arange(passage.force.shape[0], dtype=np.float64),
        "axle_position": simulated.axles,
        "contact_force": passage.force,
        "rail_displacement": under_wheels,
        "irregularity": -simulated.contact.irregularity[:, :, 0],
        "carbody_acceleration": carbody_acceleration(simulated),
        "deck_deflection": passage.point_displacement @ simulated.deck_row,
        "rail_position": layout.nodes,
        "rail_lowest": passage.highest[rail],
        "rail_highest": -passage.lowest[rail],
        "sleeper_position": layout.sleepers,
        "sleeper_acceleration_max": passage.largest_acceleration[numbering.sleepers],
        "bridge_position": layout.bridge_nodes,
        "bridge_deflection_max": np.where(bridge < 0, 0.0, passage.highest[bridge]),
        "bridge_acceleration_max": np.where(bridge < 0, 0.0, passage.largest_acceleration[bridge]),
        **snapshot_histories(simulated),
    }
    for name, values in histories.items():
        if not np.isfinite(values).all():
            raise SimulationError(
                f"train-track-bridge: the simulation diverged, {name} is not finite; reduce time_step "
                f"({simulated.time_step:g} s) or check the stiffnesses and masses for values out of proportion"
            )
    return histories


def carbody_acceleration(simulated: Simulated) -> FloatArray:
    """a_c (t, v), downward, from the equations of motion of the carbodies."""
    train, passage = simulated.train, simulated.passage
    bodies = passage.vehicle_displacement.shape[1]
    carbody = BODIES * np.arange(train.static_load.size // 4)
    force = passage.vehicle_displacement @ train.stiffness[carbody, :bodies].T
    force += passage.vehicle_velocity @ train.damping[carbody, :bodies].T
    return np.asarray(-force / np.diag(train.mass)[carbody])


def measure(
    parameters: TrainTrackBridgeParameters, simulated: Simulated, histories: Mapping[str, FloatArray]
) -> dict[str, float]:
    """The metrics of a passage by name."""
    measured = slice(simulated.measured_from, None)
    carbody = histories["carbody_acceleration"][measured]
    on_bridge = forces_on_bridge(simulated, histories["contact_force"])
    frequencies = bridge_frequencies(parameters)
    return {
        "W_z": float(ride_comfort_index(carbody.T, simulated.time_step).max()),
        "U_r": float(histories["rail_lowest"].max()),
        "A_s": float(histories["sleeper_acceleration_max"][measured_sleepers(parameters, simulated)].max()),
        "U_d": float(histories["deck_deflection"][measured].max()),
        "carbody_acceleration_max": float(np.abs(carbody).max()),
        "contact_force_max": float(on_bridge.max()),
        "contact_force_min": float(on_bridge.min()),
        "bridge_acceleration_max": float(histories["bridge_acceleration_max"].max()),
        "bridge_frequency_1": float(frequencies[0]),
        "bridge_frequency_2": float(frequencies[1]),
        "bridge_span": simulated.elements.layout.span,
    }


def forces_on_bridge(simulated: Simulated, force: FloatArray) -> FloatArray:
    """The forces of `force` (t, w) under wheels that stand on the bridge while it is measured."""
    rounding = ROUNDING * simulated.elements.layout.element
    on = (simulated.axles >= -rounding) & (simulated.axles <= simulated.elements.layout.span + rounding)
    on[: simulated.measured_from] = False
    return np.asarray(force[on])


def measured_sleepers(parameters: TrainTrackBridgeParameters, simulated: Simulated) -> FloatArray:
    """Mask (s,) of the sleepers that count for A_s."""
    layout = simulated.elements.layout
    margin = np.inf if parameters.sleeper_range == ALL else parameters.sleeper_margin + ROUNDING * layout.element
    return np.asarray((layout.sleepers >= -margin) & (layout.sleepers <= layout.span + margin))
