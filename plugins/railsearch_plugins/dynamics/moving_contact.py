"""Vehicles on wheels over a linear track: Newmark's method with one factorisation and a small dense contact system.

symbol    meaning                                                        shape        unit      source
M, C, K   track matrices by lower diagonals                              (b + 1, n)   kg, …
u, v, a   track displacement (down), velocity and acceleration           (n,)         m, …
N         contact rows: rail displacement under a wheel = N u            (w, 4)       -, m
r         irregularity, positive downward                                (w,)         m
d         orders of time derivatives that the contact needs: 1 with a    scalar       -
          Hertz spring (y), 3 if the wheel follows the rail (y, ẏ, ÿ)
F         wheel-rail forces (compression positive)                       (w,)         N
A         4 M/dt² + 2 C/dt + K = L D Lᵀ                                  (b + 1, n)   N/m       Newmark (1959)
h         half the increment of displacement in a step                   (n,)         m
G         receptances: y, ẏ, ÿ at the end of a step by F there           (3, w, w)    m/N, …

With β = 1/4 and γ = 1/2 two successive equations of motion, averaged, give A h = (f_n + f_{n+1})/2 + g_n, f = Nᵀ F and
g = (2/dt) M v − K u, u_{n+1} = u_n + 2 h, v_{n+1} = 4 h/dt − v_n; `newmark` says how g is carried on. It is Newmark's method
itself; a_{n+1} = (2/dt)(v_{n+1} − v_n) − a_n is computed where needed. N moves with the wheel, and so a rigid contact has

    y = N u + r,   ẏ = N v + Ṅ u + ṙ,   ÿ = N a + 2 Ṅ v + N̈ u + r̈,   Ṅ = dN/dt = (speed) N′.

A step is first taken with extrapolated forces. With its y, ẏ, ÿ the vehicles (`vehicles`) leave F⁰ − Z y − F to be made up;
(1 + Z G) ΔF is that, and h + ½ A⁻¹ Nᵀ ΔF is the solution. Columns of A⁻¹ decay: they are kept as far as they matter.
"""

from typing import NamedTuple

import numpy as np

from railsearch_plugins.dynamics.banded import block_widths, mirrored, runs
from railsearch_plugins.dynamics.beam import FloatArray, IntArray, find, hermite
from railsearch_plugins.dynamics.kernels import backward, factorise, forward, integrate, inverse_columns
from railsearch_plugins.dynamics.newmark import Recursion, recursion
from railsearch_plugins.dynamics.vehicles import Vehicle, at_rest, prepare_vehicle

NONE = np.empty(0, dtype=np.int64)
NEVER = np.iinfo(np.int64).max
# Where columns of A⁻¹ are cut off, as the force that would hold what is left out relative to the largest one. They carry the
# error of an extrapolated force, 1e-3 of it and less: metrics change by 3e-10 and less.
NEGLIGIBLE = 1e-9


class Track(NamedTuple):
    """Track matrices by lower diagonals (b + 1, n); Rayleigh's factors by unknown (2, n), see `newmark`: they save time."""

    mass: FloatArray
    damping: FloatArray
    stiffness: FloatArray
    rayleigh: FloatArray | None = None


class Contact(NamedTuple):
    """Per time step and wheel: unknowns (t, w, 4) under it, N and its time derivatives (t, w, d, 4), r alike (t, w, d).

    A held unknown is replaced by another one of its element, with zeros in its rows.
    """

    unknowns: IntArray
    rows: FloatArray
    irregularity: FloatArray


class Observation(NamedTuple):
    """What is to be recorded: ∫ v² dt of `supports` (s,), u of `points` (h,), envelopes from step `extremes_from` on.

    kept: ascending steps (k,) at which u and v of the whole track are kept.
    """

    supports: IntArray = NONE
    points: IntArray = NONE
    extremes_from: int = NEVER
    kept: IntArray = NONE


class Passage(NamedTuple):
    """Histories of a passage.

    force (t, w), motion y, ẏ, ÿ (t, w, d) of the rail with its irregularity under the wheels, vehicle states (t, q),
    ∫ v² dt (s,), u of the points (t, h), envelopes of u (largest, smallest) and |a| (n,), track states (k, n) kept.
    """

    force: FloatArray
    motion: FloatArray
    vehicle_displacement: FloatArray
    vehicle_velocity: FloatArray
    support_integrals: FloatArray
    point_displacement: FloatArray
    highest: FloatArray
    lowest: FloatArray
    largest_acceleration: FloatArray
    track_displacement: FloatArray
    track_velocity: FloatArray


class Columns(NamedTuple):
    """Columns of A⁻¹ that have been cut off; see `kernels.inverse_columns`."""

    place: IntArray
    first: IntArray
    offset: IntArray
    values: FloatArray


class TrackStep(NamedTuple):
    """What a step needs of the track: factors of A, their runs, what carries g on, columns."""

    lower: FloatArray
    upper: FloatArray
    lower_runs: IntArray
    upper_runs: IntArray
    recursion: Recursion
    columns: Columns


class Start(NamedTuple):
    """Static equilibrium: track (n,), g = −K u (n,), integrated vehicle unknowns (q,), y (w,), F (w,)."""

    track: FloatArray
    known: FloatArray
    train: FloatArray
    wheel: FloatArray
    force: FloatArray


def make_contact(
    nodes: FloatArray, rail: IntArray, positions: FloatArray, irregularity: FloatArray, speed: float = 0.0
) -> Contact:
    """Contact of wheels at `positions` (t, w) in m on a rail with `nodes` (m + 1,) in m and unknowns `rail` (m + 1, 2).

    irregularity: r (t, w, d) with its time derivatives; d of 3 needs the `speed` in m/s.
    """
    element, offset, length = find(nodes, positions.ravel())
    orders = irregularity.shape[2]
    rows = np.empty((element.size, orders, 4))
    for order in range(orders):
        rows[:, order] = speed**order * hermite(offset, length, order)
    unknowns = np.concatenate([rail[:-1], rail[1:]], axis=1)[element]
    held = np.flatnonzero((unknowns < 0).any(axis=1))
    rows[held] *= (unknowns[held] >= 0)[:, None, :]
    unknowns[held] = np.where(unknowns[held] < 0, unknowns[held].max(axis=1, keepdims=True), unknowns[held])
    return Contact(
        unknowns.reshape(*positions.shape, 4),
        rows.reshape(*positions.shape, orders, 4),
        irregularity,
    )


def pass_over(
    track: Track,
    vehicle: Vehicle,
    contact: Contact,
    time_step: float,
    observation: Observation = Observation(),  # noqa: B008 - immutable
) -> Passage:
    """Simulate a passage that starts from static equilibrium with all wheels at their first positions.

    time_step: dt in s.
    The supports' ∫ v² dt is taken by the trapezoidal rule over all steps, the first state included.
    A track that is not stable, or a solution that diverges, gives histories that are not finite.
    """
    step = _prepare_track(track, contact, time_step)
    start = _static_equilibrium(track, vehicle, contact)
    return Passage(*integrate(step, prepare_vehicle(vehicle, time_step), contact, observation, start, time_step))


def static_displacement(stiffness: FloatArray, load: FloatArray) -> FloatArray:
    """u (n,) in m of K u = f for K by lower diagonals (b + 1, n) and a load f (n,)."""
    lower, displacement = factorise(stiffness), load.copy()
    upper = mirrored(lower)
    forward(lower, runs(lower), displacement)
    backward(upper, runs(upper), displacement)
    return displacement


def _static_equilibrium(track: Track, vehicle: Vehicle, contact: Contact) -> Start:
    """Vehicles that are statically determinate stand on the track with their static loads, whatever its stiffness."""
    unknowns, rows, load = contact.unknowns[0], contact.rows[0, :, 0], np.zeros(track.mass.shape[1])
    np.add.at(load, unknowns, vehicle.static_load[:, None] * rows)
    displacement = static_displacement(track.stiffness, load) if load.any() else load
    on_rail = np.einsum("wk,wk->w", rows, displacement[unknowns]) + contact.irregularity[0, :, 0]
    resting = at_rest(vehicle, on_rail + vehicle.static_load / vehicle.contact_stiffness)
    integrated = resting.size - (on_rail.size if np.isinf(vehicle.contact_stiffness) else 0)
    return Start(displacement, -load, resting[:integrated], on_rail, vehicle.static_load)


def _prepare_track(track: Track, contact: Contact, time_step: float) -> TrackStep:
    newmark = (2.0 / time_step) * ((2.0 / time_step) * track.mass + track.damping) + track.stiffness
    lower = factorise(newmark)
    upper = mirrored(lower)
    columns = Columns(*inverse_columns(lower, block_widths(lower), _touched(contact), NEGLIGIBLE))
    # A stiffness beyond all numbers is found in the histories.
    with np.errstate(invalid="ignore", over="ignore"):
        carried = recursion(track.mass, track.damping, newmark, track.rayleigh, time_step)
    return TrackStep(lower, upper, runs(lower), runs(upper), carried, columns)


def _touched(contact: Contact) -> IntArray:
    """The unknowns that a wheel touches at some step, ascending."""
    touched = np.zeros(int(contact.unknowns.max()) + 1, dtype=bool)
    touched[contact.unknowns] = True
    return np.flatnonzero(touched)
