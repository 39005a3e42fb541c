"""Coordinates of random inputs in which a stationary process lives: those of their polynomials, over the range of the data.

| symbol | meaning | shape | unit |
|---|---|---|---|
| x | inputs | (n, d) | theirs |
| t | coordinates of the polynomials, see families.py | (n, d) | - |
| z | (t − lower)/span, from 0 to 1 over the data | (n, d) | - |
"""

from dataclasses import dataclass

import numpy as np

from railsearch.distributions import RandomVector, random_vector
from railsearch.errors import InputError
from railsearch.space import FloatArray

from .families import Family


@dataclass(frozen=True)
class Coordinates:
    """The map from inputs x to z; lower and span (d,) are of t."""

    families: tuple[Family, ...]
    lower: FloatArray
    span: FloatArray

    @property
    def polynomials(self) -> tuple[Family, ...]:
        """The polynomials of the inputs as functions of z."""
        columns = zip(self.families, self.lower, self.span, strict=True)
        return tuple(family.over(float(low), float(width)) for family, low, width in columns)

    def placed(self, points: FloatArray) -> FloatArray:
        """Points z (n, d) of inputs x (n, d)."""
        return (_coordinates(self.families, points) - self.lower) / self.span

    def pulled_back(self, slopes: FloatArray, points: FloatArray) -> FloatArray:
        """Derivatives (n, d) by x from those by z."""
        columns = zip(self.families, points.T, strict=True)
        return slopes * np.column_stack([family.slope(x) for family, x in columns]) / self.span


def coordinates_over(families: tuple[Family, ...], points: FloatArray) -> Coordinates:
    """The coordinates whose z go from 0 to 1 over the points (n, d); the width of an input without a range is 1."""
    t = _coordinates(families, points)
    span = np.ptp(t, axis=0)
    return Coordinates(families, t.min(axis=0), np.where(span > 0.0, span, 1.0))


def plain_coordinates(points: FloatArray) -> Coordinates:
    """The same of inputs as they are, t = x."""
    return coordinates_over((_PLAIN,) * points.shape[1], points)


def unit_cube(dimension: int) -> RandomVector:
    """The random vector of a search, uniform on the unit cube. Raises InputError for a dimension below 1."""
    if dimension < 1:
        raise InputError(f"a surrogate needs a dimension of 1 or more, received {dimension}")
    uniform = {"distribution": "uniform", "lower": 0.0, "upper": 1.0}
    return random_vector({f"u{k + 1}": uniform for k in range(dimension)})


_PLAIN = Family("the input itself", np.asarray, np.ones_like, np.zeros(1), np.arange(2.0))


def _coordinates(families: tuple[Family, ...], points: FloatArray) -> FloatArray:
    return np.column_stack([family.coordinate(x) for family, x in zip(families, points.T, strict=True)])
