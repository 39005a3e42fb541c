"""A surrogate that chooses how to look at the objective: its transform and, if wished, its length scales.

| symbol | meaning | shape | unit | source |
|---|---|---|---|---|
| f, T | values and transformed values | (n,) | of f, - | |
| e | leave-one-out residuals of T | (n,) | - | Rippa 1999 |
| ρ | Spearman's rank correlation | scalar | - | |
| ℓ | length scales, in [1/8, 8] of their geometric mean, mean 1 | (d,) | - | |
| w | weights 1/(1 + 4 rank/n), the best point first | (n,) | - | |

A transform is made anew every so many evaluations; values in between are transformed as those before. Where that leaves the
transformed values of all earlier points as they are, new points are added to the surrogate, otherwise it is fitted anew.

The transform with the largest ρ(T, T − e) over all points plus ρ over the better half is taken, the present one with a bonus
of 0.02 so that it does not flutter. Length scales are moved one by one, in random order, by a factor of 1.6 up, else down,
where that lowers Σ w e².
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol, cast

import numpy as np

from railsearch.errors import SurrogateError
from railsearch.interfaces import Surrogate
from railsearch.space import FloatArray

from .transforms import TRANSFORMS, Transform, identity

HABIT = 0.02
"""Bonus of the present transform."""

STEP = 1.6
"""Factor by which a length scale is moved."""

SPREAD = 8.0
"""Length scales stay within this factor of their geometric mean."""


class ScoredSurrogate(Surrogate, Protocol):
    """A surrogate that knows its leave-one-out residuals."""

    def leave_one_out_residuals(self) -> FloatArray:
        """Residuals (n,) in the order of the points."""


MakeSurrogate = Callable[[Mapping[str, object]], Surrogate]
"""Makes the surrogate with settings that differ from the strategy's own."""


@dataclass(frozen=True)
class Adaptation:
    """What is adapted: the transform, one of these names, the first to begin with; whether length scales are; how often."""

    transforms: tuple[str, ...] = ("identity",)
    length_scales: bool = False
    every: int = 10

    @property
    def needed(self) -> bool:
        """Whether there is anything to choose."""
        return self.length_scales or len(self.transforms) > 1


class AdaptiveModel:
    """A surrogate of transformed values, kept up to date as evaluations come in.

    generator: for the order in which length scales are moved; needed only where they are.
    After `refresh`: `surrogate`, and `values` (n,), the transformed ones.
    """

    def __init__(
        self, make: MakeSurrogate, adaptation: Adaptation | None = None, generator: np.random.Generator | None = None
    ) -> None:
        self._make = make
        self._adaptation = adaptation or Adaptation()
        self._generator = generator or np.random.default_rng(0)
        self._scales = np.empty(0)
        self._adapted = 0
        self._fitted = 0
        self._made = 0
        self._made_transform: Transform = identity(np.empty(0))
        self.transform = self._adaptation.transforms[0]
        self.values = np.empty(0)
        self.surrogate: Surrogate | None = None

    def refresh(self, points: FloatArray, values: FloatArray) -> Surrogate | None:
        """Learn from points (n, d) with values f (n,), of which the first may be known; None if they determine no model."""
        try:
            if self._adaptation.needed and (not self._adapted or len(points) - self._adapted >= self._adaptation.every):
                self._adapt(points, values)
            self._fit(points, values)
        except SurrogateError:
            self.surrogate = None
        return self.surrogate

    def _fit(self, points: FloatArray, values: FloatArray) -> None:
        """Add what is new where the values stay as they are; otherwise fit anew."""
        before, self.values = self.values, self._transformed(values)
        same = np.array_equal(before, self.values[: len(before)])
        if self.surrogate is None or self._adaptation.needed or not same:
            self.surrogate = self._fitted_surrogate(points, self.values, self._scales)
        elif len(points) > self._fitted:
            try:
                self.surrogate.add(points[self._fitted :], self.values[self._fitted :])
            except SurrogateError:
                self.surrogate = self._fitted_surrogate(points, self.values, self._scales)
        self._fitted = len(points)

    def _transformed(self, values: FloatArray) -> FloatArray:
        """The values by the present transform, which is made anew when that is due."""
        if not self._made or len(values) - self._made >= self._adaptation.every:
            self._made_transform, self._made = TRANSFORMS[self.transform](values), len(values)
        return self._made_transform(values)

    def _adapt(self, points: FloatArray, values: FloatArray) -> None:
        """Choose the transform, then move the length scales."""
        names = self._adaptation.transforms
        if len(names) > 1:
            bonus = {name: HABIT * (name == self.transform) for name in names}
            scores = {name: self._score(points, TRANSFORMS[name](values)(values)) + bonus[name] for name in names}
            self.transform = max(names, key=lambda name: scores[name])
        if self._adaptation.length_scales:
            self._scales = self._moved_scales(points, TRANSFORMS[self.transform](values)(values))
        self._adapted = len(points)

    def _score(self, points: FloatArray, transformed: FloatArray) -> float:
        """ρ(T, T − e) over all points plus ρ over the better half."""
        predicted = transformed - self._residuals(points, transformed, self._scales)
        better = transformed <= np.median(transformed)
        return _rank_correlation(transformed, predicted) + _rank_correlation(transformed[better], predicted[better])

    def _moved_scales(self, points: FloatArray, transformed: FloatArray) -> FloatArray:
        """One pass over the variables."""
        dimension = points.shape[1]
        ranks = _ranks(transformed, "ordinal") - 1.0
        weights = 1.0 / (1.0 + 4.0 * ranks / len(ranks))
        scales = self._scales if len(self._scales) else np.ones(dimension)
        least = _weighted_error(weights, self._residuals(points, transformed, scales))
        for variable in self._generator.permutation(dimension):
            for factor in (STEP, 1.0 / STEP):
                trial = _normalised(scales, int(variable), factor)
                error = _weighted_error(weights, self._residuals(points, transformed, trial))
                if error < least:
                    scales, least = trial, error
                    break
        return scales

    def _residuals(self, points: FloatArray, transformed: FloatArray, scales: FloatArray) -> FloatArray:
        return cast(ScoredSurrogate, self._fitted_surrogate(points, transformed, scales)).leave_one_out_residuals()

    def _fitted_surrogate(self, points: FloatArray, values: FloatArray, scales: FloatArray) -> Surrogate:
        surrogate = self._make({"length_scales": tuple(scales.tolist())} if len(scales) else {})
        surrogate.fit(points, values)
        return surrogate


def _normalised(scales: FloatArray, variable: int, factor: float) -> FloatArray:
    """The scales with one moved, within their spread and with mean 1."""
    moved = scales.copy()
    moved[variable] *= factor
    centre = np.exp(np.mean(np.log(moved)))
    moved = np.clip(moved, centre / SPREAD, centre * SPREAD)
    return moved / np.mean(moved)


def _weighted_error(weights: FloatArray, residuals: FloatArray) -> float:
    return float(np.sum(weights * residuals**2))


def _ranks(values: FloatArray, ties: str = "average") -> FloatArray:
    """The ranks of values from 1 on; scipy.stats takes half a second to import."""
    from scipy.stats import rankdata

    ranks: FloatArray = rankdata(values, method=ties)
    return ranks


def _rank_correlation(first: FloatArray, second: FloatArray) -> float:
    """Spearman's ρ; 0 where one of them is constant."""
    ranks = [_ranks(values) - 0.5 * (len(values) + 1) for values in (first, second)]
    scale = float(np.sqrt(np.sum(ranks[0] ** 2) * np.sum(ranks[1] ** 2)))
    return float(ranks[0] @ ranks[1]) / scale if scale > 0.0 else 0.0
