"""The live progress of a campaign: evaluations, complete cells, failures, the last result, time left."""

import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager

from rich.progress import BarColumn, MofNCompleteColumn, Progress, TaskID, TextColumn, TimeRemainingColumn
from rich.table import Column

from railsearch.campaign.coordinator import CellTask, Watcher
from railsearch.campaign.tasks import TaskProgress
from railsearch.commands.options import messages
from railsearch.commands.progress import best_so_far
from railsearch.design_problem import DesignProblem
from railsearch.interfaces import Evaluation
from railsearch.run import front

SPEED_OVER = 600.0
LOG_EVERY = 60.0


@contextmanager
def campaign_progress(
    problems: Mapping[str, DesignProblem], tasks: Sequence[CellTask], before: TaskProgress
) -> Iterator[Watcher]:
    """A progress bar on standard error; gives what the coordinator tells its news to."""
    columns = (
        BarColumn(bar_width=10),
        MofNCompleteColumn(),
        TextColumn("evaluations, {task.fields[cells]} of {task.fields[planned]} cells{task.fields[failed]},"),
        TimeRemainingColumn(),
        TextColumn("left"),
        # What a narrow terminal has no room for is the end of this column.
        TextColumn("{task.fields[last]}", table_column=Column(ratio=1, no_wrap=True, overflow="ellipsis")),
    )
    visible = messages.is_terminal
    with Progress(
        *columns, console=messages, speed_estimate_period=SPEED_OVER, expand=True, disable=not visible
    ) as progress:
        bar = progress.add_task(
            "campaign",
            total=sum(task.evaluations for task in tasks),
            completed=before.evaluations,
            cells=before.complete,
            planned=len(tasks),
            failed="",
            last="",
        )
        shown = _Shown(problems, progress, bar, before)
        yield Watcher(shown.evaluation, shown.complete, messages.print)


class _Shown:
    """What the bar says; called in the threads of the places."""

    def __init__(self, problems: Mapping[str, DesignProblem], progress: Progress, bar: TaskID, before: TaskProgress) -> None:
        self._problems = problems
        self._progress = progress
        self._bar = bar
        self._cells = before.complete
        self._done = dict(before.stored)
        self._failed = 0
        self._told = time.monotonic()
        self._lock = threading.Lock()

    def evaluation(self, task: CellTask, evaluation: Evaluation) -> None:
        """One more evaluation."""
        with self._lock:
            self._done[task.cell] += 1
            self._failed += evaluation.failed
            failed = f", {self._failed} failed" if self._failed else ""
            self._progress.update(self._bar, advance=1, failed=failed)
            self._tell_log()

    def complete(self, task: CellTask, evaluations: Sequence[Evaluation]) -> None:
        """One more complete cell; what other processes evaluated of it counts now."""
        with self._lock:
            self._cells += 1
            elsewhere = len(evaluations) - self._done[task.cell]
            problem, cell = self._problems[task.cell.problem], task.cell
            best = best_so_far(problem, front(evaluations))
            last = f"last {cell.strategy} on {cell.problem}: {best}"
            self._progress.update(self._bar, advance=elsewhere, cells=self._cells, last=last)

    def _tell_log(self) -> None:
        """Where there is no terminal, a line from time to time takes the place of the bar."""
        now = time.monotonic()
        if self._progress.console.is_terminal or now - self._told < LOG_EVERY:
            return
        self._told = now
        (bar,) = self._progress.tasks
        left = "" if bar.time_remaining is None else f", about {bar.time_remaining / 60.0:.0f} min left"
        self._progress.console.print(
            f"{bar.completed:.0f} of {bar.total:.0f} evaluations, {self._cells} of {bar.fields['planned']} cells"
            f"{bar.fields['failed']}{left}"
        )
