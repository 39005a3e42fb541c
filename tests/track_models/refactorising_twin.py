"""A slow, independent twin of the level-crossing model: coupled matrices, refactorised with scipy.sparse at every step.

It shares nothing with the fast model but the parameters: its own layout, numbering (rail, slabs, sleepers, vehicle),
element matrices in closed form, Newmark's method with accelerations, and gravity acting on absolute displacements.
"""

import functools
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import scipy.sparse
from numpy.polynomial import Polynomial
from scipy.interpolate import CubicSpline
from scipy.sparse.linalg import splu

from railsearch_plugins.track_models.level_crossing.parameters import LevelCrossingParameters

# With COLAMD the fastest of SuperLU's orderings for this matrix.
ORDERING = "MMD_AT_PLUS_A"
SYMMETRIC = {"SymmetricMode": True, "DiagPivotThresh": 0.0}


@dataclass(frozen=True)
class Coupled:
    """Matrices of track and vehicle without contact; the last three unknowns are carbody, bogie and wheelset."""

    mass: scipy.sparse.csc_array
    damping: scipy.sparse.csc_array
    stiffness: scipy.sparse.csc_array
    free: np.ndarray
    nodes: np.ndarray
    sleeper_position: np.ndarray
    first_sleeper: int


@dataclass(frozen=True)
class Result:
    position: np.ndarray
    force: np.ndarray
    rail: np.ndarray
    carbody_acceleration: np.ndarray
    sleeper_energy: np.ndarray


def hermite_polynomials(length):
    """The four Hermite functions as polynomials of the position in an element."""
    l = length  # noqa: E741
    return [
        Polynomial([1, 0, -3 / l**2, 2 / l**3]),
        Polynomial([0, 1, -2 / l, 1 / l**2]),
        Polynomial([0, 0, 3 / l**2, -2 / l**3]),
        Polynomial([0, 0, -1 / l, 1 / l**2]),
    ]


@functools.lru_cache(maxsize=4096)
def integrated(length, start, stop, order=0):
    """∫ Nᵢ Nⱼ over [start, stop], or of their derivatives of some order, by the primitive."""
    functions = [f.deriv(order) for f in hermite_polynomials(length)]
    primitives = [[(f * g).integ() for g in functions] for f in functions]
    return np.array([[p(stop) - p(start) for p in row] for row in primitives])


class Triplets:
    """Collects dense blocks into a sparse matrix."""

    def __init__(self):
        self.rows, self.columns, self.values = [], [], []

    def add(self, unknowns, block):
        self.rows.append(np.repeat(unknowns, len(unknowns)))
        self.columns.append(np.tile(unknowns, len(unknowns)))
        self.values.append(np.ravel(block))

    def matrix(self, size):
        triplets = np.concatenate(self.values), (np.concatenate(self.rows), np.concatenate(self.columns))
        return scipy.sparse.csc_array(scipy.sparse.coo_array(triplets, shape=(size, size)))


def sleepers(p: LevelCrossingParameters):
    """Position, mass and pad stiffness of all sleepers, walked one by one outwards from each interface."""
    listed = []
    sides = [(p.geometry.approach_length, -1.0, 0.0), (p.geometry.crossing_end, 1.0, p.geometry.total_length)]
    for interface, direction, end in sides:
        x, number = interface, 0
        while True:
            near = number < len(p.zone.sleeper_distances)
            x += direction * (p.zone.sleeper_distances[-1 - number] if near else p.sleeper.spacing)
            if direction * (end - x) < 1e-6:
                break
            pad = p.zone.pad_stiffness[-1 - number] if number < len(p.zone.pad_stiffness) else p.railpad.stiffness
            strong = number < p.zone.strengthened_sleepers
            listed.append((x, p.sleeper.strengthened_mass if strong else p.sleeper.mass, pad))
            number += 1
    return np.array(sorted(listed)).T


def mesh(p: LevelCrossingParameters):
    g = p.geometry
    edges = [0.0, *(g.approach_length + g.slab_length * i for i in range(g.slab_count + 1)), g.total_length]
    pieces = [np.linspace(a, b, int(np.ceil((b - a) / p.passage.element_length - 1e-6)) + 1) for a, b in pairwise(edges)]
    return np.concatenate([pieces[0], *(piece[1:] for piece in pieces[1:])])


def couple(p: LevelCrossingParameters) -> Coupled:
    nodes, position = mesh(p), sleepers(p)[0]
    M, C, K = Triplets(), Triplets(), Triplets()
    rail_mass, EI = p.rail.density * p.rail.area, p.rail.young_modulus * p.rail.second_moment
    slab_mass, slab_EI = p.slab.density * p.slab.area, p.slab.young_modulus * p.slab.second_moment
    slab_first, size = {}, 2 * nodes.size
    for e, (a, b) in enumerate(pairwise(nodes)):
        l = round(b - a, 13)  # noqa: E741
        gram, curvature = integrated(l, 0.0, l), integrated(l, 0.0, l, 2)
        rail = np.arange(2 * e, 2 * e + 4)
        M.add(rail, rail_mass * gram)
        K.add(rail, EI * curvature)
        slab_number = int((0.5 * (a + b) - p.geometry.approach_length) // p.geometry.slab_length)
        if not 0 <= slab_number < p.geometry.slab_count:
            continue
        if slab_number not in slab_first:
            slab_first[slab_number] = size, e
            size += 2 * (np.searchsorted(nodes, a + p.geometry.slab_length - 1e-6) - e + 1)
        slab = slab_first[slab_number][0] + 2 * (e - slab_first[slab_number][1]) + np.arange(4)
        M.add(slab, slab_mass * gram)
        C.add(slab, p.slab.subgrade_damping * gram)
        K.add(slab, p.slab.subgrade_stiffness * gram + slab_EI * curvature)
        change = min(max(p.geometry.approach_length + p.zone.type_2_strip_length - a, 0.0), l)
        for k, part in (
            (p.strip.type_2_stiffness, integrated(l, 0.0, change)),
            (p.strip.type_1_stiffness, integrated(l, change, l)),
        ):
            both, sign = np.concatenate([rail, slab]), np.array([[1.0, -1.0], [-1.0, 1.0]])
            K.add(both, k * np.kron(sign, part))
            C.add(both, 2 * p.strip.damping_ratio * np.sqrt(k * rail_mass) * np.kron(sign, part))
    add_sleepers(p, nodes, size, M, C, K)
    first = size + position.size
    add_vehicle(p, first, M, C, K)
    total = first + 3
    free = np.setdiff1d(np.arange(total), [0, 2 * nodes.size - 2])
    return Coupled(M.matrix(total), C.matrix(total), K.matrix(total), free, nodes, position, size)


def add_sleepers(p: LevelCrossingParameters, nodes, size, M, C, K):
    """Pads, sleepers and ballast; the sleepers are numbered from `size`."""
    position, mass, pads = sleepers(p)
    halved = 0.5 if p.railpad.reading == "full-track" else 1.0
    for i, (x, m, pad) in enumerate(zip(position, mass, pads, strict=True)):
        unknowns, row = contact(nodes, x)
        unknowns, row = np.append(unknowns, size + i), np.append(row, -1.0)
        K.add(unknowns, halved * pad * np.outer(row, row))
        C.add(unknowns, halved * pad / p.railpad.stiffness * p.railpad.damping * np.outer(row, row))
        M.add([size + i], [m])
        K.add([size + i], [p.ballast.stiffness])
        C.add([size + i], [p.ballast.damping])


def add_vehicle(p: LevelCrossingParameters, first, M, C, K):
    """Carbody, bogie and wheelset, numbered from `first`."""
    v = p.vehicle
    carbody = v.static_load / v.gravity - v.bogie_mass - v.wheelset_mass
    for i, m in enumerate((carbody, v.bogie_mass, v.wheelset_mass)):
        M.add([first + i], [m])
    pair = np.array([[1.0, -1.0], [-1.0, 1.0]])
    for i, k, c in ((0, v.secondary_stiffness, v.secondary_damping), (1, v.primary_stiffness, v.primary_damping)):
        K.add([first + i, first + i + 1], k * pair)
        C.add([first + i, first + i + 1], c * pair)


def contact(nodes, x):
    """Rail unknowns and Hermite row at x."""
    e = min(max(int(np.searchsorted(nodes, x, side="right")) - 1, 0), nodes.size - 2)
    l = nodes[e + 1] - nodes[e]  # noqa: E741
    s = (x - nodes[e]) / l
    row = [1 - 3 * s**2 + 2 * s**3, l * (s - 2 * s**2 + s**3), 3 * s**2 - 2 * s**3, l * (s**3 - s**2)]
    return np.arange(2 * e, 2 * e + 4), np.array(row)


def run(p: LevelCrossingParameters, steps: int | None = None) -> Result:
    """Simulate from static equilibrium at x = 0, all steps of the run or the first `steps` of them."""
    return march(p, couple(p), steps)


def march(p: LevelCrossingParameters, coupled: Coupled, steps: int | None = None) -> Result:
    free, dt, kw = coupled.free, p.passage.time_step, 1.5 / p.vehicle.hertz_constant * p.vehicle.static_load ** (1 / 3)
    M, C, K = (matrix[free][:, free] for matrix in (coupled.mass, coupled.damping, coupled.stiffness))
    constant = scipy.sparse.csc_array(K + 2 / dt * C + 4 / dt**2 * M)
    place = np.full(coupled.mass.shape[0], -1)
    place[free] = np.arange(free.size)
    count = int(p.geometry.total_length / (p.passage.speed * dt)) if steps is None else steps
    position = np.arange(count + 1) * p.passage.speed * dt
    upward = (
        CubicSpline(p.irregularity.position, p.irregularity.height)(position) if p.irregularity.position else 0 * position
    )
    weight = np.zeros(free.size)
    weight[-3:] = p.vehicle.gravity * M.diagonal()[-3:]
    u, velocity, acceleration = np.zeros(free.size), np.zeros(free.size), np.zeros(free.size)
    u[-1] = weight[-3:].sum() / kw - upward[0]
    u[-2] = u[-1] + weight[-3:-1].sum() / p.vehicle.primary_stiffness
    u[-3] = u[-2] + weight[-3] / p.vehicle.secondary_stiffness
    force, rail, carbody = [weight.sum()], [0.0], [0.0]
    under = place[coupled.first_sleeper + np.arange(coupled.sleeper_position.size)]
    energy = np.zeros(under.size)
    for n in range(1, count + 1):
        unknowns, row = contact(coupled.nodes, position[n])
        held = place[unknowns] < 0
        touched, row = np.append(place[unknowns][~held], free.size - 1), np.append(row[~held], -1.0)
        load = weight + M @ (4 / dt * velocity + acceleration) + C @ velocity - K @ u
        load[touched] += kw * (upward[n] - row @ u[touched]) * row
        spring = scipy.sparse.csc_array(
            (kw * np.outer(row, row).ravel(), (np.repeat(touched, row.size), np.tile(touched, row.size))),
            shape=constant.shape,
        )
        increment = splu(scipy.sparse.csc_array(constant + spring), permc_spec=ORDERING, options=SYMMETRIC).solve(load)
        change = 4 / dt**2 * increment - 4 / dt * velocity - 2 * acceleration
        velocity = velocity + dt * acceleration + 0.5 * dt * change
        u, acceleration = u + increment, acceleration + change
        force.append(kw * (-row @ u[touched] + upward[n]))
        rail.append(row[:-1] @ u[touched[:-1]])
        carbody.append(acceleration[-3])
        energy += (0.5 if n == count else 1.0) * dt * p.ballast.damping * velocity[under] ** 2
    return Result(position, np.array(force), np.array(rail), np.array(carbody), energy)
