"""Who may write: a study is claimed by one process at a time, and a process that dies lets go of what it claimed.

On a server the claims are locks of one database session (PostgreSQL's advisory locks, MySQL's user-level locks), which the
server releases when the session ends. An SQLite file has one writer: its claim is a lock on a file beside it.
"""

import fcntl
import hashlib
import threading
from contextlib import suppress
from typing import IO, Protocol

from sqlalchemy import Connection, create_engine, text
from sqlalchemy.engine import Engine, make_url
from sqlalchemy.exc import SQLAlchemyError

from railsearch.errors import InputError, StorageError
from railsearch.storage.address import is_file, without_password

TAKE = {
    "postgresql": "SELECT pg_try_advisory_lock(:number)",
    "mysql": "SELECT COALESCE(GET_LOCK(:name, 0), 0) = 1",
    "mariadb": "SELECT COALESCE(GET_LOCK(:name, 0), 0) = 1",
}
RELEASE = {
    "postgresql": "SELECT pg_advisory_unlock(:number)",
    "mysql": "SELECT RELEASE_LOCK(:name)",
    "mariadb": "SELECT RELEASE_LOCK(:name)",
}


class Claims(Protocol):
    """Claims of studies by name; all methods may be called from several threads."""

    def take(self, name: str) -> bool:
        """Claim a study; False if another process has it."""

    def kept(self, name: str) -> bool:
        """Whether a claim still holds; one that was lost with its connection is taken again if nobody else has it."""

    def release(self, name: str) -> None:
        """Let a study go."""

    def close(self) -> None:
        """Let everything go."""


class ServerClaims:
    """Claims on a database server. Raises InputError for a database that has no such locks."""

    def __init__(self, url: str) -> None:
        self._url = url
        self._engine: Engine | None = None
        self._connection: Connection | None = None
        self._held: set[str] = set()
        self._lock = threading.Lock()

    def take(self, name: str) -> bool:
        """Claim a study; False if another process, or another thread of this one, has it."""
        with self._lock:
            connection = self._connected()
            if name in self._held or not _locked(connection, name):
                return False
            self._held.add(name)
            return True

    def kept(self, name: str) -> bool:
        """Whether a claim still holds, after a new connection if the old one broke."""
        with self._lock:
            self._connected()
            return name in self._held

    def release(self, name: str) -> None:
        """Let a study go; if the connection broke, the server has done it."""
        with self._lock:
            self._let_go(name)

    def close(self) -> None:
        """Let everything go."""
        with self._lock:
            for name in sorted(self._held):
                self._let_go(name)
            if self._connection is not None and self._engine is not None:
                self._connection.close()
                self._engine.dispose()
            self._connection = None

    def _let_go(self, name: str) -> None:
        if name in self._held and self._connection is not None:
            with suppress(SQLAlchemyError):
                self._connection.execute(text(RELEASE[self._connection.dialect.name]), _key(name))
        self._held.discard(name)

    def _connected(self) -> Connection:
        """The session that holds the locks; in a new one, those of the old one are taken again as far as they are free."""
        if self._connection is not None:
            try:
                self._connection.execute(text("SELECT 1"))
                return self._connection
            except SQLAlchemyError:
                self._connection.invalidate()
                self._connection = None
        if self._engine is None:
            self._engine = create_engine(self._url, isolation_level="AUTOCOMMIT", pool_size=1)
        if self._engine.dialect.name not in TAKE:
            raise InputError(
                f"--storage: {without_password(self._url)} has no locks by which several processes could share it; "
                "use PostgreSQL or MySQL, or an SQLite file for one process"
            )
        connection = self._engine.connect()
        self._held = {name for name in sorted(self._held) if _locked(connection, name)}
        self._connection = connection
        return connection


class FileClaims:
    """The claim of an SQLite file as a whole. Raises StorageError if another process has it."""

    def __init__(self, url: str) -> None:
        self._database = make_url(url).database
        self._lock_file: IO[str] | None = None
        self._lock = threading.Lock()

    def take(self, name: str) -> bool:
        """Claim the file with the first study; True ever after."""
        with self._lock:
            if self._lock_file is None and self._database not in (None, "", ":memory:"):
                self._lock_file = self._locked_file()
        return True

    def kept(self, name: str) -> bool:
        """A file lock is not lost while the process lives."""
        return True

    def release(self, name: str) -> None:
        """The file stays claimed until the end."""

    def close(self) -> None:
        """Let the file go."""
        if self._lock_file is not None:
            self._lock_file.close()
        self._lock_file = None

    def _locked_file(self) -> IO[str]:
        file = open(f"{self._database}.lock", "a", encoding="utf-8")  # noqa: SIM115 - held until close
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            file.close()
            raise StorageError(
                f"{self._database} is in use by another process, and an SQLite file has one writer: wait for it, or "
                "share a PostgreSQL server (--storage postgresql://…)"
            ) from None
        return file


def claims_of(url: str) -> Claims:
    """The claims of a storage."""
    return server_claims(url) or FileClaims(url)


def server_claims(url: str) -> Claims | None:
    """The claims of a server's storage, None for a file."""
    return None if is_file(url) else ServerClaims(url)


def _locked(connection: Connection, name: str) -> bool:
    return bool(connection.execute(text(TAKE[connection.dialect.name]), _key(name)).scalar())


def _key(name: str) -> dict[str, int | str]:
    """A lock's number (63 bits) for PostgreSQL, its name (up to 64 characters) for MySQL."""
    digest = hashlib.sha256(f"railsearch {name}".encode()).digest()
    return {"number": int.from_bytes(digest[:8], "big") >> 1, "name": digest.hex()}
