"""A Dask cluster as a place to work: its workers come and go, and its scheduler may be started again."""

import logging
import threading
import time
import uuid
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any

from railsearch.errors import InputError
from railsearch.wording import install_remedy

LOOK_AGAIN = 1.0


class ClusterLost(Exception):
    """A worker or the scheduler went away; what was under way there is lost."""


class DaskCluster:
    """A client of a scheduler that connects again when the connection breaks.

    address: of the scheduler; patience: seconds to wait for a scheduler or for workers that went away; notify: is told
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
        self._present: frozenset[str] = frozenset()
        self._away_since: float | None = None
        self._connecting = threading.Lock()
        # What a lost connection does to its inner workings is no news to users; what it means to them is told here.
        logging.getLogger("distributed").setLevel(logging.CRITICAL)
        self._connect()

    def threads(self) -> dict[str, int]:
        """Threads by worker, none while the scheduler is away. Raises InputError when there has been none for too long."""
        with self._connecting:
            found = self._threads()
            self._present = frozenset(found)
            self._check_patience()
            return found

    def call(self, function: Callable[..., Any], arguments: Sequence[object], worker: str | None = None) -> Any:
        """What a function gives at a worker, or at any. Raises ClusterLost, and what the function raises."""
        try:
            future = self._client.submit(
                function,
                *arguments,
                key=f"railsearch-{uuid.uuid4().hex}",
                workers=None if worker is None else [worker],
                allow_other_workers=False,
                pure=False,
            )
        except Exception as error:  # noqa: BLE001 - a client whose scheduler is gone raises many kinds
            raise ClusterLost(f"the scheduler at {self._address} is away ({type(error).__name__})") from None
        return self._result(future, worker)

    def close(self) -> None:
        """Leave the cluster; it goes on without this client."""
        self._present = frozenset()
        self._disconnect()

    def _result(self, future: Any, worker: str | None) -> Any:
        from distributed.client import FutureCancelledError

        while True:
            try:
                return future.result(timeout=LOOK_AGAIN)
            except TimeoutError:
                if worker is None or worker in self._present:
                    continue
                with suppress(Exception):
                    future.cancel()
                raise ClusterLost(f"worker {worker} went away") from None
            except (FutureCancelledError, OSError) as error:
                place = "the scheduler" if worker is None else f"worker {worker}"
                raise ClusterLost(f"{place} was lost ({type(error).__name__})") from None

    def _threads(self) -> dict[str, int]:
        try:
            if self._client.status != "running":
                raise OSError("the connection is lost")
            found: dict[str, int] = self._client.nthreads()
        except Exception:  # noqa: BLE001 - whatever the reason, the answer is a new connection
            self._disconnect()
            try:
                self._connect()
                found = self._client.nthreads()
            except (InputError, OSError):
                return {}
        return found

    def _connect(self) -> None:
        from distributed import Client

        try:
            self._client = Client(self._address, timeout=self._connect_seconds, set_as_default=False)
        except (OSError, ValueError) as error:
            raise InputError(
                f"--dask: no scheduler answers at {self._address} ({error}); start one with `dask scheduler`, and workers "
                "with `dask worker ADDRESS --nthreads 1`"
            ) from None

    def _disconnect(self) -> None:
        with suppress(Exception):
            self._client.close(timeout=2.0)

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


def connected(address: str, notify: Callable[[str], None]) -> DaskCluster:
    """The cluster at an address. Raises InputError if there is none, or if Dask is not installed."""
    try:
        return DaskCluster(address, notify=notify)
    except ImportError as error:
        raise InputError(f"--dask: {error}: {install_remedy('dask')}") from None
