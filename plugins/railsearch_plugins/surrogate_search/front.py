"""The front found so far, and the choice of the candidates that add most to it.

| symbol | meaning | shape | unit | source |
|---|---|---|---|---|
| F | objectives of the front, scaled to [0, 1] by best and worst values | (p, m) | - | |
| r | reference point, 1 + margin in every objective | (m,) | - | Ishibuchi et al. 2018 |
| f̂ | predicted objectives of the candidates, scaled likewise | (t, m) | - | |
| Δ | distances of the candidates to the nearest evaluated point | (t,) | unit cube | |
| w | weight of the gain, the rest being that of the distance | scalar | - | Regis and Shoemaker 2007 |
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.distance import cdist

from railsearch.indicators import hypervolume, non_dominated
from railsearch.interfaces import Evaluation
from railsearch.space import FloatArray
from railsearch_plugins.metric_search.merit import merit

from .hypervolume_gain import hypervolume_gain


@dataclass(frozen=True)
class Front:
    """The non-dominated designs (p, d) with their objectives (p, m), and best values (m,) and ranges (m,) to scale by."""

    designs: FloatArray
    objectives: FloatArray
    best: FloatArray
    ranges: FloatArray

    def scaled(self, objectives: FloatArray) -> FloatArray:
        """Objectives (k, m) as multiples of the ranges above the best values."""
        return (objectives - self.best) / self.ranges


def best_of(evaluations: Sequence[Evaluation]) -> list[Evaluation]:
    """Those of one or more successful evaluations that no other one dominates."""
    return [evaluations[row] for row in non_dominated(np.array([evaluation.objectives for evaluation in evaluations]))]


def front_of(evaluations: Sequence[Evaluation], predicted: FloatArray) -> Front:
    """The front of one or more successful evaluations, scaled by what is found together with what is predicted (k, m).

    Where a search has found but a corner of the front, the predicted one tells how far it may reach: measured by the corner
    alone, going beyond it would hardly gain. An objective without a range is scaled by its range over all evaluations, or
    not at all.
    """
    best = best_of(evaluations)
    objectives = np.array([evaluation.objectives for evaluation in best])
    both = np.vstack([objectives, predicted[non_dominated(predicted)]])
    reached, everything = np.ptp(both, axis=0), np.ptp([evaluation.objectives for evaluation in evaluations], axis=0)
    ranges = np.where(reached > 0.0, reached, np.where(everything > 0.0, everything, 1.0))
    return Front(np.array([evaluation.design for evaluation in best]), objectives, both.min(axis=0), ranges)


def recent_gain(evaluations: Sequence[Evaluation], front: Front, count: int, margin: float) -> float:
    """The part of the front's hypervolume, below 1 + margin of the scale, that the last `count` evaluations have brought."""
    objectives = front.scaled(np.array([evaluation.objectives for evaluation in evaluations]))
    reference = np.full(objectives.shape[1], 1.0 + margin)
    return 1.0 - hypervolume(objectives[:-count], reference) / hypervolume(objectives, reference)


@dataclass(frozen=True)
class Candidates:
    """Points (t, d) of the unit cube with predicted objectives (t, m) and, if they are known, deviations (t, m)."""

    points: FloatArray
    values: FloatArray
    deviations: FloatArray | None = None


def select_by_gain(
    candidates: Candidates,
    front: Front,
    evaluated: FloatArray,
    weights: Iterator[float],
    count: int,
    minimum_distance: float,
    margin: float,
) -> list[int]:
    """The indices of up to `count` candidates of lowest merit, in which minus the hypervolume gain stands for the value.

    Those that gain something come before all others. Each one chosen joins the evaluated points (n, d), and its prediction
    the front, before the next is chosen with the next weight. Candidates nearer than `minimum_distance` to an evaluated
    point are left out; if all are, the list is shorter or empty.
    """
    known, values = front.scaled(front.objectives), front.scaled(candidates.values)
    deviations = None if candidates.deviations is None else candidates.deviations / front.ranges
    reference = np.full(values.shape[1], 1.0 + margin)
    distances = cdist(candidates.points, evaluated).min(axis=1, initial=np.inf)
    chosen: list[int] = []
    while len(chosen) < count:
        rows = np.flatnonzero(distances >= minimum_distance)
        if not len(rows):
            break
        gains = hypervolume_gain(values[rows], known, reference, None if deviations is None else deviations[rows])
        better = gains > 0.0
        if better.any():
            rows, gains = rows[better], gains[better]
        row = int(rows[np.argmin(merit(-gains, distances[rows], next(weights)))])
        chosen.append(row)
        known = np.vstack([known, values[row]])
        known = known[non_dominated(known)]
        distances = np.minimum(distances, cdist(candidates.points, candidates.points[row][None, :])[:, 0])
    return chosen
