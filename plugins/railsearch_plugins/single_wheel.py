"""What the track models of one wheel share: the vehicle, the irregularity, histories and measures of a passage.

Shang et al. 2023 = Shang, Nogal, Teixeira & Wolfert, Engineering Structures 282 (2023) 115740; masses and suspension are
halved because one rail is modelled.

symbol  meaning                                                                 shape   unit   source
F       wheel-rail force in the force window                                    (t,)    N
a_c     carbody acceleration                                                    (t,)    m/s²
E_i     ∫ c v_i² dt, energy dissipated in the damper of support i over the      (s,)    N·m    Shang et al. (2023)
        passage (trapezoidal rule)
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from railsearch.errors import InputError, SimulationError
from railsearch.interfaces import Quantity
from railsearch.parameters import parameter
from railsearch_plugins.dynamics.vehicles import Vehicle as VehicleMatrices
from railsearch_plugins.dynamics.vehicles import multibody

FloatArray = NDArray[np.float64]

PRINTED = "Shang et al. 2023"
HALVED = "Shang et al. 2023, halved"

WHEEL_METRICS: Sequence[Quantity] = (
    Quantity("F_rms", "N", "root mean square of the wheel-rail force in the force window"),
    Quantity("F_max", "N", "largest minus smallest wheel-rail force in the force window"),
    Quantity("A_max", "m/s²", "largest minus smallest carbody acceleration in the force window"),
)
WHEEL_HISTORIES: Sequence[Quantity] = (
    Quantity("time", "s", "time since the start"),
    Quantity("wheel_position", "m", "position of the wheel"),
    Quantity("wheel_rail_force", "N", "wheel-rail force, compression positive"),
    Quantity("rail_displacement", "m", "rail under the wheel, downward"),
    Quantity("wheel_displacement", "m", "wheel from touching an unloaded level rail, downward"),
    Quantity("carbody_acceleration", "m/s²", "carbody, downward"),
)


@dataclass(frozen=True)
class Vehicle:
    """A quarter of a VIRM car reduced to one wheel: carbody, bogie and wheelset in line."""

    carbody_mass: float = parameter(
        7047.25,
        unit="kg",
        meaning="carbody, taken with wheel_load 'from masses'",
        source="Shang et al. 2023, 56378/8",
        above=0.0,
    )
    bogie_mass: float = parameter(943.0, unit="kg", meaning="bogie", source="Shang et al. 2023, 3772/4", above=0.0)
    wheelset_mass: float = parameter(909.5, unit="kg", meaning="wheelset", source="Shang et al. 2023, 1819/2", above=0.0)
    primary_stiffness: float = parameter(1222.5e3, unit="N/m", meaning="wheelset to bogie", source=HALVED, above=0.0)
    primary_damping: float = parameter(1e3, unit="N s/m", meaning="wheelset to bogie", source=HALVED, minimum=0.0)
    secondary_stiffness: float = parameter(1113.5e3, unit="N/m", meaning="bogie to carbody", source=HALVED, above=0.0)
    secondary_damping: float = parameter(25.05e3, unit="N s/m", meaning="bogie to carbody", source=HALVED, minimum=0.0)
    wheel_load: float | str = parameter(
        50e3,
        unit="N",
        meaning="static wheel load, reached by adjusting the carbody mass, or 'from masses'",
        source="Shang et al. 2023, level of the force",
        above=0.0,
        choices=("from masses",),
    )
    hertz_constant: float = parameter(5.13e-8, unit="m/N^(2/3)", meaning="Hertz constant G", source=PRINTED, above=0.0)
    gravity: float = parameter(9.8, unit="m/s²", meaning="acceleration of gravity", source=PRINTED, above=0.0)

    @property
    def static_load(self) -> float:
        """Static wheel load P in N."""
        if isinstance(self.wheel_load, str):
            return self.gravity * (self.carbody_mass + self.bogie_mass + self.wheelset_mass)
        return float(self.wheel_load)

    @property
    def effective_carbody_mass(self) -> float:
        """The carbody mass in kg that makes the static wheel load."""
        return self.static_load / self.gravity - self.bogie_mass - self.wheelset_mass

    @property
    def contact_stiffness(self) -> float:
        """Linearised Hertz spring k_w = 3/(2G) P^(1/3) in N/m."""
        return 1.5 / self.hertz_constant * math.cbrt(self.static_load)


@dataclass(frozen=True)
class Irregularity:
    """Vertical level of the unloaded rail, interpolated by a cubic spline; none by default."""

    position: tuple[float, ...] = parameter(
        (), unit="m", meaning="ascending positions that cover the run", source="measured"
    )
    height: tuple[float, ...] = parameter((), unit="m", meaning="height there, positive upward", source="measured")


def vehicle_matrices(vehicle: Vehicle) -> VehicleMatrices:
    """Carbody, bogie and wheelset in line on a Hertz contact."""
    matrices = multibody(
        np.array([vehicle.effective_carbody_mass, vehicle.bogie_mass, vehicle.wheelset_mass]),
        np.array([[1.0, -1.0, 0.0], [0.0, 1.0, -1.0]]),
        np.array([vehicle.secondary_stiffness, vehicle.primary_stiffness]),
        np.array([vehicle.secondary_damping, vehicle.primary_damping]),
    )
    return VehicleMatrices(*matrices, np.array([vehicle.static_load]), vehicle.contact_stiffness)


def irregularity_at(irregularity: Irregularity, positions: FloatArray) -> FloatArray:
    """Irregularity (t,) in m, positive downward, by a cubic spline through the measured heights; zero without any."""
    if not irregularity.position:
        return np.zeros_like(positions)
    from scipy.interpolate import CubicSpline

    return np.asarray(-CubicSpline(irregularity.position, irregularity.height)(positions))


def check_vehicle(vehicle: Vehicle, model: str) -> None:
    """Raise InputError if the static load leaves nothing for the carbody; `model` begins the name of the field."""
    least = vehicle.gravity * (vehicle.bogie_mass + vehicle.wheelset_mass)
    if not vehicle.static_load > least:
        raise InputError(
            f"{model}.vehicle.wheel_load: bogie and wheelset alone weigh {least:g} N and the carbody must weigh something, "
            f"received {vehicle.wheel_load} N; raise the load or lower the masses"
        )


def check_irregularity(irregularity: Irregularity, run: tuple[float, float], model: str) -> None:
    """Raise InputError unless the profile, if there is one, ascends and covers the run from … to … in m."""
    position, height, (start, end) = irregularity.position, irregularity.height, run
    if len(position) != len(height) or len(position) == 1:
        raise InputError(
            f"{model}.irregularity.height: as many heights as positions are needed, none or at least two, received "
            f"{len(position)} positions and {len(height)} heights; give one height per position"
        )
    if position and not (steps := np.diff(position)).min() > 0.0:
        raise InputError(
            f"{model}.irregularity.position: positions must ascend, received a step of {steps.min():g} m; sort them"
        )
    if position and not (position[0] <= start and position[-1] >= end):
        raise InputError(
            f"{model}.irregularity.position: positions must cover the run from {start:g} to {end:g} m, received "
            f"{position[0]:g} to {position[-1]:g} m; extend the measured profile"
        )


def carbody_acceleration(vehicle: VehicleMatrices, displacement: FloatArray, velocity: FloatArray) -> FloatArray:
    """a_c (t,) from the equation of motion of the carbody; its static load is balanced at rest and left out."""
    return np.asarray(-(displacement @ vehicle.stiffness[0] + velocity @ vehicle.damping[0]) / vehicle.mass[0, 0])


def check_finite(histories: Mapping[str, FloatArray], where: str, time_step: float) -> None:
    """Raise SimulationError that names the first history with a number that is not finite."""
    for name, values in histories.items():
        if not np.isfinite(values).all():
            raise SimulationError(
                f"{where}: the simulation diverged, {name} is not finite; reduce passage.time_step ({time_step:g} s) or "
                "check the stiffnesses and masses for values out of proportion"
            )


def passage_metrics(force: FloatArray, acceleration: FloatArray, energy: FloatArray) -> dict[str, float]:
    """The metrics of force and carbody acceleration in the force window (k,) and energies under supports (s,), s ≥ 2."""
    return {
        "F_rms": rms(force),
        "F_max": float(np.ptp(force)),
        "E_rms": rms(energy),
        "E_max": float(np.ptp(energy)),
        "E_adjacent": float(np.abs(np.diff(energy)).max()),
        "A_max": float(np.ptp(acceleration)),
    }


def rms(values: FloatArray) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(values**2)))
