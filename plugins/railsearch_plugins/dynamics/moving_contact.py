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

from railsearch_plugins.dynamics.banded import block_widths, diagonal_ranges, mirrored, runs
from railsearch_plugins.dynamics.beam import FloatArray, IntArray
from railsearch_plugins.dynamics.kernels import factorise, integrate


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
    return Passage(*integrate(*steps, contact, track.supports, time_step, states))


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
