"""The command as its users meet it: dry run, stop and go on, extend, refuse, report, export."""

import html
import json
import re
import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from campaign_runs import Trial, command, wait_until

from railsearch.campaign.analysis import FORMAT

Cli = Callable[..., Any]
pytestmark = pytest.mark.usefixtures("sample_plugin")


def finish(trial: Trial, out: Path) -> None:
    """Carry a campaign out in a process of its own."""
    process = command("campaign", trial.file(), "--out", out)
    _, err = process.communicate(timeout=240)
    assert process.returncode == 0, err


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> tuple[Trial, Path]:
    """A finished campaign and its folder."""
    folder = tmp_path_factory.mktemp("finished")
    trial = Trial(folder / "trial", strategies=("lmsrs", "random"), repetitions=4, budget=24)
    finish(trial, folder / "out")
    return trial, folder / "out"


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> Trial:
    """A campaign that nobody stopped."""
    trial = Trial(tmp_path_factory.mktemp("undisturbed"))
    finish(trial, trial.folder)
    return trial


def test_a_dry_run_shows_cells_and_cost_and_leaves_nothing_behind(railsearch: Cli, tmp_path: Path) -> None:
    trial = Trial(tmp_path / "trial", seconds=0.01)
    answer = railsearch("campaign", trial.file(), "--dry-run", "--workers", 2, "--out", tmp_path / "out")
    assert answer.code == 0, answer.err
    assert re.search(r"journalled +dycors +2 +0 +50 +0\.01", answer.out)
    assert "4 cells of 25 evaluations, 0 complete and 0 evaluations recorded" in answer.out
    assert "some 5 to 100 ms per evaluation of one with a surrogate" in " ".join(answer.out.split())
    assert len(trial.calls) == 1
    assert not (tmp_path / "out").exists()


def test_a_campaign_leaves_report_figures_statistics_and_table(finished: tuple[Trial, Path]) -> None:
    trial, out = finished
    assert len(trial.calls) == trial.evaluations
    for name in ("campaign.json", "study.db", "report.html", "statistics.json", "results.parquet"):
        assert (out / name).stat().st_size > 500
    assert list((out / "figures").glob("*.svg"))
    assert list((out / "figures").glob("*.png"))
    found = json.loads((out / "statistics.json").read_text())
    assert (found["format"], found["status"], found["complete"]) == (FORMAT, "complete", 8)
    words = re.sub(r"<[^>]*>", "", html.unescape((out / "report.html").read_text()))
    assert found["conclusion"] in words


def test_a_campaign_says_at_once_what_it_will_do(railsearch: Cli, tmp_path: Path) -> None:
    trial = Trial(tmp_path, strategies=("random",), repetitions=1)
    answer = railsearch("campaign", trial.file(), "--workers", 2, "--out", tmp_path)
    assert answer.code == 0, answer.err
    assert answer.err.splitlines()[0] == "1 cell, 25 evaluations"
    assert railsearch("campaign", trial.file(), "--out", tmp_path).err.startswith("complete: all 25 evaluations")


def test_the_same_command_again_evaluates_nothing_and_writes_the_same(railsearch: Cli, finished: tuple[Trial, Path]) -> None:
    trial, out = finished
    before = json.loads((out / "statistics.json").read_text())
    answer = railsearch("campaign", trial.file(), "--out", out, "--json")
    assert answer.code == 0, answer.err
    assert "nothing is evaluated" in answer.err
    assert len(trial.calls) == trial.evaluations
    after = json.loads(answer.out)
    assert {**after, "command": ""} == {**before, "command": ""}


def test_the_report_is_made_from_the_storage_alone(railsearch: Cli, finished: tuple[Trial, Path]) -> None:
    _, out = finished
    before = (out / "statistics.json").read_bytes()
    for name in ("report.html", "statistics.json", "results.parquet"):
        (out / name).unlink()
    answer = railsearch("report", out)
    assert answer.code == 0, answer.err
    assert "lmsrs" in answer.out
    assert (out / "statistics.json").read_bytes() == before
    assert (out / "report.html").exists()


@pytest.mark.parametrize("name", ["evaluations.csv", "evaluations.parquet"])
def test_an_export_has_every_evaluation(railsearch: Cli, finished: tuple[Trial, Path], tmp_path: Path, name: str) -> None:
    import pandas

    trial, out = finished
    answer = railsearch("export", out, "--out", tmp_path / name)
    assert answer.code == 0, answer.err
    table = pandas.read_csv(tmp_path / name) if name.endswith("csv") else pandas.read_parquet(tmp_path / name)
    assert len(table) == trial.evaluations


def test_an_export_for_iohanalyzer_is_a_folder(railsearch: Cli, finished: tuple[Trial, Path], tmp_path: Path) -> None:
    _, out = finished
    answer = railsearch("export", out, "--format", "iohprofiler", "--out", tmp_path / "ioh")
    assert answer.code == 0, answer.err
    assert list((tmp_path / "ioh").rglob("IOHprofiler*.json"))


def test_an_export_of_unknown_kind_is_refused(railsearch: Cli, finished: tuple[Trial, Path], tmp_path: Path) -> None:
    answer = railsearch("export", finished[1], "--out", tmp_path / "evaluations.xls")
    assert answer.code == 2
    assert "--format: cannot be told from the name evaluations.xls; give one of parquet, csv, iohprofiler" in answer.err


@pytest.mark.parametrize("moment", [3, 17, 40])
def test_a_campaign_killed_at_any_moment_goes_on_to_the_same_end(
    railsearch: Cli, undisturbed: Trial, tmp_path: Path, moment: int
) -> None:
    killed = Trial(tmp_path, seconds=0.02)
    words = ["campaign", killed.file(), "--workers", 2, "--out", killed.folder]
    process = command(*words)
    wait_until(lambda: len(killed.calls) >= moment)
    process.kill()
    process.communicate()
    answer = railsearch(*words)
    assert answer.code == 0, answer.err
    assert killed.found() == undisturbed.found()
    assert killed.evaluations <= len(killed.calls) <= killed.evaluations + 2


@pytest.mark.parametrize("sign", [signal.SIGINT, signal.SIGTERM])
def test_ctrl_c_finishes_what_is_under_way_and_says_how_to_go_on(tmp_path: Path, sign: signal.Signals) -> None:
    trial = Trial(tmp_path, seconds=0.3, repetitions=5)
    process = command("campaign", trial.file(), "--workers", 2, "--out", trial.folder)
    wait_until(lambda: len(trial.calls) >= 6)
    process.send_signal(sign)
    begun = len(trial.calls)
    _, err = process.communicate(timeout=60)
    assert len(trial.calls) <= begun + 4
    assert process.returncode == 130
    stored = sum(len(rows) for rows in trial.found().values())
    assert stored == len(trial.calls)
    assert f"stopped: {stored} evaluations are recorded; the same command goes on from there" in err
    assert "Traceback" not in err


def test_what_was_added_to_the_file_extends_the_campaign(railsearch: Cli, tmp_path: Path) -> None:
    first = Trial(tmp_path, strategies=("random",))
    assert railsearch("campaign", first.file(), "--out", tmp_path).code == 0
    more = Trial(tmp_path, strategies=("random", "lmsrs"), repetitions=3)
    answer = railsearch("campaign", more.file(), "--out", tmp_path)
    assert answer.code == 0, answer.err
    assert "changed: strategy 'lmsrs' is added" in answer.err
    assert "changed: repetitions: 3 instead of 2" in answer.err
    assert "continuing: 50 evaluations and 2 complete cells are recorded" in answer.err
    assert len(more.calls) == more.evaluations


def test_a_file_that_means_something_else_is_refused_with_what_changed(railsearch: Cli, tmp_path: Path) -> None:
    first = Trial(tmp_path, strategies=("random",))
    assert railsearch("campaign", first.file(), "--out", tmp_path).code == 0
    other = Trial(tmp_path, strategies=("random",), budget=30)
    for extra in ([], ["--dry-run"]):
        answer = railsearch("campaign", other.file(), "--out", tmp_path, *extra)
        assert answer.code == 2
        assert "holds another campaign than the file describes" in answer.err
        assert "budget: there 25, here 30" in answer.err
    answer = railsearch("campaign", other.file(), "--out", tmp_path / "new", "--storage", first.url)
    assert answer.code == 2
    assert "holds other runs under the names of this campaign's cells" in answer.err
    assert "budget: there 25, here 30 (in 2 cells)" in answer.err
    assert not (tmp_path / "new").exists()
    assert len(first.calls) == first.evaluations


def test_strategies_that_cannot_do_a_problem_are_left_out_only_when_asked(railsearch: Cli, tmp_path: Path) -> None:
    file = tmp_path / "two.toml"
    file.write_text(
        """
[campaign]
budget = 20
repetitions = 1
seed = 1
strategies = ["lmsrs", "nsga2", "random"]
problems = ["ackley"]
[[problem]]
name = "two-spheres"
reference_point = { left = 50.0, right = 50.0 }
"""
    )
    refused = railsearch("campaign", file, "--out", tmp_path / "out")
    assert refused.code == 2
    assert "lmsrs on two-spheres" in refused.err
    assert "--skip-incapable" in refused.err
    assert not (tmp_path / "out").exists()
    answer = railsearch("campaign", file, "--out", tmp_path / "out", "--skip-incapable", "--dry-run")
    assert answer.code == 0, answer.err
    assert "left out: lmsrs on two-spheres" in answer.err
    assert re.search(r"two-spheres +nsga2 +1 +0 +20 ", answer.out)


def test_a_cell_that_fails_is_told_at_the_end_and_the_report_is_made(railsearch: Cli, tmp_path: Path) -> None:
    trial = Trial(tmp_path, strategies=("breaking", "random"))
    answer = railsearch("campaign", trial.file(), "--out", tmp_path)
    assert answer.code == 2
    assert "2 cells could not be finished; their evaluations are kept" in answer.err
    assert "ZeroDivisionError: the tenth is one too many" in answer.err
    assert (tmp_path / "report.html").exists()


def test_a_campaign_file_to_begin_with_runs(railsearch: Cli, tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    assert railsearch("init-campaign", "level-crossing", "--out", file).code == 0
    answer = railsearch("campaign", file, "--dry-run")
    assert answer.code == 0, answer.err
    assert "cells of 200 evaluations" in answer.out
    assert "exists and is not overwritten" in railsearch("init-campaign", "level-crossing", "--out", file).err


def test_a_folder_without_a_campaign_is_refused(railsearch: Cli, tmp_path: Path) -> None:
    answer = railsearch("report", tmp_path)
    assert answer.code == 2
    assert "holds no campaign" in answer.err


def test_workers_of_two_kinds_are_refused(railsearch: Cli, tmp_path: Path) -> None:
    answer = railsearch("campaign", Trial(tmp_path).file(), "--workers", 2, "--dask", "tcp://127.0.0.1:1")
    assert answer.code == 2
    assert "either processes of this machine or the workers of a cluster" in answer.err
