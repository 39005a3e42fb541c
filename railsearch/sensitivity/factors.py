"""Factors of a sensitivity analysis: bounds, and the grid of values at which each one is held.

| symbol | meaning | shape | unit |
|---|---|---|---|
| d | number of factors | scalar | - |
| x_i^l, x_i^u | bounds of factor i | (d,) | SI |
| n_i | number of grid values of factor i | scalar | - |
| x_ij | grid values of factor i, rising | (n_i,) | SI |
| w_j | weights: half the distance between both neighbours, at the ends half the end interval | (n_i,) | SI |
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, TypeVar

import numpy as np
from numpy.typing import NDArray

from railsearch.errors import InputError
from railsearch.space import FloatArray, Space, Variable
from railsearch.wording import closest

if TYPE_CHECKING:  # half a second of scipy that only those who have random vectors need
    from railsearch.distributions import RandomVector

EQUAL, LOGARITHMIC, RANDOM = SPACINGS = ("equal", "logarithmic", "random")
T = TypeVar("T")

WIDE = 1e3
"""A range wider than this (SI) gets a logarithmic grid where its lower bound is positive."""

POINTS = 50
FEWEST_POINTS = 2


@dataclass(frozen=True)
class Factors:
    """The factors in order: names, units and bounds as a space, a grid (n_i,) for each, and how it is spaced."""

    space: Space
    grids: tuple[FloatArray, ...]
    spacings: tuple[str, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the factors."""
        return self.space.names

    @property
    def dimension(self) -> int:
        """d."""
        return self.space.dimension

    @cached_property
    def weights(self) -> tuple[FloatArray, ...]:
        """w (n_i,) of every grid."""
        return tuple(trapezoidal_weights(grid) for grid in self.grids)

    @property
    def number_of_values(self) -> int:
        """Σ n_i."""
        return sum(map(len, self.grids))

    def index(self, name: str) -> int:
        """The place of a factor. Raises InputError for an unknown name."""
        _check_known([name], self.names, "factor")
        return self.names.index(name)


def factors_on(
    space: Space,
    points: int | Mapping[str, int] = POINTS,
    spacings: str | Mapping[str, str] | None = None,
    generator: np.random.Generator | None = None,
) -> Factors:
    """Factors with the bounds of a space, and grids for them.

    points: n_i, one number or by name (others 50); spacings: `equal`, `logarithmic` or `random`, one or by name; where none
    is given, logarithmic if x^u − x^l > 10³ and x^l > 0, otherwise equal; generator: draws random grids.
    Raises InputError for fewer than two points, a logarithmic grid of a range that is not positive, an unknown factor or
    spacing, and a random grid without a generator. Source: Shang et al. 2024.
    """
    numbers = _by_name(points, space.names, "points")
    kinds = _by_name(spacings, space.names, "spacings")
    chosen = [kinds.get(variable.name) or default_spacing(variable) for variable in space.variables]
    grids = [
        grid_values(variable, numbers.get(variable.name, POINTS), spacing, generator)
        for variable, spacing in zip(space.variables, chosen, strict=True)
    ]
    return Factors(space, tuple(grids), tuple(chosen))


def input_space(
    inputs: "RandomVector",
    level: float = 0.01,
    ranges: Mapping[str, Sequence[float]] | None = None,
    units: Mapping[str, str] | None = None,
) -> Space:
    """The bounds of random inputs as a space: those of `ranges`, else their own, else percentiles at `level`, 1 − `level`.

    Raises InputError for bounds that are reversed, equal, not finite or beyond what an input can have, and for the name of
    no input. Source: Shang et al. 2024.
    """
    stated, words = dict(ranges or {}), dict(units or {})
    _check_known([*stated, *words], inputs.names, "input")
    variables = []
    for name, bounds in zip(inputs.names, inputs.ranges(level), strict=True):
        low, high = _stated(name, stated[name], inputs) if name in stated else bounds
        variables.append(Variable(name, float(low), float(high), words.get(name, "")))
    return Space(tuple(variables))


def default_spacing(variable: Variable) -> str:
    """`logarithmic` for a wide positive range of real values, else `equal`."""
    wide = variable.upper - variable.lower > WIDE and variable.lower > 0.0 and not variable.integer
    return LOGARITHMIC if wide else EQUAL


def grid_values(variable: Variable, points: int, spacing: str, generator: np.random.Generator | None = None) -> FloatArray:
    """The grid (n,) of a variable; that of an integer has each whole number once. Raises InputError as `factors_on`."""
    if isinstance(points, bool) or not isinstance(points, int | np.integer) or points < FEWEST_POINTS:
        raise InputError(f"points of {variable.name}: an integer ≥ {FEWEST_POINTS} is needed, received {points!r}")
    if spacing not in _GRIDS:
        raise InputError(f"spacing of {variable.name}: {', '.join(SPACINGS)} are known, received {spacing!r}")
    if spacing == LOGARITHMIC and not variable.lower > 0.0:
        raise InputError(
            f"spacing of {variable.name}: a logarithmic grid needs a lower bound above 0, received {variable.lower:g}; "
            "choose an equal one"
        )
    if spacing == RANDOM and generator is None:
        raise InputError(f"spacing of {variable.name}: a random grid needs a generator; hand one in")
    values = _GRIDS[spacing](variable, int(points), generator)
    return np.unique(np.round(values)) if variable.integer else values


def trapezoidal_weights(grid: FloatArray) -> FloatArray:
    """w (n,) of a rising grid (n,): w_j = (x_{j+1} − x_{j−1})/2, half the end interval at both ends."""
    halves = 0.5 * np.diff(grid)
    return np.asarray(np.append(halves, 0.0) + np.append(0.0, halves))


def _equal(variable: Variable, points: int, generator: np.random.Generator | None) -> FloatArray:
    return np.linspace(variable.lower, variable.upper, points)


def _logarithmic(variable: Variable, points: int, generator: np.random.Generator | None) -> FloatArray:
    return np.asarray(np.geomspace(variable.lower, variable.upper, points))


def _random(variable: Variable, points: int, generator: np.random.Generator | None) -> FloatArray:
    assert generator is not None, "checked before"
    return np.sort(generator.uniform(variable.lower, variable.upper, points))


_GRIDS: Mapping[str, Callable[[Variable, int, np.random.Generator | None], FloatArray]] = {
    EQUAL: _equal,
    LOGARITHMIC: _logarithmic,
    RANDOM: _random,
}


def _by_name(value: T | Mapping[str, T] | None, names: Sequence[str], where: str) -> Mapping[str, T]:
    if isinstance(value, Mapping):
        _check_known(list(value), names, "factor", f"{where}: ")
        return value
    return {} if value is None else dict.fromkeys(names, value)


def _stated(name: str, bounds: Sequence[float], inputs: "RandomVector") -> NDArray[np.float64]:
    pair = np.asarray(bounds, dtype=float)
    if pair.shape != (2,):
        raise InputError(f"range of {name}: a lower and an upper bound are needed, received {bounds!r}")
    low, high = inputs.marginals[name].support
    if not (pair[0] >= low and pair[1] <= high):
        raise InputError(
            f"range of {name}: {inputs.marginals[name]} has values from {low:g} to {high:g}, received {pair[0]:g} to "
            f"{pair[1]:g}; stay inside"
        )
    return pair


def _check_known(names: Sequence[str], known: Sequence[str], kind: str, where: str = "") -> None:
    for name in names:
        if name not in known:
            raise InputError(f"{where}unknown {kind} '{name}'{closest(name, known)}; there are {', '.join(known)}")
