"""Surrogate `pck`: PC-Kriging, on the unit cube or on random inputs in their own units."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from railsearch.distributions import RandomVector
from railsearch.errors import SurrogateError
from railsearch.hookspecs import Register, hookimpl
from railsearch.interfaces import parameter
from railsearch.space import FloatArray

from ..gaussian_process.estimation import given_length_scales
from ..polynomial_chaos.coordinates import unit_cube
from ..polynomial_chaos.families import families
from ..polynomial_chaos_kriging.model import FittedPolynomialChaosKriging, fit_polynomial_chaos_kriging
from ..polynomial_chaos_kriging.parameters import PolynomialChaosKrigingParameters
from ..surrogate_data import checked_data


@dataclass(frozen=True)
class SurrogateParameters(PolynomialChaosKrigingParameters):
    """What can be set of the surrogate."""

    refit_every: int = parameter(
        10, meaning="added points after which terms and length scales are searched again", source="own choice", minimum=1
    )
    seed: int = parameter(0, meaning="seed of the starts of a fit", minimum=0)


class PolynomialChaosKriging:
    """Gaussian process whose trend are the terms of a sparse polynomial chaos expansion; it goes through the points.

    Adding a point costs O(n²) until terms and length scales are searched again. Source: Schöbi, Sudret & Wiart 2015.
    """

    Parameters = SurrogateParameters
    add_tolerance = 0.05

    def __init__(self, dimension: int, parameters: SurrogateParameters, inputs: RandomVector | None = None) -> None:
        if parameters.length_scales is not None:
            given_length_scales(parameters, dimension)
        self._dimension = dimension
        self._parameters = parameters
        self._inputs = inputs
        self._points = np.empty((0, dimension))
        self._values = np.empty(0)
        self._searched = 0
        self._fitted: FittedPolynomialChaosKriging | None = None

    @classmethod
    def for_inputs(cls, inputs: RandomVector, parameters: SurrogateParameters) -> "PolynomialChaosKriging":
        """The surrogate on points of these random inputs, in their own units."""
        return cls(inputs.dimension, parameters, inputs)

    @property
    def fitted(self) -> FittedPolynomialChaosKriging:
        """The expansion that was found, the terms of the trend, and the process. Raises SurrogateError before a fit."""
        if self._fitted is None:
            raise SurrogateError("pck: the model is not fitted; call fit with the first points")
        return self._fitted

    @property
    def errors(self) -> Mapping[str, float]:
        """`training`, `leave-one-out` and `corrected-expansion`: mean squares as fractions of the variance (model.py)."""
        return self.fitted.errors

    @property
    def loo_error(self) -> float:
        """The mean square of the leave-one-out residuals, with the same terms, as a fraction of the variance."""
        return self.errors["leave-one-out"]

    def fit(self, points: FloatArray, values: FloatArray) -> None:
        """Fit to points (n, d) with values (n,).

        Raises SurrogateError for points of the wrong shape, fewer than three, or values that are not finite, InputError for
        points that the inputs cannot have.
        """
        points, values = self._checked(points, values)
        inputs, parameters = self._inputs or unit_cube(self._dimension), self._parameters
        chosen = families(inputs.marginals.values(), parameters.degree, [parameters.basis] * self._dimension)
        generator = np.random.default_rng(parameters.seed)
        self._fitted = fit_polynomial_chaos_kriging(chosen, points, values, parameters, generator)
        self._points, self._values, self._searched = points, values, len(points)

    def add(self, points: FloatArray, values: FloatArray) -> None:
        """Add points (k, d) with values (k,): terms and length scales stay, or are searched again.

        Raises SurrogateError and InputError as `fit`, and before the first fit.
        """
        model = self.fitted.model
        points, values = self._checked(points, values)
        points, values = np.concatenate([self._points, points]), np.concatenate([self._values, values])
        if len(points) - self._searched >= self._parameters.refit_every:
            self.fit(points, values)
        else:
            model.extend(points[len(self._points) :], values[len(self._points) :])
            self._points, self._values = points, values

    def predict(self, points: FloatArray) -> FloatArray:
        """Predictions (k,) at points (k, d)."""
        return self.fitted.model.predict(points)

    def gradient(self, points: FloatArray) -> FloatArray:
        """Derivatives (k, d) of the prediction at points (k, d)."""
        return self.fitted.model.gradient(points)

    def predict_with_gradient(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Predictions (k,) and their derivatives (k, d) at points (k, d), from one matrix of correlations."""
        return self.fitted.model.predict_with_gradient(points)

    def deviation(self, points: FloatArray) -> FloatArray:
        """Standard deviations (k,) of the prediction at points (k, d), the uncertainty of the trend included."""
        return self.fitted.model.deviation(points)

    def deviation_gradient(self, points: FloatArray) -> FloatArray:
        """Derivatives (k, d) of the standard deviation at points (k, d)."""
        return self.fitted.model.deviation_gradient(points)

    def _checked(self, points: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
        points, values = checked_data("pck", self._dimension, points, values)
        return points if self._inputs is None else self._inputs.checked(points), values


@hookimpl
def railsearch_surrogates(register: Register) -> None:
    """Register `pck`."""
    register("pck", PolynomialChaosKriging)
