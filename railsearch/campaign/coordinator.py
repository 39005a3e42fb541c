"""Carries a campaign out: gives cells to places, stores every evaluation before the next one is asked for.

This process alone writes. A place that is lost costs what was under way there; its cell goes on elsewhere from the record.
Several coordinators may share a database server: a cell is claimed before it is touched.
"""

import threading
import time
import uuid
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from railsearch.campaign.cell_run import Beginning, Request, Step
from railsearch.campaign.cells import Cell
from railsearch.campaign.places import Place, PlaceLost, Places
from railsearch.interfaces import Evaluation
from railsearch.result import versions
from railsearch.space import Space
from railsearch.storage import RunStorage, Storage, StudyDescription

LOSSES_BEFORE_ISOLATION = 2
LOSSES_BEFORE_FAILURE = 5
LOOK_AGAIN = 1.0
ASK_OTHERS = 5.0


@dataclass(frozen=True)
class CellTask:
    """A cell with all that its run and its record need."""

    cell: Cell
    description: StudyDescription
    space: Space
    budget: int

    @property
    def evaluations(self) -> int:
        """How many evaluations a complete cell has."""
        return int(min(self.budget, self.space.size))


@dataclass(frozen=True)
class Watcher:
    """Who is told what happens: new evaluations, complete cells with all of theirs, and messages. Called in any thread."""

    evaluation: Callable[[CellTask, Evaluation], None] = lambda task, evaluation: None
    complete: Callable[[CellTask, Sequence[Evaluation]], None] = lambda task, evaluations: None
    message: Callable[[str], None] = lambda text: None


@dataclass
class _Work:
    """A task under way: what is stored, and how often a place was lost at which evaluation."""

    task: CellTask
    token: str = field(default_factory=lambda: uuid.uuid4().hex)
    losses: dict[int, int] = field(default_factory=dict)


class Coordinator:
    """Carries out tasks at places.

    parallel: evaluations of a batch at a time within a run; made: the evaluations that are known of a run from elsewhere,
    which are stored in place of being made. `failed` has the cells that an error ended, with the reason.
    """

    def __init__(
        self,
        storage: Storage,
        tasks: Sequence[CellTask],
        timeout: float | None = None,
        parallel: int = 1,
        watcher: Watcher | None = None,
        made: Callable[[CellTask], Sequence[Evaluation]] = lambda task: (),
    ) -> None:
        self._storage = storage
        self._timeout = timeout
        self._parallel = parallel
        self._watcher = watcher or Watcher()
        self._made = made
        self._waiting = deque(_Work(task) for task in tasks)
        self._elsewhere: dict[Cell, tuple[float, _Work]] = {}
        self._unfinished = len(self._waiting)
        self._changed = threading.Condition()
        self._stopping = False
        self._fault: BaseException | None = None
        self._versions = versions()
        self._told: set[str] = set()
        self.failed: dict[Cell, str] = {}

    def carry_out(self, places: Places) -> None:
        """Work until every cell is complete or failed. Raises StorageError when the record cannot be written any more.

        An interruption (KeyboardInterrupt) lets the evaluations under way finish and be stored; a second one does not.
        """
        threads: dict[str, threading.Thread] = {}
        try:
            while not self._over():
                self._ask_again()
                for place in places.present():
                    if place.name not in threads or not threads[place.name].is_alive():
                        threads[place.name] = threading.Thread(target=self._serve, args=(place,), daemon=True)
                        threads[place.name].start()
                with self._changed:
                    self._changed.wait_for(self._over, LOOK_AGAIN)
        except KeyboardInterrupt:
            self._watcher.message("stopping when the evaluations under way are finished; Ctrl-C again stops at once")
            self._stop(None)
            _join(threads.values())
            raise
        finally:
            self._stop(None)
            places.close()
        if self._fault is not None:
            _join(threads.values())
            raise self._fault

    def _over(self) -> bool:
        return self._unfinished == 0 or self._fault is not None

    def _stop(self, fault: BaseException | None) -> None:
        with self._changed:
            self._stopping = True
            self._fault = self._fault or fault
            self._changed.notify_all()

    def _serve(self, place: Place) -> None:
        """The thread of one place: one cell after the other until there is none, or the place is lost."""
        while (work := self._next()) is not None:
            try:
                self._claimed(work, place)
            except PlaceLost as lost:
                if not self._stopping:
                    self._watcher.message(f"{lost}; {_named(work.task.cell)} goes on from its record")
                self._put_back(work)
                return
            except Exception as fault:  # noqa: BLE001 - every thread stops; the main thread raises it
                self._stop(fault)
                return

    def _next(self) -> _Work | None:
        with self._changed:
            while not self._waiting and not self._stopping and not self._over():
                self._changed.wait(LOOK_AGAIN)
            return None if self._stopping or not self._waiting else self._waiting.popleft()

    def _put_back(self, work: _Work) -> None:
        with self._changed:
            self._waiting.appendleft(work)
            self._changed.notify_all()

    def _ask_again(self) -> None:
        """Look again at cells that other processes had: by now complete, or left behind by a process that died."""
        with self._changed:
            due = [cell for cell, (since, _) in self._elsewhere.items() if time.monotonic() - since > ASK_OTHERS]
            self._waiting.extend(self._elsewhere.pop(cell)[1] for cell in due)
            self._changed.notify_all()

    def _claimed(self, work: _Work, place: Place) -> None:
        """Carry a cell out if no other process has it."""
        name = work.task.description.name
        if not self._storage.claim(name):
            with self._changed:
                self._elsewhere[work.task.cell] = (time.monotonic(), work)
            return
        try:
            self._run(work, place)
        finally:
            self._storage.release(name)

    def _run(self, work: _Work, place: Place) -> None:
        task = work.task
        record = self._storage.run(task.description, task.space)
        stored = record.load()
        if len(stored) < task.evaluations:
            self._take_over(task, record, stored)
        finished = self._stopping or len(stored) >= task.evaluations
        error = "" if finished else self._searched(work, place, record, stored)
        if self._stopping and len(stored) < task.evaluations:
            return
        with self._changed:
            if error:
                self.failed[task.cell] = error
            self._unfinished -= 1
            self._changed.notify_all()
        if not error:
            self._watcher.complete(task, stored)

    def _take_over(self, task: CellTask, record: RunStorage, stored: list[Evaluation]) -> None:
        """Store what is known from elsewhere of a run, if what is stored of it is how that began."""
        known = self._made(task)
        if not all(_same(here, there) for here, there in zip(stored, known, strict=False)):
            return
        if new := known[len(stored) :]:
            self._keep(task, record, stored, new)

    def _keep(self, task: CellTask, record: RunStorage, stored: list[Evaluation], new: Sequence[Evaluation]) -> None:
        record.append(*new)
        stored.extend(new)
        for evaluation in new:
            self._watcher.evaluation(task, evaluation)

    def _searched(self, work: _Work, place: Place, record: RunStorage, stored: list[Evaluation]) -> str:
        """Carry a run on until it ends; the error that ended it, empty if it is complete."""
        step = self._step(work, place, stored, begin=True)
        self._check_versions(place, step)
        while step.evaluation is not None:
            self._keep(work.task, record, stored, [step.evaluation])
            if self._stopping:
                return ""
            step = self._step(work, place, stored)
        return step.error

    def _check_versions(self, place: Place, step: Step) -> None:
        """Say once of every place that it works with other versions than this process."""
        others = [f"{name} {version}" for name, version in step.versions.items() if self._versions.get(name) != version]
        if others and place.name not in self._told:
            self._told.add(place.name)
            own = ", ".join(f"{name} {version}" for name, version in self._versions.items())
            self._watcher.message(
                f"{place.name} works with {', '.join(others)}, this process with {own}: a run that moves may change"
            )

    def _step(self, work: _Work, place: Place, stored: Sequence[Evaluation], begin: bool = False) -> Step:
        """The next step of a run; it is begun from its record where it is not under way."""
        try:
            step = place.advance(Request(work.token, len(stored), self._beginning(work, stored) if begin else None))
        except PlaceLost as lost:
            losses = work.losses[len(stored)] = work.losses.get(len(stored), 0) + 1
            if losses < LOSSES_BEFORE_FAILURE or self._stopping:
                raise
            return Step(error=f"{losses} workers were lost at evaluation {len(stored) + 1}, the last one because {lost}")
        return self._step(work, place, stored, begin=True) if step.unknown else step

    def _beginning(self, work: _Work, stored: Sequence[Evaluation]) -> Beginning:
        isolated = work.losses.get(len(stored), 0) >= LOSSES_BEFORE_ISOLATION
        identity = dict(work.task.description.identity)
        return Beginning(identity, self._timeout, tuple(stored), self._parallel, isolated)


def _same(here: Evaluation, there: Evaluation) -> bool:
    """Whether two records of an evaluation say the same, times apart."""
    equal = np.array_equal(here.design, there.design) and np.array_equal(here.objectives, there.objectives, equal_nan=True)
    return equal and (here.number, here.reason) == (there.number, there.reason)


def _join(threads: Iterable[threading.Thread]) -> None:
    for thread in threads:
        while thread.is_alive():
            thread.join(LOOK_AGAIN)


def failure_message(failed: Mapping[Cell, str]) -> str:
    """All cells that an error ended, in words."""
    rows = [f"{_named(cell)}: {reason}" for cell, reason in sorted(failed.items())]
    return "\n- ".join((f"{len(rows)} cells could not be finished; their evaluations are kept:", *rows))


def _named(cell: Cell) -> str:
    return f"{cell.strategy} on {cell.problem}, repetition {cell.repetition}"
