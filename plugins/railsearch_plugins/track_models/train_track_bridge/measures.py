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
from numpy.typing import NDArray

from railsearch.errors import SimulationError
from railsearch_plugins.track_models.train_track_bridge.assembly import bridge_frequencies
from railsearch_plugins.track_models.train_track_bridge.layout import ROUNDING, FloatArray, element_length, first_axle
from railsearch_plugins.track_models.train_track_bridge.parameters import ALL, TrainTrackBridgeParameters
from railsearch_plugins.track_models.train_track_bridge.passage import Simulated, first_measured
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
    measured, span = slice(simulated.measured_from, None), simulated.elements.layout.span
    carbody = histories["carbody_acceleration"][measured]
    on_bridge = histories["contact_force"][wheels_on_bridge(parameters, histories["axle_position"], span)]
    sleepers = measured_sleepers(parameters, histories["sleeper_position"], span)
    frequencies = bridge_frequencies(parameters)
    return {
        "W_z": float(comfort_indices(parameters, histories).max()),
        "U_r": float(histories["rail_lowest"].max()),
        "A_s": float(histories["sleeper_acceleration_max"][sleepers].max()),
        "U_d": float(histories["deck_deflection"][measured].max()),
        "carbody_acceleration_max": float(np.abs(carbody).max()),
        "contact_force_max": float(on_bridge.max()),
        "contact_force_min": float(on_bridge.min()),
        "bridge_acceleration_max": float(histories["bridge_acceleration_max"].max()),
        "bridge_frequency_1": float(frequencies[0]),
        "bridge_frequency_2": float(frequencies[1]),
        "bridge_span": span,
    }


def comfort_indices(parameters: TrainTrackBridgeParameters, histories: Mapping[str, FloatArray]) -> FloatArray:
    """Sperling's index (v,) of every carbody over the measured steps."""
    measured = slice(first_measured(parameters, histories["axle_position"][:, 0]), None)
    return ride_comfort_index(histories["carbody_acceleration"][measured].T, first_axle(parameters)[1])


def wheels_on_bridge(parameters: TrainTrackBridgeParameters, axles: FloatArray, span: float) -> NDArray[np.bool_]:
    """Mask (t, w) of the wheels at `axles` (t, w) in m that stand on the bridge, of `span` in m, while it is measured."""
    rounding = ROUNDING * element_length(parameters)
    on = (axles >= -rounding) & (axles <= span + rounding)
    on[: first_measured(parameters, axles[:, 0])] = False
    return np.asarray(on)


def measured_sleepers(parameters: TrainTrackBridgeParameters, sleepers: FloatArray, span: float) -> NDArray[np.bool_]:
    """Mask (s,) of the sleepers at positions (s,) in m that count for A_s; `span` in m."""
    margin = np.inf if parameters.sleeper_range == ALL else parameters.sleeper_margin + ROUNDING * element_length(parameters)
    return np.asarray((sleepers >= -margin) & (sleepers <= span + margin))
