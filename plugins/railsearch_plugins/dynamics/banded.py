"""Symmetric banded matrices in natural order along the track: assembly, product, LDLᵀ factorisation, substitution.

symbol  meaning                                                shape       unit
b       half-bandwidth: no entries further from the diagonal   scalar      -
B       matrix by lower diagonals, B[k, i] = A[i, i − k]       (b + 1, n)  as A
L, D    A = L D Lᵀ, L[k, i] below the unit diagonal            (b + 1, n)  -
        1/D is stored in L[0]
h       most sub-diagonals a block of BLOCK rows needs         (blocks,)   -

The envelope of a row is kept by LDLᵀ (George & Liu 1981, sec. 4.2), so the widths of A are those of L. Rows with at
most NARROW sub-diagonals (a beam with single masses under it) are substituted with the last results held in registers.
"""

from collections.abc import Iterable

import numpy as np
from numba import njit

from railsearch_plugins.dynamics.beam import FloatArray, IntArray

BLOCK = 32
NARROW = 4

Elements = tuple[IntArray, FloatArray]


def assemble(elements: Iterable[Elements], size: int, half_bandwidth: int) -> FloatArray:
    """Sum element matrices into a symmetric banded matrix (b + 1, size), b = max(half_bandwidth, NARROW).

    elements: pairs of unknowns (m, p), −1 for one that is held, and matrices (m, p, p).
    """
    band = np.zeros((max(half_bandwidth, NARROW) + 1, size))
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


def block_widths(band: FloatArray) -> tuple[IntArray, IntArray]:
    """Sub-diagonals that the rows, and super-diagonals that the columns, of each block of the factor need."""
    width, size = band.shape[0] - 1, band.shape[1]
    rows = np.zeros(size, dtype=np.int64)
    for k in range(1, width + 1):
        rows[band[k] != 0.0] = k
    reach = np.arange(size) - rows
    columns = np.zeros(size, dtype=np.int64)
    for k in range(1, width + 1):
        inside = reach[k:] <= np.arange(size - k)
        columns[: size - k][inside] = k
    starts = np.arange(0, size, BLOCK)
    return np.maximum.reduceat(rows, starts), np.maximum.reduceat(columns, starts)


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
def forward_block(lower, width, start, stop, y):  # type: ignore[no-untyped-def]
    """L y = b for rows start…stop; y holds b on entry and the rows before `start` are done."""
    if width > NARROW:
        for i in range(start, stop):
            value = y[i]
            for k in range(min(width, i), 0, -1):
                value -= lower[k, i] * y[i - k]
            y[i] = value
        return
    y1 = y[start - 1] if start > 0 else 0.0
    y2 = y[start - 2] if start > 1 else 0.0
    y3 = y[start - 3] if start > 2 else 0.0
    y4 = y[start - 4] if start > 3 else 0.0
    for i in range(start, stop):
        value = y[i] - lower[4, i] * y4 - lower[3, i] * y3 - lower[2, i] * y2 - lower[1, i] * y1
        y4, y3, y2, y1 = y3, y2, y1, value
        y[i] = value


@njit(cache=True, fastmath={"contract"})
def backward_block(lower, width, start, stop, x):  # type: ignore[no-untyped-def]
    """Lᵀ x = D⁻¹ y for rows stop…start; x holds y on entry and the rows from `stop` on are done."""
    size = x.size
    if width > NARROW or stop + NARROW > size:
        for i in range(stop - 1, start - 1, -1):
            value = x[i] * lower[0, i]
            for k in range(min(width, size - 1 - i), 0, -1):
                value -= lower[k, i + k] * x[i + k]
            x[i] = value
        return
    x1, x2, x3, x4 = x[stop], x[stop + 1], x[stop + 2], x[stop + 3]
    for i in range(stop - 1, start - 1, -1):
        value = (
            x[i] * lower[0, i] - lower[4, i + 4] * x4 - lower[3, i + 3] * x3 - lower[2, i + 2] * x2 - lower[1, i + 1] * x1
        )
        x4, x3, x2, x1 = x3, x2, x1, value
        x[i] = value


@njit(cache=True, fastmath={"contract"})
def forward(lower, row_widths, y):  # type: ignore[no-untyped-def]
    """L y = b in place."""
    for block in range(row_widths.size):
        forward_block(lower, row_widths[block], block * BLOCK, min((block + 1) * BLOCK, y.size), y)


@njit(cache=True, fastmath={"contract"})
def backward(lower, column_widths, x):  # type: ignore[no-untyped-def]
    """Lᵀ x = D⁻¹ y in place."""
    for block in range(column_widths.size - 1, -1, -1):
        backward_block(lower, column_widths[block], block * BLOCK, min((block + 1) * BLOCK, x.size), x)


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
