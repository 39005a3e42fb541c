"""Places where the runs of cells are carried out: this process, or processes of this machine."""

import threading
from collections.abc import Sequence
from multiprocessing.connection import Connection
from typing import Protocol

from railsearch.campaign.cell_run import LiveRuns, Request, Step, advance
from railsearch.child_process import AnsweringEnd, ChildProcess, start_child
from railsearch.plugin_manager import Registry


class PlaceLost(Exception):
    """A place died or cannot be reached; what was under way there is lost."""


class Place(Protocol):
    """Carries runs on, one request at a time."""

    @property
    def name(self) -> str:
        """What tells it from other places."""

    def advance(self, request: Request) -> Step:
        """Answer a request. Raises PlaceLost."""

    def close(self) -> None:
        """Stop what is under way and release what is held."""


class Places(Protocol):
    """All places at the moment; there may be more or fewer a moment later."""

    def present(self) -> Sequence[Place]:
        """The places that can be used now; a place keeps its object and name as long as it lasts."""

    def close(self) -> None:
        """Close all of them."""


class Here:
    """This process."""

    name = "here"

    def __init__(self, registry: Registry) -> None:
        self._runs = LiveRuns(registry)

    def advance(self, request: Request) -> Step:
        """Carry a run on."""
        return self._runs.advance(request)

    def close(self) -> None:
        """End all runs as soon as the evaluation under way is finished."""
        self._runs.close()


class Worker:
    """A process of this machine, started when it is first needed and again after it died."""

    def __init__(self, name: str) -> None:
        self.name = name
        self._child: ChildProcess | None = None
        self._closed = False
        self._starting = threading.Lock()

    def advance(self, request: Request) -> Step:
        """Let the process carry a run on. Raises PlaceLost when it dies meanwhile."""
        child = self._started()
        try:
            child.connection.send(request)
            step: Step = child.receive()
        except (EOFError, OSError) as error:
            self._end()
            raise PlaceLost(f"{self.name} died ({error or 'no answer'})") from None
        return step

    def close(self) -> None:
        """Kill the process."""
        with self._starting:
            self._closed = True
        self._end()

    def _started(self) -> ChildProcess:
        with self._starting:
            if self._closed:
                raise PlaceLost(f"{self.name} is closed")
            if self._child is None:
                # Not daemonic: it may have processes of its own for time limits and batches.
                self._child = start_child(_serve, [], daemon=False)
            return self._child

    def _end(self) -> None:
        with self._starting:
            child, self._child = self._child, None
        if child is not None:
            child.end()


class FixedPlaces:
    """Places that stay the same."""

    def __init__(self, members: Sequence[Place]) -> None:
        self._members = tuple(members)

    def present(self) -> Sequence[Place]:
        """All of them."""
        return self._members

    def close(self) -> None:
        """Close all of them."""
        for place in self._members:
            place.close()


def places_here(registry: Registry, workers: int) -> FixedPlaces:
    """This process for one worker, otherwise that many processes."""
    if workers == 1:
        return FixedPlaces([Here(registry)])
    return FixedPlaces([Worker(f"worker {number + 1}") for number in range(workers)])


def _serve(connection: Connection) -> None:
    parent = AnsweringEnd(connection)
    while True:
        try:
            request = parent.receive()
        except EOFError:
            return
        parent.answer(advance(request))
