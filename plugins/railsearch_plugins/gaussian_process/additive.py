"""Gaussian process that is in part a sum of processes of one variable each.

| symbol | meaning | shape | unit | source |
|---|---|---|---|---|
| R | (1 − w) R_θ(x, x') + (w/d) Σ_r R₁(x_r, x'_r), R_θ the ellipsoidal correlation | scalar | - | Duvenaud et al. 2011 |
| w | share of the sum, logit w normal about logit w₀ with deviation SHARE_DEVIATION | scalar | - | |
| t | nodes on [0, 1] | (m,) | unit cube | |
| a | length scale of the processes of one variable | scalar | unit cube | |
| φ(s) | C⁻¹ r(t, s), r Matérn's of order 5/2 at scale a, C Cᵀ = r(t, t) | (m,) | - | Quiñonero-Candela, Rasmussen 2005 |
| ψ(s) | φ/‖φ‖, so that R₁(s, s') = ψ(s)ᵀψ(s') is one at s = s' | (m,) | - | |
| Ψ | rows (ψ(x_1), …, ψ(x_d))/√d | (k, d m) | - | |

What the variables do one by one is learnt from every point at once, so that few points tell of several waves in each of
many variables; the other part learns what they do together. The nodes make the sum cost what one correlation costs.
"""

import math
from collections import deque
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import cholesky, solve_triangular
from scipy.special import expit, logit

from railsearch.space import FloatArray

from .correlation import correlations, matern_5_2
from .estimation import CRITERIA, Hyperparameters, Unknowns, by_length_scales, minimiser, starts, subset
from .parameters import GaussianProcessParameters
from .process import GaussianProcess
from .system import Solution, Training, factorise, solve
from .trend import Trend

SPACING = 0.6
"""The nodes are no farther apart than this, in units of the length scale a."""

JITTER = 1e-8
"""Added to the diagonal of r(t, t), which is nearly singular."""

SHARE_DEVIATION = 1.5
"""Standard deviation of logit w before the data: 0.18 to 0.82 about one half."""

SHARE_BOUNDS = (0.001, 0.98)
"""Least and largest w."""

REMEMBERED = 2
"""For so many sets of points the functions are kept: those of the fit, and those last asked about."""


@dataclass(frozen=True)
class AdditiveBasis:
    """The functions ψ of one variable: nodes t (m,), the factor C (m, m) and the length scale a."""

    nodes: FloatArray
    factor: FloatArray
    length_scale: float

    def values(self, points: FloatArray) -> FloatArray:
        """Ψ (k, d m) at points (k, d)."""
        values, _ = matern_5_2(self._differences(points) ** 2)
        functions = self._solved(values)
        functions *= 1.0 / np.sqrt(points.shape[1] * np.einsum("ij,ij->i", functions, functions))[:, None]
        flat: FloatArray = functions.reshape(len(points), -1)
        return flat

    def gradient(self, points: FloatArray) -> FloatArray:
        """The derivatives (k, d, m) of the functions in Ψ, each by its own variable: (φ' − ψ ψᵀφ')/‖φ‖ /√d."""
        differences = self._differences(points)
        values, slopes = matern_5_2(differences**2)
        functions = self._solved(values)
        slopes = self._solved(-slopes * differences / self.length_scale)
        norm = np.linalg.norm(functions, axis=1, keepdims=True)
        functions = functions / norm
        along = np.sum(functions * slopes, axis=1, keepdims=True)
        derivatives = (slopes - functions * along) / (norm * math.sqrt(points.shape[1]))
        shaped: FloatArray = derivatives.reshape(*points.shape, -1)
        return shaped

    def _differences(self, points: FloatArray) -> FloatArray:
        """(s − t)/a (k d, m)."""
        differences: FloatArray = (points.reshape(-1, 1) - self.nodes) / self.length_scale
        return differences

    def _solved(self, rows: FloatArray) -> FloatArray:
        """C⁻¹ applied to each row (k d, m)."""
        solved: FloatArray = solve_triangular(self.factor, rows.T, lower=True, check_finite=False).T
        return solved


def additive_basis(length_scale: float) -> AdditiveBasis:
    """The functions of one variable at a length scale a."""
    nodes = np.linspace(0.0, 1.0, math.ceil(1.0 / (SPACING * length_scale)) + 1)
    values, _ = matern_5_2(((nodes[:, None] - nodes) / length_scale) ** 2)
    return AdditiveBasis(nodes, cholesky(values + JITTER * np.eye(len(nodes)), lower=True), length_scale)


class AdditiveProcess(GaussianProcess):
    """A trend and a process of which a share w is a sum of processes of one variable; w is estimated with the length scales.

    share: w₀, about which it is estimated.
    """

    def __init__(self, trend: Trend, parameters: GaussianProcessParameters, basis: AdditiveBasis, share: float) -> None:
        super().__init__(trend, parameters)
        self._basis = basis
        self._share_before = share
        self._known: deque[tuple[FloatArray, FloatArray]] = deque(maxlen=REMEMBERED)

    def _estimated(
        self, training: Training, generator: np.random.Generator, start: Hyperparameters | None
    ) -> Hyperparameters:
        """The hyperparameters of least criterion, searched from `start` alone or, without it, from several starts."""
        if start is not None:
            return self._minimised(training, start)[0]
        small = subset(training, generator)
        additive = self._additive(small.points)

        def worth(at: Hyperparameters) -> float:
            return self._criterion(small, additive, self._with_share(at))[0]

        begun = [self._with_share(at) for at in starts(small, self._parameters, generator, worth)]
        best, _ = min((self._minimised(small, at) for at in begun), key=lambda pair: pair[1])
        return best if small is training else self._minimised(training, best)[0]

    def _with_share(self, at: Hyperparameters) -> Hyperparameters:
        """These hyperparameters with the share w₀."""
        return replace(at, share=self._share_before)

    def _minimised(self, training: Training, start: Hyperparameters) -> tuple[Hyperparameters, float]:
        """The local minimiser of the criterion and the priors by L-BFGS-B in η and logit w, and the value there."""
        additive, before = self._additive(training.points), float(logit(self._share_before))
        eta = Unknowns(self._parameters, start)

        def hyperparameters(x: FloatArray) -> Hyperparameters:
            return replace(eta.hyperparameters(x[:-1]), share=float(expit(x[-1])))

        def objective(x: FloatArray) -> tuple[float, FloatArray]:
            value, by_scales, by_nugget, by_share = self._criterion(training, additive, hyperparameters(x))
            of_scales, gradient = eta.with_prior(x[:-1], by_scales, by_nugget, training.size)
            standard = (x[-1] - before) / SHARE_DEVIATION
            by_share += 2.0 * standard / (SHARE_DEVIATION * training.size)
            return value + of_scales + standard**2 / training.size, np.append(gradient, by_share)

        share = float(logit(np.clip(start.share, *SHARE_BOUNDS)))
        found, value = minimiser(objective, np.append(eta.start, share), [*eta.bounds, tuple(logit(SHARE_BOUNDS))])
        return hyperparameters(found), value

    def _criterion(
        self, training: Training, additive: FloatArray, at: Hyperparameters
    ) -> tuple[float, FloatArray, float, float]:
        """The criterion at given hyperparameters, its derivatives by log θ (d,), and those by log ν and logit w."""
        points = training.points - 0.5
        values, slopes = correlations(self._correlation, points, points, at.length_scales)
        lower, nugget = factorise((1.0 - at.share) * values + at.share * additive, at.nugget)
        value, derivative = CRITERIA[self._parameters.estimation](solve(lower, training))
        by_nugget = nugget * float(np.trace(derivative))
        by_share = at.share * (1.0 - at.share) * float(np.vdot(derivative, additive - values))
        weighted = (1.0 - at.share) * derivative * slopes
        return value, by_length_scales(weighted, points, at.length_scales), by_nugget, by_share

    def _solved(self, training: Training, at: Hyperparameters) -> tuple[Solution, float]:
        values, _ = correlations(self._correlation, training.points, training.points, at.length_scales)
        additive = self._additive(training.points)
        lower, nugget = factorise((1.0 - at.share) * values + at.share * additive, at.nugget)
        return solve(lower, training), nugget

    def _correlations(self, points: FloatArray, others: FloatArray) -> tuple[FloatArray, FloatArray]:
        """R (k, n), and the slopes g of its ellipsoidal part."""
        share = self.hyperparameters.share
        values, slopes = super()._correlations(points, others)
        additive = self._functions(points) @ self._functions(others).T
        return (1.0 - share) * values + share * additive, (1.0 - share) * slopes

    def _descent(self, points: FloatArray, slopes: FloatArray, weights: FloatArray) -> FloatArray:
        training, _ = self._state()
        of_functions = weights @ self._functions(training.points)
        of_functions = of_functions.reshape(len(of_functions), points.shape[1], -1)
        additive = np.sum(self._basis.gradient(points) * of_functions, axis=2)
        descent: FloatArray = super()._descent(points, slopes, weights) - self.hyperparameters.share * additive
        return descent

    def _additive(self, points: FloatArray) -> FloatArray:
        """(1/d) Σ_r R₁ (n, n) between points (n, d)."""
        functions = self._functions(points)
        product: FloatArray = functions @ functions.T
        return product

    def _functions(self, points: FloatArray) -> FloatArray:
        """Ψ (k, d m) at points (k, d), kept for the next time."""
        for entry in self._known:
            if np.array_equal(entry[0], points):
                return entry[1]
        functions = self._basis.values(points)
        self._known.append((points.copy(), functions))
        return functions
