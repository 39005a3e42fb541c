"""Mixed-integer tree search: branch and bound over the surrogate.

| symbol | meaning | shape | unit | source |
|---|---|---|---|---|
| x | point of the unit cube, integers relaxed | (d,) | unit cube | |
| z | steps of the integers above their lower bounds, z = x · (upper − lower) | (d,) | - | |
| f̂ | surrogate value | scalar | of f | |

Each node is a box. Its relaxation is minimised, the integer farthest from a whole number splits the box in two, and a box
whose relaxation is no lower than the lowest integer point met is dropped (Land and Doig 1960; on a surrogate: Holmström
2008, Müller 2016). The surrogate is not convex, so a relaxation's local minimum is a bound in practice, not in proof.
"""

import heapq
import itertools
from collections.abc import Callable
from typing import Protocol

import numpy as np
from scipy.optimize import minimize

from railsearch.space import FloatArray, Space


class SmoothFunction(Protocol):
    """What can be searched: a surrogate, or something made of one."""

    def predict(self, points: FloatArray) -> FloatArray:
        """Values (k,) at points (k, d)."""

    def gradient(self, points: FloatArray) -> FloatArray:
        """Derivatives (k, d) at points (k, d)."""


Relaxation = Callable[[FloatArray, FloatArray, FloatArray | None], tuple[FloatArray, float]]
"""Minimises f̂ in the box from `lower` (d,) to `upper` (d,), perhaps from a given start: the minimiser (d,) and f̂ there."""

WHOLE = 1e-6
"""An integer nearer than this to a whole number of steps is not branched on."""

ITERATIONS = 30
"""Limit of the quasi-Newton iterations of one relaxation; the integers need its minimiser to a fraction of a step only."""


def tree_search(surrogate: SmoothFunction, space: Space, pool: FloatArray, n_starts: int, max_nodes: int) -> FloatArray:
    """The integer points (k, d), unit cube, met in a branch and bound over the surrogate, the lowest last.

    `pool` (t, d) holds points of the unit cube, the lowest of which in a box are the starts of its relaxation.
    """

    def predict(point: FloatArray) -> float:
        return float(surrogate.predict(point[None, :])[0])

    points = branch_and_bound(_relaxation(surrogate, pool, n_starts), predict, space, max_nodes)
    return np.array(points).reshape(-1, space.dimension)


def branch_and_bound(
    relaxation: Relaxation, predict: Callable[[FloatArray], float], space: Space, max_nodes: int
) -> list[FloatArray]:
    """The integer points (d,) of the unit cube, each lower in f̂ than the one before, met in up to `max_nodes` boxes.

    Boxes are taken by the value of their parent's relaxation, the lowest first. Every relaxed minimiser is rounded, so
    that there is something to bound by from the first box on.
    """
    found: list[FloatArray] = []
    best, order = np.inf, itertools.count()
    queue: list[tuple[float, int, FloatArray, FloatArray, FloatArray | None]]
    queue = [(-np.inf, next(order), np.zeros(space.dimension), np.ones(space.dimension), None)]
    for _ in range(max_nodes):
        if not queue or queue[0][0] >= best:
            break
        _, _, lower, upper, start = heapq.heappop(queue)
        point, bound = relaxation(lower, upper, start)
        whole = space.to_unit(space.from_unit(point))
        if (value := predict(whole)) < best:
            best = value
            found.append(whole)
        for low, high in _halves(space, point, lower, upper):
            heapq.heappush(queue, (bound, next(order), low, high, point))
    return found


def _halves(space: Space, point: FloatArray, lower: FloatArray, upper: FloatArray) -> list[tuple[FloatArray, FloatArray]]:
    """The two boxes without the fractional values of the most fractional integer; none if all are whole."""
    span = space.upper - space.lower
    steps = point * span
    fraction = np.where(space.integer, np.abs(steps - np.round(steps)), 0.0)
    split = int(np.argmax(fraction))
    if fraction[split] <= WHOLE:
        return []
    below, above = upper.copy(), lower.copy()
    below[split] = np.floor(steps[split]) / span[split]
    above[split] = np.ceil(steps[split]) / span[split]
    return [(lower, below), (above, upper)]


def _relaxation(surrogate: SmoothFunction, pool: FloatArray, n_starts: int) -> Relaxation:
    """Minimise the surrogate in a box by L-BFGS-B from the parent's minimiser and the lowest points of the pool."""
    values = surrogate.predict(pool)
    order = np.argsort(values, kind="stable")
    ranked = pool[order]
    scale = float(np.ptp(values)) or 1.0

    def scaled(point: FloatArray) -> tuple[float, FloatArray]:
        row = point[None, :]
        return float(surrogate.predict(row)[0]) / scale, surrogate.gradient(row)[0] / scale

    def relax(lower: FloatArray, upper: FloatArray, start: FloatArray | None) -> tuple[FloatArray, float]:
        inside = ranked[((ranked >= lower) & (ranked <= upper)).all(axis=1)]
        starts = [] if start is None else [np.clip(start, lower, upper)]
        starts += list(inside[: n_starts - len(starts)])
        bounds = np.column_stack([lower, upper])
        results = [
            minimize(scaled, x, jac=True, method="L-BFGS-B", bounds=bounds, options={"maxiter": ITERATIONS}) for x in starts
        ]
        best = min(results, key=lambda result: result.fun)
        return np.clip(best.x, lower, upper), float(best.fun) * scale

    return relax
