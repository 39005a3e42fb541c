"""The live progress bars of a search, a sample and a sensitivity study: what is done, best so far, failures, time left."""

import re
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TaskID, TextColumn, TimeRemainingColumn
from rich.table import Column

from railsearch.commands.options import messages
from railsearch.design_problem import DesignProblem
from railsearch.interfaces import Evaluation
from railsearch.result import START, flat_start, values_of
from railsearch.run import Watch, front
from railsearch.sensitivity_study import StudyWatcher

FAILURES_SHOWN = 5
NUMBER = re.compile(r"[-+]?\d[\d.]*(?:e[-+]?\d+)?")
SPEED_OVER = 60.0


@contextmanager
def run_progress(problem: DesignProblem, budget: int) -> Iterator[Watch]:
    """A progress bar on standard error; gives the function to call with every evaluation."""
    columns = (
        BarColumn(bar_width=10),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
        TextColumn("left{task.fields[failed]}, best"),
        # What a narrow terminal has no room for is the end of this column.
        TextColumn("{task.fields[best]}", table_column=Column(ratio=1, no_wrap=True, overflow="ellipsis")),
    )
    with Progress(*columns, console=messages, expand=True) as progress:
        task = progress.add_task(problem.name, total=budget, best="–", failed="")
        members: list[Evaluation] = []
        first: list[Evaluation] = []
        failures = _Failures(progress.console, "evaluation")

        def watch(evaluation: Evaluation) -> None:
            nonlocal members
            if len(first) < START:
                first.append(evaluation)
                if len(first) == min(START, budget) and (warning := flat_start(problem, first)):
                    progress.console.print(f"warning: {warning}")
            members = front([*members, evaluation])
            progress.update(task, advance=1, best=best_so_far(problem, members), failed=failures.noted(evaluation))

        yield watch


@contextmanager
def sample_progress(number: int, done: Sequence[Evaluation]) -> Iterator[Watch]:
    """A progress bar on standard error over `number` samples; gives the function to call with every one after `done`."""
    columns = (
        BarColumn(bar_width=10),
        MofNCompleteColumn(),
        TextColumn("samples{task.fields[failed]},"),
        TimeRemainingColumn(),
        TextColumn("left"),
    )
    with Progress(*columns, console=messages, speed_estimate_period=SPEED_OVER) as progress:
        failures = _Failures(progress.console, "sample", sum(evaluation.failed for evaluation in done))
        task = progress.add_task("samples", total=number, completed=len(done), failed=failures.words)

        def watch(evaluation: Evaluation) -> None:
            progress.update(task, advance=1, failed=failures.noted(evaluation))

        yield watch


@contextmanager
def study_progress() -> Iterator[StudyWatcher]:
    """What a sensitivity study does next, in lines on standard error, and a progress bar for refits of each criterion."""
    columns = (
        TextColumn("{task.description}"),
        BarColumn(bar_width=10),
        MofNCompleteColumn(),
        TextColumn("refits,"),
        TimeRemainingColumn(),
        TextColumn("left"),
    )
    with Progress(*columns, console=messages) as progress:
        bars: dict[str, TaskID] = {}

        def refit(criterion: str, number: int, count: int) -> None:
            if criterion not in bars:
                bars[criterion] = progress.add_task(criterion, total=count)
            progress.update(bars[criterion], completed=number)

        yield StudyWatcher(progress.console.print, refit)


@contextmanager
def plain_warnings() -> Iterator[None]:
    """Show what libraries warn of as one plain line each, once however often it is repeated with other numbers."""
    told: set[str] = set()

    def show(message: Warning | str, *details: object, **more: object) -> None:
        text = " ".join(str(message).split())
        kind = NUMBER.sub("", text)
        if kind not in told:
            told.add(kind)
            messages.print(f"warning: {text} (told once)")

    with warnings.catch_warnings():
        warnings.showwarning = show
        yield


class _Failures:
    """Counts failures and prints the first few."""

    def __init__(self, console: Console, what: str, before: int = 0) -> None:
        self._console = console
        self._what = what
        self._count = before

    def noted(self, evaluation: Evaluation) -> str:
        """The failures so far in words, this evaluation included."""
        self._count += evaluation.failed
        if evaluation.failed and self._count <= FAILURES_SHOWN:
            self._console.print(f"{self._what} {evaluation.number + 1} failed: {evaluation.reason}")
        return self.words

    @property
    def words(self) -> str:
        """The failures so far in words."""
        return f", {self._count} failed" if self._count else ""


def best_so_far(problem: DesignProblem, members: list[Evaluation]) -> str:
    """The best value with its raw objectives, or the size of the front, in words."""
    if not members:
        return "none yet"
    if problem.n_obj > 1:
        return f"front of {len(members)}"
    values = values_of(problem, members[0])
    shown = dict.fromkeys([*problem.objectives, *problem.simulated.objectives])
    return ", ".join(f"{q.name} {_short(values[q.name])} {q.unit}".rstrip() for q in shown)


def _short(value: float) -> str:
    """Three significant digits, or whole thousands and more: the line has to fit a narrow terminal."""
    return f"{value:.0f}" if abs(value) >= 1000.0 else f"{value:.3g}"
