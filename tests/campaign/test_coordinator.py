"""A campaign is carried out: everything recorded, nothing twice, whatever dies."""

import os
import signal
from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest
from campaign_runs import Trial

from railsearch.campaign.cell_run import Request, Step
from railsearch.campaign.cells import Cell
from railsearch.campaign.coordinator import Watcher, failure_message
from railsearch.campaign.places import FixedPlaces, Here
from railsearch.errors import StorageError
from railsearch.plugin_manager import load_plugins
from railsearch.storage import Storage, claims_of

pytestmark = pytest.mark.usefixtures("sample_plugin")


def same_problem(trial: Trial) -> dict[tuple[str, int], object]:
    """What a trial found, comparable with another trial whose journal is elsewhere."""
    return {(strategy, repetition): rows for (_, strategy, repetition), rows in trial.found().items()}


def test_processes_find_what_one_process_finds_and_evaluate_nothing_twice(tmp_path: Path) -> None:
    alone, together = Trial(tmp_path / "alone"), Trial(tmp_path / "together")
    assert alone.carry_out() == {}
    assert together.carry_out(workers=2) == {}
    assert same_problem(alone) == same_problem(together)
    assert len(alone.calls) == len(together.calls) == alone.evaluations
    assert len(same_problem(alone)) == 4
    assert len({line.split()[0] for line in together.calls}) == 2


def test_a_complete_campaign_evaluates_nothing_and_more_repetitions_only_theirs(tmp_path: Path) -> None:
    first = Trial(tmp_path, strategies=("random",))
    first.carry_out()
    before = first.found()
    more = Trial(tmp_path, strategies=("random", "lmsrs"), repetitions=3)
    more.carry_out()
    assert len(more.calls) == more.evaluations
    after = more.found()
    assert {key: after[key] for key in before} == before
    more.carry_out()
    assert len(more.calls) == more.evaluations


def test_a_worker_killed_in_mid_campaign_costs_what_it_had_under_way(tmp_path: Path) -> None:
    trial, undisturbed = Trial(tmp_path / "killed", seconds=0.02), Trial(tmp_path / "undisturbed")
    killed: list[int] = []

    def kill_once(task: object, evaluation: object) -> None:
        if not killed and len(trial.calls) > 30:
            killed.append(int(trial.calls[-1].split()[0]))
            os.kill(killed[0], signal.SIGKILL)

    failed = trial.carry_out(workers=2, watcher=Watcher(evaluation=kill_once))
    undisturbed.carry_out()
    assert killed
    assert failed == {}
    assert same_problem(trial) == same_problem(undisturbed)
    assert trial.evaluations <= len(trial.calls) <= trial.evaluations + 1


def test_what_a_model_warns_of_in_a_process_of_a_process_is_told_here(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    trial = Trial(tmp_path, strategies=("random",), repetitions=1, budget=40, fault="warn", timeout=60.0)
    with pytest.warns(UserWarning, match="^count is 4$"):
        assert trial.carry_out(workers=2) == {}
    assert "count" not in capfd.readouterr().err


def test_a_model_that_kills_its_process_is_a_failed_evaluation_in_the_end(tmp_path: Path) -> None:
    """The first such design is tried by two workers, then in a process of its own, as are all that follow in the cell."""
    trial = Trial(tmp_path, strategies=("random",), repetitions=1, budget=40, fault="die")
    assert trial.carry_out(workers=2) == {}
    (rows,) = trial.found().values()
    deadly = [row for row in rows if row[3]]
    assert len(rows) == 40
    assert len(deadly) > 1
    assert all("died" in reason for *_, reason in deadly)
    calls = Counter(line.split(" ", 1)[1] for line in trial.calls)
    assert sorted(calls.values()) == [1] * 39 + [3]


def test_a_hanging_model_is_a_failed_evaluation_at_its_time_limit(tmp_path: Path) -> None:
    trial = Trial(tmp_path, strategies=("random",), budget=30, fault="hang", timeout=0.5)
    trial.carry_out(workers=2)
    reasons = {reason for rows in trial.found().values() for *_, reason in rows if reason}
    assert reasons == {"time limit of 0.5 s exceeded"}
    assert len(trial.calls) == trial.evaluations


def test_a_strategy_that_breaks_ends_its_cells_and_no_others(tmp_path: Path) -> None:
    trial = Trial(tmp_path, strategies=("breaking", "random"))
    failed = trial.carry_out(workers=2)
    assert failed == {
        Cell("journalled", "breaking", number): "ZeroDivisionError: the tenth is one too many" for number in (1, 2)
    }
    found = trial.found()
    assert [len(found["journalled", "breaking", number]) for number in (1, 2)] == [10, 10]
    assert [len(found["journalled", "random", number]) for number in (1, 2)] == [25, 25]
    assert "breaking on journalled, repetition 2: ZeroDivisionError" in failure_message(failed)


def test_an_sqlite_file_has_one_coordinator(tmp_path: Path) -> None:
    trial = Trial(tmp_path)
    trial.folder.mkdir(exist_ok=True)
    other = Storage(trial.url, claims=claims_of(trial.url))
    assert other.claim("trial/journalled/random/1")
    with pytest.raises(StorageError, match="in use by another process"):
        trial.carry_out()
    other.close()
    assert trial.carry_out() == {}


def test_an_unforeseen_fault_of_the_coordinator_stops_everything_and_loses_nothing(tmp_path: Path) -> None:
    trial = Trial(tmp_path, repetitions=4)

    class Vanished(Exception):
        pass

    def vanish(task: object, evaluation: object) -> None:
        if len(trial.calls) > 40:
            raise Vanished

    with pytest.raises(Vanished):
        trial.carry_out(workers=2, watcher=Watcher(evaluation=vanish))
    stored = sum(len(rows) for rows in trial.found().values())
    # What each of the two workers has under way when it happens is made but not stored.
    assert stored <= len(trial.calls) <= stored + 2
    assert 40 < len(trial.calls) < trial.evaluations
    trial.carry_out()
    assert len(trial.calls) <= trial.evaluations + 2
    assert sum(len(rows) for rows in trial.found().values()) == trial.evaluations


def test_a_place_with_other_versions_is_told_once(tmp_path: Path) -> None:
    class Elsewhere(Here):
        name = "elsewhere"

        def advance(self, request: Request) -> Step:
            step = super().advance(request)
            return replace(step, versions=step.versions and {**step.versions, "numpy": "1.0"})

    told: list[str] = []
    trial = Trial(tmp_path, strategies=("random",))
    trial.carry_out(places=FixedPlaces([Elsewhere(load_plugins())]), watcher=Watcher(message=told.append))
    (message,) = told
    assert message.startswith("elsewhere works with numpy 1.0, this process with python")
