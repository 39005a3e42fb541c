"""The terms of an expansion as the trend of a Gaussian process.

| symbol | meaning | shape | source |
|---|---|---|---|
| z | points in the coordinates of the process | (k, d) | |
| α | multi-indices of the terms | (p, d) | |
| F | Π_i ψ_{i,α_i}(z_i), trend functions at points | (k, p) | Schöbi et al. 2015, Eq. 10 |
"""

from dataclasses import dataclass

import numpy as np

from railsearch.space import FloatArray

from ..polynomial_chaos.expansion import design_matrix
from ..polynomial_chaos.families import Family
from ..polynomial_chaos.multi_indices import IndexArray


@dataclass(frozen=True)
class ExpansionTrend:
    """The terms of multi-indices (p, d) in polynomials of d families."""

    families: tuple[Family, ...]
    indices: IndexArray

    def values(self, points: FloatArray) -> FloatArray:
        """F (k, p) at points (k, d)."""
        return design_matrix(self.families, self.indices, points)

    def gradient(self, points: FloatArray) -> FloatArray:
        """Derivatives (k, d, p) of F at points (k, d): by an input, the product of its slope and the others' values."""
        factors, slopes = self._factors(points)
        gradient = np.zeros((len(points), len(factors), len(self.indices)))
        for i, present in enumerate(self.indices.T > 0):
            rates = slopes[i][:, present]
            for j, values in enumerate(factors):
                if j != i:
                    rates = rates * values[:, present]
            gradient[:, i, present] = rates
        return gradient

    def _factors(self, points: FloatArray) -> tuple[list[FloatArray], list[FloatArray]]:
        """By input, the univariate polynomials of all terms and their slopes, (k, p) each."""
        factors, slopes = [], []
        for family, x, degrees in zip(self.families, points.T, self.indices.T, strict=True):
            values, rates = family.values_and_slopes(x, int(degrees.max()))
            factors.append(values[degrees].T)
            slopes.append(rates[degrees].T)
        return factors, slopes
