"""What Newmark's step knows of a track before it is taken, carried from step to step by a product with the mass alone.

symbol   meaning                                                     shape        unit
M, C, K  track matrices by lower diagonals                           (b + 1, n)   kg, …
A        4 M/dt² + 2 C/dt + K                                        (b + 1, n)   N/m
h        half the increment of displacement: A h = g + f̄             (n,)         m
f̄        mean of the loads at start and end of the step              (n,)         N
g        (2/dt) M v − K u at the start                               (n,)         N
α, β     C = α M + β K + discrete dampers, by unknown                (n,)         1/s, s
S        β/(1 + 2 β/dt)                                              (n,)         s
e        α − (4/dt² + 2 α/dt) S                                      (n,)         1/s
s        (4/dt) S − 1                                                (n,)         -
B, D     (4/dt) M and (4/dt)(C − S A − M e)                          (b + 1, n)   N s/m, N/m

With v_{n+1} = 4 h/dt − v_n and K h eliminated by A h = g_n + f̄, the step leaves

    g_{n+1} = (4/dt)(M v_{n+1} + C h) − g_n − 2 f̄ = B (v_{n+1} + e h) + D h + s g_n + (s − 1) f̄

without rounding's loss, because (v, g) is as good a state as (v, u). K is not needed, and C no further than Rayleigh's: D
has entries where discrete springs and dampers are, few and held as single ones. It is not symmetric. Whatever α and β are
given, D makes up for them; they only make it sparse.
"""

from typing import NamedTuple

import numpy as np

from railsearch_plugins.dynamics.beam import FloatArray, IntArray
from railsearch_plugins.dynamics.kernels import BLOCK, MIDDLE, NARROW

# Entries of (dt/4) A, and so of D, relative to the diagonal that are rounding.
ROUNDING = 1e-15


class Recursion(NamedTuple):
    """How g is carried on: rows in blocks (r, (2b + 3) BLOCK) as `kernels.next_known` wants them, with their widths (r,);
    e, s (n,); pairs (p, 2) of unknowns i > j and D[i, j], D[j, i] (p, 2).
    """

    blocks: FloatArray
    widths: IntArray
    proportional: FloatArray
    retained: FloatArray
    pairs: IntArray
    couplings: FloatArray


def recursion(
    mass: FloatArray, damping: FloatArray, newmark: FloatArray, rayleigh: FloatArray | None, time_step: float
) -> Recursion:
    """The recursion for M, C and A (b + 1, n); rayleigh: α and β (2, n), or none."""
    rate, size = 4.0 / time_step, mass.shape[1]
    alpha, beta = np.zeros((2, size)) if rayleigh is None else rayleigh
    stiff = beta / (1.0 + 0.5 * rate * beta)
    proportional = alpha - (0.25 * rate**2 + 0.5 * rate * alpha) * stiff
    scale = np.sqrt(newmark[0])
    pairs, couplings = [], []
    for k in range(1, min(mass.shape)):
        here, there = slice(k, None), slice(None, -k)
        matrices = mass[k, here], damping[k, here], newmark[k, here]
        noise = ROUNDING / rate * scale[here] * scale[there]
        lower = _remainder(*matrices, stiff[here], proportional[there], noise)
        upper = _remainder(*matrices, stiff[there], proportional[here], noise)
        rows = np.flatnonzero((lower != 0.0) | (upper != 0.0))
        pairs.append(np.stack([rows + k, rows], axis=1))
        couplings.append(np.stack([lower[rows], upper[rows]], axis=1))
    diagonal = damping[0] - stiff * newmark[0] - mass[0] * proportional
    retained = rate * stiff - 1.0
    together = np.concatenate([np.empty((0, 2), dtype=np.int64), *pairs])
    order = np.argsort(together[:, 0], kind="stable")
    return Recursion(
        *_row_blocks(rate * mass, rate * diagonal, retained),
        proportional,
        retained,
        together[order],
        rate * np.concatenate([np.empty((0, 2)), *couplings])[order],
    )


def _remainder(
    m: FloatArray, c: FloatArray, a: FloatArray, stiff: FloatArray, proportional: FloatArray, noise: FloatArray
) -> FloatArray:
    """C − S A − M e, zero where it is no more than the rounding of A."""
    remainder = c - stiff * a - m * proportional
    return np.where(np.abs(remainder) <= noise, 0.0, remainder)


def _row_blocks(band: FloatArray, diagonal: FloatArray, retained: FloatArray) -> tuple[FloatArray, IntArray]:
    """Blocks of rows with `retained`, `diagonal` and all diagonals of a symmetric matrix, and the diagonals on a side."""
    size, count = band.shape[1], -(-band.shape[1] // BLOCK)
    used = [k for k in range(1, min(band.shape)) if band[k].any()]
    most = max([MIDDLE, *used])
    rows = np.zeros((2 * most + 3, count * BLOCK))
    rows[0, :size], rows[1, :size], rows[2, :size] = retained, diagonal, band[0]
    widths = np.full(count, NARROW)
    for k in used:
        rows[2 * k + 1, k:size], rows[2 * k + 2, : size - k] = band[k, k:], band[k, k:]
        filled = (rows[2 * k + 1] != 0.0) | (rows[2 * k + 2] != 0.0)
        if k > NARROW:
            widths[filled.reshape(count, BLOCK).any(axis=1)] = max(MIDDLE, k)
    return np.ascontiguousarray(rows.reshape(-1, count, BLOCK).swapaxes(0, 1).reshape(count, -1)), widths
