"""Symmetric matrices in envelope storage, for tracks whose band is too wide for the kernels of `banded`.

symbol  meaning                                                        shape     unit    source
A       symmetric positive definite matrix                             (n, n)    N/m
f       first column with an entry in each row of the lower triangle   (n,)      -       George & Liu (1981), sec. 4.2
o       where each row starts in the values, A[i, j] at o_i + j − f_i  (n + 1,)  -
L, D    A = L D Lᵀ with the envelope of A; 1/D stands on the diagonal  (o_n,)    -
p, q    rows and columns of entries of the lower triangle              (m,)      -

A row is substituted by a dot product, its transpose by a multiple of it: both run along memory, and L is kept once. The rows
of a long and narrow track numbered along it are short, and elimination trees of other orderings gain little on it.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from railsearch_plugins.dynamics.beam import FloatArray, IntArray
from railsearch_plugins.dynamics.kernels import doubled

# Rows whose entries are looked at together where a column of the inverse is cut off, and where that is (see `kernels`).
BLOCK = 64
NEGLIGIBLE = 1e-9

FAST = {"contract", "reassoc"}


class Envelope(NamedTuple):
    """f (n,) and o (n + 1,) of a pattern."""

    first: IntArray
    offset: IntArray


class Columns(NamedTuple):
    """Columns A⁻¹ e_k by place: k → place (n,), first row (r,), where each starts in the values (r + 1,), the values."""

    place: IntArray
    first: IntArray
    offset: IntArray
    values: FloatArray


def envelope_of(rows: IntArray, columns: IntArray, size: int) -> Envelope:
    """The envelope of a lower triangle with entries at p (m,), q (m,); the diagonal belongs to it."""
    first = np.arange(size)
    np.minimum.at(first, rows, columns)
    return Envelope(first, np.concatenate([[0], np.cumsum(np.arange(size) - first + 1)]))


def in_envelope(envelope: Envelope, rows: IntArray, columns: IntArray, values: FloatArray) -> FloatArray:
    """The values (o_n,) of a matrix with `values` (m,) at p (m,), q (m,) of its lower triangle, each place named once."""
    stored = np.zeros(int(envelope.offset[-1]))
    stored[envelope.offset[rows] + columns - envelope.first[rows]] = values
    return stored


@njit(cache=True, fastmath=FAST)
def factorise(first, offset, values):  # type: ignore[no-untyped-def]
    """LDLᵀ (o_n,), 1/D on the diagonal, and the first row whose pivot is not positive, −1 if all are."""
    size = first.size
    lower, inverse = values.copy(), np.empty(size)
    for i in range(size):
        row = lower[offset[i] : offset[i + 1]]
        for j in range(first[i], i):
            begin = max(first[i], first[j])
            other = lower[offset[j] + begin - first[j] : offset[j + 1] - 1]
            here = row[begin - first[i] : j - first[i]]
            total = 0.0
            for m in range(here.size):
                total += here[m] * other[m]
            row[j - first[i]] -= total
        pivot = row[-1]
        for m in range(row.size - 1):
            value = row[m] * inverse[first[i] + m]
            pivot -= row[m] * value
            row[m] = value
        if not pivot > 0.0:
            return lower, i
        inverse[i] = 1.0 / pivot
        row[-1] = inverse[i]
    return lower, -1


@njit(cache=True, fastmath=FAST)
def solve(first, offset, lower, x):  # type: ignore[no-untyped-def]
    """A⁻¹ x in place."""
    for i in range(x.size):
        row, here, total = lower[offset[i] : offset[i + 1] - 1], x[first[i] : i], 0.0
        for m in range(row.size):
            total += row[m] * here[m]
        x[i] -= total
    for i in range(x.size):
        x[i] *= lower[offset[i + 1] - 1]
    for i in range(x.size - 1, 0, -1):
        row, here, value = lower[offset[i] : offset[i + 1] - 1], x[first[i] : i], x[i]
        for m in range(row.size):
            here[m] -= row[m] * value


@njit(cache=True, fastmath=FAST)
def _forward_column(first, offset, lower, k, x):  # type: ignore[no-untyped-def]
    """x = D⁻¹ L⁻¹ e_k from row k to where it has decayed; returns one past its last row."""
    x[k], stop, largest = 1.0, k, 0.0
    while stop < x.size:
        begin, stop, block = stop, min(stop + BLOCK, x.size), 0.0
        for i in range(max(begin, k + 1), stop):
            start, total = max(first[i], k), 0.0
            row, here = lower[offset[i] + start - first[i] : offset[i + 1] - 1], x[start:i]
            for m in range(row.size):
                total += row[m] * here[m]
            x[i] = -total
        for i in range(begin, stop):
            block = max(block, abs(x[i] * lower[offset[i + 1] - 1]))
        largest = max(largest, block)
        if block <= NEGLIGIBLE * largest:
            break
    for i in range(k, stop):
        x[i] *= lower[offset[i + 1] - 1]
    return stop


@njit(cache=True, fastmath=FAST)
def _backward_column(first, offset, lower, k, stop, x):  # type: ignore[no-untyped-def]
    """x = A⁻¹ e_k of `_forward_column`'s result, down to where it has decayed: that row, and the last one touched."""
    start, largest, touched = stop, 0.0, k
    while start > 0:
        end, start, block = start, max(start - BLOCK, 0), 0.0
        for i in range(end - 1, start - 1, -1):
            value, block, touched = x[i], max(block, abs(x[i])), min(touched, first[i])
            row, here = lower[offset[i] : offset[i + 1] - 1], x[first[i] : i]
            for m in range(row.size):
                here[m] -= row[m] * value
        largest = max(largest, block)
        if start < k and block <= NEGLIGIBLE * largest:
            break
    return start, touched


@njit(cache=True)
def inverse_columns(first, offset, lower, unknowns):  # type: ignore[no-untyped-def]
    """The fields of `Columns` for some unknowns k (r,), each column cut off where it has decayed."""
    size = first.size
    place, begins = np.zeros(size, dtype=np.int64), np.zeros(unknowns.size, dtype=np.int64)
    starts = np.zeros(unknowns.size + 1, dtype=np.int64)
    values, x = np.empty(256 * unknowns.size), np.zeros(size)
    for c in range(unknowns.size):
        stop = _forward_column(first, offset, lower, unknowns[c], x)
        start, touched = _backward_column(first, offset, lower, unknowns[c], stop, x)
        place[unknowns[c]], begins[c] = c, start
        starts[c + 1] = starts[c] + stop - start
        while starts[c + 1] > values.size:
            values = doubled(values)
        for i in range(start, stop):
            values[starts[c] + i - start] = x[i]
        x[min(touched, start) : stop] = 0.0
    return place, begins, starts, values[: starts[-1]].copy()


@njit(cache=True, fastmath=FAST)
def add_products(rows, columns, first, second, x, z, y):  # type: ignore[no-untyped-def]
    """y += A x + B z for two symmetric matrices by their values (m,) at p, q of the lower triangle."""
    for m in range(rows.size):
        i, j = rows[m], columns[m]
        y[i] += first[m] * x[j] + second[m] * z[j]
        if i != j:
            y[j] += first[m] * x[i] + second[m] * z[i]
