"""Read a campaign from its storage."""

from collections.abc import Mapping, Sequence

import numpy as np

from railsearch.campaign.cells import Campaign, Cell
from railsearch.campaign.problems import make_problems
from railsearch.campaign.results import CampaignResults, CellRecord
from railsearch.design_problem import DesignProblem
from railsearch.errors import StorageError
from railsearch.plugin_manager import Registry
from railsearch.space import FloatArray
from railsearch.storage.reader import StudyColumns, read_studies


def read_campaign(registry: Registry, url: str, campaign: Campaign) -> CampaignResults:
    """What a storage has of a campaign: the records of those of its cells that have an evaluation.

    Raises StorageError if the storage cannot be read, and PluginError, InputError or CapabilityError if a problem of the
    campaign cannot be made.
    """
    problems = make_problems(registry, campaign)
    cells = {cell.study_name(campaign.name): cell for cell in campaign.cells()}
    records: dict[Cell, CellRecord] = {}
    for study in read_studies(url, f"{campaign.name}/"):
        cell = cells.get(study.name)
        if cell is not None and len(study.origins):
            records[cell] = cell_record(problems[cell.problem], study)
    return CampaignResults(campaign, problems, records)


def cell_record(problem: DesignProblem, study: StudyColumns) -> CellRecord:
    """The record of a run of `problem`. Raises StorageError if the study is that of another problem."""
    n = len(study.origins)
    missing = [name for name in problem.space.names if name not in study.variables]
    if missing:
        raise StorageError(f"study '{study.name}' has no {', '.join(missing)}: it is not a record of {problem.label}")
    return CellRecord(
        identity=study.identity,
        designs=np.column_stack([study.variables[name] for name in problem.space.names]),
        objectives=_stacked(study.objectives, problem.n_obj, n),
        constraints=_constraints(study.constraints, problem.n_ieq_constr),
        metrics={quantity.name: np.full(n, np.nan) for quantity in problem.metrics} | dict(study.metrics),
        origins=study.origins,
        trajectories=study.trajectories,
        reasons=study.reasons,
        durations=study.durations,
        overheads=study.overheads,
    )


def _stacked(columns: Mapping[int, FloatArray], m: int, n: int) -> FloatArray:
    """Objectives (n, m), NaN where no evaluation succeeded."""
    nothing = np.full(n, np.nan)
    return np.column_stack([columns.get(index, nothing) for index in range(m)])


def _constraints(rows: Sequence[Sequence[float] | None], k: int) -> FloatArray:
    """Constraints (n, k), NaN where an evaluation failed."""
    nothing = [np.nan] * k
    return np.array([nothing if row is None else row for row in rows], dtype=float)
