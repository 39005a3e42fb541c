"""Two orders in which terms come into a regression: by the least angle, and by what they gain at once.

| symbol | meaning | shape | source |
|---|---|---|---|
| X, Q, R, y, r | as in active_set.py | | |
| c | correlations Xᵀ(y − μ) of the candidates with what the path has left | (m,) | Efron et al. 2004, Eq. 2.8 |
| C | the largest of them, which all active terms have | scalar | Eq. 2.9 |
| s | their signs | (k,) | Eq. 2.10 |
| u, A | equiangular vector of the active terms and its correlation with each of them | (n,), scalar | Eq. 2.6 |
| a | correlations Xᵀu of the candidates with it | (m,) | Eq. 2.11 |
| γ | length of a step, until another term is as correlated as the active ones | scalar | Eq. 2.13 |
| w | squared lengths of the candidates outside of the active terms | (m,) | Chen et al. 1989 |

Both are hybrid: coefficients and error of every step are those of the least-squares fit of its terms (Efron et al. 2004,
section 3.3; Blatman & Sudret 2011, section 3.4).
"""

import numpy as np
from scipy.linalg import solve_triangular

from railsearch.space import FloatArray

from .active_set import COLLINEAR, ActiveSet, Candidates, SelectionPath, Steps

UNCORRELATED = 1e-13
"""Correlations below this fraction of the first one are rounding."""


def least_angle_path(
    candidates: Candidates, values: FloatArray, count: int, most_terms: int, patience: int
) -> SelectionPath:
    """Terms by least angle regression among the first `count` candidates, for values y (n,) that are not all equal.

    It ends after `most_terms` terms, with `patience` terms that have brought no lower error, or when nothing is left.
    Source: Efron, Hastie, Johnstone & Tibshirani 2004.
    """
    active = ActiveSet(candidates, values, count, most_terms)
    steps = Steps(active, patience)
    correlation = active.columns.T @ active.residual
    floor = UNCORRELATED * float(np.max(np.abs(correlation), initial=0.0))
    signs: list[float] = []
    while active.capacity:
        term = active.enter(np.abs(correlation) - floor)
        if term is None:
            break
        signs.append(float(np.sign(correlation[term])))
        if not steps.taken():
            break
        correlation = correlation - _change(active, np.array(signs), correlation, float(abs(correlation[term])))
    return steps.path


def forward_path(candidates: Candidates, values: FloatArray, count: int, most_terms: int, patience: int) -> SelectionPath:
    """Terms by forward selection: each the one that lowers Σ r² most, by (Xᵀr)²/w. Arguments as of `least_angle_path`.

    Source: Chen, Billings & Luo 1989, orthogonal least squares.
    """
    active = ActiveSet(candidates, values, count, most_terms)
    steps = Steps(active, patience)
    correlation, lengths = active.columns.T @ active.residual, np.ones(count)
    while active.capacity:
        before = active.residual.copy()
        if active.enter(np.where(lengths > COLLINEAR, correlation**2 / np.maximum(lengths, COLLINEAR), -1.0)) is None:
            break
        if not steps.taken():
            break
        new = active.basis[:, -1]
        rates = active.columns.T @ new
        correlation, lengths = correlation - (new @ before) * rates, lengths - rates**2
    return steps.path


def _change(active: ActiveSet, signs: FloatArray, correlation: FloatArray, largest: float) -> FloatArray:
    """By how much the correlations (m,) fall over a step of least angle regression: γ a."""
    half = solve_triangular(active.factor[: active.size, : active.size], signs, trans="T", check_finite=False)
    speed = 1.0 / float(np.linalg.norm(half))
    rates = active.columns.T @ (speed * (active.basis @ half))
    rest, rate = correlation[active.open], rates[active.open]
    ends = np.concatenate([_positive(largest - rest, speed - rate), _positive(largest + rest, speed + rate)])
    return np.asarray(min(float(np.min(ends, initial=np.inf)), largest / speed) * rates)


def _positive(numerator: FloatArray, denominator: FloatArray) -> FloatArray:
    """The ratios that are positive; infinity for the others."""
    sound = (numerator > 0.0) & (denominator > 0.0)
    return np.where(sound, numerator / np.where(sound, denominator, 1.0), np.inf)
