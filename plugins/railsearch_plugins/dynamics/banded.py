"""Symmetric banded matrices in natural order along the track: assembly, product, LDLᵀ factorisation, substitution.

symbol  meaning                                                shape       unit
b       half-bandwidth: no entries further from the diagonal   scalar      -
B       matrix by lower diagonals, B[k, i] = A[i, i − k]       (b + 1, n)  as A
L, D    A = L D Lᵀ, L[k, i] below the unit diagonal            (b + 1, n)  -
        1/D is stored in L[0]

The envelope of A is that of L (George & Liu 1981, sec. 4.2): rows of L are as short as those of A. Rows with at most
NARROW sub-diagonals (a beam with single masses under it) or WIDE ones (two beams, one over a joint of the other) are
substituted with the last results held in registers: what limits a substitution is the wait for the row before.
"""

from collections.abc import Iterable

import numpy as np
from numba import njit

from railsearch_plugins.dynamics.beam import FloatArray, IntArray

BLOCK = 64
NARROW = 4
WIDE = 9

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

    A block at either end is a run of its own, since there the rows before it are missing.
    """
    widths = block_widths(factor)
    alike = np.where(widths <= NARROW, NARROW, np.where(widths <= WIDE, WIDE, widths))
    cuts = np.flatnonzero(np.diff(alike)) + 1
    first = np.unique(np.concatenate([[0, min(1, alike.size - 1), alike.size - 1], cuts]))
    stops = np.append(first[1:] * BLOCK, factor.shape[1])
    return np.stack([first * BLOCK, stops, alike[first]], axis=1)


def mirrored(lower: FloatArray) -> FloatArray:
    """U, the factor as seen from the far end of the track: U[k, i] = L[k, n − 1 − i + k], and 1/D as it is."""
    upper = np.zeros_like(lower)
    upper[0] = lower[0]
    for k in range(1, min(lower.shape)):
        upper[k, k:] = lower[k, k:][::-1]
    return upper


def diagonal_ranges(band: FloatArray) -> tuple[IntArray, IntArray]:
    """First row and one past the last row (b + 1,) in which each lower diagonal has an entry; k, k where it has none."""
    used = [np.flatnonzero(diagonal) for diagonal in band]
    starts = [int(rows[0]) if rows.size else k for k, rows in enumerate(used)]
    stops = [int(rows[-1]) + 1 if rows.size else k for k, rows in enumerate(used)]
    return np.array(starts), np.array(stops)


@njit(cache=True, fastmath={"contract"})
def factorise(band):  # type: ignore[no-untyped-def]
    """LDLᵀ of a symmetric positive definite banded matrix; the reciprocal of D in row 0 of the result.

    A pivot that is not positive makes the result NaN from there on.
    """
    width, size = band.shape[0] - 1, band.shape[1]
    lower = np.zeros_like(band)
    pivots = np.zeros(size)
    for i in range(size):
        first = max(0, i - width)
        pivot = band[0, i]
        for j in range(first, i):
            value = band[i - j, i]
            for m in range(max(first, j - width), j):
                value -= lower[i - m, i] * pivots[m] * lower[j - m, j]
            lower[i - j, i] = value / pivots[j]
            pivot -= lower[i - j, i] * value
        pivots[i] = pivot if pivot > 0.0 else np.nan
        lower[0, i] = 1.0 / pivots[i]
    return lower


@njit(cache=True, fastmath={"contract"})
def _narrow_sweep(l1, l2, l3, l4, y1, y2, y3, y4, y):  # type: ignore[no-untyped-def]
    """y[i] −= Σ l_k[i] y[i − k] for NARROW diagonals; y1…y4 are the results before the first row."""
    for i in range(y.size):
        value = y[i] - l4[i] * y4 - l3[i] * y3 - l2[i] * y2 - l1[i] * y1
        y4, y3, y2, y1 = y3, y2, y1, value
        y[i] = value


@njit(cache=True, fastmath={"contract"})
def _wide_sweep(l1, l2, l3, l4, l5, l6, l7, l8, l9, y1, y2, y3, y4, y5, y6, y7, y8, y9, y):  # type: ignore[no-untyped-def]
    """As `_narrow_sweep` for WIDE diagonals."""
    for i in range(y.size):
        value = y[i] - l9[i] * y9 - l8[i] * y8 - l7[i] * y7 - l6[i] * y6 - l5[i] * y5
        value = value - l4[i] * y4 - l3[i] * y3 - l2[i] * y2 - l1[i] * y1
        y9, y8, y7, y6, y5, y4, y3, y2, y1 = y8, y7, y6, y5, y4, y3, y2, y1, value
        y[i] = value


@njit(cache=True, fastmath={"contract"})
def forward_block(lower, width, start, stop, y):  # type: ignore[no-untyped-def]
    """L y = b for rows start…stop; y holds b on entry and the rows before `start` are done."""
    here = lower[:, start:stop]
    if width <= NARROW <= start:
        last = y[start - NARROW : start]
        _narrow_sweep(here[1], here[2], here[3], here[4], last[3], last[2], last[1], last[0], y[start:stop])
    elif width <= WIDE <= start:
        last = y[start - WIDE : start]
        _wide_sweep(
            here[1], here[2], here[3], here[4], here[5], here[6], here[7], here[8], here[9],
            last[8], last[7], last[6], last[5], last[4], last[3], last[2], last[1], last[0], y[start:stop],
        )  # fmt: skip
    else:
        for i in range(start, stop):
            for k in range(min(width, i), 0, -1):
                y[i] -= lower[k, i] * y[i - k]


@njit(cache=True, fastmath={"contract"})
def forward(lower, runs, y):  # type: ignore[no-untyped-def]
    """L y = b in place, over the `runs` of its rows."""
    for r in range(runs.shape[0]):
        forward_block(lower, runs[r, 2], runs[r, 0], runs[r, 1], y)


@njit(cache=True, fastmath={"contract"})
def backward(upper, runs, x):  # type: ignore[no-untyped-def]
    """Lᵀ x = D⁻¹ y in place, over the `runs` of U: seen from the far end it is a forward substitution."""
    for i in range(x.size):
        x[i] *= upper[0, i]
    forward(upper, runs, x[::-1])


@njit(cache=True, fastmath={"contract"})
def add_products(first, second, starts, stops, x, z, y):  # type: ignore[no-untyped-def]
    """y += A x + B z for two symmetric banded matrices that share the `diagonal_ranges` of their sum."""
    for k in range(first.shape[0]):
        start, stop = starts[k], stops[k]
        a, b = first[k, start:stop], second[k, start:stop]
        x_here, z_here, y_here = x[start:stop], z[start:stop], y[start:stop]
        x_near, z_near, y_near = x[start - k : stop - k], z[start - k : stop - k], y[start - k : stop - k]
        for i in range(stop - start):
            y_here[i] += a[i] * x_near[i] + b[i] * z_near[i]
        if k > 0:
            for i in range(stop - start):
                y_near[i] += a[i] * x_here[i] + b[i] * z_here[i]
