"""Monotone transforms of the objective before a surrogate is fitted.

| symbol | meaning | shape | unit | source |
|---|---|---|---|---|
| f | values | (n,) | of f | |
| g | f − min f | (n,) | of f | |
| m | median of f | scalar | of f | |
| u | reach of `tail`, 30 (m − min f) | scalar | of f | |
| T | transformed values | (n,) | of f, - | |
| Φ | distribution function of the standard normal variable | - | - | |

A transform is made for values, and gives T of these or of more of them.
"""

from collections.abc import Callable

import numpy as np
from scipy.special import ndtri

from railsearch.space import FloatArray

FLOOR = 0.1
"""The logarithm is taken of g plus this fraction of the median of g."""


REACH = 30.0
"""Values are compressed from so many times the distance of median and least value above the median."""

Transform = Callable[[FloatArray], FloatArray]


def identity(values: FloatArray) -> Transform:
    """T = f."""
    return lambda f: f


def copula(values: FloatArray) -> Transform:
    """T = Φ⁻¹((rank + 1/2)/n), the ranks from 0: the normal scores of the values. Equal values share their mean rank."""
    return _normal_scores


def logarithm(values: FloatArray) -> Transform:
    """T = log(g + 0.1 median g); f itself where half of the values or more are the least one."""
    return _logarithm


def tail(values: FloatArray) -> Transform:
    """T = f up to m + u, m + u (1 + log((f − m)/u)) beyond: only values far above all others are compressed.

    m and u stay those of the values for which it was made. f itself where half of the values or more are the least one,
    or where there is none.
    """
    if not len(values):
        return identity(values)
    median = float(np.median(values))
    reach = REACH * (median - float(np.min(values)))

    def compressed(f: FloatArray) -> FloatArray:
        far = np.maximum((f - median) / reach, 1.0)
        return np.where(far > 1.0, median + reach * (1.0 + np.log(far)), f)

    return compressed if reach > 0.0 else identity(values)


def _normal_scores(values: FloatArray) -> FloatArray:
    ordered = np.sort(values)
    ranks = 0.5 * (np.searchsorted(ordered, values, "left") + np.searchsorted(ordered, values, "right") - 1)
    scores: FloatArray = ndtri((ranks + 0.5) / len(values))
    return scores


def _logarithm(values: FloatArray) -> FloatArray:
    above = values - np.min(values)
    floor = FLOOR * float(np.median(above))
    return np.log(above + floor) if floor > 0.0 else values


TRANSFORMS: dict[str, Callable[[FloatArray], Transform]] = {
    "copula": copula,
    "logarithm": logarithm,
    "identity": identity,
    "tail": tail,
}
