"""From a campaign to its tasks: every cell with its identity, its study and its note, and what is recorded of it already."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from railsearch.campaign.cells import Campaign, Cell
from railsearch.campaign.coordinator import CellTask
from railsearch.campaign.identity import cell_identity
from railsearch.design_problem import DesignProblem
from railsearch.errors import StorageError
from railsearch.plugin_manager import Registry
from railsearch.result import RunCommand
from railsearch.simulation import InProcess
from railsearch.storage import StudyDescription, StudyProgress, identity_differences
from railsearch.study_note import study_note

DIFFERENCES_SHOWN = 5


def cell_tasks(
    registry: Registry, campaign: Campaign, problems: Mapping[str, DesignProblem], cells: Iterable[Cell], command: str
) -> list[CellTask]:
    """The tasks of cells; `command` is what the note in the dashboard says to repeat."""
    return [_task(registry, campaign, problems[cell.problem], cell, command) for cell in cells]


def _task(registry: Registry, campaign: Campaign, problem: DesignProblem, cell: Cell, command: str) -> CellTask:
    identity = cell_identity(registry, campaign, cell, problem)
    names = tuple(objective.name for objective in problem.objectives)
    note = study_note(problem, RunCommand(command, identity))
    description = StudyDescription(cell.study_name(campaign.name), identity, names, problem.n_ieq_constr, note)
    return CellTask(cell, description, problem.space, campaign.budget)


@dataclass(frozen=True)
class TaskProgress:
    """How much of the tasks is recorded: complete cells, evaluations by cell, and evaluations still to make by problem."""

    complete: int
    stored: Mapping[Cell, int]
    missing: Mapping[str, int]

    @property
    def evaluations(self) -> int:
        """The recorded evaluations of all cells."""
        return sum(self.stored.values())


def recorded(tasks: Sequence[CellTask], studies: Mapping[str, StudyProgress], made: Collection[Cell] = ()) -> TaskProgress:
    """How much of the tasks the studies of a storage hold; `made` are complete elsewhere and count as if they were here."""
    stored: dict[Cell, int] = {}
    missing = dict.fromkeys((task.cell.problem for task in tasks), 0)
    for task in tasks:
        progress = studies.get(task.description.name)
        here = min(progress.evaluations if progress else 0, task.evaluations)
        stored[task.cell] = task.evaluations if task.cell in made else here
        missing[task.cell.problem] += task.evaluations - stored[task.cell]
    return TaskProgress(sum(stored[task.cell] == task.evaluations for task in tasks), stored, missing)


def is_complete(task: CellTask, stored: Mapping[str, StudyProgress]) -> bool:
    """Whether all evaluations of a task are in a storage."""
    progress = stored.get(task.description.name)
    return progress is not None and progress.evaluations >= task.evaluations


def evaluation_seconds(problem: DesignProblem) -> float:
    """How long one evaluation takes here, at the reference design or else at the lower bounds; for an estimate."""
    simulator = InProcess(problem)
    simulator.warm_up()
    design = problem.space.rounded(problem.space.lower) if problem.reference is None else problem.reference
    return simulator.simulate(design).duration


def check_recorded(tasks: Sequence[CellTask], stored: Mapping[str, StudyProgress], place: str) -> None:
    """Raise StorageError if the studies of a storage belong to other runs than the tasks, with what differs."""
    reasons: dict[str, int] = {}
    for task in tasks:
        known = stored.get(task.description.name)
        if known is None or (known.identity is None and not known.evaluations):
            continue
        identity: Mapping[str, Any] = known.identity or {}
        for difference in identity_differences(identity, task.description.identity):
            reasons[difference] = reasons.get(difference, 0) + 1
    if reasons:
        rows = [f"{difference} (in {count} cells)" for difference, count in list(reasons.items())[:DIFFERENCES_SHOWN]]
        if len(reasons) > DIFFERENCES_SHOWN:
            rows.append(f"and {len(reasons) - DIFFERENCES_SHOWN} more")
        raise StorageError(
            "\n- ".join((f"{place} holds other runs under the names of this campaign's cells:", *rows))
            + "\nNothing was changed. Give the campaign another name, use another storage, or repeat the file that made them"
        )
