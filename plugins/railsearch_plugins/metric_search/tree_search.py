"""Mixed-integer tree search: branch and bound over the surrogate.

| symbol | meaning | shape | unit | source |
|---|---|---|---|---|
| x | point of the unit cube, integers relaxed | (d,) | unit cube | |
| z | steps of the integers above their lower bounds, z = x · (upper − lower) | (d,) | - | |
| f̂ | surrogate value | scalar | of f | |

Each node is a box. Its relaxation is minimised, the integer farthest from a whole number splits the box in two, and a box
whose relaxation is no lower than the lowest integer point met is dropped (Land and Doig 1960; on a surrogate: Holmström
2008, Müller 2016). The surrogate is not convex, so a relaxation's local minimum is a bound in practice, not in proof.

The boxes of lowest bound are taken several at a time and their relaxations minimised side by side. Before a lowest integer
point becomes what the rest is bounded by, single steps of its integers improve it as far as they go.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from railsearch.projected_gradient import SmoothFunction, minimised
from railsearch.space import FloatArray, Space

Relaxations = Callable[["Boxes"], tuple[FloatArray, FloatArray]]
"""Minimises f̂ in each of k boxes: the minimisers (k, d) and f̂ there (k,)."""

WHOLE = 1e-6
"""An integer nearer than this to a whole number of steps is not branched on."""

BATCH = 16
"""Boxes whose relaxations are minimised side by side, and starts of the first one."""

LOWEST = 256
"""So many points of the pool, the lowest, are starts of boxes after the first one."""

ITERATIONS = 8
"""Limit of the iterations of one relaxation: a box begins where the box that it was split off came to."""

FIRST_ITERATIONS = 30
"""The same in the first box and for the reals of the lowest integer point."""

TOLERANCE = 1e-5
"""A relaxation is done when a step promises less than this fraction of the spread of f̂ over the pool."""

FINAL_TOLERANCE = 1e-9
"""The same for the reals of the lowest integer point."""


@dataclass(frozen=True)
class Boxes:
    """Boxes from `lower` to `upper` (k, d) of the unit cube, a start in each (k, d) and a lower bound (k,) of f̂."""

    lower: FloatArray
    upper: FloatArray
    starts: FloatArray
    bounds: FloatArray

    def __len__(self) -> int:
        return len(self.bounds)

    def taken(self, rows: NDArray[np.intp]) -> Self:
        """The boxes of these rows."""
        return type(self)(self.lower[rows], self.upper[rows], self.starts[rows], self.bounds[rows])

    def joined(self, others: Self) -> Self:
        """These boxes and others."""
        pairs = zip(self._arrays(), others._arrays(), strict=True)
        return type(self)(*(np.concatenate(pair) for pair in pairs))

    def _arrays(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        return self.lower, self.upper, self.starts, self.bounds


def tree_search(surrogate: SmoothFunction, space: Space, pool: FloatArray, n_starts: int, max_nodes: int) -> FloatArray:
    """The integer points (k, d), unit cube, met in a branch and bound over the surrogate, the lowest last.

    `pool` (t, d) holds points of the unit cube: the first relaxation is minimised from 16 of them, of all ranks; every other
    one from its parent's minimiser and the n_starts − 1 lowest in its box, of the 256 lowest of the pool.
    """
    values = surrogate.predict(pool)
    ranked = pool[np.argsort(values, kind="stable")]
    scale = float(np.ptp(values)) or 1.0
    relaxations = _relaxations(surrogate, ranked, n_starts, TOLERANCE * scale)
    found = branch_and_bound(relaxations, surrogate.predict, space, max_nodes)
    if not space.integer.all():
        found.extend(_with_better_reals(surrogate, space, found[-1], FINAL_TOLERANCE * scale))
    return np.array(found)


def branch_and_bound(
    relaxations: Relaxations, predict: Callable[[FloatArray], FloatArray], space: Space, max_nodes: int
) -> list[FloatArray]:
    """The integer points (d,) of the unit cube, each lower in f̂ than the one before, met in up to `max_nodes` boxes.

    Boxes are taken by the value of their parent's relaxation, the lowest first. Every relaxed minimiser is rounded, so
    that there is something to bound by from the first box on.
    """
    found: list[FloatArray] = []
    best, corner = np.inf, np.zeros((1, space.dimension))
    queue = Boxes(corner, corner + 1.0, corner + 0.5, np.array([-np.inf]))
    while max_nodes > 0 and len(queue := queue.taken(np.flatnonzero(queue.bounds < best))):
        order = np.argsort(queue.bounds, kind="stable")
        now = min(BATCH, max_nodes)
        boxes, queue = queue.taken(order[:now]), queue.taken(order[now:])
        max_nodes -= len(boxes)
        points, bounds = relaxations(boxes)
        whole = space.to_unit(space.from_unit(points))
        values = predict(whole)
        if values.min() < best:
            met, best = _descent(predict, space, whole[np.argmin(values)], float(values.min()))
            found.extend(met)
        queue = queue.joined(_halves(space, boxes, points, bounds))
    return found


def _descent(
    predict: Callable[[FloatArray], FloatArray], space: Space, point: FloatArray, value: float
) -> tuple[list[FloatArray], float]:
    """From an integer point (d,) by the best single step of an integer until none is lower: the points, the last value."""
    integers = np.flatnonzero(space.integer)
    steps = np.zeros((2 * len(integers), space.dimension))
    steps[np.arange(len(steps)), np.tile(integers, 2)] = np.repeat([1.0, -1.0], len(integers))
    path = [point]
    while True:
        near = space.from_unit(path[-1]) + steps
        near = space.to_unit(near[((near >= space.lower) & (near <= space.upper)).all(axis=1)])
        values = predict(near) if len(near) else np.array([np.inf])
        lowest = int(np.argmin(values))
        if not values[lowest] < value:
            break
        path.append(near[lowest])
        value = float(values[lowest])
    return path, value


def _halves(space: Space, boxes: Boxes, points: FloatArray, bounds: FloatArray) -> Boxes:
    """The boxes without the fractional values of the most fractional integer, two of each; none where all are whole."""
    span = space.upper - space.lower
    steps = points * span
    fraction = np.where(space.integer, np.abs(steps - np.round(steps)), 0.0)
    split = np.argmax(fraction, axis=1)
    parents = np.flatnonzero(fraction.max(axis=1) > WHOLE)
    lower, upper, split = boxes.lower[parents], boxes.upper[parents], split[parents]
    below, above, rows = upper.copy(), lower.copy(), np.arange(len(parents))
    below[rows, split] = np.floor(steps[parents, split]) / span[split]
    above[rows, split] = np.ceil(steps[parents, split]) / span[split]
    twice = np.tile(parents, 2)
    return Boxes(np.concatenate([lower, above]), np.concatenate([below, upper]), points[twice], bounds[twice])


def _relaxations(surrogate: SmoothFunction, ranked: FloatArray, n_starts: int, tolerance: float) -> Relaxations:
    """Minimise the surrogate in boxes, with the points of the pool `ranked` (t, d) by their values, the lowest first."""
    spread = ranked[:: -(-len(ranked) // BATCH)]

    def relax(boxes: Boxes) -> tuple[FloatArray, FloatArray]:
        if np.isinf(boxes.bounds[0]):
            rows, starts, iterations = np.zeros(len(spread), dtype=np.intp), spread, FIRST_ITERATIONS
        else:
            rows, others = _lowest_inside(ranked[:LOWEST], boxes, n_starts - 1)
            rows, starts = np.concatenate([np.arange(len(boxes)), rows]), np.concatenate([boxes.starts, others])
            iterations = ITERATIONS
        points, values = minimised(surrogate, starts, boxes.lower[rows], boxes.upper[rows], tolerance, iterations)
        order = np.lexsort((values, rows))
        first = order[np.searchsorted(rows[order], np.arange(len(boxes)))]
        return points[first], values[first]

    return relax


def _lowest_inside(ranked: FloatArray, boxes: Boxes, count: int) -> tuple[NDArray[np.intp], FloatArray]:
    """Up to `count` of the ranked points (t, d) in each box, the first ones: the rows of the boxes, and the points."""
    if not count:
        return np.empty(0, dtype=np.intp), ranked[:0]
    inside = ((ranked >= boxes.lower[:, None]) & (ranked <= boxes.upper[:, None])).all(axis=2)
    rows, places = np.nonzero(inside & (np.cumsum(inside, axis=1) <= count))
    return rows, ranked[places]


def _with_better_reals(surrogate: SmoothFunction, space: Space, point: FloatArray, tolerance: float) -> list[FloatArray]:
    """The point (d,) with its integers held and its reals minimised, if that is lower."""
    row = point[None, :]
    lower, upper = (np.where(space.integer, row, bound) for bound in (0.0, 1.0))
    points, values = minimised(surrogate, row, lower, upper, tolerance, FIRST_ITERATIONS)
    return list(points[values < surrogate.predict(row)])
