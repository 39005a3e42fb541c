"""A PostgreSQL server of one's own, in a temporary folder, on the loopback."""

import os
import shutil
import socket
import subprocess
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

QUIET = ("fsync=off", "full_page_writes=off", "synchronous_commit=off", "max_connections=60")


def binaries() -> Path:
    """Where the server's programs are: the newest of those that Debian installs side by side, or the PATH."""
    found = sorted(Path("/usr/lib/postgresql").glob("*/bin"), key=lambda path: float(path.parent.name))
    beside = shutil.which("initdb")
    return found[-1] if found else Path(beside or "/usr/bin/initdb").parent


@contextmanager
def postgresql() -> Iterator[str]:
    """A fresh server; gives the storage URL of its database `postgres`."""
    folder = Path(tempfile.mkdtemp(prefix="railsearch-postgresql-"))
    data, port = folder / "data", _free_port()
    if os.getuid() == 0:
        shutil.chown(folder, "postgres")
    try:
        _run(["initdb", "--pgdata", data, "--username", "railsearch", "--auth", "trust", "--no-sync", "--encoding", "UTF8"])
        options = " ".join([f"-p {port} -h 127.0.0.1 -k {folder}", *(f"-c {setting}" for setting in QUIET)])
        server = ["pg_ctl", "--pgdata", data, "--wait", "--log", folder / "log", "--options", options]
        _run([*server, "start"])
        try:
            yield f"postgresql+psycopg://railsearch@127.0.0.1:{port}/postgres"
        finally:
            _run(["pg_ctl", "--pgdata", data, "--mode", "immediate", "stop"])
    finally:
        shutil.rmtree(folder)


def _run(words: Sequence[str | Path]) -> None:
    """Run one of the server's programs, which refuse to work for root, as the user postgres if need be."""
    user = ["runuser", "-u", "postgres", "--"] if os.getuid() == 0 else []
    subprocess.run([*user, str(binaries() / words[0]), *map(str, words[1:])], check=True, stdout=subprocess.DEVNULL)


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])
