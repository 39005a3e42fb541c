"""A slow, plain twin of the train-track-bridge model: one coupled system, made and solved with scipy.sparse at every step.

Upward positive. The wheel follows the rail, y = N q + r, so its inertia, the primary suspension and the convective terms
go into the coupled matrices. It shares nothing with the fast model but the parameters: its own layout, numbering (rail,
sleepers, ballast, bridge, vehicles), closed-form element matrices and Newmark's method with accelerations.
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse
from scipy.sparse.linalg import splu

ORDERING, SYMMETRIC = "MMD_AT_PLUS_A", {"SymmetricMode": True, "DiagPivotThresh": 0.1}


class Triplets:
    """Collects dense blocks into a sparse matrix; −1 is held."""

    def __init__(self):
        self.rows, self.columns, self.values = [], [], []

    def add(self, rows, block, columns=None):
        rows, columns = np.asarray(rows), np.asarray(rows if columns is None else columns)
        r, c = np.repeat(rows, columns.size), np.tile(columns, rows.size)
        free = (r >= 0) & (c >= 0)
        self.rows.append(r[free])
        self.columns.append(c[free])
        self.values.append(np.ravel(block)[free])

    def matrix(self, size):
        if not self.values:
            return scipy.sparse.csc_array((size, size))
        triplets = np.concatenate(self.values), (np.concatenate(self.rows), np.concatenate(self.columns))
        return scipy.sparse.csc_array(scipy.sparse.coo_array(triplets, shape=(size, size)))


@dataclass(frozen=True)
class Model:
    """Uncoupled matrices and where things are: nodes (k,), sleepers (s,), bridge nodes (b, 2) and their positions."""

    mass: object
    damping: object
    stiffness: object
    nodes: np.ndarray
    sleepers: np.ndarray
    first_sleeper: int
    bridge: np.ndarray
    bridge_nodes: np.ndarray
    first_vehicle: int
    axles: np.ndarray
    time_step: float
    front: np.ndarray


@dataclass(frozen=True)
class Run:
    """Histories, upward positive: force (t, w), rail and bridge envelopes, sleeper accelerations, carbody and midspan."""

    position: np.ndarray
    force: np.ndarray
    carbody_acceleration: np.ndarray
    rail_lowest: np.ndarray
    bridge_lowest: np.ndarray
    bridge_acceleration: np.ndarray
    sleeper_acceleration: np.ndarray
    deck: np.ndarray
    displacement: np.ndarray
    velocity: np.ndarray


def beam(length, bending, mass):
    """Stiffness and consistent mass of a beam element."""
    l, l2 = length, length**2  # noqa: E741
    k = [
        [12, 6 * l, -12, 6 * l],
        [6 * l, 4 * l2, -6 * l, 2 * l2],
        [-12, -6 * l, 12, -6 * l],
        [6 * l, 2 * l2, -6 * l, 4 * l2],
    ]
    m = [
        [156, 22 * l, 54, -13 * l],
        [22 * l, 4 * l2, 13 * l, -3 * l2],
        [54, 13 * l, 156, -22 * l],
        [-13 * l, -3 * l2, -22 * l, 4 * l2],
    ]
    return bending / l**3 * np.array(k), mass * l / 420 * np.array(m)


def rayleigh(frequency_1, frequency_2, ratio):
    """a and b of C = a M + b K with the ratio at both frequencies (Hz)."""
    w = 2 * np.pi * np.array([frequency_1, frequency_2])
    return np.linalg.solve(np.stack([0.5 / w, 0.5 * w], axis=1), [ratio, ratio])


def build(p, ballast_mass, ballast_stiffness):
    """Lay out the model and assemble what does not move."""
    v, h = p.vehicle, p.sleeper_spacing / p.elements_per_spacing
    offsets = [s * v.bogie_distance + t * v.axle_distance for s in (1, -1) for t in (1, -1)]
    axles = np.concatenate([offsets[0] - np.array(offsets) + n * v.pitch for n in range(p.vehicles)])
    spans = round(p.bridge_length / h)
    span = spans * h
    start, end = p.start_position, p.end_position
    duration = (end - start) / p.speed
    steps = int(np.ceil(duration / p.time_step - 1e-6))
    first = int(np.floor((start - axles[-1]) / p.sleeper_spacing - p.margin_sleepers + 1e-6))
    last = int(np.ceil(end / p.sleeper_spacing + p.margin_sleepers - 1e-6))
    sleepers = p.sleeper_spacing * np.arange(first, last + 1)
    nodes = first * p.sleeper_spacing + h * np.arange((last - first) * p.elements_per_spacing + 1)
    M, C, K = Triplets(), Triplets(), Triplets()

    rail_k, rail_m = beam(h, p.rail.bending_stiffness, p.rail.mass_per_length)
    deck_k, deck_m = beam(h, p.bridge_modulus * p.bridge_inertia, p.bridge_mass)
    f = np.array([1, 4]) * np.pi / (2 * span**2) * np.sqrt(p.bridge_modulus * p.bridge_inertia / p.bridge_mass)
    rail_ab, deck_ab = rayleigh(*f, p.rail.damping), rayleigh(*f, p.bridge_damping)
    for e in range(nodes.size - 1):
        u = 2 * e + np.arange(4)
        M.add(u, rail_m)
        K.add(u, rail_k)
        C.add(u, rail_ab[0] * rail_m + rail_ab[1] * rail_k)
    size = 2 * nodes.size
    first_sleeper = size
    size += sleepers.size
    on = (sleepers > -1e-6) & (sleepers < span + 1e-6)
    ballast = np.full(sleepers.size, -1)
    ballast[~on] = size + np.arange((~on).sum())
    size += (~on).sum()
    bridge = np.full((spans + 1, 2), -1)
    for i in range(spans + 1):
        for j in range(2):
            if j == 1 or 0 < i < spans:
                bridge[i, j] = size
                size += 1
    for i in range(spans):
        u = bridge[i : i + 2].ravel()
        M.add(u, deck_m)
        K.add(u, deck_k)
        C.add(u, deck_ab[0] * deck_m + deck_ab[1] * deck_k)
    pair = np.array([[1, -1], [-1, 1]])
    for i, x in enumerate(sleepers):
        s, r = first_sleeper + i, 2 * i * p.elements_per_spacing
        below = bridge[round(x / h), 0] if on[i] else ballast[i]
        M.add([s], [p.sleeper_mass])
        K.add([r, s], p.pad_stiffness * pair)
        C.add([r, s], p.pad_damping * pair)
        M.add([below], [ballast_mass])
        K.add([s, below], ballast_stiffness * pair)
        C.add([s, below], p.ballast_damping * pair)
        if not on[i]:
            K.add([below], [p.subballast_stiffness])
            C.add([below], [p.subballast_damping])
            if i + 1 < sleepers.size and not on[i + 1]:
                K.add([below, ballast[i + 1]], p.ballast_shear_stiffness * pair)
                C.add([below, ballast[i + 1]], p.ballast_shear_damping * pair)
    first_vehicle = size
    for n in range(p.vehicles):
        zc, tc, z1, t1, z2, t2 = size + 6 * n + np.arange(6)
        M.add([zc], [p.carbody_mass_factor * v.carbody_mass])
        M.add([tc], [v.carbody_inertia])
        for sign, z, t in ((1, z1, t1), (-1, z2, t2)):
            M.add([z], [v.bogie_mass])
            M.add([t], [v.bogie_inertia])
            row = np.array([1.0, sign * v.bogie_distance, -1.0])
            K.add([zc, tc, z], p.secondary_stiffness_factor * v.secondary_stiffness * np.outer(row, row))
            C.add([zc, tc, z], v.secondary_damping * np.outer(row, row))
    size += 6 * p.vehicles
    return Model(
        M.matrix(size), C.matrix(size), K.matrix(size), nodes, sleepers, first_sleeper, bridge, h * np.arange(spans + 1),
        first_vehicle, axles, duration / steps, start + (end - start) * np.arange(steps + 1) / steps,
    )  # fmt: skip


def contact_rows(nodes, x):
    """Rail unknowns, N, N′ and N″ at x."""
    l = nodes[1] - nodes[0]  # noqa: E741
    e = min(int((x - nodes[0]) / l + 1e-9), nodes.size - 2)
    s = (x - nodes[e]) / l
    n = [1 - 3 * s**2 + 2 * s**3, l * (s - 2 * s**2 + s**3), 3 * s**2 - 2 * s**3, l * (s**3 - s**2)]
    d = np.array([-6 * s + 6 * s**2, l * (1 - 4 * s + 3 * s**2), 6 * s - 6 * s**2, l * (3 * s**2 - 2 * s)]) / l
    c = np.array([-6 + 12 * s, l * (6 * s - 4), 6 - 12 * s, l * (6 * s - 2)]) / l**2
    return 2 * e + np.arange(4), np.array(n), d, c


def wheels(p, model, front):
    """Per wheel: rail unknowns, rows, unknowns (z_b, θ_b) of its bogie and the row that gives the bogie above the wheel."""
    for w, offset in enumerate(model.axles):
        vehicle, axle = divmod(w, 4)
        bogie = model.first_vehicle + 6 * vehicle + 2 + 2 * (axle // 2)
        arm = p.vehicle.axle_distance * (1 - 2 * (axle % 2))
        yield (*contact_rows(model.nodes, front - offset), np.array([bogie, bogie + 1]), np.array([1.0, arm]))


def coupled(p, model, front, r, dr, ddr):
    """Matrices and load of wheels, primary suspension and convection; r, dr, ddr (w,) of the wheels in time."""
    v, speed = p.vehicle, p.speed
    k1, c1, m = p.primary_stiffness_factor * v.primary_stiffness, v.primary_damping, v.wheelset_mass
    weight = v.gravity * (p.carbody_mass_factor * v.carbody_mass + 2 * v.bogie_mass + 4 * m) / 4
    M, C, K = Triplets(), Triplets(), Triplets()
    size = model.mass.shape[0]
    load = np.zeros(size)
    for w, (rail, n, d, c, bogie, arm) in enumerate(wheels(p, model, front)):
        M.add(rail, m * np.outer(n, n))
        C.add(rail, np.outer(n, c1 * n + 2 * m * speed * d))
        K.add(rail, np.outer(n, k1 * n + c1 * speed * d + m * speed**2 * c))
        C.add(rail, -c1 * np.outer(n, arm), bogie)
        K.add(rail, -k1 * np.outer(n, arm), bogie)
        C.add(bogie, -c1 * np.outer(arm, n), rail)
        K.add(bogie, -np.outer(arm, k1 * n + c1 * speed * d), rail)
        C.add(bogie, c1 * np.outer(arm, arm))
        K.add(bogie, k1 * np.outer(arm, arm))
        load[rail] -= n * (weight + m * ddr[w] + c1 * dr[w] + k1 * r[w])
        load[bogie] += arm * (c1 * dr[w] + k1 * r[w])
    return M.matrix(size), C.matrix(size), K.matrix(size), load


def contact_force(p, model, front, u, v, a, r, dr, ddr):
    """Compression (w,) under the wheels, with the wheel's own inertia."""
    k1, c1, m = p.primary_stiffness_factor * p.vehicle.primary_stiffness, p.vehicle.primary_damping, p.vehicle.wheelset_mass
    weight = p.vehicle.gravity * (p.carbody_mass_factor * p.vehicle.carbody_mass + 2 * p.vehicle.bogie_mass + 4 * m) / 4
    force = np.empty(model.axles.size)
    for w, (rail, n, d, c, bogie, arm) in enumerate(wheels(p, model, front)):
        y, dy = n @ u[rail] + r[w], n @ v[rail] + p.speed * d @ u[rail] + dr[w]
        ddy = n @ a[rail] + 2 * p.speed * d @ v[rail] + p.speed**2 * c @ u[rail] + ddr[w]
        force[w] = weight + m * ddy + c1 * (dy - arm @ v[bogie]) + k1 * (y - arm @ u[bogie])
    return force


def run(p, ballast_mass, ballast_stiffness, profile, steps=None, deck_at=25.0):
    """Simulate all steps, or the first `steps`; profile(x) gives r, dr/dx, d²r/dx², upward, at positions (w,)."""
    model = build(p, ballast_mass, ballast_stiffness)
    return march(p, model, profile, steps, deck_at)


def level(x):
    """No irregularity."""
    return np.zeros((3, x.size))


def march(p, model, profile, steps=None, deck_at=25.0):
    dt = model.time_step
    front = model.front if steps is None else model.front[: steps + 1]
    quiet = np.zeros(model.axles.size)
    # At rest nothing moves along the track: no rates, no convection.
    load = coupled(p, model, front[0], profile(front[0] - model.axles)[0], quiet, quiet)[3]
    still = wheel_stiffness(p, model, front[0])
    u = splu(scipy.sparse.csc_array(model.stiffness + still)).solve(load)
    v, a = np.zeros(u.size), np.zeros(u.size)
    weight = p.vehicle.gravity * (p.carbody_mass_factor * p.vehicle.carbody_mass + 2 * p.vehicle.bogie_mass) / 4
    force = [np.full(model.axles.size, weight + p.vehicle.gravity * p.vehicle.wheelset_mass)]
    carbody, deck = [np.zeros(p.vehicles)], []
    rail, under = np.arange(0, 2 * model.nodes.size, 2), model.first_sleeper + np.arange(model.sleepers.size)
    bodies = model.first_vehicle + 6 * np.arange(p.vehicles)
    rail_lowest, sleeper = u[rail].copy(), np.zeros(under.size)
    vertical = model.bridge[1:-1, 0]
    bridge_lowest, bridge_acceleration = u[vertical].copy(), np.zeros(vertical.size)
    deck.append(deck_value(model, u, deck_at))
    for n in range(1, front.size):
        x = front[n] - model.axles
        r, slope, bend = profile(x)
        irregular = r, p.speed * slope, p.speed**2 * bend
        m, c, k, load = coupled(p, model, front[n], *irregular)
        M, C, K = model.mass + m, model.damping + c, model.stiffness + k
        predicted_a = 4 / dt**2 * u + 4 / dt * v + a
        predicted_v = 2 / dt * u + v
        left = scipy.sparse.csc_array(4 / dt**2 * M + 2 / dt * C + K)
        new = splu(left, permc_spec=ORDERING, options=SYMMETRIC).solve(load + M @ predicted_a + C @ predicted_v)
        a, v, u = 4 / dt**2 * new - predicted_a, 2 / dt * new - predicted_v, new
        force.append(contact_force(p, model, front[n], u, v, a, *irregular))
        carbody.append(a[bodies])
        deck.append(deck_value(model, u, deck_at))
        np.minimum(rail_lowest, u[rail], out=rail_lowest)
        np.minimum(bridge_lowest, u[vertical], out=bridge_lowest)
        np.maximum(bridge_acceleration, np.abs(a[vertical]), out=bridge_acceleration)
        np.maximum(sleeper, np.abs(a[under]), out=sleeper)
    return Run(
        front, np.array(force), np.array(carbody), rail_lowest, bridge_lowest, bridge_acceleration, sleeper,
        np.array(deck), u, v,
    )  # fmt: skip


def wheel_stiffness(p, model, front):
    """Primary springs on the rail, without convection."""
    k1, K = p.primary_stiffness_factor * p.vehicle.primary_stiffness, Triplets()
    for rail, n, _, _, bogie, arm in wheels(p, model, front):
        K.add(np.concatenate([rail, bogie]), k1 * np.outer(np.append(n, -arm), np.append(n, -arm)))
    return K.matrix(model.mass.shape[0])


def deck_value(model, u, x):
    """Vertical displacement of the bridge at x."""
    e = int(x / (model.bridge_nodes[1] - model.bridge_nodes[0]) + 1e-9)
    _, n, _, _ = contact_rows(model.bridge_nodes, x)
    unknowns = model.bridge[e : e + 2].ravel()
    return sum(n[j] * u[unknowns[j]] for j in range(4) if unknowns[j] >= 0)
