"""Ellipsoidal correlation functions of a stationary Gaussian process.

| symbol | meaning | shape | unit | source |
|---|---|---|---|---|
| x, x' | points of the unit cube | (d,) | - | |
| θ | length scales | (d,) | unit cube | Rasmussen and Williams 2006, section 4.2 |
| h² | Σ_r ((x_r − x'_r)/θ_r)² | any | - | |
| R(h) | correlation | of h² | - | |
| g(h) | slope −R′(h)/h, so that ∂R/∂x_r = −g (x_r − x'_r)/θ_r² and ∂R/∂ log θ_r = g ((x_r − x'_r)/θ_r)² | of h² | - | |

Each function gives R and g of squared distances h²: R is smooth in them where it is smooth at all.
"""

from collections.abc import Callable, Mapping

import numpy as np
from scipy.spatial.distance import cdist

from railsearch.space import FloatArray

Correlation = Callable[[FloatArray], tuple[FloatArray, FloatArray]]
"""R and g, each of the shape of the squared distances h² that are given."""


def matern_5_2(squares: FloatArray) -> tuple[FloatArray, FloatArray]:
    """R = (1 + √5 h + 5h²/3) e^(−√5 h) and g = 5/3 (1 + √5 h) e^(−√5 h): twice differentiable paths."""
    distances = np.sqrt(5.0 * squares)
    decay = np.exp(-distances)
    slope = (1.0 + distances) * decay
    return slope + (5.0 / 3.0) * squares * decay, (5.0 / 3.0) * slope


def matern_3_2(squares: FloatArray) -> tuple[FloatArray, FloatArray]:
    """R = (1 + √3 h) e^(−√3 h) and g = 3 e^(−√3 h): once differentiable paths."""
    distances = np.sqrt(3.0 * squares)
    decay = np.exp(-distances)
    return (1.0 + distances) * decay, 3.0 * decay


def gaussian(squares: FloatArray) -> tuple[FloatArray, FloatArray]:
    """R = g = e^(−h²/2): analytic paths."""
    values = np.exp(-0.5 * squares)
    return values, values


def exponential(squares: FloatArray) -> tuple[FloatArray, FloatArray]:
    """R = e^(−h) and g = e^(−h)/h: continuous paths; the slope at its kink h = 0 is given as zero."""
    distances = np.sqrt(squares)
    values = np.exp(-distances)
    return values, np.divide(values, distances, out=np.zeros_like(values), where=distances > 0.0)


CORRELATIONS: Mapping[str, Correlation] = {
    "matern-5/2": matern_5_2,
    "matern-3/2": matern_3_2,
    "gaussian": gaussian,
    "exponential": exponential,
}


def correlations(
    correlation: Correlation, points: FloatArray, others: FloatArray, length_scales: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """R and g (k, n) between points (k, d) and others (n, d) at length scales θ (d,)."""
    return correlation(cdist(points / length_scales, others / length_scales, "sqeuclidean"))
