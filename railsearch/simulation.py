"""Carry out the expensive part of an evaluation, here or in a process that can be stopped when it exceeds its time."""

import multiprocessing
import os
import pickle
import signal
import threading
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from typing import Protocol

from railsearch.design_problem import DesignProblem
from railsearch.errors import InputError
from railsearch.interfaces import Outcome
from railsearch.space import FloatArray

START_SECONDS = 120.0


class Simulator(Protocol):
    """Carries out `problem.simulate`; a failure comes back as its reason, never as an exception."""

    def warm_up(self) -> None:
        """Do what is done once per process, so that no evaluation is charged for it."""

    def simulate(self, design: FloatArray) -> Outcome | str:
        """The outcome of a design (d,), or the reason why there is none."""

    def close(self) -> None:
        """Release what is held."""


class InProcess:
    """Simulates in this process, without a time limit."""

    def __init__(self, problem: DesignProblem) -> None:
        self._problem = problem

    def warm_up(self) -> None:
        """Warm the problem up here."""
        self._problem.warm_up()

    def simulate(self, design: FloatArray) -> Outcome | str:
        """The outcome of a design (d,), or the exception that was raised, in words."""
        try:
            return self._problem.simulate(design)
        except Exception as error:  # noqa: BLE001 - whatever a model raises is a failed evaluation
            return f"{type(error).__name__}: {error}"

    def close(self) -> None:
        """Nothing is held."""


class TimeLimited:
    """Simulates in one process of its own, which is killed when a simulation exceeds `timeout` seconds.

    The time counts from when the process is ready: starting it and warming the problem up are not part of it.
    """

    def __init__(self, problem: DesignProblem, timeout: float) -> None:
        self._problem = problem
        self._timeout = timeout
        self._process: BaseProcess | None = None
        self._connection: Connection | None = None

    def warm_up(self) -> None:
        """Start the process, which warms the problem up."""
        self._started()

    def simulate(self, design: FloatArray) -> Outcome | str:
        """The outcome of a design (d,), or why there is none: an exception, the time limit, the death of the process."""
        if self._process is not None and not self._process.is_alive():
            self.close()
        connection, process = self._started()
        connection.send(design)
        return self._received(connection, process, self._timeout)

    def close(self) -> None:
        """Kill the process, if there is one."""
        if self._process is not None and self._connection is not None:
            self._process.kill()
            self._process.join()
            self._connection.close()
        self._process = self._connection = None

    def _started(self) -> tuple[Connection, BaseProcess]:
        if self._process is None or self._connection is None:
            context = multiprocessing.get_context("spawn")
            self._connection, theirs = context.Pipe()
            self._process = context.Process(target=_serve, args=(theirs, self._problem), daemon=True)
            _start(self._process)
            theirs.close()
            ready = self._received(self._connection, self._process, START_SECONDS)
            if isinstance(ready, str) or self._process is None:
                raise InputError(f"the process that simulates under a time limit cannot be started: {ready}")
        return self._connection, self._process

    def _received(self, connection: Connection, process: BaseProcess, seconds: float) -> Outcome | str:
        if not wait([connection, process.sentinel], timeout=seconds):
            self.close()
            return f"time limit of {seconds:g} s exceeded"
        try:
            received: Outcome | str = connection.recv()
        except (EOFError, OSError):
            process.join()
            self.close()
            return f"the simulating process died (exit code {process.exitcode})"
        return received


def simulator(problem: DesignProblem, timeout: float | None) -> Simulator:
    """The simulator for a problem: in this process without a time limit, in one of its own with one."""
    return InProcess(problem) if timeout is None else TimeLimited(problem, timeout)


def _start(process: BaseProcess) -> None:
    try:
        process.start()
    except (AttributeError, TypeError, pickle.PicklingError) as error:
        raise InputError(
            f"timeout: the problem cannot travel to the process that would be stopped ({error}); define its classes "
            "at the top level of a module that can be imported"
        ) from None


def _serve(connection: Connection, problem: DesignProblem) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    problem.warm_up()
    connection.send(None)
    worker = InProcess(problem)
    while True:
        try:
            design = connection.recv()
        except EOFError:
            return
        connection.send(worker.simulate(design))


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
