"""Addresses of storages: the URLs of SQLAlchemy, which Optuna uses."""

import os

from sqlalchemy.engine import make_url
from sqlalchemy.exc import ArgumentError

from railsearch.errors import InputError, StorageError


def storage_url(url: str) -> str:
    """An Optuna storage URL, the path of an SQLite file absolute, PostgreSQL's driver psycopg 3 unless another is named.

    Raises InputError if it is none.
    """
    try:
        parsed = make_url(url)
    except ArgumentError:
        raise InputError(
            f"--storage: an URL such as sqlite:///FILE or postgresql://USER@HOST/NAME is needed, received {url!r}"
        ) from None
    if parsed.drivername.startswith("sqlite") and parsed.database:
        parsed = parsed.set(database=os.path.abspath(parsed.database))
    if parsed.drivername == "postgresql":
        parsed = parsed.set(drivername="postgresql+psycopg")
    return parsed.render_as_string(hide_password=False)


def without_password(url: str) -> str:
    """A storage URL that can be shown; what is no URL stays as it is."""
    try:
        return make_url(url).render_as_string(hide_password=True)
    except ArgumentError:
        return url


def storage_exists(url: str) -> bool:
    """False for an SQLite file that does not exist: opening it would make one."""
    database = make_url(url).database
    return not is_file(url) or database in (None, "", ":memory:") or os.path.exists(str(database))


def check_storage(url: str) -> None:
    """Raise StorageError if the storage is an SQLite file that does not exist: opening it would make one."""
    if not storage_exists(url):
        raise StorageError(
            f"there is no record at {without_password(url)}: bring the file back, or name its place with --storage"
        )


def is_file(url: str) -> bool:
    """True for a storage in an SQLite file, which has one writer; False for one on a server, which has many."""
    return make_url(url).drivername.startswith("sqlite")
