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
        degrees = self.indices.T
        columns = zip(self.families, points.T, degrees, strict=True)
        tables = [family.values_and_slopes(x, int(own.max())) for family, x, own in columns]
        gradient = np.zeros((len(points), *degrees.shape))
        for i, (_, slopes) in enumerate(tables):
            present = np.flatnonzero(degrees[i])
            rates = slopes[degrees[i, present]]
            for j in set(range(len(tables))) - {i}:
                both = np.flatnonzero(degrees[j, present])
                rates[both] *= tables[j][0][degrees[j, present[both]]]
            gradient[:, i, present] = rates.T
        return gradient
