"""PC-Kriging as a scikit-learn regressor, on inputs in any units."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from sklearn.utils import check_random_state
from sklearn.utils.validation import check_is_fitted, validate_data

from railsearch.distributions import RandomVector
from railsearch.parameters import make_parameters

from ..gaussian_process.parameters import INPUT_BOUNDS
from ..gaussian_process.process_regressor import ProcessRegressor
from ..polynomial_chaos.columns import described_columns
from .model import fit_polynomial_chaos_kriging
from .parameters import PolynomialChaosKrigingParameters

OWN = ("inputs", "basis", "random_state")
"""Settings that are not those of the mathematics."""


class PolynomialChaosKrigingRegressor(ProcessRegressor):
    """PC-Kriging: prediction, standard deviation, gradients and leave-one-out error.

    inputs: the `RandomVector` of the columns in order; without it each is uniform over the range that it has in the data.
    basis: one for all inputs or one by name, those left out having `own`. The others are those of
    `PolynomialChaosKrigingParameters`; length scales and their bounds are fractions of the range that an input has in the
    data, a lognormal one in its logarithm. random_state: of the starts of the optimisation.

    After `fit`: `terms_`, the multi-indices (p, d) of the trend, `expansion_`, the expansion that was searched, `process_`,
    the Gaussian process, `nugget_added_` (0.0, or what it took beyond the nugget asked for), `loo_error`, `loo_residuals`
    and `errors`. Source: Schöbi, Sudret & Wiart 2015.
    """

    def __init__(
        self,
        *,
        inputs: RandomVector | None = None,
        variant: str = "sequential",
        degree: int = 15,
        norms: Sequence[float] = (0.5, 0.75, 1.0),
        basis: str | Mapping[str, str] = "own",
        candidates_per_point: float = 2.0,
        target_error: float = 0.0,
        stop_early: bool = False,
        growth: bool = True,
        correlation: str = "gaussian",
        estimation: str = "restricted-maximum-likelihood",
        length_scales: Sequence[float] | None = None,
        length_scale_bounds: Sequence[float] = INPUT_BOUNDS,
        nugget: float = 0.0,
        estimate_nugget: bool = False,
        starts: int = 5,
        random_state: Any = 0,
    ) -> None:
        self.inputs = inputs
        self.variant = variant
        self.degree = degree
        self.norms = norms
        self.basis = basis
        self.candidates_per_point = candidates_per_point
        self.target_error = target_error
        self.stop_early = stop_early
        self.growth = growth
        self.correlation = correlation
        self.estimation = estimation
        self.length_scales = length_scales
        self.length_scale_bounds = length_scale_bounds
        self.nugget = nugget
        self.estimate_nugget = estimate_nugget
        self.starts = starts
        self.random_state = random_state

    def fit(self, X: Any, y: Any) -> "PolynomialChaosKrigingRegressor":
        """Fit to inputs X (n, d) with values y (n,).

        Raises InputError for parameters that are not allowed and values that an input cannot have, ValueError for data that
        scikit-learn refuses, SurrogateError for too few points.
        """
        X, y = validate_data(self, X, y, dtype=float, y_numeric=True, ensure_min_samples=2)
        settings = self._checked_parameters()
        columns = described_columns("PolynomialChaosKrigingRegressor", self.inputs, self.basis, X)
        generator = np.random.default_rng(check_random_state(self.random_state).randint(2**31))
        values = np.asarray(y, dtype=float)
        self._fitted = fit_polynomial_chaos_kriging(columns.families(settings.degree), X, values, settings, generator)
        self._model, self.terms_ = self._fitted.model, self._fitted.indices
        self.expansion_, self.process_ = self._fitted.expansion.expansion, self._model.process
        self.nugget_added_ = self.process_.nugget_added
        return self

    @property
    def errors(self) -> Mapping[str, float]:
        """Mean squared errors as fractions of the variance of y.

        `training` at the points; `leave-one-out`, which is too small where many terms were chosen by the same points; and
        for this reason `corrected-expansion`, the corrected leave-one-out error of the expansion that was found.
        """
        check_is_fitted(self)
        return self._fitted.errors

    def _checked_parameters(self) -> PolynomialChaosKrigingParameters:
        values = {key: value for key, value in self.get_params(deep=False).items() if key not in OWN}
        for name in ("norms", "length_scales", "length_scale_bounds"):
            if values[name] is not None:
                values[name] = np.ravel(values[name]).tolist()
        return make_parameters(PolynomialChaosKrigingParameters, values, "PolynomialChaosKrigingRegressor")
