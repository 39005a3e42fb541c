"""Carry out the expensive part of evaluations: here, or in processes of their own, several at a time or time-limited."""

import math
import pickle
import queue
import threading
import time
from collections.abc import Generator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from typing import Protocol

from railsearch.child_process import AnsweringEnd, ChildProcess, start_child
from railsearch.design_problem import DesignProblem
from railsearch.errors import InputError
from railsearch.interfaces import Outcome
from railsearch.space import FloatArray

START_SECONDS = 120.0


@dataclass(frozen=True)
class Simulated:
    """The outcome of a design, or the reason why there is none, and the seconds that it took."""

    outcome: Outcome | str
    duration: float


class Simulator(Protocol):
    """Carries out `problem.simulate`; a failure comes back as its reason, never as an exception."""

    def warm_up(self) -> None:
        """Do what is done once per process, so that no evaluation is charged for it."""

    def simulate(self, design: FloatArray) -> Simulated:
        """Simulate a design (d,)."""

    def close(self) -> None:
        """Release what is held."""


class InProcess:
    """Simulates in this process, without a time limit."""

    def __init__(self, problem: DesignProblem) -> None:
        self._problem = problem

    def warm_up(self) -> None:
        """Warm the problem up here."""
        self._problem.warm_up()

    def simulate(self, design: FloatArray) -> Simulated:
        """Simulate a design (d,); an exception is the reason why there is no outcome, but for an interruption."""
        start = time.perf_counter()
        try:
            outcome: Outcome | str = self._problem.simulate(design)
        except Exception as error:
            if _interrupted(error):
                raise KeyboardInterrupt from error
            outcome = f"{type(error).__name__}: {error}"
        return Simulated(outcome, time.perf_counter() - start)

    def close(self) -> None:
        """Nothing is held."""


class SeparateProcess:
    """Simulates in one process of its own, which is killed when a simulation exceeds `timeout` seconds, if there is a limit.

    The time counts from when the process is ready: starting it and warming the problem up are not part of it.
    """

    def __init__(self, problem: DesignProblem, timeout: float | None = None) -> None:
        self._problem = problem
        self._timeout = timeout
        self._child: ChildProcess | None = None
        self._closing = threading.Lock()

    def warm_up(self) -> None:
        """Start the process, which warms the problem up."""
        self._started()

    def simulate(self, design: FloatArray) -> Simulated:
        """Simulate a design (d,); there is no outcome after an exception, the time limit, or the death of the process."""
        if self._child is not None and not self._child.process.is_alive():
            self.close()
        child = self._started()
        start = time.perf_counter()
        child.connection.send(design)
        received = self._received(child, self._timeout)
        return received if isinstance(received, Simulated) else Simulated(str(received), time.perf_counter() - start)

    def close(self) -> None:
        """Kill the process, if there is one; also while another thread waits for it."""
        with self._closing:
            child, self._child = self._child, None
        if child is not None:
            child.end()

    def _started(self) -> ChildProcess:
        child = self._child
        if child is None:
            child = self._child = _start(self._problem)
            ready = self._received(child, START_SECONDS)
            if isinstance(ready, str):
                raise InputError(f"the process that simulates cannot be started: {ready}")
        return child

    def _received(self, child: ChildProcess, seconds: float | None) -> Simulated | str | None:
        """What the process sends, None when it is ready; or why nothing came."""
        if not wait([child.connection, child.process.sentinel], timeout=seconds):
            self.close()
            return f"time limit of {seconds:g} s exceeded"
        try:
            received: Simulated | None = child.receive()
        except (EOFError, OSError):
            child.process.join()
            self.close()
            return f"the simulating process died (exit code {child.process.exitcode})"
        return received


class Simulators:
    """Simulators side by side, each at work on one design at a time."""

    def __init__(self, members: Sequence[Simulator]) -> None:
        self._members = list(members)

    def warm_up(self) -> None:
        """Warm all of them up, side by side."""
        if len(self._members) == 1:
            self._members[0].warm_up()
            return
        with ThreadPoolExecutor(len(self._members)) as threads:
            for warmed in [threads.submit(member.warm_up) for member in self._members]:
                warmed.result()

    def simulate(self, designs: Sequence[FloatArray]) -> Generator[tuple[int, Simulated]]:
        """Simulate designs (d,); gives each one's place and result as it is finished.

        With one member the next design is begun when it is asked for; with several, as soon as a member is free.
        """
        if len(self._members) == 1 or len(designs) == 1:
            yield from ((place, self._members[0].simulate(design)) for place, design in enumerate(designs))
            return
        free: queue.SimpleQueue[Simulator] = queue.SimpleQueue()
        for member in self._members:
            free.put(member)
        threads = ThreadPoolExecutor(len(self._members))
        try:
            places = {threads.submit(_by_free_member, free, design): place for place, design in enumerate(designs)}
            yield from ((places[done], done.result()) for done in as_completed(places))
        finally:
            threads.shutdown(wait=False, cancel_futures=True)

    def close(self) -> None:
        """Release what they hold; what is under way is stopped."""
        for member in self._members:
            member.close()


def simulators(problem: DesignProblem, timeout: float | None = None, workers: int = 1) -> Simulators:
    """Simulators for a problem: one in this process, or `workers` processes if they are several or time-limited.

    Raises InputError for a time limit that is not positive.
    """
    check_timeout(timeout)
    if timeout is None and workers == 1:
        return Simulators([InProcess(problem)])
    return Simulators([SeparateProcess(problem, timeout) for _ in range(workers)])


def check_timeout(timeout: float | None) -> None:
    """Raise InputError for a time limit of an evaluation that is not a positive number of seconds."""
    if timeout is not None and not 0.0 < timeout < math.inf:
        raise InputError(f"timeout: a positive number of seconds is needed, received {timeout!r}")


def _by_free_member(free: "queue.SimpleQueue[Simulator]", design: FloatArray) -> Simulated:
    member = free.get()
    try:
        return member.simulate(design)
    finally:
        free.put(member)


def _interrupted(error: BaseException | None) -> bool:
    """Whether an exception came of an interruption, which compiled code gives back as a SystemError."""
    while error is not None:
        if isinstance(error, KeyboardInterrupt):
            return True
        error = error.__cause__ or error.__context__
    return False


def _start(problem: DesignProblem) -> ChildProcess:
    try:
        return start_child(_serve, [problem], daemon=True)
    except (AttributeError, TypeError, pickle.PicklingError) as error:
        raise InputError(
            f"timeout, workers: the problem cannot travel to a process of its own ({error}); define its classes "
            "at the top level of a module that can be imported"
        ) from None


def _serve(connection: Connection, problem: DesignProblem) -> None:
    parent = AnsweringEnd(connection)
    problem.warm_up()
    parent.answer(None)
    worker = InProcess(problem)
    while True:
        try:
            design = parent.receive()
        except EOFError:
            return
        parent.answer(worker.simulate(design))
