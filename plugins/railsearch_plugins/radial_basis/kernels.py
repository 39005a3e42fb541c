"""Kernels of radial basis functions and the tails they need.

| symbol | meaning | shape | unit | source |
|---|---|---|---|---|
| r | distances | any | - | |
| φ | kernel | of r | - | Powell 1992 |
| s | sign: s φ is conditionally positive definite of the order of the tail | ±1 | - | Wendland 2005 |
| P | tail basis at the points, rows [xᵀ 1], or [1] for the linear kernel | (n, m) | - | Powell 1992 |
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import qr

from railsearch.errors import SurrogateError
from railsearch.space import FloatArray

UNISOLVENCE_TOLERANCE = 1e-8
"""Diagonal entries of the pivoted triangular factor of P below this fraction of the first count as zero."""


@dataclass(frozen=True)
class Kernel:
    """φ(r), its slope φ′(r)/r with kinks at zero, its sign s and whether its tail is linear (or else constant)."""

    value: Callable[[FloatArray], FloatArray]
    slope: Callable[[FloatArray], FloatArray]
    sign: float
    linear_tail: bool

    def tail_size(self, dimension: int) -> int:
        """The number m of tail functions."""
        return dimension + 1 if self.linear_tail else 1

    def tail(self, points: FloatArray) -> FloatArray:
        """The tail basis P (n, m) at points (n, d)."""
        ones = np.ones((len(points), 1))
        return np.hstack([points, ones]) if self.linear_tail else ones


def unisolvent_first(tail: FloatArray) -> NDArray[np.intp]:
    """An order of the points whose first m determine the tail P (n, m). Raises SurrogateError if none do."""
    m = tail.shape[1]
    triangle, order = qr(tail.T, mode="r", pivoting=True) if len(tail) else (np.empty((m, 0)), np.empty(0, dtype=int))
    pivots = np.abs(np.diagonal(triangle))
    rank = int(np.sum(pivots > UNISOLVENCE_TOLERANCE * pivots[:1]))
    if rank < m:
        raise SurrogateError(
            f"rbf: {m} affinely independent points are needed to determine the tail, received {len(tail)} points of rank "
            f"{rank}: add {m - rank} or more points off their common hyperplane"
        )
    return np.concatenate([order[:m], np.sort(order[m:])])


def _cubic(distances: FloatArray) -> FloatArray:
    return distances * distances * distances


def _cubic_slope(distances: FloatArray) -> FloatArray:
    return 3.0 * distances


def _thin_plate(distances: FloatArray) -> FloatArray:
    return distances * distances * _logarithm(distances)


def _thin_plate_slope(distances: FloatArray) -> FloatArray:
    return np.where(distances > 0.0, 2.0 * _logarithm(distances) + 1.0, 0.0)


def _linear(distances: FloatArray) -> FloatArray:
    return distances


def _linear_slope(distances: FloatArray) -> FloatArray:
    return np.divide(1.0, distances, out=np.zeros_like(distances), where=distances > 0.0)


def _logarithm(distances: FloatArray) -> FloatArray:
    """log r, and 0 at r = 0."""
    logarithm: FloatArray = np.log(distances, out=np.zeros_like(distances), where=distances > 0.0)
    return logarithm


KERNELS = {
    "cubic": Kernel(_cubic, _cubic_slope, sign=1.0, linear_tail=True),
    "thin-plate": Kernel(_thin_plate, _thin_plate_slope, sign=1.0, linear_tail=True),
    "linear": Kernel(_linear, _linear_slope, sign=-1.0, linear_tail=False),
}
