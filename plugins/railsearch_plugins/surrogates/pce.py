"""Surrogate `pce`: a sparse polynomial chaos expansion, on the unit cube or on random inputs in their own units."""

import numpy as np

from railsearch.distributions import RandomVector, random_vector
from railsearch.errors import InputError, SurrogateError
from railsearch.hookspecs import Register, hookimpl
from railsearch.space import FloatArray

from ..polynomial_chaos.expansion import Expansion
from ..polynomial_chaos.families import families
from ..polynomial_chaos.parameters import PolynomialChaosParameters
from ..polynomial_chaos.search import FittedExpansion, fit_expansion


class PolynomialChaos:
    """Expansion in orthonormal polynomials: Legendre's on the unit cube of a search, others of given inputs (`for_inputs`).

    It regresses: values are not met exactly. Added points bring a search for the terms from the start.
    Source: Blatman & Sudret 2011.
    """

    Parameters = PolynomialChaosParameters
    interpolates = False

    def __init__(self, dimension: int, parameters: PolynomialChaosParameters, inputs: RandomVector | None = None) -> None:
        self._dimension = dimension
        self._parameters = parameters
        self._inputs = inputs
        self._points = np.empty((0, dimension))
        self._values = np.empty(0)
        self._fitted: FittedExpansion | None = None

    @classmethod
    def for_inputs(cls, inputs: RandomVector, parameters: PolynomialChaosParameters) -> "PolynomialChaos":
        """The surrogate on points of these random inputs, in their own units."""
        return cls(inputs.dimension, parameters, inputs)

    @property
    def fitted(self) -> FittedExpansion:
        """The expansion with its moments and Sobol' indices, its residuals, and the sets of terms that were searched."""
        if self._fitted is None:
            raise SurrogateError("pce: the expansion is not fitted; call fit with the first points")
        return self._fitted

    @property
    def expansion(self) -> Expansion:
        """The expansion itself. Raises SurrogateError before a fit."""
        return self.fitted.expansion

    def fit(self, points: FloatArray, values: FloatArray) -> None:
        """Fit to points (n, d) with values (n,).

        Raises SurrogateError for points of the wrong shape, fewer than three, or values that are not finite, InputError for
        points that the inputs cannot have.
        """
        points, values = self._checked(points, values)
        inputs = self._inputs or _unit_cube(self._dimension)
        chosen = families(inputs.marginals.values(), self._parameters.degree, [self._parameters.basis] * self._dimension)
        self._fitted = fit_expansion(chosen, points, values, self._parameters)
        self._points, self._values = points, values

    def add(self, points: FloatArray, values: FloatArray) -> None:
        """Fit afresh with points (k, d) and values (k,) added. Raises SurrogateError as `fit`, and before the first fit."""
        if self._fitted is None:
            raise SurrogateError("pce: the expansion is not fitted; call fit with the first points")
        self.fit(np.concatenate([self._points, points]), np.concatenate([self._values, values]))

    def predict(self, points: FloatArray) -> FloatArray:
        """Predictions (k,) at points (k, d)."""
        return self.expansion.predict(np.atleast_2d(points))

    def gradient(self, points: FloatArray) -> FloatArray:
        """Derivatives (k, d) of the prediction at points (k, d)."""
        return self.expansion.gradient(np.atleast_2d(points))

    def predict_with_gradient(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Predictions (k,) and their derivatives (k, d) at points (k, d), from one table of polynomials."""
        return self.expansion.predict_with_gradient(np.atleast_2d(points))

    def _checked(self, points: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
        points, values = np.array(points, dtype=float), np.array(values, dtype=float)
        if points.ndim != 2 or points.shape[1] != self._dimension or values.shape != (len(points),):
            raise SurrogateError(
                f"pce: points (n, {self._dimension}) and values (n,) are needed, received shapes {points.shape} and "
                f"{values.shape}"
            )
        if not (np.isfinite(points).all() and np.isfinite(values).all()):
            raise SurrogateError("pce: finite points and values are needed; leave failed evaluations out of the fit")
        return points if self._inputs is None else self._inputs.checked(points), values


def _unit_cube(dimension: int) -> RandomVector:
    if dimension < 1:
        raise InputError(f"pce: a dimension of 1 or more is needed, received {dimension}")
    uniform = {"distribution": "uniform", "lower": 0.0, "upper": 1.0}
    return random_vector({f"u{k + 1}": uniform for k in range(dimension)})


@hookimpl
def railsearch_surrogates(register: Register) -> None:
    """Register `pce`."""
    register("pce", PolynomialChaos)
