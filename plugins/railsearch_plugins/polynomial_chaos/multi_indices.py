"""Sets of multi-indices: which products of univariate polynomials an expansion may have.

| symbol | meaning | shape | source |
|---|---|---|---|
| d | number of inputs | scalar | |
| α | multi-index, degrees by input | (d,) | |
| q | exponent of the norm, 0 < q ≤ 1; the smaller, the fewer interactions | scalar | Blatman & Sudret 2011, Eq. 12 |
| ‖α‖_q | (Σ α_i^q)^(1/q) | scalar | Blatman & Sudret 2011, Eq. 12 |
| p | largest norm in the set | scalar | |
"""

import numpy as np
from numpy.typing import NDArray

from railsearch.space import FloatArray

IndexArray = NDArray[np.int64]

ROUNDING = 1e-10
"""Norms that exceed p by this fraction are rounding: (3^0.5)² is above 3."""


def q_norms(indices: IndexArray, q: float) -> FloatArray:
    """‖α‖_q (m,) of multi-indices (m, d)."""
    return np.asarray((indices.astype(float) ** q).sum(axis=1) ** (1.0 / q))


def hyperbolic_set(dimension: int, degree: int, q: float, limit: int) -> IndexArray | None:
    """All α (m, d) with ‖α‖_q ≤ p by growing norm, the constant first; None if there are more than `limit`.

    Source: Blatman & Sudret 2011, Eq. 13.
    """
    degrees = np.arange(degree + 1)
    costs, budget = degrees.astype(float) ** q, float(degree) ** q * (1.0 + ROUNDING * q)
    indices, spent = np.empty((1, 0), dtype=np.int64), np.zeros(1)
    for _ in range(dimension):
        row, last = np.nonzero(spent[:, None] + costs <= budget)
        if len(row) > limit:
            return None
        indices, spent = np.column_stack([indices[row], last]), spent[row] + costs[last]
    return indices[_order(indices, q)]


def _order(indices: IndexArray, q: float) -> NDArray[np.intp]:
    """By norm, then by total degree, then by the degrees of the first inputs, falling."""
    norms = np.round(q_norms(indices, q), 8)
    return np.lexsort((*-indices.T[::-1], indices.sum(axis=1), norms))
