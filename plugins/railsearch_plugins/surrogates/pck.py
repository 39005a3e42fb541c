"""Surrogate `pck`: PC-Kriging, on the unit cube or on random inputs in their own units."""

from dataclasses import dataclass

import numpy as np

from railsearch.distributions import RandomVector
from railsearch.hookspecs import Register, hookimpl
from railsearch.interfaces import parameter
from railsearch.space import FloatArray

from ..gaussian_process.estimation import given_length_scales
from ..polynomial_chaos.families import Family
from ..polynomial_chaos.surrogate import ExpansionSurrogate, Predictor
from ..polynomial_chaos_kriging.model import FittedPolynomialChaosKriging, fit_polynomial_chaos_kriging
from ..polynomial_chaos_kriging.parameters import PolynomialChaosKrigingParameters


@dataclass(frozen=True)
class SurrogateParameters(PolynomialChaosKrigingParameters):
    """What can be set of the surrogate."""

    refit_every: int = parameter(
        10, meaning="added points after which terms and length scales are searched again", source="own choice", minimum=1
    )
    seed: int = parameter(0, meaning="seed of the starts of a fit", minimum=0)


class PolynomialChaosKriging(ExpansionSurrogate[SurrogateParameters, FittedPolynomialChaosKriging]):
    """Gaussian process whose trend are the terms of a sparse polynomial chaos expansion; it goes through the points.

    Adding a point costs O(n²) until terms and length scales are searched again. Source: Schöbi, Sudret & Wiart 2015.
    """

    Parameters = SurrogateParameters
    name = "pck"
    add_tolerance = 0.05

    def __init__(self, dimension: int, parameters: SurrogateParameters, inputs: RandomVector | None = None) -> None:
        if parameters.length_scales is not None:
            given_length_scales(parameters, dimension)
        super().__init__(dimension, parameters, inputs)
        self._searched = 0

    def add(self, points: FloatArray, values: FloatArray) -> None:
        """Add points (k, d) with values (k,): terms and length scales stay, or are searched again.

        Raises SurrogateError and InputError as `fit`, and before the first fit.
        """
        known = len(self._points)
        points, values = self._with(points, values)
        if len(points) - self._searched >= self._parameters.refit_every:
            self.fit(points, values)
        else:
            self.fitted.model.extend(points[known:], values[known:])
            self._points, self._values = points, values

    def deviation(self, points: FloatArray) -> FloatArray:
        """Standard deviations (k,) of the prediction at points (k, d), the uncertainty of the trend included."""
        return self.fitted.model.deviation(points)

    def deviation_gradient(self, points: FloatArray) -> FloatArray:
        """Derivatives (k, d) of the standard deviation at points (k, d)."""
        return self.fitted.model.deviation_gradient(points)

    @property
    def _predictor(self) -> Predictor:
        return self.fitted.model

    def _fit(self, polynomials: tuple[Family, ...], points: FloatArray, values: FloatArray) -> FittedPolynomialChaosKriging:
        generator = np.random.default_rng(self._parameters.seed)
        found = fit_polynomial_chaos_kriging(polynomials, points, values, self._parameters, generator)
        self._searched = len(points)
        return found


@hookimpl
def railsearch_surrogates(register: Register) -> None:
    """Register `pck`."""
    register("pck", PolynomialChaosKriging)
