"""Storages that fail for a while, one writer at a time, and progress without reading."""

import sqlite3
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import optuna
import pytest
from optuna.exceptions import StorageInternalError
from optuna.trial import FrozenTrial
from sqlalchemy.exc import IntegrityError, OperationalError, ProgrammingError

from railsearch.errors import InputError, StorageError
from railsearch.storage import (
    Patience,
    Storage,
    StudyDescription,
    StudyProgress,
    access,
    open_run,
    read_progress,
    storage_url,
)
from railsearch.storage import progress as progress_module
from railsearch.storage.claims import FileClaims, ServerClaims
from sample_problems import MIXED, sphere_evaluation


class Clock:
    """Time that passes only in sleep."""

    def __init__(self) -> None:
        self.now = 0.0
        self.pauses: list[float] = []

    def monotonic(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        self.pauses.append(seconds)
        self.now += seconds


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    made = Clock()
    monkeypatch.setattr(access, "time", made)
    return made


class Failing:
    """Fails so many times, then answers."""

    def __init__(self, failures: int, error: Exception) -> None:
        self.left, self.error = failures, error

    def __call__(self) -> str:
        if self.left:
            self.left -= 1
            raise self.error
        return "answer"


@pytest.mark.parametrize(
    "error", [OperationalError("", {}, Exception("gone")), StorageInternalError("gone"), ConnectionResetError("gone")]
)
def test_patience_waits_twice_as_long_each_time(clock: Clock, error: Exception) -> None:
    told: list[str] = []
    assert Patience(100.0, told.append).insist(Failing(7, error)) == "answer"
    assert clock.pauses == [0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 30.0]
    assert len(told) == 7
    assert "gone" in told[0]


def test_patience_ends_exactly_and_raises_what_failed(clock: Clock) -> None:
    with pytest.raises(ConnectionResetError):
        Patience(10.0).insist(Failing(1000, ConnectionResetError()))
    assert clock.now == 10.0
    assert clock.pauses == [0.5, 1.0, 2.0, 4.0, 2.5]


def test_what_is_no_failure_of_the_storage_is_not_repeated(clock: Clock) -> None:
    failing = Failing(1, ZeroDivisionError())
    with pytest.raises(ZeroDivisionError):
        Patience(10.0).insist(failing)
    assert clock.pauses == []


def test_an_evaluation_whose_storing_was_not_confirmed_is_not_stored_twice(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, clock: Clock
) -> None:
    """The transaction was carried out, but the connection broke before the answer."""
    url = f"sqlite:///{tmp_path / 'study.db'}"
    record = Storage(url, Patience(10.0)).run(StudyDescription("two", {}, ("distance",), 0, ""), MIXED)
    add = record._add
    calls: list[Sequence[FrozenTrial]] = []

    def unconfirmed(trials: Sequence[FrozenTrial]) -> None:
        calls.append(trials)
        add(trials)
        if len(calls) == 1:
            raise OperationalError("", {}, Exception("server closed the connection"))

    monkeypatch.setattr(record, "_add", unconfirmed)
    for number in (0, 2, 4):
        record.append(sphere_evaluation(number), sphere_evaluation(number + 1))
    assert [evaluation.number for evaluation in record.load()] == list(range(6))
    assert [len(trials) for trials in calls] == [2, 0, 2, 2]


def test_an_evaluation_that_was_not_stored_is_stored_at_the_next_attempt(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, clock: Clock
) -> None:
    url = f"sqlite:///{tmp_path / 'study.db'}"
    record = Storage(url, Patience(10.0)).run(StudyDescription("two", {}, ("distance",), 0, ""), MIXED)
    add = record._add
    calls: list[Sequence[FrozenTrial]] = []

    def refused(trials: Sequence[FrozenTrial]) -> None:
        calls.append(trials)
        if len(calls) == 1:
            raise OperationalError("", {}, Exception("no connection"))
        add(trials)

    monkeypatch.setattr(record, "_add", refused)
    record.append(sphere_evaluation(0))
    assert len(record.load()) == 1


@pytest.mark.parametrize("collision", [IntegrityError, ProgrammingError])
def test_a_storage_that_another_process_makes_at_the_same_moment_is_opened(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, collision: type[IntegrityError | ProgrammingError]
) -> None:
    make, attempts = optuna.storages.RDBStorage.__init__, []

    def colliding(*arguments: Any, **settings: Any) -> None:
        attempts.append(arguments)
        if len(attempts) < 3:
            raise collision("CREATE TYPE", {}, Exception("duplicate key value violates pg_type_typname_nsp_index"))
        make(*arguments, **settings)

    monkeypatch.setattr(optuna.storages.RDBStorage, "__init__", colliding)
    record = Storage(f"sqlite:///{tmp_path / 'study.db'}").run(StudyDescription("two", {}, ("distance",), 0, ""), MIXED)
    record.append(sphere_evaluation(0))
    assert len(record.load()) == 1


def test_evaluations_finished_out_of_order_come_back_in_order(tmp_path: Path) -> None:
    record = open_run(f"sqlite:///{tmp_path / 'study.db'}", StudyDescription("two", {}, ("distance",), 0, ""), MIXED)
    for number in (0, 3, 1):
        record.append(sphere_evaluation(number))
    loaded = record.load()
    assert [evaluation.number for evaluation in loaded] == [0, 1, 3]
    assert [evaluation.design.tobytes() for evaluation in loaded] == [
        sphere_evaluation(number).design.tobytes() for number in (0, 1, 3)
    ]


def test_an_evaluation_that_is_there_twice_is_an_error(tmp_path: Path) -> None:
    record = open_run(f"sqlite:///{tmp_path / 'study.db'}", StudyDescription("two", {}, ("distance",), 0, ""), MIXED)
    record.append(sphere_evaluation(1))
    record.append(sphere_evaluation(1))
    with pytest.raises(StorageError, match="an evaluation twice"):
        record.load()


def test_a_file_is_claimed_by_one_process_until_it_ends(tmp_path: Path) -> None:
    url = f"sqlite:///{tmp_path / 'study.db'}"
    mine = FileClaims(url)
    assert mine.take("a")
    assert mine.take("b")
    assert mine.kept("a")
    with pytest.raises(StorageError, match="in use by another process"):
        FileClaims(url).take("a")
    mine.close()
    code = f"from railsearch.storage.claims import FileClaims; assert FileClaims({url!r}).take('a')"
    subprocess.run([sys.executable, "-c", code], check=True)
    again = FileClaims(url)
    assert again.take("a")
    again.close()


def test_a_database_without_locks_is_refused() -> None:
    with pytest.raises(InputError, match="has no locks by which several processes could share it"):
        ServerClaims("sqlite://").take("a")


@pytest.mark.parametrize("schema", ["known", "another"])
def test_progress_counts_without_reading(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, schema: str) -> None:
    url = f"sqlite:///{tmp_path / 'study.db'}"
    assert read_progress(url, "c/") == {}
    assert not (tmp_path / "study.db").exists()
    for name, count in (("c/p/s/1", 3), ("c/p/s/2", 0), ("C/p/s/1", 1), ("other", 2)):
        record = open_run(url, StudyDescription(name, {"name": name}, ("distance",), 0, ""), MIXED)
        for number in range(count):
            record.append(sphere_evaluation(number))
    if schema == "another":
        monkeypatch.setattr(progress_module, "KNOWN_SCHEMA", "unknown")
    assert read_progress(url, "c/") == {
        "c/p/s/1": StudyProgress({"name": "c/p/s/1"}, 3),
        "c/p/s/2": StudyProgress({"name": "c/p/s/2"}, 0),
    }


def test_a_file_that_is_no_storage_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "study.db"
    path.write_text("this is not a database, whatever its name says" * 10)
    with pytest.raises(StorageError, match="cannot be opened"):
        read_progress(f"sqlite:///{path}", "c/")
    sqlite3.connect(tmp_path / "empty.db").close()
    (tmp_path / "empty.db").touch()
    assert read_progress(f"sqlite:///{tmp_path / 'empty.db'}", "c/") == {}


@pytest.mark.parametrize(
    ("given", "used"),
    [
        ("postgresql://me:secret@host/db", "postgresql+psycopg://me:secret@host/db"),
        ("postgresql+psycopg2://me@host/db", "postgresql+psycopg2://me@host/db"),
        ("mysql+pymysql://me@host/db", "mysql+pymysql://me@host/db"),
    ],
)
def test_postgresql_means_the_driver_that_is_installed_with_railsearch(given: str, used: str) -> None:
    assert storage_url(given) == used


def test_a_missing_driver_is_named_with_how_to_install_it() -> None:
    with pytest.raises(StorageError, match=r"me:\*\*\*@host/db needs a driver .*No module named 'oracledb'"):
        read_progress("oracle+oracledb://me:secret@host/db", "c/")
