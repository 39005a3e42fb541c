"""The columns of a regressor as random inputs."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from railsearch.distributions import Marginal, RandomVector, random_vector
from railsearch.errors import InputError
from railsearch.space import FloatArray

from .families import Family, families


@dataclass(frozen=True)
class Columns:
    """The distributions of the columns, and the basis of each."""

    vector: RandomVector
    bases: tuple[str, ...]

    def families(self, degree: int) -> tuple[Family, ...]:
        """Their polynomials up to a degree. Raises InputError as `orthonormal_family`."""
        return families(self.vector.marginals.values(), degree, self.bases)


def described_columns(
    owner: str, inputs: RandomVector | None, basis: str | Mapping[str, str], points: FloatArray
) -> Columns:
    """The columns of points (n, d) as the `inputs`, or without these as uniform over the range that they have.

    basis: one for all, or one by name, those left out having `own`. Raises InputError, beginning with the regressor `owner`,
    for a number of columns other than that of the inputs, unknown names, and values that an input cannot have.
    """
    if inputs is None:
        # The ends of these ranges may lie beside the data by rounding, so that the data are not held to them.
        vector = random_vector({f"x{k + 1}": _range_of(column) for k, column in enumerate(points.T)})
        return Columns(vector, _bases(owner, basis, vector))
    if inputs.dimension != points.shape[1]:
        raise InputError(
            f"{owner}.inputs: {points.shape[1]} columns were given for the {inputs.dimension} inputs "
            f"{', '.join(inputs.names)}; give one for each, in this order"
        )
    bases = _bases(owner, basis, inputs)
    inputs.checked(points)
    return Columns(inputs, bases)


def _bases(owner: str, basis: str | Mapping[str, str], vector: RandomVector) -> tuple[str, ...]:
    if isinstance(basis, str):
        return (basis,) * vector.dimension
    unknown = [name for name in basis if name not in vector.names]
    if unknown:
        raise InputError(f"{owner}.basis: {', '.join(unknown)} are not among the inputs {', '.join(vector.names)}")
    return tuple(basis.get(name, "own") for name in vector.names)


def _range_of(column: FloatArray) -> Mapping[str, object] | Marginal:
    low, high = float(np.min(column)), float(np.max(column))
    return {"distribution": "uniform", "lower": low, "upper": high if high > low else low + 1.0}
