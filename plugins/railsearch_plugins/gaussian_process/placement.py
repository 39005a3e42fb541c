"""Where a Gaussian process sees the points of a surrogate: rounded ones, or coordinates of random inputs.

| symbol | meaning | shape |
|---|---|---|
| x | points as they are given | (k, d) |
| z | points as the process sees them | (k, d) |
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from railsearch.space import FloatArray

from .estimation import Hyperparameters
from .process import GaussianProcess


class Placement(Protocol):
    """A map from x to z."""

    def placed(self, points: FloatArray) -> FloatArray:
        """Points z (k, d) of points x (k, d)."""

    def pulled_back(self, slopes: FloatArray, points: FloatArray) -> FloatArray:
        """Derivatives (k, d) by x at points x (k, d), from those by z."""


@dataclass(frozen=True)
class Rounding:
    """Points of the unit cube rounded to `steps` (d,) over the range of a variable; 0 leaves it as it is."""

    steps: FloatArray

    def placed(self, points: FloatArray) -> FloatArray:
        """The rounded points (k, d)."""
        whole = self.steps > 0.0
        if not whole.any():
            return points
        return np.where(whole, np.round(points * self.steps) / np.where(whole, self.steps, 1.0), points)

    def pulled_back(self, slopes: FloatArray, points: FloatArray) -> FloatArray:
        """Zero by a rounded variable."""
        return np.where(self.steps > 0.0, 0.0, slopes)


@dataclass(frozen=True)
class PlacedProcess:
    """A Gaussian process that sees z, asked and answering by x."""

    process: GaussianProcess
    placement: Placement

    def fit(
        self,
        points: FloatArray,
        values: FloatArray,
        generator: np.random.Generator,
        start: Hyperparameters | None = None,
    ) -> None:
        """Fit to points x (n, d), as `GaussianProcess.fit`."""
        self.process.fit(self.placement.placed(points), values, generator, start)

    def extend(self, points: FloatArray, values: FloatArray) -> None:
        """Add points x (k, d), as `GaussianProcess.extend`."""
        self.process.extend(self.placement.placed(points), values)

    def predict(self, points: FloatArray) -> FloatArray:
        """Predictions (k,) at points x (k, d)."""
        return self.process.predict(self.placement.placed(np.atleast_2d(points)))

    def gradient(self, points: FloatArray) -> FloatArray:
        """Derivatives (k, d) of the prediction by x."""
        points = np.atleast_2d(points)
        return self.placement.pulled_back(self.process.gradient(self.placement.placed(points)), points)

    def predict_with_gradient(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Both at once."""
        points = np.atleast_2d(points)
        values, slopes = self.process.predict_with_gradient(self.placement.placed(points))
        return values, self.placement.pulled_back(slopes, points)

    def deviation(self, points: FloatArray) -> FloatArray:
        """Standard deviations (k,) of the prediction, the uncertainty of the trend included."""
        return self.process.deviation(self.placement.placed(np.atleast_2d(points)))

    def deviation_gradient(self, points: FloatArray) -> FloatArray:
        """Derivatives (k, d) of the standard deviation by x."""
        points = np.atleast_2d(points)
        return self.placement.pulled_back(self.process.deviation_gradient(self.placement.placed(points)), points)
