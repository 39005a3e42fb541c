"""Storages that fail: errors in words, and waiting for a server that is away for a while."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TypeVar

from optuna.exceptions import OptunaError, StorageInternalError
from sqlalchemy.exc import SQLAlchemyError

from railsearch.errors import StorageError
from railsearch.wording import install_remedy

Result = TypeVar("Result")
STORAGE_PATIENCE = 300.0
"""Seconds for which commands wait for a server."""
FIRST_WAIT = 0.5
LONGEST_WAIT = 30.0


@dataclass(frozen=True)
class Patience:
    """How long to wait for a storage that fails: seconds in all; `notify` is told what is waited for."""

    seconds: float = 0.0
    notify: Callable[[str], None] = lambda message: None

    def insist(self, attempt: Callable[[], Result]) -> Result:
        """Repeat `attempt` while the storage fails, waiting twice as long each time; at the end its error is raised."""
        deadline, pause = time.monotonic() + self.seconds, FIRST_WAIT
        while True:
            try:
                return attempt()
            except (SQLAlchemyError, StorageInternalError, OSError) as error:
                left = deadline - time.monotonic()
                if left <= 0.0:
                    raise
                self.notify(f"the storage does not answer ({cause(error)}); next attempt in {pause:g} s")
            time.sleep(min(pause, left))
            pause = min(2.0 * pause, LONGEST_WAIT)


@contextmanager
def readable(place: str) -> Iterator[None]:
    """Turn a failure to read into a StorageError that says what to do."""
    try:
        yield
    except ImportError as error:
        raise StorageError(
            f"the storage {place} needs a driver that is not installed ({cause(error)}); for PostgreSQL: "
            f"{install_remedy('postgresql')}"
        ) from error
    except (SQLAlchemyError, OptunaError, OSError, ValueError) as error:
        raise StorageError(
            f"the storage {place} cannot be opened: {cause(error)}. Check the URL, the rights and the space there"
        ) from error


@contextmanager
def writable(place: str, safe: str) -> Iterator[None]:
    """Turn a failure to write into a StorageError that says what is safe and what to do."""
    try:
        yield
    except (SQLAlchemyError, OptunaError, OSError) as error:
        raise StorageError(
            f"the storage {place} cannot be written: {cause(error)}. {safe} safe in it; "
            "make space or restore the connection, then repeat the same command to go on"
        ) from error


def cause(error: BaseException) -> str:
    """The first line of what was at the bottom of an error."""
    deepest = error
    while deepest.__cause__ is not None:
        deepest = deepest.__cause__
    return f"{deepest}".split("\n")[0]
