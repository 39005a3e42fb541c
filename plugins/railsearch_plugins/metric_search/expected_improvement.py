"""Expected improvement: how far below the best value a prediction may be expected to fall.

| symbol | meaning | shape | unit | source |
|---|---|---|---|---|
| f̂ | predicted values | (k,) | of f | |
| s | standard deviations of the prediction | (k,) | of f | |
| f_min | best value so far | scalar | of f | |
| z | (f_min − f̂)/s | (k,) | - | Jones et al. 1998 |
| Φ, ϕ | distribution and density of the standard normal variable | - | - | |
"""

import numpy as np
from scipy.special import ndtr

from railsearch.space import FloatArray

SMALLEST = 1e-300
"""Standard deviations are taken to be at least this, so that z is defined where the prediction is certain."""


def expected_improvement(values: FloatArray, deviations: FloatArray, best: float | FloatArray) -> FloatArray:
    """The expected improvement EI = s (z Φ(z) + ϕ(z)) (k,) of predictions f̂ (k,) with deviations s (k,) on f_min.

    Where s is zero it is max(f_min − f̂, 0). Source: Jones, Schonlau and Welch 1998, equation 15.
    """
    improvement = best - values
    with np.errstate(over="ignore"):
        z = improvement / np.maximum(deviations, SMALLEST)
        density = np.exp(-0.5 * np.minimum(z * z, 1500.0)) / np.sqrt(2.0 * np.pi)
    expected: FloatArray = improvement * ndtr(z) + deviations * density
    return np.maximum(expected, 0.0)
