"""Places in a Dask cluster: every thread of every worker is one; they come and go with the workers.

A request is pinned to the worker that has the run under way. When that worker leaves, the request is given up and the
cell goes on from its record elsewhere. When the scheduler goes, its clients wait for it to come back.
"""

import logging
import time
import uuid
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any

from railsearch.campaign.cell_run import Request, Step, advance
from railsearch.campaign.places import Place, PlaceLost
from railsearch.errors import InputError

LOOK_AGAIN = 1.0


class DaskPlaces:
    """The threads of the workers of a cluster.

    address: of its scheduler; patience: seconds to wait for a scheduler or for workers that went away; notify: is told
    what is waited for; connect_seconds: for one attempt to reach the scheduler. Raises InputError if there is no
    scheduler at the address.
    """

    def __init__(
        self,
        address: str,
        patience: float = 600.0,
        notify: Callable[[str], None] = lambda message: None,
        connect_seconds: float = 10.0,
    ) -> None:
        self._address = address
        self._patience = patience
        self._notify = notify
        self._connect_seconds = connect_seconds
        self._client: Any = None
        self._places: dict[str, DaskPlace] = {}
        self._present: frozenset[str] = frozenset()
        self._away_since: float | None = None
        # What a lost connection does to its inner workings is no news to users; what it means to them is told here.
        logging.getLogger("distributed").setLevel(logging.CRITICAL)
        self._connect()

    def present(self) -> Sequence[Place]:
        """One place for every thread of every worker. Raises InputError when there has been none for too long."""
        threads = self._threads()
        self._present = frozenset(threads)
        wanted = {f"{worker} thread {k + 1}": worker for worker, count in threads.items() for k in range(count)}
        self._places = {name: self._places.get(name) or DaskPlace(name, worker, self) for name, worker in wanted.items()}
        self._check_patience()
        return list(self._places.values())

    def submitted(self, request: Request, worker: str) -> Any:
        """The future of a request at a worker. Raises PlaceLost if the scheduler is away."""
        try:
            return self._client.submit(
                advance,
                request,
                key=f"railsearch-{uuid.uuid4().hex}",
                workers=[worker],
                allow_other_workers=False,
                pure=False,
            )
        except Exception as error:  # noqa: BLE001 - a client whose scheduler is gone raises many kinds
            raise PlaceLost(f"the scheduler at {self._address} is away ({type(error).__name__})") from None

    def has(self, worker: str) -> bool:
        """Whether a worker was there when the cluster was last looked at."""
        return worker in self._present

    def close(self) -> None:
        """Leave the cluster; it goes on without this client."""
        self._present = frozenset()
        _close(self._client)

    def _threads(self) -> dict[str, int]:
        """Threads by worker; none while the scheduler is away."""
        try:
            if self._client.status != "running":
                raise OSError("the connection is lost")
            found: dict[str, int] = self._client.nthreads()
        except Exception:  # noqa: BLE001 - whatever the reason, the answer is a new connection
            _close(self._client)
            try:
                self._connect()
            except InputError:
                return {}
            return self._client.nthreads() if self._client.status == "running" else {}
        return found

    def _connect(self) -> None:
        from distributed import Client

        try:
            self._client = Client(self._address, timeout=self._connect_seconds, set_as_default=False)
        except (OSError, ValueError, TimeoutError) as error:
            raise InputError(
                f"--dask: no scheduler answers at {self._address} ({error}); start one with `dask scheduler`, and workers "
                "with `dask worker ADDRESS --nthreads 1`"
            ) from None

    def _check_patience(self) -> None:
        if self._present:
            self._away_since = None
            return
        if self._away_since is None:
            self._away_since = time.monotonic()
            self._notify(f"the cluster at {self._address} has no workers; waiting for them")
        if time.monotonic() - self._away_since > self._patience:
            raise InputError(
                f"--dask: no worker at {self._address} for {self._patience:g} s. All finished evaluations are stored; start "
                "scheduler and workers, then repeat the same command to go on"
            )


class DaskPlace:
    """One thread of one worker."""

    def __init__(self, name: str, worker: str, cluster: DaskPlaces) -> None:
        self.name = name
        self._worker = worker
        self._cluster = cluster

    def advance(self, request: Request) -> Step:
        """Let the worker carry a run on. Raises PlaceLost when it, or the scheduler, goes away meanwhile."""
        future = self._cluster.submitted(request, self._worker)
        while True:
            try:
                step: Step = future.result(timeout=LOOK_AGAIN)
                return step
            except TimeoutError as waited:
                if self._cluster.has(self._worker) and not future.cancelled():
                    continue
                _cancel(future)
                raise PlaceLost(f"worker {self._worker} went away") from waited
            except Exception as error:  # noqa: BLE001 - lost workers, schedulers and connections come as many kinds
                raise PlaceLost(f"worker {self._worker} was lost ({type(error).__name__}: {error})") from None

    def close(self) -> None:
        """Nothing is held."""


def _cancel(future: Any) -> None:
    with suppress(Exception):
        future.cancel()


def _close(client: Any) -> None:
    with suppress(Exception):
        client.close(timeout=2.0)
