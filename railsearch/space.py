"""Named design variables with unit, kind and bounds, and their map to the unit cube."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from railsearch.errors import InputError
from railsearch.wording import closest

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Variable:
    """One design variable. An integer variable takes the whole numbers from `lower` to `upper`, both included."""

    name: str
    lower: float
    upper: float
    unit: str = ""
    integer: bool = False
    meaning: str = ""

    def __post_init__(self) -> None:
        if not (math.isfinite(self.lower) and math.isfinite(self.upper)):
            raise InputError(f"variable {self.name}: finite bounds are needed, received {self.lower!r} and {self.upper!r}")
        if not self.lower < self.upper:
            raise InputError(
                f"variable {self.name}: the lower bound must lie below the upper one, "
                f"received {self.lower:g} and {self.upper:g}"
            )
        if self.integer and not (float(self.lower).is_integer() and float(self.upper).is_integer()):
            raise InputError(
                f"variable {self.name}: an integer variable needs whole bounds, received {self.lower:g} and {self.upper:g}"
            )


@dataclass(frozen=True)
class Space:
    """An ordered set of variables. Designs are float vectors (d,) in native units; integers are whole numbers in them."""

    variables: tuple[Variable, ...]

    def __post_init__(self) -> None:
        if not self.variables or len(set(self.names)) != len(self.variables):
            raise InputError(f"variables: one or more with different names are needed, received {list(self.names)}")

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the variables in order."""
        return tuple(variable.name for variable in self.variables)

    @property
    def _needed(self) -> str:
        """What a design has to be, in words."""
        return f"{self.dimension} values are needed ({', '.join(self.names)})"

    @property
    def dimension(self) -> int:
        """How many variables there are."""
        return len(self.variables)

    @cached_property
    def lower(self) -> FloatArray:
        """Lower bounds (d,)."""
        return np.array([variable.lower for variable in self.variables], dtype=float)

    @cached_property
    def upper(self) -> FloatArray:
        """Upper bounds (d,)."""
        return np.array([variable.upper for variable in self.variables], dtype=float)

    @cached_property
    def integer(self) -> NDArray[np.bool_]:
        """Mask (d,) of the integer variables."""
        return np.array([variable.integer for variable in self.variables], dtype=bool)

    @property
    def size(self) -> float:
        """How many different designs there are; infinite with a real variable."""
        return float(np.prod(self.upper - self.lower + 1.0)) if self.integer.all() else math.inf

    def to_unit(self, designs: ArrayLike) -> FloatArray:
        """Map designs (..., d) from native units to the unit cube by their bounds."""
        return (np.asarray(designs, dtype=float) - self.lower) / (self.upper - self.lower)

    def from_unit(self, points: ArrayLike) -> FloatArray:
        """Map points (..., d) of the unit cube to designs, integers rounded to the nearest whole number."""
        return self.rounded(self.lower + np.asarray(points, dtype=float) * (self.upper - self.lower))

    def rounded(self, designs: ArrayLike) -> FloatArray:
        """Designs (..., d) brought inside the bounds, integers rounded to the nearest whole number, no negative zeros."""
        inside = np.clip(np.asarray(designs, dtype=float), self.lower, self.upper)
        rounded: FloatArray = np.where(self.integer, np.round(inside), inside) + 0.0
        return rounded

    def checked(self, design: ArrayLike) -> FloatArray:
        """The design (d,) as a float vector. Raises InputError naming the variable that is not allowed."""
        try:
            vector = np.array(design, dtype=float)
        except (TypeError, ValueError):
            raise InputError(f"design: {self._needed}, received {design!r}") from None
        if vector.shape != (self.dimension,):
            raise InputError(f"design: {self._needed}, received shape {vector.shape}")
        for variable, value in zip(self.variables, vector, strict=True):
            _check_value(variable, value)
        return vector + 0.0

    def amended(self, design: ArrayLike, changes: Mapping[str, float]) -> FloatArray:
        """The design (d,) with some variables changed by name. Raises InputError for a name or value not allowed."""
        vector = np.array(design, dtype=float)
        for name, value in changes.items():
            if name not in self.names:
                hint = closest(name, self.names)
                raise InputError(f"unknown variable '{name}'{hint}; the variables are {', '.join(self.names)}")
            vector[self.names.index(name)] = value
        return self.checked(vector)

    def named(self, design: Sequence[float] | FloatArray) -> dict[str, float | int]:
        """The design as {name: value}, integers as int, the rest as float."""
        return {
            variable.name: int(value) if variable.integer else float(value)
            for variable, value in zip(self.variables, design, strict=True)
        }

    def key(self, design: FloatArray) -> bytes:
        """Identity of a design: equal for equal designs, to the last bit."""
        return (np.asarray(design, dtype=float) + 0.0).tobytes()


def _check_value(variable: Variable, value: float) -> None:
    unit = f" {variable.unit}" if variable.unit else ""
    if not math.isfinite(value):
        raise InputError(f"variable {variable.name}: a finite number is needed, received {float(value)!r}")
    if variable.integer and value != round(value):
        raise InputError(f"variable {variable.name}: a whole number is needed, received {value:g}{unit}")
    if not variable.lower <= value <= variable.upper:
        raise InputError(
            f"variable {variable.name}: allowed is {variable.lower:g} to {variable.upper:g}{unit}, received {value:g}{unit}"
        )
