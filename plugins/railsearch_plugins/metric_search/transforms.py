"""Monotone transforms of the objective before a surrogate is fitted.

| symbol | meaning | shape | unit | source |
|---|---|---|---|---|
| f | values | (n,) | of f | |
| g | f − min f | (n,) | of f | |
| T | transformed values | (n,) | - | |
| Φ | distribution function of the standard normal variable | - | - | |
"""

from collections.abc import Callable

import numpy as np
from scipy.special import ndtri

from railsearch.space import FloatArray

FLOOR = 0.1
"""The logarithm is taken of g plus this fraction of the median of g."""


def identity(values: FloatArray) -> FloatArray:
    """T = f."""
    return values


def copula(values: FloatArray) -> FloatArray:
    """T = Φ⁻¹((rank + 1/2)/n), the ranks from 0: the normal scores of the values. Equal values share their mean rank."""
    ordered = np.sort(values)
    ranks = 0.5 * (np.searchsorted(ordered, values, "left") + np.searchsorted(ordered, values, "right") - 1)
    scores: FloatArray = ndtri((ranks + 0.5) / len(values))
    return scores


def logarithm(values: FloatArray) -> FloatArray:
    """T = log(g + 0.1 median g); f itself where half of the values or more are the least one."""
    above = values - np.min(values)
    floor = FLOOR * float(np.median(above))
    return np.log(above + floor) if floor > 0.0 else values


TRANSFORMS: dict[str, Callable[[FloatArray], FloatArray]] = {
    "copula": copula,
    "logarithm": logarithm,
    "identity": identity,
}
