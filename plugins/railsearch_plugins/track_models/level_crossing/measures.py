"""Measures of a passage over a level crossing.

symbol      meaning                                                      shape   unit    source
F           wheel-rail force                                             (t,)    N
a_c         carbody acceleration                                         (t,)    m/s²
E_i         ∫ c_b v_s,i² dt, energy dissipated in the ballast damper     (s,)    N·m     Shang et al. (2023)
            under sleeper i over the passage (trapezoidal rule)
"""

from collections.abc import Mapping

import numpy as np

from railsearch.errors import SimulationError
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
        "carbody_acceleration": carbody_acceleration(simulated),
        "sleeper_position": simulated.elements.sleepers.position,
        "sleeper_energy": parameters.ballast.damping * passage.support_integrals,
    }
    for name, values in histories.items():
        if not np.isfinite(values).all():
            raise SimulationError(
                f"level crossing: the simulation diverged, {name} is not finite; reduce passage.time_step "
                f"({parameters.passage.time_step:g} s) or check the stiffnesses and masses for values out of proportion"
            )
    return histories


def carbody_acceleration(simulated: Simulated) -> FloatArray:
    """a_c (t,) from the equation of motion of the carbody; its static load is balanced at rest and left out."""
    vehicle, passage = simulated.vehicle, simulated.passage
    suspension = passage.vehicle_displacement @ vehicle.stiffness[0] + passage.vehicle_velocity @ vehicle.damping[0]
    return np.asarray(-suspension / vehicle.mass[0, 0])


def measure(parameters: LevelCrossingParameters, histories: Mapping[str, FloatArray]) -> dict[str, float]:
    """The metrics of a passage by name."""
    window = force_window(parameters, histories["wheel_position"])
    force = histories["wheel_rail_force"][window]
    acceleration = histories["carbody_acceleration"][window]
    energy = approach_energy(parameters, histories)
    return {
        "F_rms": _rms(force),
        "F_max": float(np.ptp(force)),
        "E_rms": _rms(energy),
        "E_max": float(np.ptp(energy)),
        "E_adjacent": float(np.abs(np.diff(energy)).max()),
        "A_max": float(np.ptp(acceleration)),
    }


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


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))
