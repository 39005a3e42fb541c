"""Length scales and nugget by maximum likelihood or leave-one-out, with analytic gradients.

| symbol | meaning | shape | unit | source |
|---|---|---|---|---|
| η | what is optimised: log θ, and log ν if the nugget is estimated | (d,) or (d + 1,) | - | |
| σ̂² | (y − Fβ)ᵀR⁻¹(y − Fβ)/n | scalar | - | Sacks et al. 1989 |
| e, q | leave-one-out residuals α/q, q = diag Q | (n,) | - | Dubrule 1983 |
| M | derivative of a criterion by R: dc = tr(M dR) | (n, n) | - | |
| τ, μ | standard deviation and mean log(√d/2) of log θ before the data | scalars | - | Hvarfner et al. 2024 |
| D_r | squared differences (x_r − x'_r)² of the points | (n, n) | - | |

Criteria, all free of the scale of y: maximum likelihood c = log σ̂² + log det R/n (β and σ² profiled out), restricted maximum
likelihood c = log σ̃² + (log det R + log det FᵀR⁻¹F)/(n − p) with σ̃² = σ̂² n/(n − p) (Patterson & Thompson 1971; β integrated
out, so that it does not take a long trend for small correlations), and leave-one-out c = log Σ e². With
Q = R⁻¹ − R⁻¹F(FᵀR⁻¹F)⁻¹FᵀR⁻¹ and dQ = −Q dR Q,

    maximum likelihood  M = (R⁻¹ − ααᵀ/σ̂²)/n
    restricted          M = (Q − ααᵀ/σ̃²)/(n − p)
    leave-one-out       M = 2 (Q diag(e²/q) Q − α sᵀ)/Σ e²,  s = Q (e/q)

and, as ∂R/∂ log θ_r = g ∘ D_r/θ_r², the gradient Σ_ij M_ij g_ij D_r,ij/θ_r² takes one product of matrices for all r. A prior
of the length scales adds −2/n times its log-density, Σ (log θ − μ)²/(n τ²), so that few points do not tell variables apart
by chance.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import minimize

from railsearch.errors import InputError
from railsearch.space import FloatArray

from .correlation import CORRELATIONS, correlations
from .parameters import SEARCH_BOUNDS, GaussianProcessParameters
from .system import Solution, Training, factorise, inverse, leave_one_out, projection, solve

SUBSET = 300
"""Where there are more points than this, starts are compared on a random subset of this size."""

POINTS_PER_FUNCTION = 2
"""The subset has no fewer points for each function of the trend."""

NUGGETS = (1e-8, 1.0)
"""Least and largest nugget that may be estimated."""

ISOTROPIC_STARTS = np.geomspace(0.05, 5.0, 8)
"""Common length scales, in units of √d, of which the best one is where the optimisation starts."""

SPREAD = 1.0
"""Standard deviation of log θ of the further starts around it."""

NUGGET_START = 1e-3
"""Where the estimation of the nugget starts."""

ITERATIONS = 100
"""Limit of the quasi-Newton iterations of one start."""

TOLERANCE = 1e-6
"""The optimisation ends where an iteration lowers the criterion by less than this fraction of it."""

SMALLEST = 1e-300
"""Least sum of squares that is told from zero, so that values on the trend itself have a finite logarithm."""

Criterion = Callable[[Solution], tuple[float, FloatArray]]
"""A criterion c and its derivative M by R; only M + Mᵀ counts."""


@dataclass(frozen=True)
class Hyperparameters:
    """Length scales θ (d,), the nugget ν, and the share of a sum over the variables where there is one."""

    length_scales: FloatArray
    nugget: float
    share: float = 0.0


def likelihood(solution: Solution) -> tuple[float, FloatArray]:
    """log σ̂² + log det R/n: −2/n times the profiled log-likelihood, without its constant."""
    variance = max(solution.variance, SMALLEST)
    n = len(solution.residual)
    value = np.log(variance) + 2.0 * float(np.sum(np.log(np.diagonal(solution.lower)))) / n
    derivative = inverse(solution) * 2.0
    derivative.flat[:: n + 1] *= 0.5
    derivative -= np.outer(solution.weights / variance, solution.weights)
    return value, derivative / n


def restricted_likelihood(solution: Solution) -> tuple[float, FloatArray]:
    """log σ̂² + (log det R + log det FᵀR⁻¹F)/(n − p), σ̂² with divisor n − p: the likelihood of what no trend explains."""
    variance = max(solution.restricted_variance, SMALLEST)
    n, p = solution.orthogonal.shape
    determinant = 2.0 * float(np.sum(np.log(np.diagonal(solution.lower))))
    determinant += 2.0 * float(np.sum(np.log(np.abs(np.diagonal(solution.triangle)))))
    derivative = projection(solution) - np.outer(solution.weights / variance, solution.weights)
    return np.log(variance) + determinant / (n - p), derivative / (n - p)


def leave_one_out_error(solution: Solution) -> tuple[float, FloatArray]:
    """log Σ e² of the leave-one-out residuals."""
    residuals, precisions = leave_one_out(solution)
    total = max(float(residuals @ residuals), SMALLEST)
    projected = projection(solution)
    ratio = residuals / precisions
    half = projected * np.sqrt(ratio * residuals)
    derivative = half @ half.T - np.outer(solution.weights, projected @ ratio)
    return float(np.log(total)), derivative * (2.0 / total)


CRITERIA: dict[str, Criterion] = {
    "maximum-likelihood": likelihood,
    "restricted-maximum-likelihood": restricted_likelihood,
    "leave-one-out": leave_one_out_error,
}


def solved(training: Training, parameters: GaussianProcessParameters, at: Hyperparameters) -> tuple[Solution, float]:
    """The equations solved at given hyperparameters, and the nugget that it took."""
    values, _ = correlations(CORRELATIONS[parameters.correlation], training.points, training.points, at.length_scales)
    lower, nugget = factorise(values, at.nugget)
    return solve(lower, training), nugget


def criterion(
    training: Training, parameters: GaussianProcessParameters, at: Hyperparameters
) -> tuple[float, FloatArray, float]:
    """The criterion c at given hyperparameters, its derivatives by log θ (d,), and that by log ν."""
    points, scales = training.points - 0.5, at.length_scales
    values, slopes = correlations(CORRELATIONS[parameters.correlation], points, points, scales)
    lower, nugget = factorise(values, at.nugget)
    value, derivative = CRITERIA[parameters.estimation](solve(lower, training))
    by_nugget = nugget * float(np.trace(derivative))
    weighted = np.multiply(derivative, slopes, out=derivative)
    return value, by_length_scales(weighted, points, scales), by_nugget


def by_length_scales(weighted: FloatArray, points: FloatArray, scales: FloatArray) -> FloatArray:
    """Σ_ij M_ij g_ij D_r,ij/θ_r² (d,), the derivatives by log θ, with M ∘ g (n, n) at hand."""
    sums = weighted.sum(axis=0) + weighted.sum(axis=1)
    derivatives: FloatArray = (sums @ points**2 - 2.0 * np.sum(points * (weighted @ points), axis=0)) / scales**2
    return derivatives


def estimated(
    training: Training,
    parameters: GaussianProcessParameters,
    generator: np.random.Generator,
    start: Hyperparameters | None = None,
) -> Hyperparameters:
    """The hyperparameters of least criterion, searched from `start` alone or, without it, from several starts."""
    dimension = training.points.shape[1]
    if parameters.length_scales is not None and not parameters.estimate_nugget:
        return Hyperparameters(given_length_scales(parameters, dimension), parameters.nugget)
    if start is not None:
        return _minimised(training, parameters, start)[0]
    small = subset(training, generator)
    begun = starts(small, parameters, generator, lambda at: criterion(small, parameters, at)[0])
    found = [_minimised(small, parameters, at) for at in begun]
    best, _ = min(found, key=lambda pair: pair[1])
    return best if small is training else _minimised(training, parameters, best)[0]


def subset(training: Training, generator: np.random.Generator) -> Training:
    """The rows on which starts are compared: all, or a random choice of them where there are many."""
    enough = max(SUBSET, POINTS_PER_FUNCTION * training.trend.shape[1])
    if training.size <= enough:
        return training
    return training.rows(np.sort(generator.permutation(training.size)[:enough]))


def given_length_scales(parameters: GaussianProcessParameters, dimension: int) -> FloatArray:
    """The fixed length scales (d,). Raises InputError if there are neither d of them nor one."""
    given = np.array(parameters.length_scales, dtype=float)
    if len(given) not in (1, dimension):
        raise InputError(f"length_scales: one or {dimension} are needed, received {len(given)}")
    return np.broadcast_to(given, dimension).copy()


def starts(
    training: Training,
    parameters: GaussianProcessParameters,
    generator: np.random.Generator,
    worth: Callable[[Hyperparameters], float],
) -> list[Hyperparameters]:
    """The common length scale of least `worth`, and random ones by variable around it."""
    dimension = training.points.shape[1]
    nugget = NUGGET_START if parameters.estimate_nugget else parameters.nugget
    if parameters.length_scales is not None:
        return [Hyperparameters(given_length_scales(parameters, dimension), nugget)]
    lowest, highest = parameters.length_scale_bounds or SEARCH_BOUNDS
    common = np.clip(ISOTROPIC_STARTS * np.sqrt(dimension), lowest, highest)
    best = min([Hyperparameters(np.full(dimension, scale), nugget) for scale in common], key=worth)
    steps = SPREAD * generator.standard_normal((parameters.starts - 1, dimension))
    return [best] + [Hyperparameters(np.clip(best.length_scales * np.exp(step), lowest, highest), nugget) for step in steps]


@dataclass(frozen=True)
class Unknowns:
    """What is optimised, η: log θ where it is not given, log ν where it is estimated."""

    parameters: GaussianProcessParameters
    given: Hyperparameters

    @property
    def n_scales(self) -> int:
        """How many of η are length scales: d or none."""
        return len(self.given.length_scales) if self.parameters.length_scales is None else 0

    @property
    def start(self) -> FloatArray:
        """η at the given hyperparameters."""
        nuggets = [max(self.given.nugget, NUGGETS[0])] * self.parameters.estimate_nugget
        logarithms: FloatArray = np.log(np.append(self.given.length_scales[: self.n_scales], nuggets))
        return logarithms

    @property
    def bounds(self) -> list[tuple[float, float]]:
        """The least and the largest of each."""
        scales = [self.parameters.length_scale_bounds or SEARCH_BOUNDS] * self.n_scales
        return [tuple(np.log(pair)) for pair in scales + [NUGGETS] * self.parameters.estimate_nugget]

    def hyperparameters(self, eta: FloatArray) -> Hyperparameters:
        """The hyperparameters at η, those that are not part of it as given."""
        scales = np.exp(eta[: self.n_scales]) if self.n_scales else self.given.length_scales
        return replace(
            self.given,
            length_scales=scales,
            nugget=float(np.exp(eta[-1])) if self.parameters.estimate_nugget else self.given.nugget,
        )

    def with_prior(self, eta: FloatArray, by_scales: FloatArray, by_nugget: float, size: int) -> tuple[float, FloatArray]:
        """What the prior adds to the criterion of `size` points, and the derivatives by η of both together."""
        value, by_prior = surprise(eta[: self.n_scales], self.parameters.length_scale_prior)
        gradient = by_scales[: self.n_scales] + by_prior / size
        return value / size, np.append(gradient, [by_nugget] * self.parameters.estimate_nugget)


def minimiser(
    objective: Callable[[FloatArray], tuple[float, FloatArray]], start: FloatArray, bounds: Sequence[tuple[float, float]]
) -> tuple[FloatArray, float]:
    """The local minimiser of an objective with its gradient, by L-BFGS-B, and the value there."""
    options = {"maxiter": ITERATIONS, "ftol": TOLERANCE}
    result = minimize(objective, start, jac=True, method="L-BFGS-B", bounds=bounds, options=options)
    return result.x, float(result.fun)


def _minimised(
    training: Training, parameters: GaussianProcessParameters, start: Hyperparameters
) -> tuple[Hyperparameters, float]:
    """The local minimiser of the criterion and the prior in η, from a start, and the value there."""
    eta = Unknowns(parameters, start)

    def objective(x: FloatArray) -> tuple[float, FloatArray]:
        value, by_scales, by_nugget = criterion(training, parameters, eta.hyperparameters(x))
        of_scales, gradient = eta.with_prior(x, by_scales, by_nugget, training.size)
        return value + of_scales, gradient

    found, value = minimiser(objective, eta.start, eta.bounds)
    return eta.hyperparameters(found), value


def surprise(logarithms: FloatArray, deviation: float | None) -> tuple[float, FloatArray]:
    """Σ (log θ − μ)²/τ² of length scales (d,) and its derivatives; zeros without a prior."""
    if deviation is None or not len(logarithms):
        return 0.0, np.zeros_like(logarithms)
    standard = (logarithms - np.log(0.5 * np.sqrt(len(logarithms)))) / deviation
    return float(standard @ standard), 2.0 * standard / deviation
