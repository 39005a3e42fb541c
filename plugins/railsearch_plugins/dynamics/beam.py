"""Euler–Bernoulli beam elements with Hermite functions, and rows that evaluate a beam at a point.

symbol  meaning                                            shape    unit   source
l       length of an element                               (m,)     m
ξ, s    position in an element, s = ξ/l                    (m,)     m, -
N       Hermite functions of (w₁, θ₁, w₂, θ₂)              (m, 4)   -, m   Przemieniecki (1968), eq. 5.75
d       order of a derivative                              scalar   -
EI      bending stiffness                                  scalar   N m²
G       ∫ Nᵀ N dξ over a part of the element               (m, 4, 4)
"""

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

# Four Gauss points integrate the products of two cubics (degree 6) exactly.
_GAUSS_POINTS, _GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(4)


def hermite(offset: ArrayLike, length: ArrayLike, order: int = 0) -> FloatArray:
    """Hermite functions (..., 4) at `offset` ξ in an element of `length` l, both (...) in m, or dᵈN/dξᵈ of `order` d ≤ 2.

    N = [1 − 3s² + 2s³, ξ(1 − s)², 3s² − 2s³, ξ s(s − 1)] with s = ξ/l (Przemieniecki 1968, eq. 5.75).
    """
    xi, span = np.broadcast_arrays(np.asarray(offset, dtype=float), np.asarray(length, dtype=float))
    s = xi / span
    if order == 0:
        rows = [1.0 - s * s * (3.0 - 2.0 * s), xi * (1.0 - s) ** 2, s * s * (3.0 - 2.0 * s), xi * s * (s - 1.0)]
    elif order == 1:
        bend = 6.0 * s * (1.0 - s) / span
        rows = [-bend, (1.0 - s) * (1.0 - 3.0 * s), bend, s * (3.0 * s - 2.0)]
    else:
        bend = (6.0 - 12.0 * s) / span**2
        rows = [-bend, (6.0 * s - 4.0) / span, bend, (6.0 * s - 2.0) / span]
    return np.stack(rows, axis=-1)


def bending_matrices(length: ArrayLike, bending_stiffness: float) -> FloatArray:
    """Stiffness matrices (m, 4, 4) of elements of `length` (m,) in m: ∫ EI N″ᵀ N″ dξ (Przemieniecki 1968, eq. 5.121)."""
    span = np.atleast_1d(np.asarray(length, dtype=float))
    one = np.ones_like(span)
    rows = [
        [12 * one, 6 * span, -12 * one, 6 * span],
        [6 * span, 4 * span * span, -6 * span, 2 * span * span],
        [-12 * one, -6 * span, 12 * one, -6 * span],
        [6 * span, 2 * span * span, -6 * span, 4 * span * span],
    ]
    matrices = np.moveaxis(np.array(rows), -1, 0)
    return np.asarray(bending_stiffness * matrices / (span**3)[:, None, None])


def gram_matrices(length: ArrayLike, start: ArrayLike, stop: ArrayLike) -> FloatArray:
    """∫ Nᵀ N dξ (m, 4, 4) over [start, stop] inside elements of `length`, all (m,) in m.

    Times a mass per length it is the consistent mass matrix, times a stiffness per length that of a continuous layer.
    """
    span, a, b = (np.atleast_1d(np.asarray(value, dtype=float)) for value in np.broadcast_arrays(length, start, stop))
    half = 0.5 * (b - a)
    points = 0.5 * (a + b)[:, None] + half[:, None] * _GAUSS_POINTS
    rows = hermite(points, span[:, None])
    return np.asarray(np.einsum("m,g,mgi,mgj->mij", half, _GAUSS_WEIGHTS, rows, rows))


def layer_matrices(edges: FloatArray, boundary: float, before: float, after: float) -> FloatArray:
    """Matrices (m, 4, 4) of a continuous layer under elements with `edges` (m + 1,) in m.

    The layer has the property `before` (per metre) up to the position `boundary` and `after` beyond it, split exactly
    where the boundary lies inside an element.
    """
    length = np.diff(edges)
    split = np.clip(boundary - edges[:-1], 0.0, length)
    return before * gram_matrices(length, 0.0, split) + after * gram_matrices(length, split, length)


def coupled(matrices: FloatArray) -> FloatArray:
    """Matrices (m, 2p, 2p) of a layer between two bodies from those of the layer to ground (m, p, p): [[A, −A], [−A, A]]."""
    return np.asarray(np.block([[matrices, -matrices], [-matrices, matrices]]))


def find(nodes: FloatArray, positions: ArrayLike) -> tuple[IntArray, FloatArray, FloatArray]:
    """Element (k,) that holds each of the positions (k,), the offset ξ in it and its length l (k,), all in m.

    A position within 1e-9 of an element length of a node is taken on the node. Raises ValueError outside the nodes.
    """
    x = np.atleast_1d(np.asarray(positions, dtype=float))
    lengths = np.diff(nodes)
    elements = np.clip(np.searchsorted(nodes, x, side="right") - 1, 0, lengths.size - 1)
    share = (x - nodes[elements]) / lengths[elements]
    if np.any(share < -1e-9) or np.any(share > 1.0 + 1e-9):
        raise ValueError(f"positions must lie between {nodes[0]:g} and {nodes[-1]:g} m")
    nearest = np.round(share)
    share = np.where(np.abs(share - nearest) <= 1e-9, nearest, share)
    return elements, share * lengths[elements], lengths[elements]


def locate(nodes: FloatArray, positions: ArrayLike) -> tuple[IntArray, FloatArray]:
    """Element (k,) that holds each of the positions (k,), and its Hermite row (k, 4); see `find`."""
    elements, offset, length = find(nodes, positions)
    return elements, hermite(offset, length)


def outer(rows: FloatArray, factors: Any) -> FloatArray:
    """Matrices (m, p, p) = factor · rowᵀ row of springs or dampers (m,) that see the elongation row · u, rows (m, p)."""
    return np.asarray(np.einsum("m,mi,mj->mij", np.broadcast_to(factors, rows.shape[:1]), rows, rows))


def critical_speed(foundation: float, bending_stiffness: float, mass: float) -> float:
    """Speed in m/s at which a load outruns the waves of a beam on a Winkler foundation: (4 k EI/m²)^(1/4).

    foundation k in N/m², bending stiffness EI in N m² and mass m in kg/m, both of the latter with all that moves along
    (Frýba 1999, Vibration of Solids and Structures under Moving Loads, ch. 13).
    """
    return math.sqrt(2.0 * math.sqrt(foundation * bending_stiffness) / mass)
