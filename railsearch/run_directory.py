"""The folder of one run: what identifies it, its record, its result, its figures and report, and one writer at a time."""

import fcntl
import json
import os
import shutil
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from railsearch.errors import StorageError
from railsearch.storage import identity_differences, plain

IDENTITY_FILE = "run.json"
STUDY_FILE = "study.db"
RESULT_FILE = "result.json"
REPORT_FILE = "report.html"
FIGURES_FOLDER = "figures"
LOCK_FILE = ".lock"
SPACE_NEEDED = 2_000_000


class RunDirectory:
    """Paths and files of a run's folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    @property
    def embedded_url(self) -> str:
        """Storage URL of the SQLite file in the folder."""
        return f"sqlite:///{(self.folder / STUDY_FILE).resolve()}"

    @property
    def figures(self) -> Path:
        """Where the figures are."""
        return self.folder / FIGURES_FOLDER

    @property
    def report(self) -> Path:
        """The report."""
        return self.folder / REPORT_FILE

    @property
    def result(self) -> Path:
        """The result."""
        return self.folder / RESULT_FILE

    def stored(self) -> dict[str, Any] | None:
        """What run.json says: {"command", "storage", "identity"}; None without a run. Raises StorageError."""
        return read_document(self.folder / IDENTITY_FILE)

    def stored_result(self) -> dict[str, Any] | None:
        """What result.json says, None without one. Raises StorageError if it cannot be read."""
        return read_document(self.result)

    @contextmanager
    def claimed(self, document: Mapping[str, Any]) -> Iterator[Mapping[str, Any]]:
        """Hold the folder for the run that `document` describes, making it if need be.

        Gives the document of the command that began the run.
        Raises StorageError if the folder cannot be written, belongs to another run or is in use by another process.
        """
        make_folder(self.folder)
        with locked(self.folder):
            begun = self._begun(document)
            if begun is None:
                self.write(IDENTITY_FILE, json.dumps(document, indent=1, ensure_ascii=False))
            yield begun or document

    def withdraw(self, begun: Mapping[str, Any], document: Mapping[str, Any]) -> None:
        """Take back the claim that `document` made, when no record could be opened for it; an earlier claim stays."""
        if begun is document and not (self.folder / STUDY_FILE).exists():
            (self.folder / IDENTITY_FILE).unlink()

    def abandon(self) -> None:
        """Remove the claim and the record in the folder, of a run that is refused before it has searched anything."""
        for path in (self.folder / IDENTITY_FILE, *self.folder.glob(f"{STUDY_FILE}*")):
            path.unlink(missing_ok=True)

    def write(self, name: str, text: str) -> None:
        """Write a file whole or not at all."""
        write_whole(self.folder / name, text.encode("utf-8"))

    def _begun(self, document: Mapping[str, Any]) -> dict[str, Any] | None:
        """What run.json says, None in a new folder. Raises StorageError if that is another run."""
        stored = self.stored()
        if stored is None:
            if (self.folder / STUDY_FILE).exists():
                raise StorageError(f"{self.folder} holds a {STUDY_FILE} but no {IDENTITY_FILE}: use another folder")
            return None
        if stored["storage"] is None and self.result.exists() and not (self.folder / STUDY_FILE).exists():
            raise StorageError(
                f"{self.folder} holds a finished {RESULT_FILE}, but its record {STUDY_FILE} is gone: bring it back, or use "
                "another --out"
            )
        differences = identity_differences(stored["identity"], plain(document["identity"]))
        differences += identity_differences({"storage": stored["storage"]}, {"storage": document["storage"]})
        if differences:
            more = f"; and {len(differences) - 3} more" if len(differences) > 3 else ""
            raise StorageError(
                f"{self.folder} holds another run ({'; '.join(differences[:3])}{more}). Nothing was changed: "
                f"use another --out, or continue that run with: {stored['command']}"
            )
        return stored


def recorded_url(storage: str | None, embedded_url: str) -> str:
    """The storage that a folder's document names. Raises StorageError if its password was not kept."""
    if storage is None:
        return embedded_url
    if "***" in storage:
        raise StorageError(f"the record is at {storage}, whose password was not kept: give it with --storage")
    return storage


def make_folder(folder: Path) -> None:
    """Make a folder that can be written and has room. Raises StorageError."""
    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
        free = shutil.disk_usage(folder).free
    if free < SPACE_NEEDED:
        raise StorageError(f"{folder}: only {free / 1e6:.1f} MB are free, {SPACE_NEEDED / 1e6:g} MB or more are needed")


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Hold a folder. Raises StorageError if it is in use by another process."""
    with (folder / LOCK_FILE).open("a+", encoding="utf-8") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise StorageError(f"{folder} is in use by another process: wait for it, or use another folder") from None
        yield


def read_document(path: Path) -> dict[str, Any] | None:
    """A JSON file, None if there is none. Raises StorageError if it cannot be read."""
    if not path.exists():
        return None
    try:
        document: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise StorageError(f"{path} cannot be read: {error}. Remove it or use another folder") from None
    return document


def write_whole(path: Path, content: bytes) -> None:
    """Write a file whole or not at all. Raises StorageError if it cannot be written."""
    with writing(path):
        descriptor, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
        try:
            with os.fdopen(descriptor, "wb") as file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
            os.chmod(temporary, 0o644)
            os.replace(temporary, path)
        except BaseException:
            Path(temporary).unlink(missing_ok=True)
            raise


@contextmanager
def writing(place: Path) -> Iterator[None]:
    """Turn a failure to write into a StorageError that says what to do."""
    try:
        yield
    except (FileExistsError, NotADirectoryError) as error:
        raise StorageError(f"{place}: a folder is needed, and there is a file; give another place") from error
    except OSError as error:
        raise StorageError(
            f"{place} cannot be written: {error.strerror or error}. Make space or use a place that you may write to, then "
            "repeat the command; what was finished before is kept"
        ) from error
