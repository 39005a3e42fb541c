"""Contact rows on a rail that is known at its nodes.

symbol  meaning                                                         shape   unit
N       row with rail displacement under a wheel = N u                  (4,)    -, m
x_i     positions of the rail nodes                                     (k,)    m
ξ, l    offset of a wheel in its element, length of the element                 m

With rotations N are the Hermite functions. Without, `cubic` gives every node the slope of the parabola through it and its
neighbours (at the ends through the two next to it), a piecewise cubic with a continuous slope, exact for parabolas;
`linear` is the chord. All rows of vertical unknowns sum to one: the track receives the whole force.
"""

import numpy as np
from numpy.typing import NDArray

from railsearch_plugins.dynamics.beam import find, hermite
from railsearch_plugins.dynamics.moving_contact import Contact, make_contact
from railsearch_plugins.track_models.imported_track.tables import RailTable

FloatArray = NDArray[np.float64]


def rail_contact(
    rail: RailTable, interpolation: str, positions: FloatArray, irregularity: FloatArray, sign: float
) -> Contact:
    """Contact (t, 1) of one wheel at `positions` (t,) in m; irregularity (t,) downward in m.

    interpolation: 'hermite', 'cubic' or 'linear'; sign: −1 where rotations are the negative slope.
    """
    wheel, profile = positions[:, None], irregularity[:, None, None]
    if interpolation == "hermite":
        made = make_contact(rail.position, np.stack([rail.vertical, rail.rotation], axis=1), wheel, profile)
        made.rows[..., 1::2] *= sign
        return made
    nodes, rows = (cubic_rows if interpolation == "cubic" else linear_rows)(rail.position, positions)
    unknowns = rail.vertical[nodes]
    rows = np.where(unknowns >= 0, rows, 0.0)
    return Contact(np.maximum(unknowns, 0)[:, None, :], rows[:, None, None, :], profile)


def linear_rows(nodes: FloatArray, positions: FloatArray) -> tuple[NDArray[np.int64], FloatArray]:
    """Nodes (t, 4) around `positions` (t,) and their shares (t, 4); the last two are zero."""
    element, offset, length = find(nodes, positions)
    share = offset / length
    none = np.zeros_like(share)
    around = np.stack([element, element + 1, element, element], axis=1)
    return around, np.stack([1.0 - share, share, none, none], axis=1)


def cubic_rows(nodes: FloatArray, positions: FloatArray) -> tuple[NDArray[np.int64], FloatArray]:
    """Nodes (t, 4) around `positions` (t,) and their shares (t, 4): Hermite functions with the slopes of parabolas."""
    element, offset, length = find(nodes, positions)
    values, last = hermite(offset, length), nodes.size - 1
    if last == 1:
        return linear_rows(nodes, positions)
    first = np.clip(element - 1, 0, max(last - 3, 0))
    around = first[:, None] + np.arange(4)
    rows = np.zeros((positions.size, 4))
    for node, of_value, of_slope in ((element, values[:, 0], values[:, 1]), (element + 1, values[:, 2], values[:, 3])):
        rows += of_value[:, None] * (around == node[:, None])
        middle = np.clip(node, 1, last - 1)
        for neighbour, weight in zip((middle - 1, middle, middle + 1), _slope_weights(nodes, middle, node), strict=True):
            rows += (of_slope * weight)[:, None] * (around == neighbour[:, None])
    return np.minimum(around, last), rows


def _slope_weights(nodes: FloatArray, middle: NDArray[np.int64], at: NDArray[np.int64]) -> tuple[FloatArray, ...]:
    """Weights of three nodes around `middle` in the slope at node `at` of the parabola through them (Lagrange)."""
    a, b, c, x = nodes[middle - 1], nodes[middle], nodes[middle + 1], nodes[at]
    return (
        (2.0 * x - b - c) / ((a - b) * (a - c)),
        (2.0 * x - a - c) / ((b - a) * (b - c)),
        (2.0 * x - a - b) / ((c - a) * (c - b)),
    )
