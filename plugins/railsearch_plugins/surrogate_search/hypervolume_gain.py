"""How much hypervolume a design adds to a front: predicted, or expected where the prediction is uncertain.

| symbol | meaning | shape | unit | source |
|---|---|---|---|---|
| F | objectives of the front, minimised | (p, m) | of the objectives | |
| r | reference point | (m,) | of the objectives | |
| f̂, s | predicted objectives and their standard deviations, independent of one another | (k, m) | of the objectives | |
| [l_b, u_b] | boxes without common volume, all that lies below r and is not dominated by F | (b, m) | of the objectives | |
| ΔHV | hypervolume of F and f̂ together less that of F | (k,) | product of the objectives' | Zitzler et al. 2003 |
| EI_i(a) | expected improvement E max(a − f_i, 0) of objective i on a, f_i normal | (k,) | of f_i | Jones et al. 1998 |

A vector f gains of every box the part that it dominates, Π_i [max(u_bi − f_i, 0) − max(l_bi − f_i, 0)]. With objectives that
are independent and normal the expectation of the product is that of its factors (Emmerich, Deutz and Klinkenberg 2011; Yang,
Emmerich, Deutz and Bäck 2019):

    E ΔHV = Σ_b Π_i [EI_i(u_bi) − EI_i(l_bi)]
"""

import itertools

import numpy as np
from numpy.typing import NDArray

from railsearch.indicators import hypervolume, non_dominated
from railsearch.space import FloatArray
from railsearch_plugins.metric_search.expected_improvement import expected_improvement

BLOCK = 200_000
"""Candidates times boxes worked on at a time."""


def hypervolume_gain(
    values: FloatArray, front: FloatArray, reference: FloatArray, deviations: FloatArray | None = None
) -> FloatArray:
    """The hypervolume (k,) below r (m,) that vectors f̂ (k, m), certain or with deviations s (k, m), add to a front F (p, m).

    Certain ones of three objectives and more go through moocore, one by one; everything else is one sum over boxes.
    """
    if deviations is None and front.shape[1] > 2:
        return _gain_by_difference(values, front, reference)
    lower, upper = non_dominated_boxes(front, reference)
    spread = np.zeros_like(values) if deviations is None else deviations
    step = max(1, BLOCK // len(upper))
    blocks = [slice(start, start + step) for start in range(0, len(values), step)]
    return np.concatenate([np.empty(0), *(_gain_by_boxes(values[b], spread[b], lower, upper) for b in blocks)])


def non_dominated_boxes(front: FloatArray, reference: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Boxes l, u (b, m) without common volume that fill what lies below r (m,) and is not dominated by F (p, m).

    Slabs between the values of the last objective, each of which is a problem of one objective less (Fonseca et al. 2006).
    Boxes are open below: their first l is −∞.
    """
    front = front[np.all(front < reference, axis=1)]
    if front.shape[1] == 1:
        return np.full((1, 1), -np.inf), np.array([[front.min(initial=float(reference[0]))]])
    levels = np.concatenate([[-np.inf], np.unique(front[:, -1]), reference[-1:]])
    lower, upper = [], []
    for low, high in itertools.pairwise(levels):
        base = front[front[:, -1] <= low, :-1]
        below, above = non_dominated_boxes(base[non_dominated(base)] if len(base) else base, reference[:-1])
        lower.append(np.column_stack([below, np.full(len(below), low)]))
        upper.append(np.column_stack([above, np.full(len(above), high)]))
    return np.vstack(lower), np.vstack(upper)


def _gain_by_boxes(values: FloatArray, deviations: FloatArray, lower: FloatArray, upper: FloatArray) -> FloatArray:
    gains = np.ones((len(values), len(upper)))
    for i in range(values.shape[1]):
        edges, place = np.unique(np.concatenate([lower[:, i], upper[:, i]]), return_inverse=True)
        improvements = _improvements(values[:, i], deviations[:, i], edges)[:, place]
        gains *= improvements[:, len(lower) :] - improvements[:, : len(lower)]
    total: FloatArray = gains.sum(axis=1)
    return np.maximum(total, 0.0)


def _improvements(values: FloatArray, deviations: FloatArray, edges: FloatArray) -> FloatArray:
    """EI (k, e) of predictions (k,) on edges (e,); nothing is gained on −∞."""
    finite = np.isfinite(edges)
    improvements = np.zeros((len(values), len(edges)))
    if deviations.any():
        improvements[:, finite] = expected_improvement(values[:, None], deviations[:, None], edges[finite])
    else:
        improvements[:, finite] = np.maximum(edges[finite] - values[:, None], 0.0)
    return improvements


def _gain_by_difference(values: FloatArray, front: FloatArray, reference: FloatArray) -> FloatArray:
    volume = hypervolume(front, reference)
    gains = np.zeros(len(values))
    dominated: NDArray[np.bool_] = np.all(front[None] <= values[:, None], axis=2)
    inside = np.all(values < reference, axis=1) & ~dominated.any(axis=1)
    for k in np.flatnonzero(inside):
        gains[k] = max(hypervolume(np.vstack([front, values[k]]), reference) - volume, 0.0)
    return gains
