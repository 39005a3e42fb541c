"""Vehicles as multibody data: rigid bodies, springs and dampers between them, wheels on a track.

symbol     meaning                                                         shape       unit         source
z          displacement (down) of bodies, then of wheels, from where they  (p,)        m, rad
           are at rest under their own weight on an unloaded, level rail
b, w       as indices: bodies, wheels
y          wheel on the rail, rail displacement + irregularity (down)      (w,)        m
P, F       static wheel load, wheel-rail force (compression positive)      (w,)        N
k_w        linear contact stiffness, infinite for a rigid contact          scalar      N/m
E          load on what is integrated by F, y, ẏ                           (q, w)      -, N/m, N s/m
A_v        4 M/dt² + 2 C/dt + K of what is integrated                      (q, q)      N/m
H          force under a wheel by displacement and velocity there          (w, q)      N/m, N s/m
Z          force under a wheel by −y, −ẏ, −ÿ                               (3, w, w)   N/m, …

With a Hertz contact bodies and wheels are integrated, F = k_w (z_w − y) and E_F = −1 for the wheels. With a rigid contact
z_w = y: the bodies alone are integrated, with E_0 = −K_bw and E_1 = −C_bw, and the wheels' equations of motion give
F = P − M_ww ÿ − C_ww ẏ − K_ww y − C_wb ż − K_wb z. Either way, at the end of a step,

    F = F⁰ − Z_0 y − Z_1 ẏ − Z_2 ÿ,   F⁰ = F_base + H_0 z⁰ + H_1 ż⁰,

where z⁰ is what the step gives without F, y and ẏ at its end.
"""

from typing import NamedTuple

import numpy as np

from railsearch_plugins.dynamics.beam import FloatArray, IntArray, outer

RIGID = float("inf")
NONE = np.empty((0, 4), dtype=np.int64)


class Vehicle(NamedTuple):
    """Matrices (p, p) of bodies and wheels, the wheels last; static loads (w,) in N; contact stiffness in N/m or RIGID."""

    mass: FloatArray
    damping: FloatArray
    stiffness: FloatArray
    static_load: FloatArray
    contact_stiffness: float


class VehicleStep(NamedTuple):
    """What a step needs of the vehicles: A_v⁻¹, (2/dt) M, K (q, q), constant load (q,), E (q, w), F_base (w,), H, Z.

    Vehicles do not feel one another: what is integrated and the wheels depend on bodies from, to and wheels from, to, one
    past the last, (q, 4) and (w, 4).
    """

    compliance: FloatArray
    scaled_mass: FloatArray
    stiffness: FloatArray
    load: FloatArray
    by_force: FloatArray
    by_position: FloatArray
    by_velocity: FloatArray
    base_force: FloatArray
    from_displacement: FloatArray
    from_velocity: FloatArray
    impedance: FloatArray
    body_spans: IntArray = NONE
    wheel_spans: IntArray = NONE


def multibody(
    masses: FloatArray, elongations: FloatArray, stiffness: FloatArray, damping: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Mass, damping and stiffness matrices (p, p) of bodies with `masses` (p,) joined by suspensions.

    elongations: rows (s, p), the elongation of a suspension is row · z; stiffness and damping of each (s,).
    """
    return np.diag(masses), outer(elongations, damping).sum(axis=0), outer(elongations, stiffness).sum(axis=0)


def train(vehicle: Vehicle, count: int) -> Vehicle:
    """`count` alike vehicles, not coupled: all bodies, vehicle by vehicle, then all wheels."""
    size, wheels = vehicle.mass.shape[0], vehicle.static_load.size
    order = np.arange(size * count).reshape(count, size)
    order = np.concatenate([order[:, : size - wheels].ravel(), order[:, size - wheels :].ravel()])
    mass, damping, stiffness = (np.kron(np.eye(count), matrix)[np.ix_(order, order)] for matrix in vehicle[:3])
    return Vehicle(mass, damping, stiffness, np.tile(vehicle.static_load, count), vehicle.contact_stiffness)


def at_rest(vehicle: Vehicle, wheel: FloatArray) -> FloatArray:
    """Displacements (p,) of bodies and wheels at rest with the wheels at `wheel` (w,) in m."""
    bodies = vehicle.mass.shape[0] - wheel.size
    inner, across = vehicle.stiffness[:bodies, :bodies], vehicle.stiffness[:bodies, bodies:]
    resting = np.linalg.solve(inner, -across @ wheel) if bodies else np.empty(0)
    return np.concatenate([resting, wheel])


def prepare_vehicle(vehicle: Vehicle, time_step: float) -> VehicleStep:
    """The matrices of a Newmark step of `time_step` in s; the contact is rigid if its stiffness is RIGID."""
    step = _rigid(vehicle, time_step) if np.isinf(vehicle.contact_stiffness) else _hertz(vehicle, time_step)
    reached = step._replace(
        body_spans=np.concatenate(
            [
                _spans(step.compliance, step.scaled_mass, step.stiffness),
                _spans(step.by_force, step.by_position, step.by_velocity),
            ],
            axis=1,
        ),
        wheel_spans=np.concatenate([_spans(step.from_displacement, step.from_velocity), _spans(*step.impedance)], axis=1),
    )
    return VehicleStep._make(np.ascontiguousarray(array) for array in reached)


def _spans(*matrices: FloatArray) -> IntArray:
    """First and one past the last column (r, 2) in which a row of any of the matrices (r, c) has an entry; c, 0 if none."""
    used = np.any([matrix != 0.0 for matrix in matrices], axis=0)
    columns = np.arange(used.shape[1])
    first = np.where(used, columns, columns.size).min(axis=1, initial=columns.size)
    return np.stack([first, np.where(used, columns + 1, 0).max(axis=1, initial=0)], axis=1)


def _compliance(mass: FloatArray, damping: FloatArray, stiffness: FloatArray, time_step: float) -> FloatArray:
    return np.asarray(np.linalg.inv((2.0 / time_step) * ((2.0 / time_step) * mass + damping) + stiffness))


def _hertz(vehicle: Vehicle, time_step: float) -> VehicleStep:
    mass, damping, stiffness, static_load, spring = vehicle
    size, wheels = mass.shape[0], static_load.size
    compliance = _compliance(mass, damping, stiffness, time_step)
    on_wheels = np.eye(size)[:, size - wheels :]
    yielding = on_wheels.T @ compliance @ on_wheels
    force = np.linalg.solve(np.eye(wheels) + spring * yielding, spring * np.eye(wheels))
    none = np.zeros((size, wheels))
    return VehicleStep(
        compliance,
        (2.0 / time_step) * mass,
        stiffness,
        on_wheels @ static_load,
        -on_wheels,
        none,
        none,
        np.zeros(wheels),
        force @ on_wheels.T,
        none.T,
        np.stack([force, 0.0 * force, 0.0 * force]),
    )


def _rigid(vehicle: Vehicle, time_step: float) -> VehicleStep:
    wheels = vehicle.static_load.size
    bodies = vehicle.mass.shape[0] - wheels
    body, wheel = slice(bodies), slice(bodies, None)
    mass, damping, stiffness = vehicle[:3]
    compliance = _compliance(mass[body, body], damping[body, body], stiffness[body, body], time_step)
    by_position, by_velocity = -stiffness[body, wheel], -damping[body, wheel]
    from_displacement, from_velocity = -stiffness[wheel, body], -damping[wheel, body]
    readout = (from_displacement + (2.0 / time_step) * from_velocity) @ compliance
    return VehicleStep(
        compliance,
        (2.0 / time_step) * mass[body, body],
        stiffness[body, body],
        np.zeros(bodies),
        np.zeros((bodies, wheels)),
        by_position,
        by_velocity,
        vehicle.static_load,
        from_displacement,
        from_velocity,
        np.stack(
            [
                stiffness[wheel, wheel] - readout @ by_position,
                damping[wheel, wheel] - readout @ by_velocity,
                mass[wheel, wheel],
            ]
        ),
    )
