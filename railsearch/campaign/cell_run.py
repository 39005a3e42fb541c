"""The run of a cell where the work is done: it stands still after every evaluation until that is stored."""

import functools
import time
from collections.abc import Generator
from dataclasses import dataclass, field
from typing import Any

from threadpoolctl import threadpool_limits

from railsearch.errors import RailsearchError
from railsearch.interfaces import Evaluation
from railsearch.plugin_manager import Registry, load_plugins
from railsearch.result import versions
from railsearch.run import RunResult, search
from railsearch.run_identity import given_of, problem_of, settings_of
from railsearch.simulation import SeparateProcess, Simulators

FORGOTTEN_AFTER = 900.0


@dataclass(frozen=True)
class Beginning:
    """All that a run needs to begin or to continue anywhere.

    stored: the evaluations that are not to be made again; parallel: how many of a batch are evaluated at a time; isolated:
    evaluations happen in a process of their own, so that one that kills its process is a failed evaluation.
    """

    identity: dict[str, Any]
    timeout: float | None
    stored: tuple[Evaluation, ...]
    parallel: int = 1
    isolated: bool = False


@dataclass(frozen=True)
class Request:
    """Asks for the next evaluation of the run `token`, of which `n_stored` evaluations are stored."""

    token: str
    n_stored: int
    beginning: Beginning | None = None


@dataclass(frozen=True)
class Step:
    """The answer: the next evaluation, or the end of the run, or an error that ends it, or that the run is not known here.

    versions: of the libraries where the work is done, told when a run begins.
    """

    evaluation: Evaluation | None = None
    finished: bool = False
    error: str = ""
    unknown: bool = False
    versions: dict[str, str] = field(default_factory=dict)


@dataclass
class _Live:
    steps: Generator[Evaluation, None, RunResult]
    stored: set[int]
    touched: float


class LiveRuns:
    """The runs that a process has under way, each at rest between two requests."""

    def __init__(self, registry: Registry) -> None:
        self._registry = registry
        self._runs: dict[str, _Live] = {}

    def advance(self, request: Request) -> Step:
        """Carry a run on to its next new evaluation. A run that is not where the request says is begun again."""
        self._forget_old()
        run = self._runs.pop(request.token, None)
        if run is not None and len(run.stored) != request.n_stored:
            run.steps.close()
            run = None
        if run is None and request.beginning is None:
            return Step(unknown=True)
        try:
            run = run or self._begun(request.beginning)
            step = self._next(run)
        except RailsearchError as error:
            return Step(error=str(error))
        except Exception as error:  # noqa: BLE001 - whatever a strategy raises ends its cell, not the campaign
            return Step(error=f"{type(error).__name__}: {error}")
        if not step.finished:
            run.touched = time.monotonic()
            self._runs[request.token] = run
        return step if request.beginning is None else Step(step.evaluation, step.finished, versions=versions())

    def close(self) -> None:
        """End all runs."""
        for run in list(self._runs.values()):
            run.steps.close()
        self._runs.clear()

    def _begun(self, beginning: Beginning | None) -> _Live:
        assert beginning is not None
        problem = problem_of(self._registry, beginning.identity, "cell")
        settings = settings_of(beginning.identity, beginning.timeout, beginning.parallel)
        simulating = Simulators([SeparateProcess(problem, settings.timeout)]) if beginning.isolated else None
        given = given_of(problem, beginning.identity)
        steps = search(self._registry, problem, settings, given, beginning.stored, simulating)
        return _Live(steps, {evaluation.number for evaluation in beginning.stored}, time.monotonic())

    def _next(self, run: _Live) -> Step:
        for evaluation in run.steps:
            if evaluation.number not in run.stored:
                run.stored.add(evaluation.number)
                return Step(evaluation)
        return Step(finished=True)

    def _forget_old(self) -> None:
        """End runs that nobody has asked for in a long time: who asked is gone, or has turned to another process."""
        for token, run in list(self._runs.items()):
            if time.monotonic() - run.touched > FORGOTTEN_AFTER and self._runs.pop(token, None) is run:
                run.steps.close()


@functools.cache
def live_runs() -> LiveRuns:
    """The runs of this worker process, which calculates with one thread per run from now on."""
    registry = load_plugins()
    threadpool_limits(1)
    return LiveRuns(registry)


def advance(request: Request) -> Step:
    """Carry a run of this worker process on."""
    return live_runs().advance(request)
