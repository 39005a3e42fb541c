"""Measures of a passage over a level crossing.

symbol      meaning                                                      shape   unit    source
F           wheel-rail force                                             (t,)    N
a_c         carbody acceleration                                         (t,)    m/s²
E_i         ∫ c_b v_s,i² dt, energy dissipated in the ballast damper     (s,)    N·m     Shang et al. (2023)
            under sleeper i over the passage (trapezoidal rule)
"""

from collections.abc import Mapping

import numpy as np

from railsearch_plugins.single_wheel import carbody_acceleration, check_finite, passage_metrics
from railsearch_plugins.track_models.level_crossing.layout import SAME_PLACE, FloatArray
from railsearch_plugins.track_models.level_crossing.parameters import LevelCrossingParameters
from railsearch_plugins.track_models.level_crossing.passage import Simulated


def make_histories(parameters: LevelCrossingParameters, simulated: Simulated) -> dict[str, FloatArray]:
    """The histories of a passage by name. Raises SimulationError if one of them is not finite."""
    passage = simulated.passage
    histories: dict[str, FloatArray] = {
        "time": parameters.passage.time_step * np.arange(simulated.position.size, dtype=np.float64),
        "wheel_position": simulated.position,
        "wheel_rail_force": passage.force[:, 0],
        "rail_displacement": (passage.motion - simulated.contact.irregularity)[:, 0, 0],
        "wheel_displacement": passage.vehicle_displacement[:, -1],
        "carbody_acceleration": carbody_acceleration(
            simulated.vehicle, passage.vehicle_displacement, passage.vehicle_velocity
        ),
        "sleeper_position": simulated.elements.sleepers.position,
        "sleeper_energy": parameters.ballast.damping * passage.support_integrals,
    }
    check_finite(histories, "level crossing", parameters.passage.time_step)
    return histories


def measure(parameters: LevelCrossingParameters, histories: Mapping[str, FloatArray]) -> dict[str, float]:
    """The metrics of a passage by name."""
    window = force_window(parameters, histories["wheel_position"])
    force = histories["wheel_rail_force"][window]
    acceleration = histories["carbody_acceleration"][window]
    energy = approach_energy(parameters, histories)
    return passage_metrics(force, acceleration, energy)


def force_window(parameters: LevelCrossingParameters, position: FloatArray) -> FloatArray:
    """Mask (t,) of the steps at which the wheel is in the force window, edges included."""
    geometry, windows = parameters.geometry, parameters.windows
    after = geometry.crossing_length if windows.force_after is None else windows.force_after
    start = geometry.approach_length - windows.force_before - SAME_PLACE
    return np.asarray((position >= start) & (position <= geometry.approach_length + after + SAME_PLACE))


def approach_energy(parameters: LevelCrossingParameters, histories: Mapping[str, FloatArray]) -> FloatArray:
    """Energies of the measured sleepers before the crossing, ascending with position."""
    before = histories["sleeper_position"] < parameters.geometry.approach_length
    return histories["sleeper_energy"][before][-parameters.windows.energy_sleepers :]
