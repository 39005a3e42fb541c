"""What `pce` and `pck` share: a fit on the unit cube or on random inputs in their own units, its errors and predictions."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, Generic, Protocol, Self, TypeVar

import numpy as np

from railsearch.distributions import RandomVector
from railsearch.errors import SurrogateError
from railsearch.space import FloatArray

from ..surrogate_data import checked_data
from .coordinates import unit_cube
from .families import Family, families
from .parameters import PolynomialChaosParameters


class Predictor(Protocol):
    """What predicts."""

    def predict(self, points: FloatArray) -> FloatArray:
        """Predictions (k,) at points (k, d)."""

    def gradient(self, points: FloatArray) -> FloatArray:
        """Their derivatives (k, d)."""

    def predict_with_gradient(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Both at once."""


class Fitted(Protocol):
    """The result of a fit."""

    @property
    def errors(self) -> Mapping[str, float]:
        """Mean squared errors as fractions of the variance of the values; `leave-one-out` is among them."""


ParametersT = TypeVar("ParametersT", bound=PolynomialChaosParameters)
FittedT = TypeVar("FittedT", bound=Fitted)


class ExpansionSurrogate(ABC, Generic[ParametersT, FittedT]):
    """A surrogate with terms of a polynomial chaos expansion; `name` is what its errors call it.

    On the unit cube of a search its polynomials are Legendre's, on random inputs (`for_inputs`) those of their
    distributions.
    """

    name: str

    def __init__(self, dimension: int, parameters: ParametersT, inputs: RandomVector | None = None) -> None:
        self._dimension = dimension
        self._parameters = parameters
        self._inputs = inputs
        self._points = np.empty((0, dimension))
        self._values = np.empty(0)
        self._fitted: FittedT | None = None

    @classmethod
    def for_inputs(cls, inputs: RandomVector, parameters: Any) -> Self:
        """The surrogate on points of these random inputs, in their own units."""
        return cls(inputs.dimension, parameters, inputs)

    @property
    def fitted(self) -> FittedT:
        """What the fit found: terms, residuals and errors. Raises SurrogateError before a fit."""
        return self._known(self._fitted)

    @property
    def errors(self) -> Mapping[str, float]:
        """Mean squared errors as fractions of the variance of the values: `training`, `leave-one-out` and more."""
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
        self._fitted = self._fit(chosen, points, values)
        self._points, self._values = points, values

    def predict(self, points: FloatArray) -> FloatArray:
        """Predictions (k,) at points (k, d)."""
        return self._predictor.predict(np.atleast_2d(points))

    def gradient(self, points: FloatArray) -> FloatArray:
        """Derivatives (k, d) of the prediction at points (k, d)."""
        return self._predictor.gradient(np.atleast_2d(points))

    def predict_with_gradient(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Predictions (k,) and their derivatives (k, d) at points (k, d), from one evaluation of the terms."""
        return self._predictor.predict_with_gradient(np.atleast_2d(points))

    @property
    @abstractmethod
    def _predictor(self) -> Predictor:
        """What predicts after a fit."""

    @abstractmethod
    def _fit(self, polynomials: tuple[Family, ...], points: FloatArray, values: FloatArray) -> FittedT:
        """Fit with these polynomials."""

    def _with(self, points: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The points (n + k, d) and values of the fit with others added. Raises as `fit`, and before the first fit."""
        self._known(self._fitted)
        points, values = self._checked(points, values)
        return np.concatenate([self._points, points]), np.concatenate([self._values, values])

    def _known(self, fitted: FittedT | None) -> FittedT:
        if fitted is None:
            raise SurrogateError(f"{self.name}: the model is not fitted; call fit with the first points")
        return fitted

    def _checked(self, points: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
        points, values = checked_data(self.name, self._dimension, points, values)
        return points if self._inputs is None else self._inputs.checked(points), values
