"""Classical screening of factors: elementary effects, and one factor at a time.

| symbol | meaning | shape | unit |
|---|---|---|---|
| u | point of the unit box of the factors' bounds | (d,) | - |
| e_i | elementary effect (g(u + Δ e_i) − g(u))/Δ | scalar | of the output |
| μ*_i, σ_i | mean of |e_i|, standard deviation of e_i | (d,) | of the output |
| r | trajectories; r (d + 1) evaluations are made | scalar | - |
| x⁰ | where the other factors stay when one moves | (d,) | SI |

μ* by SALib (Morris 1991; Campolongo, Cariboni & Saltelli 2007).
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from railsearch.errors import InputError
from railsearch.space import FloatArray, Space

from .curves import plain, shares, weighted_variance
from .factors import Factors
from .models import Function
from .variance_based import unit_problem, whole_blocks

LEVELS = 4


@dataclass(frozen=True)
class ElementaryEffects:
    """μ*, its 95 % half width, and σ (d,), in the output's unit per whole range of a factor.

    evaluations: how many were made; dropped: trajectories in which one failed.
    """

    names: tuple[str, ...]
    mean_absolute: FloatArray
    half_width: FloatArray
    deviation: FloatArray
    evaluations: int
    dropped: int

    def document(self) -> dict[str, Any]:
        """All of it in plain types, ready for JSON."""
        columns = ("mean_absolute", "half_width", "deviation")
        return {
            "factors": list(self.names),
            **{column: plain(getattr(self, column)) for column in columns},
            "evaluations": self.evaluations,
            "dropped_trajectories": self.dropped,
        }


@dataclass(frozen=True)
class OneAtATime:
    """Curves (n_i,) of g over each factor's grid with the others at x⁰, and the shares (d,) of their weighted variances."""

    factors: Factors
    base: FloatArray
    curves: tuple[FloatArray, ...]

    @property
    def importances(self) -> FloatArray:
        """(d,), as `extremes` defines them for extreme surfaces."""
        pairs = zip(self.curves, self.factors.weights, strict=True)
        return shares(np.array([weighted_variance(curve, weights) for curve, weights in pairs]))

    def document(self) -> dict[str, Any]:
        """All of it in plain types, ready for JSON."""
        return {
            "base": self.factors.space.named(self.base),
            "importances": dict(zip(self.factors.names, plain(self.importances), strict=True)),
            "curves": {
                name: {"grid": plain(grid), "values": plain(curve)}
                for name, grid, curve in zip(self.factors.names, self.factors.grids, self.curves, strict=True)
            },
            "evaluations": self.factors.number_of_values,
            "failures": int(sum(np.isnan(curve).sum() for curve in self.curves)),
        }


def elementary_effects(
    function: Function, space: Space, trajectories: int, generator: np.random.Generator
) -> ElementaryEffects:
    """Screen by r trajectories over four levels of every factor; those with a failed evaluation are left out.

    function: values (k,) at points (k, d) in the factors' units, NaN where it failed. Raises InputError for fewer than two
    trajectories and an output that does not vary, SimulationError if fewer than two trajectories are whole.
    """
    points = trajectory_points(space, trajectories, generator)
    return effects_along(space, points, np.asarray(function(points), dtype=float), generator)


def trajectory_points(space: Space, trajectories: int, generator: np.random.Generator) -> FloatArray:
    """The points (r (d + 1), d) at which a function must be known. Raises InputError for fewer than two trajectories."""
    from SALib.sample import morris as design

    if trajectories < 2:
        raise InputError(f"trajectories: two or more are needed, received {trajectories}")
    problem, seed = unit_problem(space.names), int(generator.integers(2**31))
    return space.from_unit(design.sample(problem, trajectories, num_levels=LEVELS, seed=seed))


def effects_along(space: Space, points: FloatArray, values: FloatArray, generator: np.random.Generator) -> ElementaryEffects:
    """μ* and σ from values (r (d + 1),) at `trajectory_points`; generator: resamples them for the confidence intervals.

    Raises InputError and SimulationError as `elementary_effects`.
    """
    from SALib.analyze import morris as analysis

    trajectories = len(values) // (space.dimension + 1)
    blocks = whole_blocks(values, trajectories)
    kept = np.isfinite(values.reshape(trajectories, -1)).all(axis=1)
    unit = space.to_unit(points).reshape(trajectories, -1, space.dimension)[kept].reshape(-1, space.dimension)
    seed = int(generator.integers(2**31))
    found = analysis.analyze(unit_problem(space.names), unit, blocks.ravel(), num_levels=LEVELS, seed=seed)
    mean, half, deviation = (np.asarray(found[key], dtype=float) for key in ("mu_star", "mu_star_conf", "sigma"))
    return ElementaryEffects(space.names, mean, half, deviation, len(values), trajectories - len(blocks))


def one_at_a_time(function: Function, factors: Factors, base: FloatArray | None = None) -> OneAtATime:
    """Move one factor over its grid with the others at x⁰ (d,), by default the middle of their bounds.

    function: as in `elementary_effects`. Raises InputError for a base outside the bounds.
    """
    space = factors.space
    middle = space.checked(0.5 * (space.lower + space.upper) if base is None else base)
    points = np.repeat(middle[None, :], factors.number_of_values, axis=0)
    column = np.repeat(np.arange(factors.dimension), [len(grid) for grid in factors.grids])
    points[np.arange(len(points)), column] = np.concatenate(factors.grids)
    values = np.asarray(function(points), dtype=float)
    curves = np.split(np.where(np.isfinite(values), values, np.nan), np.cumsum([len(grid) for grid in factors.grids])[:-1])
    return OneAtATime(factors, middle, tuple(curves))
