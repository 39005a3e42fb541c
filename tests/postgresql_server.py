"""A PostgreSQL server of one's own, in a temporary folder, on the loopback."""

import os
import shutil
import socket
import subprocess
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from sqlalchemy import create_engine, text
from sqlalchemy.pool import NullPool

QUIET = ("fsync=off", "full_page_writes=off", "max_connections=60")


def binaries() -> Path:
    """Where the server's programs are: the newest of those that Debian installs side by side, or the PATH."""
    found = sorted(Path("/usr/lib/postgresql").glob("*/bin"), key=lambda path: float(path.parent.name))
    beside = shutil.which("initdb")
    return found[-1] if found else Path(beside or "/usr/bin/initdb").parent


class Server:
    """A server of one's own; it can be stopped and started again."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._port = free_port()

    @property
    def url(self) -> str:
        """The storage URL of the database `postgres`."""
        return self._url("postgres")

    def create(self) -> None:
        """Make the files of the server."""
        words = ["--username", "railsearch", "--auth", "trust", "--no-sync", "--encoding", "UTF8"]
        _run(["initdb", "--pgdata", self._folder / "data", *words])

    def start(self) -> None:
        """Start the server and wait until it answers."""
        options = " ".join([f"-p {self._port} -h 127.0.0.1 -k {self._folder}", *(f"-c {setting}" for setting in QUIET)])
        self._control("--wait", "--log", self._folder / "log", "--options", options, "start")

    def stop(self) -> None:
        """Stop the server at once: connections break, transactions under way are lost."""
        self._control("--mode", "immediate", "stop")

    def restart(self) -> None:
        """Stop the server at once and start it again."""
        self.stop()
        self.start()

    def disconnect_all(self) -> None:
        """Break every connection."""
        self._execute("SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE pid <> pg_backend_pid()")

    @contextmanager
    def database(self, name: str) -> Iterator[str]:
        """A database beside the others; gives its storage URL."""
        self._execute(f'CREATE DATABASE "{name}"')
        yield self._url(name)
        self._execute(f'DROP DATABASE "{name}" WITH (FORCE)')

    def _url(self, name: str) -> str:
        return f"postgresql+psycopg://railsearch@127.0.0.1:{self._port}/{name}"

    def _control(self, *words: str | Path) -> None:
        _run(["pg_ctl", "--pgdata", self._folder / "data", *words])

    def _execute(self, statement: str) -> None:
        engine = create_engine(self.url, isolation_level="AUTOCOMMIT", poolclass=NullPool)
        with engine.connect() as connection:
            connection.execute(text(statement))


@contextmanager
def postgresql() -> Iterator[Server]:
    """A fresh server, gone afterwards."""
    folder = Path(tempfile.mkdtemp(prefix="railsearch-postgresql-"))
    if os.getuid() == 0:
        shutil.chown(folder, "postgres")
    server = Server(folder)
    try:
        server.create()
        server.start()
        yield server
    finally:
        with suppress(subprocess.CalledProcessError):
            server.stop()
        shutil.rmtree(folder)


def _run(words: Sequence[str | Path]) -> None:
    """Run one of the server's programs, which refuse to work for root, as the user postgres if need be."""
    user = ["runuser", "-u", "postgres", "--"] if os.getuid() == 0 else []
    subprocess.run([*user, str(binaries() / words[0]), *map(str, words[1:])], check=True, stdout=subprocess.DEVNULL)


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])
