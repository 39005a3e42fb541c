"""What a campaign has recorded, in columns."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from railsearch.campaign.cells import Campaign, Cell
from railsearch.design_problem import DesignProblem
from railsearch.space import FloatArray


@dataclass(frozen=True)
class CellRecord:
    """The n evaluations of one cell in their order; d variables, m objectives, k constraints.

    objectives and metrics are stored as they are minimised (a maximised quantity negated), NaN where an evaluation failed
    or a metric is missing; constraints hold when ≤ 0; reasons are empty for successful evaluations; durations and
    overheads are the seconds inside the evaluation, and inside the strategy before it.
    """

    identity: Mapping[str, Any]
    designs: FloatArray
    objectives: FloatArray
    constraints: FloatArray
    metrics: Mapping[str, FloatArray]
    origins: Sequence[str]
    trajectories: NDArray[np.int64]
    reasons: Sequence[str]
    durations: FloatArray
    overheads: FloatArray

    @property
    def failed(self) -> NDArray[np.bool_]:
        """Which evaluations failed (n,)."""
        return np.array([bool(reason) for reason in self.reasons], dtype=bool)

    @property
    def feasible(self) -> NDArray[np.bool_]:
        """Which evaluations succeeded and keep all constraints (n,)."""
        kept: NDArray[np.bool_] = ~self.failed & np.all(self.constraints <= 0.0, axis=1)
        return kept


@dataclass(frozen=True)
class CampaignResults:
    """A campaign, its problems as objects by label, and the record of every cell that has one."""

    campaign: Campaign
    problems: Mapping[str, DesignProblem]
    records: Mapping[Cell, CellRecord]
