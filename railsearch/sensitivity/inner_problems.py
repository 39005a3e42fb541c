"""The inner problems of the method: all factors but one at a time, on the unit box.

| symbol | meaning | shape |
|---|---|---|
| R | number of problems, Σ n_i | scalar |
| r | problem: factor i held at its grid value j, the problems of a factor next to one another | - |
| u | point of the unit box | (d,) |
"""

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from railsearch.sampling import sobol_points
from railsearch.space import FloatArray

from .factors import Factors

Rows = NDArray[np.intp]

STRETCH = 2.0
"""Every second sampled point is moved away from the centre by this factor and back to the bounds, where extremes are."""


class InnerProblems:
    """The problems of factors with grids: which coordinate is held, and at what."""

    def __init__(self, factors: Factors) -> None:
        self._factors = factors

    @cached_property
    def factor(self) -> Rows:
        """The factor (R,) that is held."""
        return np.repeat(np.arange(self._factors.dimension), self.numbers)

    @cached_property
    def held_at(self) -> FloatArray:
        """The value u_i (R,) at which it is held."""
        space = self._factors.space
        grids = zip(self._factors.grids, space.lower, space.upper, strict=True)
        return np.concatenate([(grid - low) / (high - low) for grid, low, high in grids])

    @property
    def numbers(self) -> list[int]:
        """n (d,)."""
        return [len(grid) for grid in self._factors.grids]

    @property
    def number(self) -> int:
        """R."""
        return len(self.factor)

    def held(self, points: FloatArray, rows: Rows) -> FloatArray:
        """The points (k, d) with the coordinates that the problems `rows` (k,) hold."""
        moved = points.copy()
        moved[np.arange(len(rows)), self.factor[rows]] = self.held_at[rows]
        return moved

    def boxes(self, rows: Rows) -> tuple[FloatArray, FloatArray]:
        """Lower and upper bounds (k, d) of the problems `rows` (k,)."""
        shape = (len(rows), self._factors.dimension)
        return self.held(np.zeros(shape), rows), self.held(np.ones(shape), rows)

    def neighbours(self, changed: NDArray[np.bool_]) -> tuple[Rows, Rows]:
        """Problems beside the changed ones (R,) on the same curve, and the changed one beside each, (k,) and (k,)."""
        together = self.factor[1:] == self.factor[:-1]
        upwards = np.flatnonzero(together & changed[:-1])
        downwards = np.flatnonzero(together & changed[1:])
        return np.concatenate([upwards + 1, downwards]), np.concatenate([upwards, downwards + 1])

    def sampled(self, count: int, generator: np.random.Generator) -> FloatArray:
        """Points (R, count, d) in the boxes of all problems, spread evenly: scrambled Sobol' points by factor."""
        return np.concatenate([self._sampled(i, count, generator) for i in range(self._factors.dimension)])

    def split(self, values: FloatArray) -> tuple[FloatArray, ...]:
        """Values (R, …) by factor."""
        return tuple(np.split(values, np.cumsum(self.numbers)[:-1]))

    def _sampled(self, factor: int, count: int, generator: np.random.Generator) -> FloatArray:
        number = self.numbers[factor]
        points = sobol_points(number * count, self._factors.dimension, generator)
        # Sorted by the coordinate that is held, each run of `count` points fills the box of one grid value evenly.
        points = points[np.argsort(points[:, factor], kind="stable")].reshape(number, count, -1)
        points[:, 1::2] = np.clip(0.5 + STRETCH * (points[:, 1::2] - 0.5), 0.0, 1.0)
        first = sum(self.numbers[:factor])
        points[:, :, factor] = self.held_at[first : first + number, None]
        return points
