"""What has been learnt since the last restart."""

import numpy as np
from scipy.spatial.distance import cdist

from railsearch.space import FloatArray

from .parameters import MetricSearchParameters
from .step_size import StepSize


class Trajectory:
    """The points, incumbent design and step size of the search since a restart.

    number: how many restarts came before; budget: how many evaluations were left when it started.
    """

    def __init__(self, number: int, budget: int, dimension: int, parameters: MetricSearchParameters) -> None:
        self.number = number
        self.budget = budget
        self.evaluations = 0
        self.initial_size: int | None = None
        self.incumbent = np.full(dimension, np.nan)
        self.best_value = np.inf
        self.step = StepSize(
            parameters.sigma_start,
            parameters.halvings_before_restart,
            parameters.failure_tolerance or max(dimension, 5),
            parameters.success_tolerance,
        )
        self._dimension = dimension
        self._parameters = parameters
        self._points: list[FloatArray] = []
        self._values: list[float] = []

    @property
    def searching(self) -> bool:
        """Whether the initial design is behind us."""
        return self.initial_size is not None

    @property
    def points(self) -> FloatArray:
        """The points (n, d) that belong in the surrogate."""
        return np.array(self._points).reshape(-1, self._dimension)

    @property
    def values(self) -> FloatArray:
        """The values (n,) at the points."""
        return np.array(self._values)

    def begin_search(self) -> None:
        """Declare what has been evaluated so far the initial design."""
        self.initial_size = self.evaluations

    def record(self, design: FloatArray, point: FloatArray, value: float | None, repeated: bool) -> None:
        """Take in an evaluated design (d,), `point` being its place in the unit cube and `value` None if it failed.

        A repeated one is but a failure to improve.
        """
        learnt = None if repeated else value
        self.evaluations += not repeated
        if self.searching:
            self.step.record(learnt is not None and self._improves(learnt))
        if learnt is None:
            return
        if self._apart(point):
            self._points.append(point)
            self._values.append(learnt)
        if learnt < self.best_value:
            self.incumbent, self.best_value = design, learnt

    def _improves(self, value: float) -> bool:
        return bool(value < self.best_value - self._parameters.improvement_threshold * abs(self.best_value))

    def _apart(self, point: FloatArray) -> bool:
        return not self._points or cdist(point[None, :], self.points).min() >= self._parameters.minimum_distance
