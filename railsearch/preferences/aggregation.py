"""Many scores into one number.

| symbol | meaning | shape | unit | source |
|---|---|---|---|---|
| P | scores of n designs by k stated preferences | (n, k) | - | |
| w | weights, ≥ 0, one of them > 0 | (k,) | - | |
| A | aggregated score | (n,) | - | Zhilyaev et al. 2022 |
"""

from collections.abc import Callable, Mapping

import numpy as np

from railsearch.preferences.functions import FULL_SCORE
from railsearch.space import FloatArray

Aggregation = Callable[[FloatArray, FloatArray], FloatArray]


def largest_shortfall(scores: FloatArray, weights: FloatArray) -> FloatArray:
    """The largest weighted shortfall max_i w_i (100 − P_i) (n,), to be minimised.

    scores: P (n, k); weights: w (k,). Source: Shang, Binnekamp and Wolfert 2023.
    """
    shortfalls: FloatArray = (weights * (FULL_SCORE - scores)).max(axis=1)
    return shortfalls


def weighted_mean(scores: FloatArray, weights: FloatArray) -> FloatArray:
    """The aggregated score A = Σ_i w_i P_i / Σ_i w_i (n,).

    scores: P (n, k); weights: w (k,). Source: Zhilyaev, Binnekamp and Wolfert 2022, the weighted mean as aggregation.
    """
    means: FloatArray = scores @ weights / np.sum(weights)
    return means


def weighted_geometric_mean(scores: FloatArray, weights: FloatArray) -> FloatArray:
    """The overall desirability A = 100 Π_i (P_i/100)^(w_i/Σw) (n,): 0 as soon as one weighted score is 0 or below.

    scores: P (n, k); weights: w (k,). Source: Derringer and Suich 1980, eq. 1; with weights Derringer 1994.
    """
    parts = (np.maximum(scores, 0.0) / FULL_SCORE) ** (weights / np.sum(weights))
    means: FloatArray = FULL_SCORE * parts.prod(axis=1)
    return means


AGGREGATIONS: Mapping[str, Aggregation] = {"mean": weighted_mean, "geometric-mean": weighted_geometric_mean}
