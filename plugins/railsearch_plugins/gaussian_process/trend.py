"""Trends: the functions whose combination is the mean of a Gaussian process.

| symbol | meaning | shape | unit | source |
|---|---|---|---|---|
| x | points of the unit cube | (k, d) | - | |
| t | 2x − 1, which keeps the columns of F well apart from one another | (k, d) | - | |
| F | trend functions at points | (k, p) | - | Sacks et al. 1989 |
"""

from typing import Protocol

import numpy as np

from railsearch.space import FloatArray

DEGREES = {"constant": 0, "linear": 1, "quadratic": 2}


class Trend(Protocol):
    """Any basis of trend functions."""

    def values(self, points: FloatArray) -> FloatArray:
        """The p trend functions F (k, p) at points (k, d)."""

    def gradient(self, points: FloatArray) -> FloatArray:
        """Their derivatives (k, d, p) at points (k, d)."""


class PolynomialTrend:
    """All monomials in t = 2x − 1 up to degree 0, 1 or 2."""

    def __init__(self, degree: int) -> None:
        self._degree = degree

    def values(self, points: FloatArray) -> FloatArray:
        """1; t_i; t_i t_j with i ≤ j: (k, p) at points (k, d)."""
        t = 2.0 * points - 1.0
        first, second = np.triu_indices(points.shape[1])
        blocks = [np.ones((len(t), 1)), t, t[:, first] * t[:, second]]
        return np.hstack(blocks[: self._degree + 1])

    def gradient(self, points: FloatArray) -> FloatArray:
        """Derivatives (k, d, p) with respect to x at points (k, d)."""
        t, dimension = 2.0 * points - 1.0, points.shape[1]
        axes = np.arange(dimension)
        first, second = np.triu_indices(dimension)
        slopes = np.zeros((len(t), dimension, 1 + dimension + len(first)))
        slopes[:, axes, 1 + axes] = 2.0
        mixed = 1 + dimension + np.arange(len(first))
        slopes[:, first, mixed] += 2.0 * t[:, second]
        slopes[:, second, mixed] += 2.0 * t[:, first]
        sizes = (1, 1 + dimension, slopes.shape[2])
        return slopes[:, :, : sizes[self._degree]]
