"""Gaussian process with a trend (universal Kriging): fit, prediction, standard deviation and their gradients.

| symbol | meaning | shape | unit | source |
|---|---|---|---|---|
| x | points of the unit cube | (k, d) | - | |
| f | trend functions at x | (k, p) | - | Sacks et al. 1989 |
| r | correlations of x with the points of the fit | (k, n) | - | |
| ŷ | prediction fᵀβ + rᵀα | (k,) | of y | Sacks et al. 1989, equation 7 |
| v, w | L⁻¹r and S⁻ᵀ(f − Gᵀv) | (n, k), (p, k) | - | |
| s² | variance σ²(1 − vᵀv + wᵀw), w the uncertain trend's part | (k,) | of y² | Sacks et al. 1989, equation 9 |

Values are centred on their least-squares trend and divided by the root mean square of what is left, so that the process
has a variance about one whatever the unit; see system.py for L, G, S, α and β.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
from scipy.linalg import solve_triangular

from railsearch.errors import SurrogateError
from railsearch.space import FloatArray

from ..surrogate_data import relative_error
from .correlation import CORRELATIONS, correlations
from .estimation import Hyperparameters, estimated, solved
from .parameters import GaussianProcessParameters
from .system import Solution, Training, extend, leave_one_out
from .trend import Trend

BLOCK = 2**20
"""Predictions are made for so many pairs of points at a time, which bounds the memory they take."""

FLAT = 1e-14
"""What a trend leaves of the values counts as nothing below this fraction of them."""


class GaussianProcess:
    """A trend and a stationary process through points of the unit cube; more points at fixed length scales cost O(n²).

    After `fit`: hyperparameters (those in use; the nugget too), variance (σ² in units of the values squared),
    nugget_added (0.0, or by how much the nugget had to exceed the one asked for).
    """

    def __init__(self, trend: Trend, parameters: GaussianProcessParameters) -> None:
        self._trend = trend
        self._parameters = parameters
        self._correlation = CORRELATIONS[parameters.correlation]
        self._training: Training | None = None
        self._variance: float | None = None
        self.hyperparameters = Hyperparameters(np.empty(0), parameters.nugget)
        self.nugget_added = 0.0

    @property
    def fitted(self) -> bool:
        """Whether there is something to predict from."""
        return self._training is not None

    def fit(
        self,
        points: FloatArray,
        values: FloatArray,
        generator: np.random.Generator,
        start: Hyperparameters | None = None,
    ) -> None:
        """Fit to points (n, d) with values (n,); hyperparameters are searched from `start` alone if it is given.

        Raises SurrogateError for fewer points than trend functions and one more, or points that do not tell them apart.
        """
        trend = self._checked_trend(points)
        coefficients, *_ = np.linalg.lstsq(trend, values)
        rest = values - trend @ coefficients
        spread = float(np.sqrt(np.mean(rest**2)))
        flat = spread <= FLAT * float(np.max(np.abs(values)))
        self._centre, self._scale = coefficients, 1.0 if flat else spread
        training = Training(points, trend, np.zeros(len(values)) if flat else rest / spread)
        self._use(training, self._estimated(training, generator, start))

    def extend(self, points: FloatArray, values: FloatArray) -> None:
        """Add points (k, d) with values (k,) at the present hyperparameters."""
        training, solution = self._state()
        trend = self._trend.values(points)
        added = Training(points, trend, (values - trend @ self._centre) / self._scale)
        cross, _ = self._correlations(training.points, points)
        corner, _ = self._correlations(points, points)
        extended = extend(solution, cross, corner + self.hyperparameters.nugget * np.eye(len(points)), added)
        joined = training.joined(added)
        if extended is None:
            self._use(joined, self.hyperparameters)
        else:
            self._training, self._solution, self._variance = joined, extended, None

    def predict(self, points: FloatArray) -> FloatArray:
        """Predictions ŷ (k,) at points (k, d)."""
        return self._in_blocks(self._predict, points)

    def gradient(self, points: FloatArray) -> FloatArray:
        """Derivatives (k, d) of ŷ at points (k, d); kinks of the correlation give zero."""
        return self._in_blocks(self._gradient, points)

    def predict_with_gradient(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Predictions (k,) and their derivatives (k, d) at points (k, d), from one matrix of correlations."""
        values, gradients = zip(*map(self._predict_with_gradient, self._blocks(points)), strict=True)
        return np.concatenate(values), np.concatenate(gradients)

    def deviation(self, points: FloatArray) -> FloatArray:
        """Standard deviations s (k,) of the prediction at points (k, d), without the noise of an observation."""
        return self._in_blocks(self._deviation, points)

    def deviation_gradient(self, points: FloatArray) -> FloatArray:
        """Derivatives (k, d) of s at points (k, d); zero where s is zero, which is a kink."""
        return self._in_blocks(self._deviation_gradient, points)

    @property
    def variance(self) -> float:
        """The process variance σ²: of either likelihood, or with leave-one-out the mean of e² q, of Bachoc 2013."""
        return self._scale**2 * self._standard_variance()

    @property
    def coefficients(self) -> FloatArray:
        """The trend coefficients β (p,)."""
        return self._centre + self._scale * self._state()[1].coefficients

    @property
    def leave_one_out_residuals(self) -> FloatArray:
        """Residuals (n,): each value less its prediction from the others, at the hyperparameters of the fit."""
        residuals, _ = leave_one_out(self._state()[1])
        return self._scale * residuals

    @property
    def training_residuals(self) -> FloatArray:
        """Residuals (n,): each value less the prediction there, (y − Fβ) − (R − ν I) α = ν α; zero without a nugget."""
        return self._scale * self.hyperparameters.nugget * self._state()[1].weights

    @property
    def errors(self) -> Mapping[str, float]:
        """Mean squared errors as fractions of the variance of the values: `training` at the points, `leave-one-out`."""
        training, _ = self._state()
        variance = float(np.var(training.trend @ self._centre + self._scale * training.values))
        residuals = {"training": self.training_residuals, "leave-one-out": self.leave_one_out_residuals}
        return {name: relative_error(errors, variance) for name, errors in residuals.items()}

    def _checked_trend(self, points: FloatArray) -> FloatArray:
        trend = self._trend.values(points)
        n, p = trend.shape
        if n < p + 1:
            raise SurrogateError(f"kriging: a trend of {p} functions needs {p + 1} points or more, received {n}")
        rank = int(np.linalg.matrix_rank(trend))
        if rank < p:
            raise SurrogateError(
                f"kriging: the {n} points tell only {rank} of the {p} functions of the trend apart: add points, or take a "
                "simpler trend"
            )
        return trend

    def _use(self, training: Training, wanted: Hyperparameters) -> None:
        self._solution, nugget = self._solved(training, wanted)
        self._training, self._variance = training, None
        self.nugget_added = nugget - wanted.nugget
        self.hyperparameters = replace(wanted, nugget=nugget)

    def _estimated(
        self, training: Training, generator: np.random.Generator, start: Hyperparameters | None
    ) -> Hyperparameters:
        return estimated(training, self._parameters, generator, start)

    def _solved(self, training: Training, at: Hyperparameters) -> tuple[Solution, float]:
        return solved(training, self._parameters, at)

    def _state(self) -> tuple[Training, Solution]:
        if self._training is None:
            raise SurrogateError("kriging: the model is not fitted; call fit with the first points")
        return self._training, self._solution

    def _standard_variance(self) -> float:
        if self._variance is None:
            solution = self._state()[1]
            if self._parameters.estimation == "maximum-likelihood":
                self._variance = solution.variance
            elif self._parameters.estimation == "restricted-maximum-likelihood":
                self._variance = solution.restricted_variance
            else:
                residuals, precisions = leave_one_out(solution)
                self._variance = float(np.mean(residuals**2 * precisions))
        return self._variance

    def _correlations(self, points: FloatArray, others: FloatArray) -> tuple[FloatArray, FloatArray]:
        return correlations(self._correlation, points, others, self.hyperparameters.length_scales)

    def _in_blocks(self, function: Callable[[FloatArray], FloatArray], points: FloatArray) -> FloatArray:
        return np.concatenate([function(block) for block in self._blocks(points)])

    def _blocks(self, points: FloatArray) -> list[FloatArray]:
        size = max(1, BLOCK // self._state()[0].size)
        return [points[start : start + size] for start in range(0, max(len(points), 1), size)]

    def _predict(self, points: FloatArray) -> FloatArray:
        values, _ = self._correlations(points, self._state()[0].points)
        return self._mean(points, values)

    def _gradient(self, points: FloatArray) -> FloatArray:
        _, slopes = self._correlations(points, self._state()[0].points)
        return self._mean_gradient(points, slopes)

    def _predict_with_gradient(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        values, slopes = self._correlations(points, self._state()[0].points)
        return self._mean(points, values), self._mean_gradient(points, slopes)

    def _mean(self, points: FloatArray, correlations: FloatArray) -> FloatArray:
        """ŷ (k,) with the correlations (k, n) at hand."""
        predicted: FloatArray = self._trend.values(points) @ self.coefficients
        return predicted + self._scale * (correlations @ self._state()[1].weights)

    def _mean_gradient(self, points: FloatArray, slopes: FloatArray) -> FloatArray:
        """Its derivatives (k, d) with the slopes g (k, n) at hand."""
        gradient: FloatArray = self._trend.gradient(points) @ self.coefficients
        return gradient - self._scale * self._descent(points, slopes, self._state()[1].weights[None, :])

    def _descent(self, points: FloatArray, slopes: FloatArray, weights: FloatArray) -> FloatArray:
        """−Σ_k weights_k ∂R/∂x = Σ_k weights_k g_k (x − x_k)/θ² (k, d), slopes g (k, n), weights (k, n) or (1, n)."""
        training, _ = self._state()
        weights = slopes * weights
        differences: FloatArray = weights.sum(axis=1, keepdims=True) * points - weights @ training.points
        return differences / self.hyperparameters.length_scales**2

    def _whitened(self, points: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """v (n, k), w (p, k) and the slopes g (k, n) of the correlations."""
        training, solution = self._state()
        values, slopes = self._correlations(points, training.points)
        v = solve_triangular(solution.lower, values.T, lower=True, check_finite=False)
        trend = solve_triangular(solution.triangle, self._trend.values(points).T, trans="T", check_finite=False)
        return v, trend - solution.orthogonal.T @ v, slopes

    def _share(self, v: FloatArray, w: FloatArray) -> FloatArray:
        """s²/σ² (k,)."""
        share: FloatArray = np.maximum(1.0 - np.sum(v * v, axis=0) + np.sum(w * w, axis=0), 0.0)
        return share

    def _deviation(self, points: FloatArray) -> FloatArray:
        v, w, _ = self._whitened(points)
        deviation: FloatArray = np.sqrt(self.variance * self._share(v, w))
        return deviation

    def _deviation_gradient(self, points: FloatArray) -> FloatArray:
        _, solution = self._state()
        v, w, slopes = self._whitened(points)
        pulled = solve_triangular(solution.lower, v + solution.orthogonal @ w, lower=True, trans="T", check_finite=False)
        by_trend = solve_triangular(solution.triangle, w, check_finite=False)
        half = self._descent(points, slopes, pulled.T) + np.einsum("kdp,pk->kd", self._trend.gradient(points), by_trend)
        share = self._share(v, w)[:, None]
        slope: FloatArray = np.divide(half, np.sqrt(share), out=np.zeros_like(half), where=share > 0.0)
        return math.sqrt(self.variance) * slope
