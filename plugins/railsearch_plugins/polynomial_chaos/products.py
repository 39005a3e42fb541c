"""Sums of products of polynomials, and their derivatives by every factor.

| symbol | meaning | shape |
|---|---|---|
| v | table of all univariate polynomials at the points, the constant ones left out | (r, n) |
| o | order of a term, the number of its factors | scalar |
| f | rows of v that are the factors of the terms of one order | (m_o, o) |
| Y | Σ_terms c Π_j v[f_j] | (n,) |
| g | ∂Y/∂v | (r, n) |

Terms of an order are multiplied all at once; the derivative by a factor is the product of the others, from products up
to it and products after it, so that nothing is divided.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from railsearch.space import FloatArray

from .multi_indices import IndexArray


@dataclass(frozen=True)
class _Order:
    """The terms of one order: factors (o, m), coefficients (m,), and for each place the sums over terms by factor (r, m)."""

    factors: IndexArray
    coefficients: FloatArray
    sums: tuple[csr_array, ...]


class Products:
    """Terms of multi-indices (m, d) with coefficients (m,); row offsets_i + k of the table is degree k of input i."""

    def __init__(self, indices: IndexArray, offsets: IndexArray, coefficients: FloatArray, rows: int) -> None:
        orders = (indices > 0).sum(axis=1)
        self._rows = rows
        self._constant = float(coefficients[orders == 0].sum())
        self._orders = [
            _terms_of_order(indices[orders == order], offsets, coefficients[orders == order], rows)
            for order in sorted({int(order) for order in orders} - {0})
        ]

    def values(self, table: FloatArray) -> FloatArray:
        """Y (n,) of a table (r, n)."""
        total = np.full(table.shape[1], self._constant)
        for order in self._orders:
            product = table[order.factors[0]]
            for rows in order.factors[1:]:
                product *= table[rows]
            total += order.coefficients @ product
        return total

    def values_with_rates(self, table: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Y (n,) and g (r, n) of a table (r, n)."""
        total, rates = np.full(table.shape[1], self._constant), np.zeros((self._rows, table.shape[1]))
        for order in self._orders:
            factors = [table[rows] for rows in order.factors]
            before = [np.broadcast_to(order.coefficients[:, None], factors[0].shape)]
            for factor in factors:
                before.append(before[-1] * factor)
            total += before[-1].sum(axis=0)
            _add_rates(rates, order.sums, factors, before)
        return total, rates


def _add_rates(rates: FloatArray, sums: tuple[csr_array, ...], factors: list[FloatArray], before: list[FloatArray]) -> None:
    """Add what the terms of one order have in ∂Y/∂v, from the last factor to the first."""
    after = None
    for place in reversed(range(len(factors))):
        rates += sums[place] @ (before[place] if after is None else before[place] * after)
        after = factors[place] if after is None else after * factors[place]


def _terms_of_order(indices: IndexArray, offsets: IndexArray, coefficients: FloatArray, rows: int) -> _Order:
    term, variable = np.nonzero(indices)
    order = len(term) // len(indices)
    factors = (offsets[variable] + indices[term, variable]).reshape(len(indices), order).T
    ones, terms = np.ones(len(indices)), np.arange(len(indices))
    sums = tuple(csr_array((ones, (places, terms)), shape=(rows, len(indices))) for places in factors)
    return _Order(factors, coefficients, sums)
