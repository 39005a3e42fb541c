"""Sparse polynomial chaos as a scikit-learn regressor, on inputs in any units."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from sklearn.base import BaseEstimator, RegressorMixin
from sklearn.utils.validation import check_is_fitted, validate_data

from railsearch.distributions import RandomVector
from railsearch.parameters import make_parameters
from railsearch.space import FloatArray

from .columns import described_columns
from .expansion import Expansion
from .parameters import PolynomialChaosParameters
from .search import fit_expansion


class PolynomialChaosRegressor(RegressorMixin, BaseEstimator):  # type: ignore[misc]
    """Sparse polynomial chaos expansion: prediction, gradient, moments, Sobol' indices and leave-one-out error.

    inputs: the `RandomVector` of the columns in order; without it each is uniform over the range that it has in the data.
    basis: one for all inputs or one by name, those left out having `own`. The others are those of
    `PolynomialChaosParameters`.

    After `fit`: `expansion_` (moments, indices, families), `loo_error`, `loo_residuals`, `errors`, and `trials_`, the
    sets of terms that were searched. Source: Blatman & Sudret 2011; Sudret 2008.
    """

    def __init__(
        self,
        *,
        inputs: RandomVector | None = None,
        degree: int = 15,
        norms: Sequence[float] = (0.5, 0.75, 1.0),
        basis: str | Mapping[str, str] = "own",
        candidates_per_point: float = 2.0,
        target_error: float = 0.0,
        stop_early: bool = False,
        growth: bool = True,
    ) -> None:
        self.inputs = inputs
        self.degree = degree
        self.norms = norms
        self.basis = basis
        self.candidates_per_point = candidates_per_point
        self.target_error = target_error
        self.stop_early = stop_early
        self.growth = growth

    def fit(self, X: Any, y: Any) -> "PolynomialChaosRegressor":
        """Fit to inputs X (n, d) with values y (n,).

        Raises InputError for parameters that are not allowed and values that an input cannot have, ValueError for data that
        scikit-learn refuses, SurrogateError for too few points.
        """
        X, y = validate_data(self, X, y, dtype=float, y_numeric=True, ensure_min_samples=2)
        settings = self._checked_parameters()
        columns = described_columns("PolynomialChaosRegressor", self.inputs, self.basis, X)
        self._fitted = fit_expansion(columns.families(settings.degree), X, np.asarray(y, dtype=float), settings)
        self.expansion_: Expansion = self._fitted.expansion
        self.trials_ = self._fitted.trials
        return self

    def predict(self, X: Any) -> FloatArray:
        """Predictions (k,) at inputs X (k, d)."""
        check_is_fitted(self)
        return self.expansion_.predict(validate_data(self, X, dtype=float, reset=False))

    def gradient(self, X: Any) -> FloatArray:
        """Derivatives (k, d) of the prediction at inputs X (k, d)."""
        check_is_fitted(self)
        return self.expansion_.gradient(validate_data(self, X, dtype=float, reset=False))

    @property
    def loo_residuals(self) -> FloatArray:
        """Each value less its prediction from the others (n,), with the same terms."""
        check_is_fitted(self)
        return self._fitted.leave_one_out

    @property
    def loo_error(self) -> float:
        """The mean square of the leave-one-out residuals as a fraction of the variance of y."""
        return self.errors["leave-one-out"]

    @property
    def errors(self) -> Mapping[str, float]:
        """Mean squared errors as fractions of the variance of y.

        `training` at the points, `leave-one-out`, and this `corrected` for the number of points, by which terms are chosen.
        """
        check_is_fitted(self)
        return self._fitted.errors

    def _checked_parameters(self) -> PolynomialChaosParameters:
        values = {key: value for key, value in self.get_params(deep=False).items() if key not in ("inputs", "basis")}
        values["norms"] = np.ravel(values["norms"]).tolist()
        return make_parameters(PolynomialChaosParameters, values, "PolynomialChaosRegressor")
