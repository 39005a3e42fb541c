"""The Gaussian process as a scikit-learn regressor, on inputs in any units."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from sklearn.utils import check_random_state
from sklearn.utils.validation import check_is_fitted, validate_data

from railsearch.distributions import RandomVector
from railsearch.errors import InputError
from railsearch.parameters import make_parameters
from railsearch.space import FloatArray

from ..polynomial_chaos.columns import described_columns
from ..polynomial_chaos.coordinates import Coordinates, coordinates_over, plain_coordinates
from .parameters import INPUT_BOUNDS, GaussianProcessParameters
from .placement import PlacedProcess
from .process import GaussianProcess
from .process_regressor import ProcessRegressor
from .trend import DEGREES, PolynomialTrend, Trend

OWN = ("inputs", "basis", "trend", "random_state")
"""Settings that are not those of the process."""


class KrigingRegressor(ProcessRegressor):
    """Gaussian process with a trend: prediction, standard deviation, gradients and leave-one-out error.

    inputs: the `RandomVector` of the columns in order; the process then lives in the coordinates t of their polynomials
    (see polynomial_chaos/families.py: lognormal inputs in their logarithm), without it in the inputs as they are. basis:
    one for all inputs or one by name, those left out having `own`. trend: `constant`, `linear`, `quadratic`, or any `Trend`
    on these coordinates. The others are those of `GaussianProcessParameters`; length scales and their bounds are fractions
    of the range that a coordinate has in the data. random_state: of the starts of the optimisation.

    After `fit`: `length_scales_` (d,) in the units of the coordinates, `variance_` (of y²), `nugget_` and `nugget_added_`
    (0.0, or what it took beyond the nugget asked for; see system.py), `loo_error`, `loo_residuals` and `errors`.
    Source: Sacks et al. 1989; Dubrule 1983; Bachoc 2013.
    """

    def __init__(
        self,
        *,
        inputs: RandomVector | None = None,
        basis: str | Mapping[str, str] = "own",
        trend: str | Trend = "constant",
        correlation: str = "matern-5/2",
        estimation: str = "maximum-likelihood",
        length_scales: Sequence[float] | None = None,
        length_scale_bounds: Sequence[float] = INPUT_BOUNDS,
        nugget: float = 0.0,
        estimate_nugget: bool = False,
        starts: int = 5,
        random_state: Any = 0,
    ) -> None:
        self.inputs = inputs
        self.basis = basis
        self.trend = trend
        self.correlation = correlation
        self.estimation = estimation
        self.length_scales = length_scales
        self.length_scale_bounds = length_scale_bounds
        self.nugget = nugget
        self.estimate_nugget = estimate_nugget
        self.starts = starts
        self.random_state = random_state

    def fit(self, X: Any, y: Any) -> "KrigingRegressor":
        """Fit to inputs X (n, d) with values y (n,).

        Raises InputError for parameters that are not allowed and values that an input cannot have, ValueError for data that
        scikit-learn refuses, SurrogateError for too few points for the trend.
        """
        X, y = validate_data(self, X, y, dtype=float, y_numeric=True, ensure_min_samples=2)
        coordinates = self._coordinates(X)
        self.process_ = GaussianProcess(self._made_trend(coordinates), self._checked_parameters())
        self._model = PlacedProcess(self.process_, coordinates)
        seed = check_random_state(self.random_state).randint(2**31)
        self._model.fit(X, np.asarray(y, dtype=float), np.random.default_rng(seed))
        self.length_scales_ = self.process_.hyperparameters.length_scales * coordinates.span
        self.variance_ = self.process_.variance
        self.nugget_ = self.process_.hyperparameters.nugget
        self.nugget_added_ = self.process_.nugget_added
        return self

    @property
    def errors(self) -> Mapping[str, float]:
        """Mean squared errors as fractions of the variance of y: `training` at the points, `leave-one-out`."""
        check_is_fitted(self)
        return self.process_.errors

    def _coordinates(self, X: FloatArray) -> Coordinates:
        if self.inputs is None:
            return plain_coordinates(X)
        return coordinates_over(described_columns("KrigingRegressor", self.inputs, self.basis, X).families(1), X)

    def _made_trend(self, coordinates: Coordinates) -> Trend:
        if not isinstance(self.trend, str):
            return _TrendOverRange(self.trend, coordinates.lower, coordinates.span)
        if self.trend not in DEGREES:
            allowed = " or ".join(repr(name) for name in DEGREES)
            raise InputError(f"KrigingRegressor.trend: allowed is {allowed} or a Trend, received {self.trend!r}")
        return PolynomialTrend(DEGREES[self.trend])

    def _checked_parameters(self) -> GaussianProcessParameters:
        values = {key: value for key, value in self.get_params(deep=False).items() if key not in OWN}
        for name in ("length_scales", "length_scale_bounds"):
            if values[name] is not None:
                values[name] = np.ravel(values[name]).tolist()
        return make_parameters(GaussianProcessParameters, values, "KrigingRegressor")


class _TrendOverRange:
    """A trend on coordinates t, for points (t − lower)/span."""

    def __init__(self, trend: Trend, lower: FloatArray, span: FloatArray) -> None:
        self._trend = trend
        self._lower = lower
        self._span = span

    def values(self, points: FloatArray) -> FloatArray:
        return self._trend.values(self._lower + self._span * points)

    def gradient(self, points: FloatArray) -> FloatArray:
        return self._trend.gradient(self._lower + self._span * points) * self._span[:, None]
