"""Runlengths: how many evaluations runs need to reach targets, as COCO measures it.

| symbol | meaning | shape | unit | source |
|---|---|---|---|---|
| r, n, t | runs, evaluations, targets | scalars | - | |
| B | best value so far, NaN until there is one | (r, n) | of the objective | |
| B_0, B_best | median first value of the runs; best value known | scalars | of the objective | |
| φ | fraction of the way from B_0 to B_best that a target leaves open | (t,) | - | |
| T | targets, B_best + φ (B_0 − B_best) | (t,) | of the objective | |
| RL | first evaluation, from 1, at or below the target; +∞ if none is | (r, t) | evaluations | Hansen et al. 2021 |
| ERT | expected running time | (t,) | evaluations | Auger and Hansen 2005 |
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from railsearch.errors import InputError
from railsearch.space import FloatArray


@dataclass(frozen=True)
class Targets:
    """Targets T (t,) of one problem, the easiest first, with what they were made from: φ (t,), B_0 and B_best."""

    values: FloatArray
    fractions: FloatArray
    start: float
    best: float


def relative_targets(curves: FloatArray, count: int = 20, precision: float = 0.01, best_known: float = np.inf) -> Targets:
    """Targets T = B_best + φ (B_0 − B_best) between the start and the best value of the runs of all strategies.

    curves: B (r, n) of all strategies on one problem; B_0 is the median over the runs of their first value, which is the
    value of the reference design where every run begins with it; B_best is the lowest value of all or `best_known`, if
    that is lower. φ is logarithmic from 1 (left out: it is reached at the start) to `precision` in `count` steps. Only
    differences of values count, so that values of any sign can be used, and targets do not change with scale and shift.
    There are no targets without a value. Where no run is better than the start, all targets are the start itself.
    Raises InputError for a count below one and a precision outside (0, 1).
    Source: Hansen et al. 2021, with B_best in place of the optimum, which simulations do not tell.
    """
    if count < 1 or not 0.0 < precision < 1.0:
        raise InputError(f"targets: count ≥ 1 and 0 < precision < 1 are needed, received {count} and {precision}")
    values = np.asarray(curves, dtype=float)
    reached = np.isfinite(values)
    runs = reached.any(axis=1)
    if not runs.any():
        return Targets(np.empty(0), np.empty(0), np.inf, best_known)
    first = values[runs, reached[runs].argmax(axis=1)]
    start, best = float(np.median(first)), min(float(values[reached].min()), best_known)
    fractions = np.geomspace(1.0, precision, count + 1)[1:]
    return Targets(best + fractions * (start - best), fractions, start, best)


def runlengths(curves: FloatArray, targets: FloatArray) -> FloatArray:
    """Runlengths RL (r, t): the first evaluation, from 1, at which a run of curves B (r, n) is at or below a target.

    +∞ where the run never gets there. Source: Hansen et al. 2021.
    """
    hit = np.asarray(curves)[:, :, None] <= np.asarray(targets)
    return np.where(hit.any(axis=1), hit.argmax(axis=1) + 1.0, np.inf)


def expected_running_time(runlengths: FloatArray, budget: ArrayLike) -> FloatArray:
    """Expected evaluations (t,) until success of a strategy that is restarted until it succeeds.

    ERT = (Σ RL of the runs that succeed + Σ budget of those that do not) / number of successes; +∞ without one.
    runlengths: RL (r, t); budget: evaluations of every run, or of each one (r,).
    Source: Auger and Hansen 2005; Hansen et al. 2021.
    """
    lengths = np.asarray(runlengths, dtype=float)
    spent = np.broadcast_to(np.asarray(budget, dtype=float), len(lengths))[:, None]
    reached = lengths <= spent
    successes = reached.sum(axis=0)
    total = np.where(reached, lengths, spent).sum(axis=0)
    return np.where(successes > 0, total / np.maximum(successes, 1), np.inf)


def runlength_ecdf(runlengths: FloatArray, budgets: ArrayLike) -> FloatArray:
    """The fraction (b,) of all pairs of run and target with RL ≤ budget, for budgets (b,).

    runlengths: RL of any shape, so that those of many problems can be joined. Raises InputError without a pair.
    Source: Hansen et al. 2021.
    """
    lengths = np.sort(np.ravel(runlengths))
    if lengths.size == 0:
        raise InputError("runlengths: one pair of run and target or more is needed, received none")
    return np.searchsorted(lengths, np.asarray(budgets, dtype=float), side="right") / lengths.size
