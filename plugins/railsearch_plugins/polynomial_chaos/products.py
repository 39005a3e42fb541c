"""Sums of products of polynomials, and their derivatives by every factor.

| symbol | meaning | shape |
|---|---|---|
| v | table of all univariate polynomials at the points, the constant ones left out | (r, n) |
| o | order of a term, the number of its factors | scalar |
| f | rows of v that are the factors of the terms of one order | (o, m_o) |
| Y | Σ_terms c Π_j v[f_j] | (n,) |
| g | ∂Y/∂v | (r, n) |

Terms of two factors are a quadratic form of v. Those of a higher order are multiplied all at once; the derivative by a
factor is the product of the others, from products up to it and products after it, so that nothing is divided.
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
        self._constant = float(coefficients[orders == 0].sum())
        self._single = np.zeros(rows)
        self._pairs = np.zeros((rows, rows))
        (place,) = _factors(indices[orders == 1], offsets, 1)
        first, second = _factors(indices[orders == 2], offsets, 2)
        self._single[place] = coefficients[orders == 1]
        self._pairs[first, second] = self._pairs[second, first] = coefficients[orders == 2]
        self._orders = [
            _terms_of_order(indices[orders == order], offsets, coefficients[orders == order], order, rows)
            for order in sorted({int(order) for order in orders} - {0, 1, 2})
        ]

    def values(self, table: FloatArray) -> FloatArray:
        """Y (n,) of a table (r, n)."""
        total = self._low_orders(table, self._pairs @ table)
        for order in self._orders:
            product = table[order.factors[0]]
            for rows in order.factors[1:]:
                product *= table[rows]
            total += order.coefficients @ product
        return total

    def values_with_rates(self, table: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Y (n,) and g (r, n) of a table (r, n)."""
        rates = self._pairs @ table
        total = self._low_orders(table, rates)
        rates += self._single[:, None]
        for order in self._orders:
            factors = [table[rows] for rows in order.factors]
            before = [np.broadcast_to(order.coefficients[:, None], factors[0].shape)]
            for factor in factors:
                before.append(before[-1] * factor)
            total += before[-1].sum(axis=0)
            _add_rates(rates, order.sums, factors, before)
        return total, rates

    def _low_orders(self, table: FloatArray, paired: FloatArray) -> FloatArray:
        """The terms of up to two factors: a constant, a linear and a quadratic form, in which every pair stands twice."""
        return np.asarray(self._constant + self._single @ table + 0.5 * np.einsum("rn,rn->n", table, paired))


def _add_rates(rates: FloatArray, sums: tuple[csr_array, ...], factors: list[FloatArray], before: list[FloatArray]) -> None:
    """Add what the terms of one order have in ∂Y/∂v, from the last factor to the first."""
    after = None
    for place in reversed(range(len(factors))):
        rates += sums[place] @ (before[place] if after is None else before[place] * after)
        after = factors[place] if after is None else after * factors[place]


def _terms_of_order(indices: IndexArray, offsets: IndexArray, coefficients: FloatArray, order: int, rows: int) -> _Order:
    factors = _factors(indices, offsets, order)
    ones, terms = np.ones(len(indices)), np.arange(len(indices))
    sums = tuple(csr_array((ones, (places, terms)), shape=(rows, len(indices))) for places in factors)
    return _Order(factors, coefficients, sums)


def _factors(indices: IndexArray, offsets: IndexArray, order: int) -> IndexArray:
    """Rows of the table (order, m) of terms that all have so many factors."""
    term, variable = np.nonzero(indices)
    return (offsets[variable] + indices[term, variable]).reshape(len(indices), order).T
