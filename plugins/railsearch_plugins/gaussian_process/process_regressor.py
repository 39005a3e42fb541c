"""What regressors with a Gaussian process share: predictions, gradients, leave-one-out errors."""

from abc import abstractmethod
from collections.abc import Mapping
from typing import Any

from sklearn.base import BaseEstimator, RegressorMixin
from sklearn.utils.validation import check_is_fitted, validate_data

from railsearch.space import FloatArray

from .placement import PlacedProcess
from .process import GaussianProcess


class ProcessRegressor(RegressorMixin, BaseEstimator):  # type: ignore[misc]
    """A regressor whose `fit` leaves a `process_`, and a `_model` that places it in the inputs' own units."""

    process_: GaussianProcess
    _model: PlacedProcess

    def predict(self, X: Any, return_std: bool = False) -> FloatArray | tuple[FloatArray, FloatArray]:
        """Predictions (k,) at inputs X (k, d), with their standard deviations (k,) if these are asked for."""
        points = self._checked(X)
        predicted = self._model.predict(points)
        return (predicted, self._model.deviation(points)) if return_std else predicted

    def gradient(self, X: Any) -> FloatArray:
        """Derivatives (k, d) of the prediction at inputs X (k, d)."""
        return self._model.gradient(self._checked(X))

    def deviation_gradient(self, X: Any) -> FloatArray:
        """Derivatives (k, d) of the standard deviation at inputs X (k, d)."""
        return self._model.deviation_gradient(self._checked(X))

    @property
    def loo_residuals(self) -> FloatArray:
        """Each value less its prediction from the others (n,), at the same trend and scales. Source: Dubrule 1983."""
        check_is_fitted(self)
        return self.process_.leave_one_out_residuals

    @property
    def loo_error(self) -> float:
        """The mean square of the leave-one-out residuals as a fraction of the variance of y."""
        return self.errors["leave-one-out"]

    @property
    @abstractmethod
    def errors(self) -> Mapping[str, float]:
        """Mean squared errors as fractions of the variance of y, `leave-one-out` among them."""

    def _checked(self, X: Any) -> FloatArray:
        check_is_fitted(self)
        points: FloatArray = validate_data(self, X, dtype=float, reset=False)
        return points
