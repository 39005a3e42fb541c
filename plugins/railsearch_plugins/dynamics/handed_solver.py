"""Vehicles on wheels over any linear track whose equations are solved by what is handed in.

Symbols and method are those of `moving_contact`; the steps are taken here in Python, because on a track with a wide band
a step spends its time in the solution. Wheels are on Hertz springs (`vehicles`), so that y alone is needed.
"""

from typing import NamedTuple, Protocol

import numpy as np

from railsearch_plugins.dynamics import envelope
from railsearch_plugins.dynamics.beam import FloatArray, IntArray
from railsearch_plugins.dynamics.envelope import Columns, Envelope
from railsearch_plugins.dynamics.moving_contact import NONE, Contact
from railsearch_plugins.dynamics.vehicles import Vehicle, VehicleStep, at_rest, prepare_vehicle


class TrackSolver(Protocol):
    """The equations of one step, A = 4 M/dt² + 2 C/dt + K."""

    def product(self, velocity: FloatArray, displacement: FloatArray) -> FloatArray:
        """(2/dt) M v − K u (n,)."""

    def solve(self, load: FloatArray) -> FloatArray:
        """A⁻¹ f (n,)."""

    def response(self, unknowns: IntArray, row: FloatArray) -> tuple[int, FloatArray]:
        """A⁻¹ Nᵀ of a contact row (4,) at its unknowns (4,): its first row and its values from there on."""


class EnvelopeSolver(NamedTuple):
    """A track factorised in its envelope: pattern p, q (m,), (2/dt) M and −K there, factor, columns of A⁻¹."""

    rows: IntArray
    columns: IntArray
    scaled_mass: FloatArray
    minus_stiffness: FloatArray
    envelope: Envelope
    lower: FloatArray
    inverse: Columns

    def product(self, velocity: FloatArray, displacement: FloatArray) -> FloatArray:
        """(2/dt) M v − K u (n,)."""
        result = np.zeros_like(velocity)
        envelope.add_products(
            self.rows, self.columns, self.scaled_mass, self.minus_stiffness, velocity, displacement, result
        )
        return result

    def solve(self, load: FloatArray) -> FloatArray:
        """A⁻¹ f (n,)."""
        result = load.copy()
        envelope.solve(*self.envelope, self.lower, result)
        return result

    def response(self, unknowns: IntArray, row: FloatArray) -> tuple[int, FloatArray]:
        """A⁻¹ Nᵀ, from the columns that have been cut off."""
        places = self.inverse.place[unknowns]
        firsts, starts = self.inverse.first[places], self.inverse.offset[places]
        stops = firsts + self.inverse.offset[places + 1] - starts
        begin = int(firsts.min())
        total = np.zeros(int(stops.max()) - begin)
        for weight, first, stop, start in zip(row, firsts, stops, starts, strict=True):
            total[first - begin : stop - begin] += weight * self.inverse.values[start : start + stop - first]
        return begin, total


class PairObservation(NamedTuple):
    """What is to be recorded: ∫ (v_a − v_b)² dt of pairs (s, 2), b of −1 being ground; track states at `steps` (k,)."""

    pairs: IntArray
    steps: IntArray = NONE


class AnyPassage(NamedTuple):
    """Histories as in `moving_contact.Passage`, and track states (k, n) at the steps asked for."""

    force: FloatArray
    motion: FloatArray
    vehicle_displacement: FloatArray
    vehicle_velocity: FloatArray
    support_integrals: FloatArray
    track_displacement: FloatArray
    track_velocity: FloatArray


def pass_over(
    solver: TrackSolver,
    vehicle: Vehicle,
    contact: Contact,
    time_step: float,
    start: FloatArray,
    observation: PairObservation,
) -> AnyPassage:
    """Simulate a passage from static equilibrium, in which the track has the displacement `start` (n,) in m.

    time_step: dt in s. Raises ValueError for a rigid contact.
    """
    if np.isinf(vehicle.contact_stiffness):
        raise ValueError("a Hertz contact is needed: the accelerations of the rail are not computed here")
    train, (count, wheels), rate = prepare_vehicle(vehicle, time_step), contact.unknowns.shape[:2], 4.0 / time_step
    force, motion = np.empty((count, wheels)), np.empty((count, wheels, 1))
    z, zv = np.empty((count, vehicle.mass.shape[0])), np.zeros((count, vehicle.mass.shape[0]))
    u, v = start.copy(), np.zeros_like(start)
    force[0], motion[0] = vehicle.static_load, _on_rail(contact, 0, u)[:, None]
    z[0] = at_rest(vehicle, motion[0, :, 0] + force[0] / vehicle.contact_stiffness)
    integrals, wanted = np.zeros(observation.pairs.shape[0]), set(observation.steps.tolist())
    states = {0: (u, v)}
    for n in range(1, count):
        load, predicted = solver.product(v, u), _extrapolated(force, n)
        _add_forces(load, contact, n - 1, 0.5 * force[n - 1])
        _add_forces(load, contact, n, 0.5 * predicted)
        w = solver.solve(load)
        half = train.compliance @ (
            train.load + train.scaled_mass @ zv[n - 1] - train.stiffness @ z[n - 1] + 0.5 * train.by_force @ force[n - 1]
        )
        responses = [solver.response(contact.unknowns[n, i], contact.rows[n, i, 0]) for i in range(wheels)]
        receptance = _receptance(contact, n, responses, u.size)
        motion[n, :, 0] = _on_rail(contact, n, u + 2.0 * w)
        change = _changes(train, train.from_displacement @ (z[n - 1] + 2.0 * half), motion[n, :, 0], predicted, receptance)
        force[n] = predicted + change
        motion[n, :, 0] += receptance @ change
        for (first, values), missing in zip(responses, change, strict=True):
            w[first : first + values.size] += 0.5 * missing * values
        half += 0.5 * train.compliance @ (train.by_force @ force[n])
        z[n], zv[n] = z[n - 1] + 2.0 * half, rate * half - zv[n - 1]
        u, v = u + 2.0 * w, rate * w - v
        integrals += (0.5 if n == count - 1 else 1.0) * time_step * _relative(v, observation.pairs) ** 2
        if n in wanted:
            states[n] = u, v
    kept = [states[int(n)] for n in observation.steps]
    shape = (len(kept), u.size)
    displacement, velocity = (np.array([state[kind] for state in kept]).reshape(shape) for kind in range(2))
    return AnyPassage(force, motion, z, zv, integrals, displacement, velocity)


def _on_rail(contact: Contact, n: int, u: FloatArray) -> FloatArray:
    """y (w,) at step n."""
    return np.asarray((contact.rows[n, :, 0] * u[contact.unknowns[n]]).sum(axis=1) + contact.irregularity[n, :, 0])


def _add_forces(load: FloatArray, contact: Contact, n: int, forces: FloatArray) -> None:
    np.add.at(load, contact.unknowns[n], forces[:, None] * contact.rows[n, :, 0])


def _extrapolated(force: FloatArray, n: int) -> FloatArray:
    """The parabola through the last three forces, at step n; the last force if there are fewer."""
    return np.asarray(force[n - 1] if n < 3 else 3.0 * (force[n - 1] - force[n - 2]) + force[n - 3])


def _receptance(contact: Contact, n: int, responses: list[tuple[int, FloatArray]], size: int) -> FloatArray:
    """N A⁻¹ Nᵀ (w, w) at step n."""
    columns = np.zeros((size, len(responses))) if len(responses) > 1 else None
    if columns is None:
        first, values = responses[0]
        places = contact.unknowns[n, 0] - first
        inside = (places >= 0) & (places < values.size)
        return np.array([[contact.rows[n, 0, 0, inside] @ values[places[inside]]]])
    for j, (first, values) in enumerate(responses):
        columns[first : first + values.size, j] = values
    return np.asarray(np.einsum("wk,wkj->wj", contact.rows[n, :, 0], columns[contact.unknowns[n]]))


def _changes(
    train: VehicleStep, free: FloatArray, motion: FloatArray, predicted: FloatArray, receptance: FloatArray
) -> FloatArray:
    """ΔF (w,) of (1 + Z G) ΔF = F⁰ − Z y − F."""
    impedance = train.impedance[0]
    missing = train.base_force + free - impedance @ motion - predicted
    return np.asarray(np.linalg.solve(np.eye(motion.size) + impedance @ receptance, missing))


def _relative(v: FloatArray, pairs: IntArray) -> FloatArray:
    """v_a − v_b (s,)."""
    return np.asarray(v[pairs[:, 0]] - np.where(pairs[:, 1] >= 0, v[pairs[:, 1]], 0.0))
