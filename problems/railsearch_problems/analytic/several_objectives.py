"""Analytic problems of two and three objectives with stated fronts; z, p and d as in function.py.

| symbol | meaning | shape |
|---|---|---|
| m | objectives | - |
| t | the first m − 1 variables, real ones, from 0 at the lower to 1 at the upper bound: the place on the front | (m − 1,) |
| g | distance from the front, 9 Σ z_i²/Σ max z_i² over the other variables: 0 on the front, 9 in the farthest corner | - |

| problem | the front, at g = 0 | after |
|---|---|---|
| two-spheres | √f_1 + √f_2 = 1 | |
| convex-front | f_2 = 1 − √f_1 | ZDT1 of Zitzler, Deb & Thiele 2000, Evolutionary Computation 8, 173-195 |
| broken-front | five parts of f_2 = 1 − √f_1 − f_1 sin(10π f_1) | ZDT3, there |
| spherical-front | f_1² + f_2² + f_3² = 1, none negative | DTLZ2 of Deb, Thiele, Laumanns & Zitzler 2002, CEC, 825-830 |

The worst values, from which hypervolume is measured, are those of the farthest corner.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Sequence
from typing import ClassVar

import numpy as np
from scipy.optimize import brentq

from railsearch.errors import InputError
from railsearch.indicators import non_dominated
from railsearch.interfaces import Quantity
from railsearch.space import FloatArray
from railsearch_problems.analytic.function import FRONT_POINTS, SECTION, AnalyticProblem, FunctionParameters

FARTHEST = 9.0


class TwoSpheres(AnalyticProblem):
    """Two spheres with centres 1 below and 1 above the optimum in every real variable: f = (|z + e|², |z − e|²) / |2e|².

    e is 1 for real variables and 0 for integer ones. The front is √f_1 + √f_2 = 1, attained on the line between the
    centres: f = (t², (1 − t)²) at z = (2t − 1) e, 0 ≤ t ≤ 1 (the sum of the distances to both centres is least there).
    """

    function_name = "two-spheres"
    lower, upper = -5.0, 5.0
    available_objectives: ClassVar[Sequence[Quantity]] = (
        Quantity("left", meaning="squared distance to the lower centre, relative to that of the centres"),
        Quantity("right", meaning="squared distance to the upper centre, relative to that of the centres"),
    )

    def __init__(self, parameters: FunctionParameters | None = None) -> None:
        super().__init__(parameters)
        if self.space.integer.all():
            raise InputError(
                f"{SECTION}.integers: {self.name} needs a real variable, received {self.space.dimension} integers"
            )
        self.towards = np.where(self.space.integer, 0.0, 1.0)
        centres = self.optimum + np.array([[-1.0], [1.0]]) * self.towards
        if not np.array_equal(centres, np.clip(centres, self.space.lower, self.space.upper)):
            raise InputError(
                f"{SECTION}.optimum: the centres of {self.name} lie 1 from it in every real variable, inside the bounds, "
                f"received {self.optimum.tolist()}; move it from the bounds"
            )
        for objective, centre in zip(self.objectives, centres, strict=True):
            farthest = np.maximum(self.space.upper - centre, centre - self.space.lower)
            self.worst[objective.name] = float(np.sum(farthest**2)) / self._scale

    @property
    def _scale(self) -> float:
        return 4.0 * float(np.sum(self.towards**2))

    def values(self, z: FloatArray) -> FloatArray:
        """(left, right) at z (d,)."""
        return np.array([np.sum((z + self.towards) ** 2), np.sum((z - self.towards) ** 2)]) / self._scale

    def front(self, n: int = FRONT_POINTS) -> FloatArray:
        """(t², (1 − t)²) at n places, (n, 2)."""
        t = np.linspace(0.0, 1.0, n)
        return np.column_stack([t**2, (1.0 - t) ** 2])

    def _calc_pareto_set(self) -> FloatArray:
        t = np.linspace(0.0, 1.0, FRONT_POINTS)
        designs: FloatArray = self.optimum + (2.0 * t[:, None] - 1.0) * self.towards
        return designs


class FrontProblem(AnalyticProblem):
    """Objectives f(t, g) of a place t on the front and a distance g from it; subclasses state them for many places."""

    lower, upper = -5.0, 5.0
    farthest_values: ClassVar[Sequence[float]]

    def __init__(self, parameters: FunctionParameters | None = None) -> None:
        super().__init__(parameters)
        real = self.space.dimension - self.parameters.whole
        if real < self.n_obj - 1 or self.space.dimension < self.n_obj:
            raise InputError(
                f"{SECTION}.dimension: {self.name} needs {self.n_obj} variables or more, {self.n_obj - 1} of them real, "
                f"received {self.space.dimension} and {real}"
            )
        away = np.maximum(self.optimum - self.space.lower, self.space.upper - self.optimum)
        self._farthest = float(np.sum(away[self.n_obj - 1 :] ** 2))
        self.worst.update(zip((objective.name for objective in self.objectives), self.farthest_values, strict=True))

    @abstractmethod
    def objectives_of(self, t: FloatArray, g: FloatArray) -> FloatArray:
        """The objectives (n, m) at places t (n, m − 1) and distances g (n,)."""

    def values(self, z: FloatArray) -> FloatArray:
        """The objectives (m,) at z (d,)."""
        places = self.n_obj - 1
        x = z[:places] + self.optimum[:places]
        t = np.clip((x - self.lower) / (self.upper - self.lower), 0.0, 1.0)
        g = FARTHEST * np.sum(z[places:] ** 2) / self._farthest
        found: FloatArray = self.objectives_of(t[None, :], np.array([g]))[0]
        return found

    def front(self, n: int = FRONT_POINTS) -> FloatArray:
        """The objectives (at most n, m) at places spread evenly over the front."""
        places = self._places(n)
        return self.objectives_of(places, np.zeros(len(places)))

    def _places(self, n: int) -> FloatArray:
        """Places (at most n, m − 1) on a lattice, one for each point of the front."""
        steps = np.linspace(0.0, 1.0, math.floor(round(n ** (1.0 / (self.n_obj - 1)), 9)))
        lattice = np.stack(np.meshgrid(*[steps] * (self.n_obj - 1), indexing="ij"), axis=-1).reshape(-1, self.n_obj - 1)
        return lattice[non_dominated(self.objectives_of(lattice, np.zeros(len(lattice))))]

    def _calc_pareto_set(self) -> FloatArray:
        places = self._places(FRONT_POINTS)
        designs = np.tile(self.optimum, (len(places), 1))
        designs[:, : self.n_obj - 1] = self.lower + places * (self.upper - self.lower)
        return designs


class ConvexFront(FrontProblem):
    """Convex front: f_1 = t, f_2 = (1 + g) (1 − √(t/(1 + g))) on [−5, 5]^d; the front is f_2 = 1 − √f_1."""

    function_name = "convex-front"
    farthest_values = (1.0, 1.0 + FARTHEST)
    available_objectives: ClassVar[Sequence[Quantity]] = (
        Quantity("f1", meaning="place along the front"),
        Quantity("f2", meaning="falls along the front, grows away from it"),
    )

    def objectives_of(self, t: FloatArray, g: FloatArray) -> FloatArray:
        """The objectives (n, 2) at places t (n, 1) and distances g (n,)."""
        along = t[:, 0]
        return np.column_stack([along, (1.0 + g) * (1.0 - np.sqrt(along / (1.0 + g)))])


class BrokenFront(ConvexFront):
    """Broken front: f_1 = t, f_2 = (1 + g) (1 − √(t/(1 + g))) − t sin(10π t) on [−5, 5]^d; the front has five parts.

    Each part ends in a minimum of f_2 over t, and the next begins where f_2 falls below that.
    """

    function_name = "broken-front"

    def objectives_of(self, t: FloatArray, g: FloatArray) -> FloatArray:
        """The objectives (n, 2) at places t (n, 1) and distances g (n,)."""
        waves = t[:, 0] * np.sin(10.0 * np.pi * t[:, 0])
        return super().objectives_of(t, g) - np.column_stack([np.zeros(len(t)), waves])

    def _places(self, n: int) -> FloatArray:
        begins, ends = self._parts()
        before = np.concatenate([[0.0], np.cumsum(ends - begins)])
        along = np.linspace(0.0, before[-1], n)
        part = np.clip(np.searchsorted(before, along) - 1, 0, len(ends) - 1)
        places: FloatArray = (begins[part] + along - before[part])[:, None]
        return places

    def _parts(self) -> tuple[FloatArray, FloatArray]:
        """Where the five parts of the front begin and end; the sine is 1 at 0.05, −1 at 0.15, 1 at 0.25 and so on."""
        waves = 0.2 * np.arange(5)
        ends = np.array([brentq(_slope, wave + 0.05, wave + 0.1, xtol=1e-15) for wave in waves])
        begins = [0.0]
        for previous, top, end in zip(ends[:-1], waves[:-1] + 0.15, ends[1:], strict=True):
            begins.append(brentq(self._above, top, end, args=(self._height(previous),), xtol=1e-15))
        return np.array(begins), ends

    def _height(self, t: float) -> float:
        return float(self.objectives_of(np.array([[t]]), np.zeros(1))[0, 1])

    def _above(self, t: float, level: float) -> float:
        return self._height(t) - level


def _slope(t: float) -> float:
    """The derivative of the broken front's f_2 by t, at g = 0."""
    angle = 10.0 * math.pi * t
    return -0.5 / math.sqrt(t) - math.sin(angle) - angle * math.cos(angle)


class SphericalFront(FrontProblem):
    """Spherical front of three objectives: f = (1 + g) (cos α cos β, cos α sin β, sin α), (α, β) = t π/2, on [−5, 5]^d."""

    function_name = "spherical-front"
    farthest_values = (1.0 + FARTHEST,) * 3
    available_objectives: ClassVar[Sequence[Quantity]] = tuple(
        Quantity(f"f{k}", meaning=f"coordinate {k} of a point on a sphere of radius 1 + g") for k in (1, 2, 3)
    )

    def objectives_of(self, t: FloatArray, g: FloatArray) -> FloatArray:
        """The objectives (n, 3) at places t (n, 2) and distances g (n,)."""
        alpha, beta = 0.5 * np.pi * t.T
        point = np.column_stack([np.cos(alpha) * np.cos(beta), np.cos(alpha) * np.sin(beta), np.sin(alpha)])
        # cos(π/2) is 6e-17 in floating point; on the front the ends are exactly 0.
        return np.where(point < 1e-15, 0.0, point) * (1.0 + g)[:, None]


PROBLEMS = (TwoSpheres, ConvexFront, BrokenFront, SphericalFront)
