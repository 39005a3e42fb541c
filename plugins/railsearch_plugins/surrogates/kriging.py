"""Surrogate `kriging`: a Gaussian process with a trend, fitted by maximum likelihood or leave-one-out."""

from dataclasses import dataclass

import numpy as np

from railsearch.errors import InputError, SurrogateError
from railsearch.hookspecs import Register, hookimpl
from railsearch.interfaces import parameter
from railsearch.space import FloatArray

from ..gaussian_process.estimation import Hyperparameters, given_length_scales
from ..gaussian_process.parameters import GaussianProcessParameters
from ..gaussian_process.process import GaussianProcess
from ..gaussian_process.trend import DEGREES, PolynomialTrend


@dataclass(frozen=True)
class KrigingParameters(GaussianProcessParameters):
    """What can be set of the surrogate."""

    trend: str = parameter("constant", meaning="trend under the process", source="Sacks et al. 1989", choices=tuple(DEGREES))
    integer_steps: tuple[int, ...] = parameter(
        (),
        meaning="steps over the range by variable, to which inputs are rounded, 0 for a real one; if empty, all are real",
        source="Garrido-Merchán & Hernández-Lobato 2020",
        minimum=0,
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

    Source: Sacks et al. 1989; Dubrule 1983; Bachoc 2013; Garrido-Merchán and Hernández-Lobato 2020 for integers, which are
    rounded before anything else, so that the prediction is constant, and its gradient zero, between them.
    """

    Parameters = KrigingParameters
    add_tolerance = 0.05

    def __init__(self, dimension: int, parameters: KrigingParameters) -> None:
        if parameters.integer_steps and len(parameters.integer_steps) != dimension:
            raise InputError(
                f"kriging: integer_steps needs one number for each of {dimension} variables (0 for a real one), received "
                f"{list(parameters.integer_steps)}"
            )
        if parameters.length_scales is not None:
            given_length_scales(parameters, dimension)
        self._dimension = dimension
        self._parameters = parameters
        self._steps = np.array(parameters.integer_steps or [0] * dimension, dtype=float)
        self._process = GaussianProcess(PolynomialTrend(DEGREES[parameters.trend]), parameters)
        self._points = np.empty((0, dimension))
        self._values = np.empty(0)
        self._optimised = 0

    @property
    def process(self) -> GaussianProcess:
        """The Gaussian process itself: its hyperparameters, variance, nugget and leave-one-out residuals."""
        return self._process

    def fit(self, points: FloatArray, values: FloatArray) -> None:
        """Fit to points (n, d) of the unit cube with values (n,), the length scales searched from several starts.

        Raises SurrogateError for points of the wrong shape, too few for the trend, or values that are not finite.
        """
        self._points, self._values = self._checked(points, values)
        self._process.fit(self._points, self._values, np.random.default_rng(self._parameters.seed))
        self._optimised = len(self._points)

    def add(self, points: FloatArray, values: FloatArray) -> None:
        """Add points (k, d) with values (k,): the length scales stay, or are optimised from where they are.

        Raises SurrogateError as `fit`.
        """
        if not self._process.fitted:
            raise SurrogateError("kriging: the model is not fitted; call fit with the first points")
        points, values = self._checked(points, values)
        self._points, self._values = np.vstack([self._points, points]), np.append(self._values, values)
        if len(self._points) - self._optimised < self._parameters.reoptimise_every:
            self._process.extend(points, values)
        else:
            self._reoptimise()

    def predict(self, points: FloatArray) -> FloatArray:
        """Predictions (k,) at points (k, d)."""
        return self._process.predict(self._rounded(points))

    def gradient(self, points: FloatArray) -> FloatArray:
        """Derivatives (k, d) of the prediction at points (k, d); zero by a rounded variable."""
        return np.where(self._steps > 0.0, 0.0, self._process.gradient(self._rounded(points)))

    def deviation(self, points: FloatArray) -> FloatArray:
        """Standard deviations (k,) of the prediction at points (k, d), the uncertainty of the trend included."""
        return self._process.deviation(self._rounded(points))

    def deviation_gradient(self, points: FloatArray) -> FloatArray:
        """Derivatives (k, d) of the standard deviation at points (k, d); zero by a rounded variable."""
        return np.where(self._steps > 0.0, 0.0, self._process.deviation_gradient(self._rounded(points)))

    def _reoptimise(self) -> None:
        last, parameters = self._process.hyperparameters, self._parameters
        start = Hyperparameters(last.length_scales, last.nugget if parameters.estimate_nugget else parameters.nugget)
        self._process.fit(self._points, self._values, np.random.default_rng(parameters.seed), start)
        self._optimised = len(self._points)

    def _rounded(self, points: FloatArray) -> FloatArray:
        points = np.atleast_2d(points)
        whole = self._steps > 0.0
        if not whole.any():
            return points
        return np.where(whole, np.round(points * self._steps) / np.where(whole, self._steps, 1.0), points)

    def _checked(self, points: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
        points, values = np.array(points, dtype=float), np.array(values, dtype=float)
        if points.ndim != 2 or points.shape[1] != self._dimension or values.shape != (len(points),):
            raise SurrogateError(
                f"kriging: points (n, {self._dimension}) and values (n,) are needed, received shapes {points.shape} and "
                f"{values.shape}"
            )
        if not (np.isfinite(points).all() and np.isfinite(values).all()):
            raise SurrogateError("kriging: finite points and values are needed; leave failed evaluations out of the fit")
        return self._rounded(points), values


@hookimpl
def railsearch_surrogates(register: Register) -> None:
    """Register `kriging`."""
    register("kriging", Kriging)
