"""A vehicle on one wheel over a linear track: Newmark's method with one factorisation and the contact as a rank-one term.

symbol   meaning                                                       shape        unit      source
M, C, K  track matrices by lower diagonals                             (b + 1, n)   kg, …
u, v     track displacement (down) and velocity                        (n,)         m, m/s
z        vehicle displacement (down) from its position at rest under   (p,)         m
         its own weight on an unloaded, level rail
N        contact row: rail displacement under the wheel = N u          (4,)         -, m
r        irregularity, positive downward                               scalar       m
P, F     static wheel load, wheel-rail force (compression positive)    scalar       N
k_w      contact stiffness                                             scalar       N/m
A        4 M/dt² + 2 C/dt + K = L D Lᵀ, A_v alike for the vehicle      (b + 1, n)   N/m       Newmark (1959)
w        half the increment of displacement in a step                  (n,)         m

With β = 1/4 and γ = 1/2 two successive equations of motion, averaged, give A w = (f_n + f_{n+1})/2 + (2/dt) M v_n − K u_n,
u_{n+1} = u_n + 2 w, v_{n+1} = 4 w/dt − v_n, where f = Nᵀ F. It is Newmark's method itself, with no acceleration to store.
With y = L⁻¹(…) without F_{n+1} and q = L⁻¹ Nᵀ at the new position (q decays away from the contact),

    N u_{n+1} = N u_n + 2 qᵀD⁻¹y + F_{n+1} qᵀD⁻¹q,      z_{n+1} = z⁰ − h F_{n+1},  h = e_wᵀ A_v⁻¹ e_w,
    F_{n+1} = k_w (z⁰_w − N u_n − 2 qᵀD⁻¹y − r) / (1 + k_w (h + qᵀD⁻¹q)).
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from railsearch_plugins.dynamics.banded import (
    BLOCK,
    add_products,
    backward,
    block_widths,
    diagonal_ranges,
    factorise,
    forward,
    forward_block,
    mirrored,
    runs,
)
from railsearch_plugins.dynamics.beam import FloatArray, IntArray

# Entries of q this much smaller than its largest cannot change a sum in double precision.
NEGLIGIBLE = 1e-20


class Track(NamedTuple):
    """Track matrices by lower diagonals (b + 1, n), and the supports (s,) whose ∫ v² dt is wanted."""

    mass: FloatArray
    damping: FloatArray
    stiffness: FloatArray
    supports: IntArray


class Vehicle(NamedTuple):
    """Vehicle matrices (p, p), the last unknown being the wheel, its static load in N and contact stiffness in N/m."""

    mass: FloatArray
    damping: FloatArray
    stiffness: FloatArray
    static_load: float
    contact_stiffness: float


class Contact(NamedTuple):
    """Per time step: unknowns (t, 4) under the wheel (−1: held), contact row (t, 4) and irregularity (t,) down in m."""

    unknowns: IntArray
    rows: FloatArray
    irregularity: FloatArray


class Passage(NamedTuple):
    """Histories (t,) of force, rail and wheel displacement; vehicle states (t, p); ∫ v² dt (s,); track states, or none."""

    force: FloatArray
    rail: FloatArray
    wheel: FloatArray
    vehicle_displacement: FloatArray
    vehicle_velocity: FloatArray
    support_integrals: FloatArray
    track_displacement: FloatArray
    track_velocity: FloatArray


class TrackStep(NamedTuple):
    """What a step needs of the track: factors of A, their runs, (2/dt) M, −K and the ranges of their diagonals."""

    lower: FloatArray
    upper: FloatArray
    block_widths: IntArray
    lower_runs: IntArray
    upper_runs: IntArray
    scaled_mass: FloatArray
    minus_stiffness: FloatArray
    starts: IntArray
    stops: IntArray


class VehicleStep(NamedTuple):
    """What a step needs of the vehicle: A_v⁻¹, (2/dt) M_v, K_v (p, p), static load and contact stiffness."""

    compliance: FloatArray
    scaled_mass: FloatArray
    stiffness: FloatArray
    static_load: float
    contact_stiffness: float


def pass_over(track: Track, vehicle: Vehicle, contact: Contact, time_step: float, states: bool = False) -> Passage:
    """Simulate a passage that starts from rest, the wheel standing on a point of the track that cannot move.

    time_step: dt in s; states: keep u and v of the whole track at every step, (t, n) each.
    The supports' ∫ v² dt is taken by the trapezoidal rule over all steps, the first state included.
    A track that is not stable, or a solution that diverges, gives histories that are not finite.
    """
    steps = _prepare_track(track, time_step), _prepare_vehicle(vehicle, time_step)
    return Passage(*_integrate(*steps, contact, track.supports, time_step, states))


def _prepare_track(track: Track, time_step: float) -> TrackStep:
    scaled_mass = (2.0 / time_step) * track.mass
    newmark = (2.0 / time_step) * (scaled_mass + track.damping) + track.stiffness
    lower = factorise(newmark)
    upper = mirrored(lower)
    return TrackStep(
        lower,
        upper,
        block_widths(lower),
        runs(lower),
        runs(upper),
        scaled_mass,
        -track.stiffness,
        *diagonal_ranges(newmark),
    )


def _prepare_vehicle(vehicle: Vehicle, time_step: float) -> VehicleStep:
    scaled_mass = (2.0 / time_step) * vehicle.mass
    compliance = np.linalg.inv((2.0 / time_step) * (scaled_mass + vehicle.damping) + vehicle.stiffness)
    return VehicleStep(
        np.asarray(compliance), scaled_mass, vehicle.stiffness, vehicle.static_load, vehicle.contact_stiffness
    )


@njit(cache=True, fastmath={"contract"})
def _contact_column(lower, widths, unknowns, row, q):  # type: ignore[no-untyped-def]
    """q = L⁻¹ Nᵀ from the first block that the contact touches to where it has decayed; returns that range."""
    first, last = q.size, 0
    for k in range(unknowns.size):
        if unknowns[k] >= 0:
            first, last = min(first, unknowns[k]), max(last, unknowns[k])
    start = first // BLOCK * BLOCK
    stop, largest = start, 0.0
    q[max(0, start - lower.shape[0]) : start] = 0.0
    while stop < q.size:
        begin, stop = stop, min(stop + BLOCK, q.size)
        q[begin:stop] = 0.0
        for k in range(unknowns.size):
            if begin <= unknowns[k] < stop:
                q[unknowns[k]] = row[k]
        forward_block(lower, widths[begin // BLOCK], begin, stop, q)
        size = np.max(np.abs(q[begin:stop]))
        largest = max(largest, size)
        if begin > last and size <= NEGLIGIBLE * largest:
            break
    return start, stop


@njit(cache=True, fastmath={"contract"})
def _seen(unknowns, row, u):  # type: ignore[no-untyped-def]
    """N u: rail displacement under the wheel."""
    total = 0.0
    for k in range(unknowns.size):
        if unknowns[k] >= 0:
            total += row[k] * u[unknowns[k]]
    return total


@njit(cache=True, fastmath={"contract"})
def _known_load(track, u, v, unknowns, row, force, y):  # type: ignore[no-untyped-def]
    """y = (2/dt) M v_n − K u_n + f_n/2."""
    y[:] = 0.0
    add_products(track.scaled_mass, track.minus_stiffness, track.starts, track.stops, v, u, y)
    for k in range(unknowns.size):
        if unknowns[k] >= 0:
            y[unknowns[k]] += 0.5 * force * row[k]


@njit(cache=True, fastmath={"contract"})
def _vehicle_without_force(vehicle, z, zv, force, half):  # type: ignore[no-untyped-def]
    """half = A_v⁻¹ ((2/dt) M_v ż_n − K_v z_n + e_w (P − F_n/2)): half the increment with F_{n+1} = 0."""
    parts = half.size
    half[:] = 0.0
    for i in range(parts):
        load = vehicle.static_load - 0.5 * force if i == parts - 1 else 0.0
        for j in range(parts):
            load += vehicle.scaled_mass[i, j] * zv[j] - vehicle.stiffness[i, j] * z[j]
        for j in range(parts):
            half[j] += vehicle.compliance[j, i] * load


@njit(cache=True, fastmath={"contract"})
def _vehicle_with_force(vehicle, force, rate, half, z, zv, new_z, new_zv):  # type: ignore[no-untyped-def]
    """Add −A_v⁻¹ e_w F_{n+1}/2 to half the increment, and advance as the track."""
    for j in range(half.size):
        w = half[j] - 0.5 * force * vehicle.compliance[j, -1]
        new_z[j] = z[j] + 2.0 * w
        new_zv[j] = rate * w - zv[j]


@njit(cache=True, fastmath={"contract"})
def _advance(w, rate, u, v):  # type: ignore[no-untyped-def]
    """u += 2 w and v = 4 w/dt − v, with rate = 4/dt."""
    for i in range(w.size):
        u[i] += 2.0 * w[i]
        v[i] = rate * w[i] - v[i]


@njit(cache=True, fastmath={"contract"})
def _add_squares(share, v, supports, integrals):  # type: ignore[no-untyped-def]
    """One term of the trapezoidal rule for ∫ v² dt."""
    for s in range(supports.size):
        integrals[s] += share * v[supports[s]] ** 2


@njit(cache=True, fastmath={"contract"})
def _contact_force(lower, q, y, start, stop, gap, wheel_compliance, stiffness):  # type: ignore[no-untyped-def]
    """F_{n+1} from the contact column; `gap` = z⁰_w − N u_n − r is what would be compressed without any force."""
    approach, yielding = 0.0, 0.0
    for i in range(start, stop):
        weighted = q[i] * lower[0, i]
        approach += weighted * y[i]
        yielding += weighted * q[i]
    return stiffness * (gap - 2.0 * approach) / (1.0 + stiffness * (wheel_compliance + yielding))


@njit(cache=True, fastmath={"contract"})
def _integrate(track, vehicle, contact, supports, time_step, states):  # type: ignore[no-untyped-def]
    """All steps of a passage; returns the fields of `Passage`."""
    steps, size, parts = contact.irregularity.size, track.lower.shape[1], vehicle.compliance.shape[0]
    unknowns, rows, rate = contact.unknowns, contact.rows, 4.0 / time_step
    force, rail = np.empty(steps), np.zeros(steps)
    z, zv, half = np.empty((steps, parts)), np.zeros((steps, parts)), np.empty(parts)
    u, v, y, q = np.zeros(size), np.zeros(size), np.empty(size), np.zeros(size)
    integrals = np.zeros(supports.size)
    all_u, all_v = np.zeros((steps if states else 0, size)), np.zeros((steps if states else 0, size))
    force[0] = vehicle.static_load
    z[0] = vehicle.static_load / vehicle.contact_stiffness + contact.irregularity[0]
    for n in range(1, steps):
        _known_load(track, u, v, unknowns[n - 1], rows[n - 1], force[n - 1], y)
        forward(track.lower, track.lower_runs, y)
        start, stop = _contact_column(track.lower, track.block_widths, unknowns[n], rows[n], q)
        _vehicle_without_force(vehicle, z[n - 1], zv[n - 1], force[n - 1], half)
        gap = z[n - 1, -1] + 2.0 * half[-1] - _seen(unknowns[n], rows[n], u) - contact.irregularity[n]
        force[n] = _contact_force(track.lower, q, y, start, stop, gap, vehicle.compliance[-1, -1], vehicle.contact_stiffness)
        _vehicle_with_force(vehicle, force[n], rate, half, z[n - 1], zv[n - 1], z[n], zv[n])
        for i in range(start, stop):
            y[i] += 0.5 * force[n] * q[i]
        backward(track.upper, track.upper_runs, y)
        _advance(y, rate, u, v)
        rail[n] = _seen(unknowns[n], rows[n], u)
        _add_squares(0.5 * time_step if n == steps - 1 else time_step, v, supports, integrals)
        if states:
            all_u[n], all_v[n] = u, v
    return force, rail, z[:, -1].copy(), z, zv, integrals, all_u, all_v
