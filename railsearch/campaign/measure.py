"""What the strategies of a campaign are compared by on one problem: its objective, or the hypervolume of the front.

| symbol | meaning | shape | unit | source |
|---|---|---|---|---|
| F | objectives, minimised | (n, m) | each its own | |
| z | ideal point: the best recorded value of each objective | (m,) | of F | |
| r | reference point | (m,) | of F | |
| H | volume that F dominates of the box between z and r, as a share of it | scalar | - | Zitzler et al. 2003 |
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from railsearch.campaign.cells import CampaignProblem
from railsearch.campaign.results import CellRecord
from railsearch.design_problem import DesignProblem
from railsearch.indicators import hypervolume_curve
from railsearch.interfaces import Quantity
from railsearch.space import FloatArray
from railsearch.statistics import best_so_far

HYPERVOLUME = Quantity(
    "hypervolume", "", "dominated share of the box between the ideal point and the reference point", maximised=True
)
GIVEN = "given by the campaign"
WORST_KNOWN = "the problem's worst known values"
WORST_RECORDED = "the worst recorded values"


@dataclass(frozen=True)
class Box:
    """Ideal point z (m,) and reference point r (m,) between which hypervolume is measured, and where r comes from."""

    ideal: FloatArray
    reference: FloatArray
    source: str


@dataclass(frozen=True)
class Measure:
    """A quantity by which runs of one problem are compared; box: for several objectives, None for one."""

    quantity: Quantity
    box: Box | None = None

    def curve(self, record: CellRecord, budget: int) -> FloatArray:
        """The best value (budget,) so far, as it is minimised; NaN until there is one. The record must be that long."""
        objectives = np.where(record.feasible[:, None], record.objectives, np.nan)[:budget]
        if self.box is None:
            return best_so_far(objectives[:, 0])
        scaled = (objectives - self.box.ideal) / (self.box.reference - self.box.ideal)
        return 0.0 - hypervolume_curve(scaled, np.ones(objectives.shape[1]))

    def natural(self, values: FloatArray) -> FloatArray:
        """Values with their natural sign."""
        return 0.0 - values if self.quantity.maximised else values


def measure_of(problem: DesignProblem, asked: CampaignProblem, records: Sequence[CellRecord]) -> Measure:
    """The measure of a problem; the hypervolume's box is fixed by all of its records."""
    if problem.n_obj == 1:
        return Measure(problem.objectives[0])
    return Measure(HYPERVOLUME, _box(problem, asked, records))


def _box(problem: DesignProblem, asked: CampaignProblem, records: Sequence[CellRecord]) -> Box:
    """The box up to the first of the given, the known and the recorded worst point that is worse than the ideal point."""
    feasible = np.concatenate([np.empty((0, problem.n_obj)), *(record.objectives[record.feasible] for record in records)])
    if not len(feasible):
        return Box(np.zeros(problem.n_obj), np.ones(problem.n_obj), WORST_RECORDED)
    ideal, worst = feasible.min(axis=0), feasible.max(axis=0)
    signs = {q.name: -1.0 if q.maximised else 1.0 for q in problem.objectives}
    given = {name: signs[name] * value for name, value in asked.reference_point.items()}
    for values, source in ((given, GIVEN), (problem.worst, WORST_KNOWN)):
        point = _point(problem, values)
        if point is not None and np.all(point > ideal):
            return Box(ideal, point, source)
    return Box(ideal, np.where(worst > ideal, worst, ideal + 1.0), WORST_RECORDED)


def _point(problem: DesignProblem, values: Mapping[str, float]) -> FloatArray | None:
    names = [quantity.name for quantity in problem.objectives]
    return np.array([values[name] for name in names]) if set(names) <= set(values) else None
