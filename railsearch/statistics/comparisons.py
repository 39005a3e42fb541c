"""Comparisons of strategies: on one problem by pairs, over problems by ranks.

| symbol | meaning | shape | unit | source |
|---|---|---|---|---|
| k | strategies | scalar | - | |
| N | problems | scalar | - | |
| r_i | runs of strategy i | scalar | - | |
| p, p̃ | p-value; adjusted for all pairs | (k, k) | - | Holm 1979 |
| A12 | probability that a value of the first is better than one of the second | scalar | - | Vargha and Delaney 2000 |
| R | mean rank over the problems, 1 the best | (k,) | - | Friedman 1937 |
| χ²_F | Friedman's statistic, corrected for ties | scalar | - | Demšar 2006, section 3.2.2 |
| q_α | quantile of the studentized range over √2 | scalar | - | Demšar 2006, table 5 |
| CD | critical difference of mean ranks | scalar | - | Demšar 2006, section 3.2.2 |

All values are minimised: lower is better. A run without a feasible value enters as +∞, tied with others of its kind.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import stats

from railsearch.errors import InputError
from railsearch.space import FloatArray

EXACT_UP_TO = 50
"""Runs of a strategy up to which the rank-sum test counts all arrangements."""


@dataclass(frozen=True)
class PairwiseComparison:
    """All pairs of k strategies: p (k, k), p̃ (k, k), and the effect A12 (k, k) of row against column.

    effect[i, j] > 0.5: values of strategy i tend to be better (lower) than those of strategy j.
    """

    p_values: FloatArray
    adjusted: FloatArray
    effect: FloatArray


@dataclass(frozen=True)
class Friedman:
    """Ranks of k strategies over N problems: R (k,), χ²_F and its p-value, CD, and who cannot be told apart.

    groups: the largest sets of two or more strategies, by index and best rank first, within which no difference is
    significant; all strategies if the test as a whole shows none. `untested` says why there is no test; statistic,
    p_value and critical_difference are None then, and groups is empty.
    """

    mean_ranks: FloatArray
    statistic: float | None
    p_value: float | None
    critical_difference: float | None
    groups: tuple[tuple[int, ...], ...]
    untested: str = ""


def holm(p_values: ArrayLike) -> FloatArray:
    """Adjust p-values (m,) for the chance that any of m true hypotheses is rejected (step-down).

    p̃_(i) = max_{j ≤ i} min(1, (m − j + 1) p_(j)), p_(1) ≤ … ≤ p_(m). Raises InputError for p outside [0, 1].
    Source: Holm 1979.
    """
    p = np.asarray(p_values, dtype=float)
    if p.ndim != 1 or not np.all((p >= 0.0) & (p <= 1.0)):
        raise InputError(f"p_values: a vector of numbers from 0 to 1 is needed, received {p_values!r}")
    order = np.argsort(p)
    stepped = np.maximum.accumulate(np.minimum(1.0, np.arange(p.size, 0, -1) * p[order]))
    adjusted = np.empty_like(stepped)
    adjusted[order] = stepped
    return adjusted


def vargha_delaney(a: ArrayLike, b: ArrayLike) -> float:
    """The probability that a value of `a` is better, that is lower, than one of `b`; ties count half.

    A12 = P(a < b) + P(a = b)/2: 1 if all of `a` are better, 0.5 if there is no tendency, 0 if all are worse. Vargha and
    Delaney state it for larger values being better. Raises InputError for an empty sample and for NaN.
    Source: Vargha and Delaney 2000.
    """
    first, second = _sample("a", a), _sample("b", b)
    ranks = stats.rankdata(np.concatenate([first, second]))
    above = ranks[: first.size].sum() - 0.5 * first.size * (first.size + 1)
    return float(1.0 - above / (first.size * second.size))


def pairwise_comparison(samples: Sequence[ArrayLike]) -> PairwiseComparison:
    """Compare the final values (r_i,) of k strategies on one problem, every pair with every other.

    Two-sided Wilcoxon rank-sum test (Mann-Whitney), p = P(|W − E W| ≥ |w − E W|) for the sum w of the ranks of one strategy,
    tied values having their mean rank. Up to 50 runs each it counts all arrangements of the ranks as they are, ties
    included, so that tied runs of one strategy do not blur how far it is from another; beyond, it is normal with
    corrections for ties and continuity. p = 1 if all values of a pair are equal. Holm's adjustment is over all
    k(k − 1)/2 pairs.
    Raises InputError for an empty sample and for NaN.
    Source: Mann and Whitney 1947; Streitberg and Röhmel 1986 (counting with ties); Holm 1979; Vargha and Delaney 2000.
    """
    runs = [_sample(f"sample {number}", sample) for number, sample in enumerate(samples, 1)]
    k = len(runs)
    pairs = list(combinations(range(k), 2))
    p = np.array([_rank_sum(runs[i], runs[j]) for i, j in pairs])
    effects = np.full((k, k), 0.5)
    for i, j in pairs:
        effects[i, j] = vargha_delaney(runs[i], runs[j])
        effects[j, i] = 1.0 - effects[i, j]
    return PairwiseComparison(_symmetric(p, k), _symmetric(holm(p), k), effects)


def friedman(values: ArrayLike, level: float = 0.05) -> Friedman:
    """Rank k strategies over N problems, test whether they differ, and which of them (Nemenyi).

    χ²_F = 12 N/(k(k+1)) (Σ R_j² − k(k+1)²/4), over 1 − Σ(t³ − t)/(N k(k² − 1)) for ties of t, has k − 1 degrees of freedom;
    two strategies differ if their mean ranks differ by CD = q_α √(k(k+1)/(6N)) or more. The chi-squared distribution is
    an approximation: for few problems the test rejects less often than its level says, but for three strategies over four
    problems in 7 % of the cases at a level of 5 %.
    values: (N, k), for instance the median best value of each problem; ties get their average rank.
    Raises InputError for NaN, for anything but a matrix with a problem and a strategy, and a level outside (0, 1).
    Source: Friedman 1937; Demšar 2006, section 3.2.2.
    """
    table = np.asarray(values, dtype=float)
    if table.ndim != 2 or table.size == 0 or np.isnan(table).any():
        raise InputError(f"values: an array (problems, strategies) without NaN is needed, received shape {table.shape}")
    if not 0.0 < level < 1.0:
        raise InputError(f"level: a number between 0 and 1 is needed, received {level}")
    problems, k = table.shape
    ranks = stats.rankdata(table, axis=1)
    mean_ranks: FloatArray = ranks.mean(axis=0)
    if k < 3 or problems < 2:
        return Friedman(mean_ranks, None, None, None, (), _why_untested(problems, k))
    statistic, p_value = _friedman_test(ranks)
    quantile = float(stats.studentized_range.ppf(1.0 - level, k, np.inf)) / np.sqrt(2.0)
    difference = quantile * float(np.sqrt(k * (k + 1) / (6.0 * problems)))
    groups = _groups(mean_ranks, difference if p_value < level else np.inf)
    return Friedman(mean_ranks, statistic, p_value, difference, groups)


def probability_best(samples: Sequence[ArrayLike], generator: np.random.Generator, resamples: int = 10_000) -> FloatArray:
    """The share (k,) of bootstrap resamples in which each of k strategies has the lowest median; ties are shared.

    samples: the final values (r_i,) of each strategy; the runs of each are drawn with replacement, independently.
    Raises InputError without a strategy or resamples, for an empty sample and for NaN.
    Source: Efron and Tibshirani 1993, chapter 6.
    """
    if not samples or resamples < 1:
        raise InputError(f"bootstrap: samples and resamples ≥ 1 are needed, received {len(samples)} and {resamples}")
    runs = [_sample(f"sample {number}", sample) for number, sample in enumerate(samples, 1)]
    medians = np.stack([np.median(generator.choice(run, (resamples, run.size)), axis=1) for run in runs], axis=1)
    lowest = medians == medians.min(axis=1, keepdims=True)
    share: FloatArray = (lowest / lowest.sum(axis=1, keepdims=True)).mean(axis=0)
    return share


def _sample(name: str, values: ArrayLike) -> FloatArray:
    sample = np.asarray(values, dtype=float)
    if sample.ndim != 1 or sample.size == 0 or np.isnan(sample).any():
        raise InputError(
            f"{name}: a vector of one value or more is needed, +inf for a run without a feasible value, received {values!r}"
        )
    return sample


def _rank_sum(a: FloatArray, b: FloatArray) -> float:
    """The two-sided p-value of the rank-sum test."""
    if max(a.size, b.size) > EXACT_UP_TO:
        return float(stats.mannwhitneyu(a, b, method="asymptotic").pvalue)
    doubled = np.rint(2.0 * stats.rankdata(np.concatenate([a, b]))).astype(int)
    counts = _arrangements(doubled, a.size)
    distance = np.abs(np.arange(counts.size) - a.size * (doubled.size + 1))
    at_least = distance >= distance[doubled[: a.size].sum()]
    return float(min(1.0, counts[at_least].sum() / counts.sum()))


def _arrangements(ranks: NDArray[np.int_], size: int) -> FloatArray:
    """How many of all choices of `size` ranks (n,) have the sum 0, 1, …, Σ ranks. Source: Streitberg and Röhmel 1986."""
    totals = np.cumsum(np.sort(ranks))
    counts = np.zeros((size + 1, int(totals[-1]) + 1))
    counts[0, 0] = 1.0
    for rank, total in zip(np.sort(ranks), totals, strict=True):
        counts[1:, rank : total + 1] += counts[:-1, : total + 1 - rank].copy()
    chosen: FloatArray = counts[size]
    return chosen


def _symmetric(of_pairs: FloatArray, k: int) -> FloatArray:
    """A matrix (k, k) of values of the pairs i < j, row by row, with ones on the diagonal."""
    matrix = np.ones((k, k))
    rows, columns = np.triu_indices(k, 1)
    matrix[rows, columns] = matrix[columns, rows] = of_pairs
    return matrix


def _why_untested(problems: int, k: int) -> str:
    if k < 3:
        return f"ranks are tested for three strategies or more, here there are {k}: see the pairwise comparison"
    return f"ranks are tested over two problems or more, here there is {problems}: see the pairwise comparison"


def _friedman_test(ranks: FloatArray) -> tuple[float, float]:
    """χ²_F and its p-value; 0 and 1 if all strategies are tied on all problems."""
    if np.all(ranks == ranks[:, :1]):
        return 0.0, 1.0
    result = stats.friedmanchisquare(*ranks.T)
    return float(result.statistic), float(result.pvalue)


def _groups(mean_ranks: FloatArray, difference: float) -> tuple[tuple[int, ...], ...]:
    """The largest sets of two or more, best first, whose mean ranks lie less than `difference` apart."""
    order = np.argsort(mean_ranks, kind="stable")
    ordered = mean_ranks[order]
    ends = np.searchsorted(ordered, ordered + difference, side="left")
    groups = []
    reached = 0
    for begin, end in enumerate(ends):
        if end > max(reached, begin + 1):
            groups.append(tuple(int(index) for index in order[begin:end]))
            reached = int(end)
    return tuple(groups)
