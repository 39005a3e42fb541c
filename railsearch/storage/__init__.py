"""Records in Optuna's storages: the only room that touches Optuna's studies and storages."""

from railsearch.storage.access import STORAGE_PATIENCE, Patience
from railsearch.storage.address import check_storage, is_file, storage_url, without_password
from railsearch.storage.claims import Claims, claims_of, server_claims
from railsearch.storage.progress import StudyProgress, read_progress
from railsearch.storage.study import (
    IDENTITY,
    RunStorage,
    Storage,
    StudyDescription,
    identity_differences,
    open_run,
    plain,
)

__all__ = [
    "IDENTITY",
    "STORAGE_PATIENCE",
    "Claims",
    "Patience",
    "RunStorage",
    "Storage",
    "StudyDescription",
    "StudyProgress",
    "check_storage",
    "claims_of",
    "identity_differences",
    "is_file",
    "open_run",
    "plain",
    "read_progress",
    "server_claims",
    "storage_url",
    "without_password",
]
