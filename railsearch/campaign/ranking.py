"""The comparison of strategies over several problems, by ranks.

| symbol | meaning | shape | unit | source |
|---|---|---|---|---|
| N, k | problems; strategies that are compared on all of them | scalars | - | |
| x̃ | medians of the final values, minimised | (N, k) | each its own | |
| R | mean ranks over the problems, 1 the best | (k,) | - | Friedman 1937 |
| B | bootstrap resamples of the repetitions | scalar | - | Efron and Tibshirani 1993 |
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy import stats

from railsearch.campaign.comparison import LEVEL, Compared, plain, shown_numbers
from railsearch.space import FloatArray
from railsearch.statistics import friedman, runlength_ecdf

RESAMPLES = 2000


def ranking_document(compared: Sequence[Compared], generator: np.random.Generator) -> dict[str, Any] | None:
    """Friedman ranks, shares of resamples, wins and the ECDF over all problems; None for fewer than two of either."""
    usable = [data for data in compared if data.curves]
    common = [name for name in usable[0].strategies if all(name in data.curves for data in usable)] if usable else []
    if len(usable) < 2 or len(common) < 2:
        return None
    finals = [_finals(data, common) for data in usable]
    medians = np.array([[np.median(runs) for runs in final] for final in finals])
    ranks = friedman(medians, LEVEL)
    return {
        "strategies": common,
        "problems": [data.label for data in usable],
        "repetitions": min(len(data.repetitions) for data in usable),
        "mean_ranks": ranks.mean_ranks.tolist(),
        "statistic": ranks.statistic,
        "p_value": ranks.p_value,
        "critical_difference": ranks.critical_difference,
        "groups": [list(group) for group in ranks.groups],
        "untested": ranks.untested,
        "level": LEVEL,
        "wins": np.sum(medians == medians.min(axis=1, keepdims=True), axis=0).tolist(),
        "probability_best": probability_best_rank(finals, generator).tolist(),
        "ecdf": _ecdf(usable, common),
    }


def probability_best_rank(
    finals: Sequence[Sequence[FloatArray]], generator: np.random.Generator, resamples: int = RESAMPLES
) -> FloatArray:
    """The share (k,) of bootstrap resamples in which each strategy has the best mean rank R; ties are shared.

    finals: for each of N problems the final values (r,) of each of k strategies, minimised. The runs of every strategy
    on every problem are drawn with replacement, independently; the problems stay as they are, so the share speaks of these
    problems, not of others. Source: Efron and Tibshirani 1993, chapter 6.
    """
    ranks = np.zeros((resamples, len(finals[0])))
    for runs in finals:
        medians = [np.median(generator.choice(run, (resamples, run.size)), axis=1) for run in runs]
        ranks += stats.rankdata(np.stack(medians, axis=1), axis=1)
    best = ranks == ranks.min(axis=1, keepdims=True)
    share: FloatArray = (best / best.sum(axis=1, keepdims=True)).mean(axis=0)
    return share


def _finals(data: Compared, strategies: Sequence[str]) -> list[FloatArray]:
    by_name = dict(zip(data.strategies, data.finals, strict=True))
    return [by_name[strategy] for strategy in strategies]


def _ecdf(usable: Sequence[Compared], strategies: Sequence[str]) -> dict[str, Any]:
    """Share of all pairs of run and target, of all problems, that a strategy has reached after so many evaluations."""
    numbers = shown_numbers(max(next(iter(data.curves.values())).shape[1] for data in usable))
    shares = {}
    lengths = [data.runlengths for data in usable]
    for strategy in strategies:
        joined = np.concatenate([by_strategy[strategy].ravel() for by_strategy in lengths])
        shares[strategy] = plain(runlength_ecdf(joined, numbers)) if joined.size else []
    return {"numbers": numbers.tolist(), "shares": shares}
