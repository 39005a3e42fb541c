"""A rail on sleepers over ballast and soil in plane strain, assembled with scikit-fem: M, C, K and the tables of an export.

symbol  meaning                                             unit
x, y    along the track; height over the top of the ballast  m
b       effective width, half a sleeper                      m
λ, μ    Lamé's constants                                     Pa
β       stiffness-proportional damping of ballast and soil   s
c_p/s   speeds of pressure and shear waves                   m/s

The ground is soft up to the jump and stiff beyond. Every sleeper is rigid: the ballast's nodes under it move down alike.
Between it and them is a spring with a damper, the support whose energy is wanted. The bottom is held; the sides have dampers
ρ c_p and ρ c_s, through which waves leave (Lysmer & Kuhlemeyer 1969). The rail is pinned at both ends.
"""

from dataclasses import dataclass, field

import numpy as np
import scipy.sparse
import skfem
from skfem.helpers import dd, dot, eye, sym_grad, trace

from railsearch.interfaces import TrackExport

MEGA = 1e6


@dataclass(frozen=True)
class Material:
    """Young's modulus in Pa, Poisson's ratio and density in kg/m³."""

    modulus: float
    poisson: float
    density: float

    @property
    def lame(self):
        """λ and μ in Pa, plane strain."""
        shear = self.modulus / (2.0 * (1.0 + self.poisson))
        return 2.0 * shear * self.poisson / (1.0 - 2.0 * self.poisson), shear


@dataclass(frozen=True)
class Section:
    """The track section; lengths in m, one rail."""

    length: float = 36.0
    jump: float = 21.0
    spacing: float = 0.6
    element: float = 0.15
    ballast_depth: float = 0.3
    soil_depth: float = 3.0
    layers: tuple[int, int] = (2, 8)
    width: float = 1.3
    foot: float = 0.31
    bending_stiffness: float = 210e9 * 2.337e-5
    rail_mass: float = 7800.0 * 6.977e-3
    pad: float = 1120.0
    pad_damping: float = 120e3 / 1120.0
    sleeper_mass: float = 125.5
    under_stiffness: float = 200e6
    under_damping: float = 48e3
    stiffness_damping: float = 3e-4
    groups: int = 3
    in_group: int = 4
    ballast: Material = Material(150e6, 0.2, 1800.0)
    soft: Material = Material(60e6, 0.3, 1900.0)
    stiff: Material = Material(3e9, 0.2, 2300.0)


@dataclass(frozen=True)
class Assembled:
    """The section with its mesh, the places in the export of the mesh's unknowns, positions of sleepers, and the export."""

    section: Section
    mesh: skfem.MeshQuad
    materials: dict[str, np.ndarray]
    vertical: np.ndarray
    horizontal: np.ndarray
    sleepers: np.ndarray
    export: TrackExport = field(repr=False)


def assemble(section: Section) -> Assembled:
    """Assemble the section; groups of designed pads on either side of the jump are parts at 1 MN/m."""
    x = np.linspace(0.0, section.length, round(section.length / section.element) + 1)
    count = round(section.length / section.spacing)
    sleepers = section.spacing * (np.arange(count) + 0.5)
    mesh, ground = _mesh(section, x), {}
    basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementQuad1()))
    materials = _materials(section, mesh)
    ground["mass"], ground["damping"], ground["stiffness"] = _ground(section, mesh, basis, materials)
    rail_mass, rail_stiffness, rail_dofs = _rail(section, x)
    offset, first_sleeper = rail_dofs.size, rail_dofs.size + basis.N
    vertical, horizontal = (offset + basis.nodal_dofs[row] for row in (1, 0))
    under = _under(mesh, vertical, sleepers, section.foot)
    size = first_sleeper + count
    at_sleeper = np.array([rail_dofs[np.argmin(np.abs(x - place)), 0] for place in sleepers])
    own = first_sleeper + np.arange(count)
    springs = {"damping": section.under_damping, "stiffness": section.under_stiffness}
    below = {kind: _springs(own, [feet[0] for feet in under], value, size) for kind, value in springs.items()}
    blocks = {"mass": rail_mass, "damping": 0.0 * rail_mass, "stiffness": rail_stiffness}
    masses = scipy.sparse.diags_array(np.where(np.arange(size) >= first_sleeper, section.sleeper_mass, 0.0))
    rank = _ranks(sleepers, section)
    pads = _pads(section, at_sleeper, own, rank, size)
    whole = {
        kind: scipy.sparse.block_diag((blocks[kind], ground[kind], scipy.sparse.csr_array((count, count))), format="csr")
        + (masses if kind == "mass" else below[kind] + pads["rest"][kind])
        for kind in ("mass", "damping", "stiffness")
    }
    held = np.concatenate(
        [rail_dofs[[0, -1], 0], *(rows[mesh.p[1] < mesh.p[1].min() + 1e-9] for rows in (vertical, horizontal))]
    )
    tie, place = _constraints(size, under, held, _along(x, rail_dofs, mesh, vertical, horizontal, sleepers, own))
    reduced = {kind: (tie.T @ matrix @ tie).tocsr() for kind, matrix in whole.items()}
    parts = {
        name: {kind: (tie.T @ matrix @ tie).tocsr() for kind, matrix in part.items()}
        for name, part in pads.items()
        if name != "rest"
    }
    table = np.column_stack(
        [sleepers, place[own], np.full(count, section.under_damping), place[[feet[0] for feet in under]]]
    )
    export = TrackExport(
        reduced, np.column_stack([x, place[rail_dofs]]), table, _settings(section), parts, dict.fromkeys(parts, section.pad)
    )
    return Assembled(section, mesh, materials, place[vertical], place[horizontal], sleepers, export)


def _mesh(section, x):
    """Rectangles: ballast, then layers of the soil that grow with the depth."""
    ballast, soil = section.layers
    depth = section.ballast_depth + section.soil_depth * np.linspace(0.0, 1.0, soil + 1) ** 1.5
    return skfem.MeshQuad.init_tensor(
        x, -np.concatenate([np.linspace(0.0, section.ballast_depth, ballast + 1), depth[1:]])[::-1]
    )


def _materials(section, mesh):
    """Masks (elements,) of ballast, soft and stiff ground."""
    x, y = mesh.p[:, mesh.t].mean(axis=1)
    ballast = y > -section.ballast_depth
    return {"ballast": ballast, "soft": ~ballast & (x < section.jump), "stiff": ~ballast & (x > section.jump)}


def _ground(section, mesh, basis, materials):
    """M, C and K of ballast and soil, with the dampers of both sides in C."""
    constant = basis.with_element(skfem.ElementQuad0())
    fields = {}
    for name, pick in (("lam", 0), ("mu", 1)):
        values = sum(mask * getattr(section, material).lame[pick] for material, mask in materials.items())
        fields[name] = constant.interpolate(values)
    density = sum(mask * getattr(section, material).density for material, mask in materials.items())

    @skfem.BilinearForm
    def stiffness(u, v, w):
        strain = sym_grad(u)
        stress = 2.0 * w["mu"] * strain + eye(w["lam"] * trace(strain), 2)
        return section.width * np.einsum("ij...,ij...->...", stress, sym_grad(v))

    @skfem.BilinearForm
    def mass(u, v, w):
        return section.width * w["rho"] * dot(u, v)

    K = stiffness.assemble(basis, **fields)
    M = mass.assemble(basis, rho=constant.interpolate(density))
    return M, section.stiffness_damping * K + _sides(section, mesh, basis, materials, density), K


def _sides(section, mesh, basis, materials, density):
    """Dampers ρ c_p across and ρ c_s along both ends of the section."""
    x = mesh.p[0]
    ends = mesh.facets_satisfying(lambda p: (p[0] < x.min() + 1e-9) | (p[0] > x.max() - 1e-9), boundaries_only=True)
    facets = skfem.FacetBasis(mesh, skfem.ElementVector(skfem.ElementQuad1()), facets=ends)
    lam, mu = (sum(mask * getattr(section, name).lame[k] for name, mask in materials.items()) for k in range(2))
    constant = facets.with_element(skfem.ElementQuad0())
    across = constant.interpolate(np.sqrt(density * (lam + 2.0 * mu)))
    along = constant.interpolate(np.sqrt(density * mu))

    @skfem.BilinearForm
    def damping(u, v, w):
        return section.width * (w["across"] * u[0] * v[0] + w["along"] * u[1] * v[1])

    return damping.assemble(facets, across=across, along=along)


def _rail(section, x):
    """M and K of the rail in Hermite elements, and its unknowns (k, 2): displacement and slope of every node."""
    basis = skfem.Basis(skfem.MeshLine(x), skfem.ElementLineHermite())

    @skfem.BilinearForm
    def bending(u, v, w):
        return section.bending_stiffness * dd(u)[0, 0] * dd(v)[0, 0]

    @skfem.BilinearForm
    def mass(u, v, w):
        return section.rail_mass * u * v

    order = np.argsort(basis.mesh.p[0])
    return mass.assemble(basis), bending.assemble(basis), basis.nodal_dofs[:, order].T


def _under(mesh, vertical, sleepers, foot):
    """The vertical unknowns on top of the ballast under every sleeper, that at its centre first."""
    top = np.flatnonzero(mesh.p[1] > -1e-9)
    found = []
    for place in sleepers:
        distance = np.abs(mesh.p[0, top] - place)
        near = np.argsort(distance, kind="stable")
        found.append([int(vertical[top[k]]) for k in near if k == near[0] or distance[k] <= 0.5 * foot])
    return found


def _springs(first, second, values, size):
    """Springs or dampers between unknowns first and second (s,)."""
    first, second, values = np.asarray(first), np.asarray(second), np.broadcast_to(values, np.shape(first))
    rows = np.concatenate([first, second, first, second])
    columns = np.concatenate([first, second, second, first])
    return scipy.sparse.coo_array(
        (np.concatenate([values, values, -values, -values]), (rows, columns)), shape=(size, size)
    ).tocsr()


def _ranks(sleepers, section):
    """Place of every sleeper counted from the jump: −1, −2, … before it and 1, 2, … beyond."""
    before = sleepers < section.jump
    count = int(before.sum())
    return np.where(before, np.arange(sleepers.size) - count, np.arange(sleepers.size) - count + 1)


def _pads(section, rail, sleepers, rank, size):
    """Damping and stiffness of the designed pads at 1 MN/m, in groups counted from the jump, and of the rest."""
    group = np.sign(rank) * -(-np.abs(rank) // section.in_group)
    groups = {f"before_{k}": group == -k for k in range(1, section.groups + 1)}
    groups |= {f"beyond_{k}": group == k for k in range(1, section.groups + 1)}
    groups["rest"] = np.abs(group) > section.groups
    made = {}
    for name, mask in groups.items():
        scale = section.pad if name == "rest" else 1.0
        values = {"damping": scale * section.pad_damping, "stiffness": scale * MEGA}
        made[name] = {kind: _springs(rail[mask], sleepers[mask], value, size) for kind, value in values.items()}
    return made


def _along(x, rail_dofs, mesh, vertical, horizontal, sleepers, own):
    """Position along the track of every unknown, by which the export is numbered."""
    positions = np.empty(rail_dofs.size + 2 * mesh.p.shape[1] + own.size)
    positions[rail_dofs] = x[:, None]
    positions[vertical] = positions[horizontal] = mesh.p[0]
    positions[own] = sleepers
    return positions


def _constraints(size, under, held, positions):
    """u = T q without held unknowns, those under a sleeper being one; and the place of every u in q, −1 held."""
    master = np.arange(size)
    for feet in under:
        master[feet] = feet[0]
    free = np.setdiff1d(np.unique(master), held)
    free = free[np.argsort(positions[free], kind="stable")]
    number = np.full(size, -1)
    number[free] = np.arange(free.size)
    place = number[master]
    rows = np.flatnonzero(place >= 0)
    return scipy.sparse.csr_array((np.ones(rows.size), (rows, place[rows])), shape=(size, free.size)), place


def _settings(section):
    """A passage over the whole section; measured from a third of it before the jump to a sixth beyond."""
    before, beyond = section.length / 3.0, section.length / 6.0
    return {
        "rail": {"interpolation": "hermite", "rotation": "slope"},
        "windows": {
            "force_from": section.jump - before,
            "force_to": section.jump + beyond,
            "energy_from": section.jump - before,
            "energy_to": section.jump,
        },
    }
