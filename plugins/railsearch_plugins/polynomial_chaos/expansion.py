"""An expansion in orthonormal polynomials: values, gradient, moments and Sobol' indices.

| symbol | meaning | shape |
|---|---|---|
| d, n, m | number of inputs, of points, of terms | scalar |
| α | multi-index of a term, degrees by input | (m, d) |
| c | coefficients | (m,) |
| ψ_{i,k} | polynomial of degree k of input i | |
| Y | Σ_α c_α Π_i ψ_{i,α_i}(x_i) | |
| S_u, T_i | Sobol' index of a set u of inputs, total index of an input | |

Since the terms are orthonormal: E[Y] = c_0, Var[Y] = Σ_{α ≠ 0} c_α², and the part of the variance that a set u of inputs
has together is Σ c_α² over the terms in which just these inputs occur (Sudret 2008, Eq. 28 to 36).
"""

import itertools
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from railsearch.space import FloatArray

from .families import Family
from .multi_indices import IndexArray
from .products import Products

BLOCK = 1024
"""Points evaluated at a time, so that the products of a block stay in the cache."""


@dataclass(frozen=True)
class Expansion:
    """Y = Σ_α c_α Ψ_α(X): families (d,), multi-indices (m, d) and coefficients (m,)."""

    families: tuple[Family, ...]
    indices: IndexArray
    coefficients: FloatArray

    def predict(self, points: FloatArray) -> FloatArray:
        """Y (n,) at points (n, d)."""
        points = np.asarray(points, dtype=float)
        parts = [self._products.values(self._table(block)) for block in _blocks(points)]
        return np.concatenate([np.empty(0), *parts])

    def gradient(self, points: FloatArray) -> FloatArray:
        """Derivatives of Y (n, d) at points (n, d)."""
        return self.predict_with_gradient(points)[1]

    def predict_with_gradient(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Y (n,) and its derivatives (n, d) at points (n, d)."""
        points = np.asarray(points, dtype=float)
        values, gradient = np.empty(len(points)), np.empty(points.shape)
        for start in range(0, len(points), BLOCK):
            block = slice(start, start + BLOCK)
            table, slopes = self._table_with_slopes(points[block])
            values[block], rates = self._products.values_with_rates(table)
            for i, rows in enumerate(self._rows):
                gradient[block, i] = np.einsum("rn,rn->n", rates[rows], slopes[rows])
        return values, gradient

    @property
    def mean(self) -> float:
        """E[Y]."""
        return float(self.coefficients[~self.indices.any(axis=1)].sum())

    @property
    def variance(self) -> float:
        """Var[Y]."""
        return float(np.sum(self.coefficients[self.indices.any(axis=1)] ** 2))

    @property
    def first_order_indices(self) -> FloatArray:
        """S_i (d,): the part of the variance that an input has alone."""
        return np.array([self.sobol_index([i]) for i in range(self.indices.shape[1])])

    @property
    def total_indices(self) -> FloatArray:
        """T_i (d,): the part of the variance in which an input takes part."""
        return np.array([self._share(self.indices[:, i] > 0) for i in range(self.indices.shape[1])])

    def sobol_index(self, inputs: Collection[int]) -> float:
        """S_u: the part of the variance that the inputs (by number) have all together and no fewer of them."""
        inside = np.isin(np.arange(self.indices.shape[1]), list(inputs))
        return self._share(np.all((self.indices > 0) == inside, axis=1) & self.indices.any(axis=1))

    def closed_index(self, inputs: Collection[int]) -> float:
        """Var(E[Y | X_u])/Var(Y): the part of the variance that the inputs and all sets of them have."""
        inside = np.isin(np.arange(self.indices.shape[1]), list(inputs))
        present = self.indices > 0
        return self._share((present.sum(axis=1) > 0) & (present[:, ~inside].sum(axis=1) == 0))

    def _share(self, terms: NDArray[np.bool_]) -> float:
        """Σ c² of the terms as a fraction of the variance; 0 of a constant."""
        return float(np.sum(self.coefficients[terms] ** 2)) / self.variance if self.variance > 0.0 else 0.0

    @cached_property
    def _degrees(self) -> tuple[int, ...]:
        return tuple(int(k) for k in self.indices.max(axis=0))

    @cached_property
    def _rows(self) -> tuple[slice, ...]:
        """Where the polynomials of degree 1 and more of an input stand in the table."""
        ends = np.concatenate([[0], np.cumsum(self._degrees)])
        return tuple(slice(int(low), int(high)) for low, high in itertools.pairwise(ends))

    @cached_property
    def _products(self) -> Products:
        offsets = np.array([rows.start - 1 for rows in self._rows])
        return Products(self.indices, offsets, self.coefficients, sum(self._degrees))

    def _table(self, points: FloatArray) -> FloatArray:
        """ψ_{i,k} (Σ degrees, n), k ≥ 1."""
        columns = zip(self.families, points.T, self._degrees, strict=True)
        return np.concatenate([family.values(x, degree)[1:] for family, x, degree in columns])

    def _table_with_slopes(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        columns = zip(self.families, points.T, self._degrees, strict=True)
        pairs = [family.values_and_slopes(x, degree) for family, x, degree in columns]
        return np.concatenate([values[1:] for values, _ in pairs]), np.concatenate([slopes[1:] for _, slopes in pairs])


def design_matrix(families: Sequence[Family], indices: IndexArray, points: FloatArray) -> FloatArray:
    """Ψ (n, m) of multi-indices (m, d) at points (n, d), in columns."""
    matrix = np.ones((len(points), len(indices)), order="F")
    for family, x, degrees in zip(families, points.T, indices.T, strict=True):
        present = np.flatnonzero(degrees)
        if len(present):
            values = family.values(x, int(degrees.max()))
            matrix[:, present] *= values[degrees[present]].T
    return matrix


def _blocks(points: FloatArray) -> list[FloatArray]:
    return [points[start : start + BLOCK] for start in range(0, len(points), BLOCK)]
