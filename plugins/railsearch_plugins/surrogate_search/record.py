"""What has been evaluated, and what surrogates may learn from."""

from collections.abc import Sequence

import numpy as np
from scipy.spatial.distance import cdist

from railsearch.interfaces import Evaluation
from railsearch.space import FloatArray, Space


class EvaluationRecord:
    """The evaluations of a run, each design once.

    `seen` holds every design by its key, `failures` those that failed, `successes` the evaluations that did not, and
    `learnable` the successes that lie `minimum_distance` or more (unit cube) from every earlier one, so that a surrogate
    through all of them is well determined.
    """

    def __init__(self, space: Space, minimum_distance: float) -> None:
        self._space = space
        self._minimum_distance = minimum_distance
        self.seen: dict[bytes, FloatArray] = {}
        self.failures: list[FloatArray] = []
        self.successes: list[Evaluation] = []
        self.learnable: list[Evaluation] = []

    def add(self, evaluations: Sequence[Evaluation]) -> None:
        """Take in evaluations in their order; of a design told before nothing more is learnt."""
        for evaluation in evaluations:
            key = self._space.key(evaluation.design)
            if key in self.seen:
                continue
            self.seen[key] = evaluation.design
            if evaluation.failed:
                self.failures.append(evaluation.design)
                continue
            self.successes.append(evaluation)
            if self._apart(evaluation.design):
                self.learnable.append(evaluation)

    @property
    def designs(self) -> FloatArray:
        """All designs (n, d), failed ones included, in native units."""
        return np.array(list(self.seen.values())).reshape(-1, self._space.dimension)

    @property
    def points(self) -> FloatArray:
        """The learnable points (k, d) of the unit cube."""
        designs = np.array([evaluation.design for evaluation in self.learnable])
        return self._space.to_unit(designs.reshape(-1, self._space.dimension))

    def unseen(self, designs: FloatArray) -> FloatArray:
        """Those of the designs (k, d) that have not been evaluated, each once, in their order."""
        fresh = {self._space.key(design): design for design in designs}
        return np.array([design for key, design in fresh.items() if key not in self.seen]).reshape(-1, designs.shape[1])

    def _apart(self, design: FloatArray) -> bool:
        point = self._space.to_unit(design)[None, :]
        return not self.learnable or bool(cdist(point, self.points).min() >= self._minimum_distance)
