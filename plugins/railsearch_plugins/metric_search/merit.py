"""The merit of candidates: a weighted sum of surrogate value and distance from what has been evaluated.

| symbol | meaning | shape | unit | source |
|---|---|---|---|---|
| f̂ | surrogate values of the candidates | (t,) | of f | |
| Δ | distances to the nearest evaluated point | (t,) | unit cube | |
| w | weight of the surrogate value | scalar | - | Regis and Shoemaker 2007 |
| u | merit, the lowest is evaluated next | (t,) | - | Regis and Shoemaker 2007 |
"""

from collections.abc import Iterator

import numpy as np
from scipy.spatial.distance import cdist

from railsearch.space import FloatArray


def merit(values: FloatArray, distances: FloatArray, weight: float) -> FloatArray:
    """The merit u = w (f̂ − f̂_min)/(f̂_max − f̂_min) + (1 − w) (Δ_max − Δ)/(Δ_max − Δ_min) of candidates (t,).

    A term whose range is zero contributes nothing. Source: Regis and Shoemaker 2007.
    """
    return weight * _scaled(values) + (1.0 - weight) * _scaled(-distances)


def select(
    points: FloatArray,
    values: FloatArray,
    evaluated: FloatArray,
    weights: Iterator[float],
    count: int,
    minimum_distance: float,
) -> list[int]:
    """The indices of up to `count` candidates of lowest merit, points (t, d) of the unit cube with values f̂ (t,).

    Each one chosen joins the evaluated points (n, d) before the next is chosen with the next weight. Candidates nearer
    than `minimum_distance` to an evaluated point are left out; if all are, the list is shorter or empty.
    """
    distances = cdist(points, evaluated).min(axis=1)
    chosen: list[int] = []
    while len(chosen) < count:
        admissible = np.flatnonzero(distances >= minimum_distance)
        if not len(admissible):
            break
        scores = merit(values[admissible], distances[admissible], next(weights))
        chosen.append(int(admissible[np.argmin(scores)]))
        distances = np.minimum(distances, cdist(points, points[chosen[-1:]])[:, 0])
    return chosen


def _scaled(terms: FloatArray) -> FloatArray:
    """Terms mapped to [0, 1], the lowest to 0; zeros if they are all equal."""
    low, high = terms.min(), terms.max()
    return (terms - low) / (high - low) if high > low else np.zeros_like(terms)
