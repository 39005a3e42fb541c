"""Symmetric banded matrices in natural order along the track: assembly, and what the kernels need to know of a factor.

symbol  meaning                                                shape       unit
b       half-bandwidth: no entries further from the diagonal   scalar      -
B       matrix by lower diagonals, B[k, i] = A[i, i − k]       (b + 1, n)  as A
L, D    A = L D Lᵀ, L[k, i] below the unit diagonal            (b + 1, n)  -
        1/D is stored in L[0]
U       L as seen from the far end: Lᵀ x = y is a forward      (b + 1, n)  -
        substitution with U on the reversed vectors

The envelope of A is that of L (George & Liu 1981, sec. 4.2): rows of L are as short as those of A. Rows with at most
NARROW sub-diagonals (a beam with single masses under it), MIDDLE (a beam over another one) or WIDE ones (one over a joint
of the other) are substituted with the last results held in registers: what limits a substitution is the wait for the row
before.
"""

from collections.abc import Iterable

import numpy as np

from railsearch_plugins.dynamics.beam import FloatArray, IntArray
from railsearch_plugins.dynamics.kernels import BLOCK, MIDDLE, NARROW, WIDE

Elements = tuple[IntArray, FloatArray]


def assemble(elements: Iterable[Elements], size: int, half_bandwidth: int) -> FloatArray:
    """Sum element matrices into a symmetric banded matrix (b + 1, size), b = max(half_bandwidth, WIDE).

    elements: pairs of unknowns (m, p), −1 for one that is held, and matrices (m, p, p).
    """
    band = np.zeros((max(half_bandwidth, WIDE) + 1, size))
    for unknowns, matrices in elements:
        rows = np.broadcast_to(unknowns[:, :, None], matrices.shape)
        columns = np.broadcast_to(unknowns[:, None, :], matrices.shape)
        lower = (columns >= 0) & (rows >= columns)
        np.add.at(band, ((rows - columns)[lower], rows[lower]), matrices[lower])
    return band


def half_bandwidth(elements: Iterable[Elements]) -> int:
    """The largest distance between two unknowns of one element."""
    widest = 0
    for unknowns, _ in elements:
        first = np.where(unknowns >= 0, unknowns, np.iinfo(np.int64).max).min(axis=1)
        widest = max(widest, int((unknowns.max(axis=1) - first).max(initial=0)))
    return widest


def block_widths(factor: FloatArray) -> IntArray:
    """The most sub-diagonals with an entry in a row of each block of a factor, L or U."""
    rows = np.zeros(factor.shape[1], dtype=np.int64)
    for k in range(1, factor.shape[0]):
        rows[factor[k] != 0.0] = k
    return np.maximum.reduceat(rows, np.arange(0, rows.size, BLOCK))


def runs(factor: FloatArray) -> IntArray:
    """Rows from, to and width (r, 3) of the longest stretches of blocks that are substituted alike.

    The first block is a run of its own: the rows before it are missing, and its substitution is the slower, general one.
    """
    widths = block_widths(factor)
    alike = widths
    for width in (WIDE, MIDDLE, NARROW):
        alike = np.where(widths <= width, width, alike)
    cuts = np.flatnonzero(np.diff(alike)) + 1
    first = np.unique(np.concatenate([[0, min(1, alike.size - 1)], cuts]))
    stops = np.append(first[1:] * BLOCK, factor.shape[1])
    return np.stack([first * BLOCK, stops, alike[first]], axis=1)


def mirrored(lower: FloatArray) -> FloatArray:
    """U, the factor as seen from the far end of the track: U[k, i] = L[k, n − 1 − i + k], and 1/D as it is."""
    upper = np.zeros_like(lower)
    upper[0] = lower[0]
    for k in range(1, min(lower.shape)):
        upper[k, k:] = lower[k, k:][::-1]
    return upper
