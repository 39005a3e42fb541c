"""The folder of a campaign: what the campaign is, its embedded record, and what was made of it."""

import json
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

from railsearch.campaign.identity import Changes, campaign_changes
from railsearch.errors import InputError, StorageError
from railsearch.run_directory import (
    FIGURES_FOLDER,
    REPORT_FILE,
    STUDY_FILE,
    locked,
    make_folder,
    read_document,
    recorded_url,
    write_whole,
)
from railsearch.storage import storage_url

CAMPAIGN_FILE = "campaign.json"
STATISTICS_FILE = "statistics.json"
RESULTS_FILE = "results.parquet"


class CampaignDirectory:
    """Paths and files of a campaign's folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.report = folder / REPORT_FILE
        self.statistics = folder / STATISTICS_FILE
        self.results = folder / RESULTS_FILE
        self.figures = folder / FIGURES_FOLDER

    @property
    def embedded_url(self) -> str:
        """Storage URL of the SQLite file in the folder."""
        return f"sqlite:///{(self.folder / STUDY_FILE).resolve()}"

    @property
    def held(self) -> bool:
        """Whether there is a campaign in the folder."""
        return (self.folder / CAMPAIGN_FILE).exists()

    def stored(self) -> dict[str, Any]:
        """What campaign.json says: {"command", "storage", "identity", "skipped"}. Raises InputError if there is none."""
        document = read_document(self.folder / CAMPAIGN_FILE)
        if document is None:
            raise InputError(f"DIR: {self.folder} holds no campaign (no {CAMPAIGN_FILE}); give the --out of a campaign")
        return document

    def url(self, stored: Mapping[str, Any], storage: str | None = None) -> str:
        """The campaign's storage, or the one that is given. Raises InputError, StorageError if its password is needed."""
        if storage is not None:
            return storage_url(storage)
        return recorded_url(stored["storage"], self.embedded_url)

    @contextmanager
    def claimed(self, document: Mapping[str, Any]) -> Iterator[None]:
        """Hold the folder for the campaign that `document` describes, making it if need be.

        With a server's storage several processes may share the folder. Raises InputError or StorageError as `changes` does,
        StorageError if the folder cannot be written or, with its embedded record, is in use by another process.
        """
        make_folder(self.folder)
        with ExitStack() as held:
            if document["storage"] is None:
                held.enter_context(locked(self.folder))
            self.changes(document)
            self._write(CAMPAIGN_FILE, document)
            yield

    def changes(self, document: Mapping[str, Any]) -> Changes:
        """How a campaign differs from the one in the folder, if there is one.

        Raises InputError if that is another campaign, StorageError if there is a record without its campaign.
        """
        stored = read_document(self.folder / CAMPAIGN_FILE)
        if stored is None:
            if (self.folder / STUDY_FILE).exists():
                raise StorageError(f"{self.folder} holds a {STUDY_FILE} but no {CAMPAIGN_FILE}: use another folder")
            return Changes()
        if stored["storage"] != document["storage"]:
            raise InputError(
                f"--storage: {self.folder} has its record at {stored['storage'] or STUDY_FILE}; "
                "give that storage, or another folder"
            )
        changes = campaign_changes(stored["identity"], document["identity"])
        changes.check(str(self.folder))
        return changes

    def write_statistics(self, document: Mapping[str, Any]) -> None:
        """Write the statistics as JSON."""
        self._write(STATISTICS_FILE, document)

    def _write(self, name: str, document: Mapping[str, Any]) -> None:
        text = json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False)
        write_whole(self.folder / name, text.encode("utf-8"))
