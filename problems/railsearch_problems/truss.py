"""Problem `truss`: the midspan deflection of a statically determinate truss of 23 bars under six random loads.

Source: Shang, Nogal, Teixeira & Wolfert, Reliability Engineering & System Safety 243 (2024) 109818; first Lee & Kwak,
Computers and Structures 84 (2006) 1680-1690.

    13 nodes, 11 horizontal bars (4 m each), 12 diagonals; span 24 m in 6 bays, height 2 m:

        7───8───9───10──11──12          upper nodes, each with a load down
       / \\ / \\ / \\ / \\ / \\ / \\
      0───1───2───3───4───5───6         lower nodes; 0 on a pin, 6 on a roller

| symbol | meaning | shape | unit |
|---|---|---|---|
| E1, A1; E2, A2 | Young's modulus and cross-section of the horizontal bars; of the diagonals | (n,) | Pa, m² |
| P_m | loads on the upper nodes | (n, 6) | N |
| n_b, s_b, L_b | bar forces; axial stiffnesses E A/L; lengths | (n, 23) | N, N/m, m |
| K | stiffness matrix Σ_b s_b g_b g_bᵀ, g_b: elongation of bar b by displacement | (n, 23, 23) | N/m |
| w | deflection of the middle lower node, positive down | (n,) | m |

The closed form w = Σ_m P_m (a_m/(E1 A1) + b_m/(E2 A2)) is the principle of virtual work, Σ_b n_b(P) n_b(1) L_b/(E A)_b.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from railsearch.design_problem import DesignProblem
from railsearch.distributions import RandomVector, random_vector
from railsearch.errors import InputError
from railsearch.hookspecs import Register, hookimpl
from railsearch.interfaces import Outcome, Quantity
from railsearch.space import FloatArray, Space, Variable

BAYS, BAY, HEIGHT = 6, 4.0, 2.0
LOWER_NODES = BAYS + 1
MIDSPAN = BAYS // 2
HORIZONTAL_LENGTHS = np.array([36.0, 100.0, 140.0, 140.0, 100.0, 36.0])
"""a_m in m."""

DIAGONAL_LENGTHS = np.sqrt(2.0) * np.array([2.0, 6.0, 10.0, 10.0, 6.0, 2.0])
"""b_m in m."""

BLOCK = 512
"""Trusses solved at a time, to bound the memory of their matrices."""

MATERIAL = (
    Variable("E1", 1.54e11, 2.84e11, "Pa", meaning="Young's modulus of the horizontal bars"),
    Variable("E2", 1.54e11, 2.84e11, "Pa", meaning="Young's modulus of the diagonals"),
    Variable("A1", 0.0015, 0.0027, "m²", meaning="cross-section of the horizontal bars"),
    Variable("A2", 0.0007, 0.0014, "m²", meaning="cross-section of the diagonals"),
)
LOADS = tuple(
    Variable(f"P{m}", 26475.0, 64677.0, "N", meaning=f"load on upper node {m}, from the left") for m in range(1, BAYS + 1)
)
DISTRIBUTIONS: Mapping[str, Mapping[str, object]] = {
    "E1": {"distribution": "lognormal", "mean": 2.1e11, "std": 2.1e10},
    "E2": {"distribution": "lognormal", "mean": 2.1e11, "std": 2.1e10},
    "A1": {"distribution": "lognormal", "mean": 2.0e-3, "std": 2.0e-4},
    "A2": {"distribution": "lognormal", "mean": 1.0e-3, "std": 1.0e-4},
    **{load.name: {"distribution": "gumbel-max", "mean": 5.0e4, "std": 7.5e3} for load in LOADS},
}


class Truss(DesignProblem):
    """Truss of 23 bars: moduli, cross-sections and loads within their published ranges, for the midspan deflection."""

    def __init__(self) -> None:
        super().__init__(
            name="truss",
            space=Space((*MATERIAL, *LOADS)),
            objectives=[Quantity("w", "m", "midspan deflection, positive down")],
            reference=np.array([2.1e11, 2.1e11, 2.0e-3, 1.0e-3, *[5.0e4] * BAYS]),
        )
        self.distributions: RandomVector | None = random_vector(DISTRIBUTIONS)

    def simulate(self, design: FloatArray) -> Outcome:
        """The deflection by finite elements."""
        return Outcome(deflections(design[None, :]))


def deflections(designs: ArrayLike) -> FloatArray:
    """W (n,) in m of designs (n, 10), in the order E1, E2, A1, A2, P1 … P6 and SI units, by finite elements.

    Raises InputError unless designs have ten finite values with moduli and cross-sections above 0.
    """
    values = _checked(designs)
    blocks = [_deflections(values[start : start + BLOCK]) for start in range(0, len(values), BLOCK)]
    return np.concatenate([np.empty(0), *blocks])


def closed_form(designs: ArrayLike) -> FloatArray:
    """W (n,) in m of designs (n, 10) by virtual work. Raises InputError as `deflections`."""
    values = _checked(designs)
    horizontal, diagonal = values[:, 0] * values[:, 2], values[:, 1] * values[:, 3]
    return np.asarray(values[:, 4:] @ HORIZONTAL_LENGTHS / horizontal + values[:, 4:] @ DIAGONAL_LENGTHS / diagonal)


def _deflections(designs: FloatArray) -> FloatArray:
    elongations, lengths, horizontal = _bars()
    rigidity = np.where(horizontal, designs[:, 0:1] * designs[:, 2:3], designs[:, 1:2] * designs[:, 3:4])
    stiffness = np.einsum("nb,bi,bj->nij", rigidity / lengths, elongations, elongations, optimize=True)
    # Displacements in the order x and y of every node: the pin takes both of node 0, the roller that in y of node 6.
    free = np.delete(np.arange(2 * (LOWER_NODES + BAYS)), [0, 1, 2 * BAYS + 1])
    forces = np.zeros((len(designs), 2 * (LOWER_NODES + BAYS)))
    forces[:, 2 * LOWER_NODES + 1 :: 2] = -designs[:, 4:]
    displacements = np.linalg.solve(stiffness[:, free[:, None], free], forces[:, free, None])[:, :, 0]
    return np.asarray(-displacements[:, np.searchsorted(free, 2 * MIDSPAN + 1)])


@cache
def _bars() -> tuple[FloatArray, FloatArray, NDArray[np.bool_]]:
    """Elongations g (23, 26) by displacement, lengths (23,), and which bars are horizontal (23,)."""
    lower = np.column_stack([BAY * np.arange(LOWER_NODES), np.zeros(LOWER_NODES)])
    upper = np.column_stack([BAY * (np.arange(BAYS) + 0.5), np.full(BAYS, HEIGHT)])
    nodes = np.vstack([lower, upper])
    chords = [(k, k + 1) for k in range(BAYS)] + [(LOWER_NODES + k, LOWER_NODES + k + 1) for k in range(BAYS - 1)]
    diagonals = [(k + side, LOWER_NODES + k) for k in range(BAYS) for side in (0, 1)]
    start, end = np.array(chords + diagonals).T
    ends = nodes[end] - nodes[start]
    lengths = np.linalg.norm(ends, axis=1)
    elongations = np.zeros((len(ends), 2 * len(nodes)))
    for axis in (0, 1):
        elongations[np.arange(len(ends)), 2 * start + axis] = -ends[:, axis] / lengths
        elongations[np.arange(len(ends)), 2 * end + axis] = ends[:, axis] / lengths
    return elongations, lengths, ends[:, 1] == 0.0


def _checked(designs: ArrayLike) -> FloatArray:
    values = np.asarray(designs, dtype=float)
    if values.ndim != 2 or values.shape[1] != len(DISTRIBUTIONS):
        raise InputError(f"truss: designs (n, {len(DISTRIBUTIONS)}) are needed, received shape {values.shape}")
    if not np.isfinite(values).all() or not (values[:, :4] > 0.0).all():
        raise InputError("truss: finite values, with moduli and cross-sections above 0, are needed; correct the designs")
    return values


@hookimpl
def railsearch_problems(register: Register) -> None:
    """Register `truss`."""
    register("truss", Truss)
