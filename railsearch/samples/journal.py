"""A record that survives a kill at any moment: a file of JSON lines, each written before anything else happens."""

import fcntl
import json
import os
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO

from railsearch.errors import StorageError
from railsearch.run_directory import writing

HEAD = "head"
SECONDS_BETWEEN_SYNCS = 1.0


class Journal:
    """Entries of one process at a time. The last `head` says what the entries are; a line cut off by a kill is dropped.

    An entry is handed to the operating system at once, and to the disk every second, so that a kill loses nothing and a
    power failure no more than that.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.head: dict[str, Any] | None = None
        self.entries: list[dict[str, Any]] = []
        self._file: BinaryIO | None = None
        self._synced = 0.0

    def read(self) -> None:
        """Read what is there. Raises StorageError if it cannot be read."""
        self.head, self.entries = None, []
        if not self.path.exists():
            return
        try:
            whole_lines = self.path.read_bytes().split(b"\n")[:-1]
            entries: list[dict[str, Any]] = [json.loads(line) for line in whole_lines]
        except (OSError, ValueError) as error:
            raise StorageError(f"{self.path} cannot be read: {error}. Repair it, or use another --out") from None
        for entry in entries:
            if HEAD in entry:
                self.head = entry[HEAD]
            else:
                self.entries.append(entry)

    @contextmanager
    def claimed(self) -> Iterator[None]:
        """Hold the journal and read it; one that stays empty is removed at the end. Raises StorageError if it is in use."""
        with writing(self.path):
            file = self.path.open("a+b")
        with file:
            self._lock(file)
            self.read()
            file.truncate(_whole(self.path.read_bytes()))
            self._file = file
            try:
                yield
            finally:
                self._file = None
                if self.path.exists() and not self.path.stat().st_size:
                    self.path.unlink()

    def begin(self, head: Mapping[str, Any]) -> None:
        """Say what the entries are from now on. Raises StorageError if it cannot be written."""
        self._write({HEAD: head})
        self.head = dict(head)

    def append(self, entry: Mapping[str, Any]) -> None:
        """Write one more entry. Raises StorageError if it cannot be written."""
        self._write(entry)

    def remove(self) -> None:
        """Remove the journal, whose entries are kept elsewhere."""
        self.path.unlink()

    def _lock(self, file: BinaryIO) -> None:
        in_use = StorageError(f"{self.path} is in use by another process: wait for it, or use another --out")
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise in_use from None
        # Another process may have finished, and removed the file, between its opening and its lock.
        if not self.path.exists() or not os.path.samestat(os.fstat(file.fileno()), self.path.stat()):
            raise in_use

    def _write(self, entry: Mapping[str, Any]) -> None:
        if self._file is None:
            raise RuntimeError("a journal is written while it is claimed")
        with writing(self.path):
            self._file.write(json.dumps(entry, ensure_ascii=False).encode() + b"\n")
            self._file.flush()
            if time.monotonic() - self._synced > SECONDS_BETWEEN_SYNCS:
                os.fsync(self._file.fileno())
                self._synced = time.monotonic()


def _whole(content: bytes) -> int:
    """How many bytes of the content are whole lines."""
    return content.rfind(b"\n") + 1
