"""Several campaign processes on one PostgreSQL server, and a server that goes away."""

from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from campaign_runs import Trial, command, wait_until

from command_line import Answer
from postgresql_server import Server, postgresql
from railsearch.campaign.coordinator import Watcher
from railsearch.errors import StorageError
from railsearch.storage import Patience, Storage, StudyDescription, claims_of
from railsearch.storage.claims import ServerClaims
from sample_problems import MIXED, sphere_evaluation

pytestmark = [
    pytest.mark.system,
    pytest.mark.usefixtures("sample_plugin"),
]


@pytest.fixture(scope="module")
def server() -> Iterator[Server]:
    with postgresql() as running:
        yield running


def test_processes_that_share_a_server_take_each_cell_exactly_once(server: Server, tmp_path: Path) -> None:
    trial = Trial(tmp_path / "shared", strategies=("dycors", "random", "lmsrs"), seconds=0.03)
    alone = Trial(tmp_path / "alone", strategies=trial.strategies)
    file = trial.file()
    words = ["campaign", file, "--storage", server.url, "--out"]
    processes = [command(*words, tmp_path / f"out {number}") for number in range(3)]
    ended = [process.communicate(timeout=240) for process in processes]
    assert [process.returncode for process in processes] == [0, 0, 0], ended
    assert len(trial.calls) == trial.evaluations
    designs = Counter(line.split(" ", 1)[1] for line in trial.calls)
    assert len({line.split()[0] for line in trial.calls}) > 1
    alone.carry_out()
    assert designs == Counter(line.split(" ", 1)[1] for line in alone.calls)
    assert trial.found(server.url) == alone.found()
    reports = {(tmp_path / f"out {number}" / "statistics.json").read_text().count("complete") for number in range(3)}
    assert len(reports) == 1


def test_the_cells_of_a_process_that_died_are_finished_by_another(server: Server, tmp_path: Path) -> None:
    with server.database("died") as url:
        trial = Trial(tmp_path / "shared", strategies=("random",), seconds=0.05)
        words = ["campaign", trial.file(), "--storage", url, "--out"]
        first = command(*words, tmp_path / "first")
        wait_until(lambda: len(trial.calls) > 5)
        second = command(*words, tmp_path / "second")
        wait_until(lambda: len(trial.calls) > 20)
        first.kill()
        first.communicate()
        _, err = second.communicate(timeout=120)
        assert second.returncode == 0, err
        assert trial.evaluations <= len(trial.calls) <= trial.evaluations + 1
        assert {len(rows) for rows in trial.found(url).values()} == {trial.budget}


def test_a_server_that_is_started_again_is_waited_for_and_nothing_is_stored_twice(tmp_path: Path) -> None:
    with postgresql() as server:
        trial = Trial(tmp_path / "interrupted", strategies=("random",))
        events: list[str] = []

        def restart(task: object, evaluation: object) -> None:
            if len(trial.calls) == 20:
                events.append("stopped")
                server.stop()
            if len(trial.calls) == 35:
                events.append("started again")
                server.restart()

        told: list[str] = []

        def started_when_missed(message: str) -> None:
            told.append(message)
            if len(told) == 2:
                server.start()

        with trial.coordinator(server.url, Watcher(evaluation=restart), Patience(60.0, started_when_missed)) as coordinator:
            coordinator.carry_out(trial.places())
        assert events == ["stopped", "started again"]
        assert len(told) >= 2
        assert "does not answer" in told[0]
        assert len(trial.calls) == trial.evaluations
        assert {len(rows) for rows in trial.found(server.url).values()} == {trial.budget}


def test_a_server_that_stays_away_stops_the_campaign_cleanly(tmp_path: Path) -> None:
    with postgresql() as server:
        trial = Trial(tmp_path / "gone", strategies=("random",))

        def stop(task: object, evaluation: object) -> None:
            if len(trial.calls) == 20:
                server.stop()

        with (
            pytest.raises(StorageError, match=r"cannot be written.* 20 evaluations are safe in it.*repeat the same command"),
            trial.coordinator(server.url, Watcher(evaluation=stop), Patience(1.0)) as coordinator,
        ):
            coordinator.carry_out(trial.places())
        server.start()
        assert sum(len(rows) for rows in trial.found(server.url).values()) == 20
        trial.carry_out(url=server.url)
        assert len(trial.calls) == trial.evaluations + 1


def test_a_claim_is_exclusive_until_it_is_released(server: Server) -> None:
    one, other = ServerClaims(server.url), ServerClaims(server.url)
    assert one.take("a/b/c/1")
    assert not other.take("a/b/c/1")
    assert not one.take("a/b/c/1")
    assert other.take("a/b/c/2")
    one.release("a/b/c/1")
    assert other.take("a/b/c/1")
    other.close()
    assert one.take("a/b/c/1")
    one.close()


def test_a_claim_lost_with_its_connection_is_taken_again_unless_another_has_it(server: Server) -> None:
    one, other = ServerClaims(server.url), ServerClaims(server.url)
    assert one.take("kept")
    assert one.take("lost")
    server.disconnect_all()
    assert other.take("lost")
    assert one.kept("kept")
    assert not one.kept("lost")
    one.close()
    other.close()


def test_the_writer_of_a_study_that_another_process_took_over_stops(server: Server) -> None:
    with server.database("taken") as url:
        storage = Storage(url, claims=claims_of(url))
        assert storage.claim("two")
        storage.run(StudyDescription("two", {"problem": "two"}, ("distance",), 0, ""), MIXED)
        server.disconnect_all()
        other = ServerClaims(url)
        assert other.take("two")
        record = storage.run(StudyDescription("two", {"problem": "two"}, ("distance",), 0, ""), MIXED)
        with pytest.raises(StorageError, match="taken over by another process"):
            record.append(sphere_evaluation(0))
        storage.close()
        other.close()


def test_a_server_without_an_answer_is_refused_at_the_door(railsearch: Callable[..., Answer], tmp_path: Path) -> None:
    trial = Trial(tmp_path)
    answer = railsearch("campaign", trial.file(), "--storage", "postgresql+psycopg://me:secret@127.0.0.1:1/x")
    assert answer.code == 2
    assert "postgresql+psycopg://me:***@127.0.0.1:1/x cannot be opened" in answer.err
    assert "secret" not in answer.err + answer.out
    assert trial.calls == []


def test_a_run_whose_study_is_in_work_elsewhere_is_refused(
    railsearch: Callable[..., Answer], server: Server, tmp_path: Path
) -> None:
    with server.database("run") as url:
        words = ["run", "ackley", "--strategy", "random", "--budget", 5, "--seed", 1, "--storage", url]
        other = ServerClaims(url)
        assert other.take("ackley (f) / random / seed 1")
        refused = railsearch(*words, "--out", tmp_path / "refused")
        assert refused.code == 2
        assert "study 'ackley (f) / random / seed 1' is in work by another process" in refused.err
        other.close()
        again = railsearch(*words, "--out", tmp_path / "again")
        assert again.code == 0, again.err
