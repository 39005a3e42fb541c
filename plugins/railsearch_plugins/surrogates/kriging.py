"""Surrogate `kriging`: a Gaussian process with a trend, on the unit cube or on random inputs in their own units."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from railsearch.distributions import RandomVector
from railsearch.errors import InputError, SurrogateError
from railsearch.hookspecs import Register, hookimpl
from railsearch.interfaces import parameter
from railsearch.space import FloatArray

from ..gaussian_process.additive import AdditiveProcess, additive_basis
from ..gaussian_process.estimation import given_length_scales
from ..gaussian_process.parameters import INPUT_BOUNDS, GaussianProcessParameters
from ..gaussian_process.placement import PlacedProcess, Rounding
from ..gaussian_process.process import GaussianProcess
from ..gaussian_process.trend import DEGREES, PolynomialTrend
from ..polynomial_chaos.coordinates import coordinates_over
from ..polynomial_chaos.families import BASES, families
from ..surrogate_data import checked_data


@dataclass(frozen=True)
class KrigingParameters(GaussianProcessParameters):
    """What can be set of the surrogate."""

    trend: str = parameter("constant", meaning="trend under the process", source="Sacks et al. 1989", choices=tuple(DEGREES))
    basis: str = parameter(
        "own",
        meaning="what random inputs are to the process: themselves, or ln x if lognormal (own), or Φ⁻¹(F(x)) (hermite)",
        source="own choice",
        choices=BASES,
    )
    integer_steps: tuple[int, ...] = parameter(
        (),
        meaning="steps over the range by variable, to which inputs are rounded, 0 for a real one; if empty, all are real",
        source="Garrido-Merchán & Hernández-Lobato 2020",
        minimum=0,
    )
    additive_share: float = parameter(
        0.0,
        meaning="share of a sum of processes of one variable, about which it is estimated, its logit with a deviation "
        "of 1.5; 0 for a process without such a part",
        source="Duvenaud, Nickisch & Rasmussen 2011",
        minimum=0.0,
        below=1.0,
    )
    additive_length_scale: float = parameter(
        0.15,
        meaning="length scale of the processes of one variable, as a fraction of its range",
        source="own choice: several waves over the range of a variable",
        minimum=0.02,
        maximum=2.0,
    )
    reoptimise_every: int = parameter(
        10,
        meaning="added points after which the length scales are optimised again, from the last ones",
        source="own choice",
        minimum=1,
    )
    seed: int = parameter(0, meaning="seed of the starts of a fit", minimum=0)


class Kriging:
    """Gaussian process with a trend and its standard deviation; adding a point costs O(n²) until the scales move.

    On the unit cube of a search, or of random inputs in their own units (`for_inputs`): there it lives in the coordinates
    of their polynomials, lognormal inputs in their logarithm, over the range of the points of the last fit.
    Source: Sacks et al. 1989; Dubrule 1983; Bachoc 2013; Garrido-Merchán and Hernández-Lobato 2020 for integers, which are
    rounded before anything else, so that the prediction is constant, and its gradient zero, between them; Duvenaud, Nickisch
    and Rasmussen 2011 for `additive_share`.
    """

    Parameters = KrigingParameters
    add_tolerance = 0.05

    def __init__(self, dimension: int, parameters: KrigingParameters, inputs: RandomVector | None = None) -> None:
        if parameters.integer_steps and len(parameters.integer_steps) != dimension:
            raise InputError(
                f"kriging: integer_steps needs one number for each of {dimension} variables (0 for a real one), received "
                f"{list(parameters.integer_steps)}"
            )
        if parameters.length_scales is not None:
            given_length_scales(parameters, dimension)
        self._dimension = dimension
        self._parameters = parameters
        self._inputs = inputs
        process = _process(parameters)
        self._model = PlacedProcess(process, Rounding(np.array(parameters.integer_steps or [0] * dimension, dtype=float)))
        self._points = np.empty((0, dimension))
        self._values = np.empty(0)
        self._optimised = 0

    @classmethod
    def for_inputs(cls, inputs: RandomVector, parameters: KrigingParameters) -> "Kriging":
        """The surrogate on points of these random inputs, in their own units. Raises InputError for `integer_steps`."""
        if any(parameters.integer_steps):
            raise InputError(
                f"kriging: integer_steps are of the unit cube, and these inputs are continuous, received "
                f"{list(parameters.integer_steps)}; leave them out"
            )
        if parameters.additive_share > 0.0:
            raise InputError(
                "kriging: additive_share is of the unit cube, and these inputs may lie beyond any; leave it out"
            )
        bounds = parameters.length_scale_bounds or INPUT_BOUNDS
        return cls(inputs.dimension, replace(parameters, length_scale_bounds=bounds), inputs)

    @property
    def process(self) -> GaussianProcess:
        """The Gaussian process itself: its hyperparameters, variance, nugget and leave-one-out residuals."""
        return self._model.process

    @property
    def errors(self) -> Mapping[str, float]:
        """Mean squared errors as fractions of the variance of the values: `training`, `leave-one-out`."""
        return self.process.errors

    @property
    def loo_error(self) -> float:
        """The mean square of the leave-one-out residuals as a fraction of the variance of the values."""
        return self.errors["leave-one-out"]

    def leave_one_out_residuals(self) -> FloatArray:
        """Residuals (n,): each value less its prediction from the others, at the hyperparameters of the fit."""
        return self.process.leave_one_out_residuals

    def fit(self, points: FloatArray, values: FloatArray) -> None:
        """Fit to points (n, d) with values (n,), the length scales searched from several starts.

        Raises SurrogateError for points of the wrong shape, too few for the trend, or values that are not finite, InputError
        for points that the inputs cannot have.
        """
        self._points, self._values = self._checked(points, values)
        if self._inputs is not None and len(self._points):
            bases = [self._parameters.basis] * self._dimension
            chosen = families(self._inputs.marginals.values(), 1, bases)
            self._model = PlacedProcess(self.process, coordinates_over(chosen, self._points))
        self._model.fit(self._points, self._values, np.random.default_rng(self._parameters.seed))
        self._optimised = len(self._points)

    def add(self, points: FloatArray, values: FloatArray) -> None:
        """Add points (k, d) with values (k,): the length scales stay, or are optimised from where they are.

        Raises SurrogateError and InputError as `fit`.
        """
        if not self.process.fitted:
            raise SurrogateError("kriging: the model is not fitted; call fit with the first points")
        points, values = self._checked(points, values)
        self._points, self._values = np.vstack([self._points, points]), np.append(self._values, values)
        if len(self._points) - self._optimised < self._parameters.reoptimise_every:
            self._model.extend(points, values)
        else:
            self._reoptimise()

    def predict(self, points: FloatArray) -> FloatArray:
        """Predictions (k,) at points (k, d)."""
        return self._model.predict(points)

    def gradient(self, points: FloatArray) -> FloatArray:
        """Derivatives (k, d) of the prediction at points (k, d); zero by a rounded variable."""
        return self._model.gradient(points)

    def predict_with_gradient(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Predictions (k,) and their derivatives (k, d) at points (k, d), from one matrix of correlations."""
        return self._model.predict_with_gradient(points)

    def deviation(self, points: FloatArray) -> FloatArray:
        """Standard deviations (k,) of the prediction at points (k, d), the uncertainty of the trend included."""
        return self._model.deviation(points)

    def deviation_gradient(self, points: FloatArray) -> FloatArray:
        """Derivatives (k, d) of the standard deviation at points (k, d); zero by a rounded variable."""
        return self._model.deviation_gradient(points)

    def _reoptimise(self) -> None:
        last, parameters = self.process.hyperparameters, self._parameters
        start = replace(last, nugget=last.nugget if parameters.estimate_nugget else parameters.nugget)
        self._model.fit(self._points, self._values, np.random.default_rng(parameters.seed), start)
        self._optimised = len(self._points)

    def _checked(self, points: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
        points, values = checked_data("kriging", self._dimension, points, values)
        return points if self._inputs is None else self._inputs.checked(points), values


def _process(parameters: KrigingParameters) -> GaussianProcess:
    """The Gaussian process that the parameters ask for, not fitted."""
    trend = PolynomialTrend(DEGREES[parameters.trend])
    if parameters.additive_share == 0.0:
        return GaussianProcess(trend, parameters)
    return AdditiveProcess(trend, parameters, additive_basis(parameters.additive_length_scale), parameters.additive_share)


@hookimpl
def railsearch_surrogates(register: Register) -> None:
    """Register `kriging`."""
    register("kriging", Kriging)
