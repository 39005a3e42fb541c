"""Surrogate `pce`: a sparse polynomial chaos expansion, on the unit cube or on random inputs in their own units."""

from collections.abc import Mapping

import numpy as np

from railsearch.distributions import RandomVector
from railsearch.errors import SurrogateError
from railsearch.hookspecs import Register, hookimpl
from railsearch.space import FloatArray

from ..polynomial_chaos.coordinates import unit_cube
from ..polynomial_chaos.expansion import Expansion
from ..polynomial_chaos.families import families
from ..polynomial_chaos.parameters import PolynomialChaosParameters
from ..polynomial_chaos.search import FittedExpansion, fit_expansion
from ..surrogate_data import checked_data


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

    @property
    def errors(self) -> Mapping[str, float]:
        """Mean squared errors as fractions of the variance of the values: `training`, `leave-one-out`, `corrected`."""
        return self.fitted.errors

    @property
    def loo_error(self) -> float:
        """The mean square of the leave-one-out residuals as a fraction of the variance of the values."""
        return self.errors["leave-one-out"]

    def fit(self, points: FloatArray, values: FloatArray) -> None:
        """Fit to points (n, d) with values (n,).

        Raises SurrogateError for points of the wrong shape, fewer than three, or values that are not finite, InputError for
        points that the inputs cannot have.
        """
        points, values = self._checked(points, values)
        inputs = self._inputs or unit_cube(self._dimension)
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
        points, values = checked_data("pce", self._dimension, points, values)
        return points if self._inputs is None else self._inputs.checked(points), values


@hookimpl
def railsearch_surrogates(register: Register) -> None:
    """Register `pce`."""
    register("pce", PolynomialChaos)
