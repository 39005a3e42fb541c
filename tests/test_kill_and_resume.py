"""A real process is killed at random moments; started again with the same command it ends as an undisturbed one."""

import json
import random
import signal
import sqlite3
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from command_line import Answer

Cli = Callable[..., Answer]
COMMAND = (sys.executable, "-m", "railsearch")
SHORT = "[track.geometry]\ntotal_length = 60.0\napproach_length = 30.0\n"
SLOW = "[function]\ndimension = 4\nintegers = 2\nseconds = 0.1\ncomputing = false\n"


def crossing(folder: Path) -> tuple[str, ...]:
    """The words of a run on a short track; its site is written into a folder."""
    (folder / "site.toml").write_text(SHORT, encoding="utf-8")
    words = ("run", "level-crossing", "--scalarise", "asf", "--budget", "34", "--seed", "6")
    return (*words, "--parameters", str(folder / "site.toml"))


def quick(folder: Path, budget: int = 24) -> tuple[str, ...]:
    """The words of a run that begins and ends sooner, its evaluations waiting; its site is written into a folder."""
    (folder / "site.toml").write_text(SLOW, encoding="utf-8")
    return ("run", "ackley", "--budget", str(budget), "--seed", "6", "--parameters", str(folder / "site.toml"))


def started(out: Path, words: tuple[str, ...], pipe: int = subprocess.DEVNULL) -> subprocess.Popen[str]:
    return subprocess.Popen([*COMMAND, *words, "--out", str(out)], stdout=pipe, stderr=pipe, text=True)


def stored(out: Path, mode: str = "ro") -> int:
    """How many evaluations are in the record; `rw` after a kill, whose last transaction a reader alone cannot take back."""
    if not (out / "study.db").exists():
        return 0
    try:
        with sqlite3.connect(f"file:{out / 'study.db'}?mode={mode}", uri=True) as connection:
            return int(connection.execute("select count(*) from trials").fetchone()[0])
    except sqlite3.OperationalError:
        return 0


def kill_after(out: Path, words: tuple[str, ...], evaluations: int, seconds: float) -> None:
    """Start the run and kill it some time after that many evaluations have been stored."""
    process = started(out, words)
    while stored(out) < evaluations and process.poll() is None:
        time.sleep(0.005)
    time.sleep(seconds)
    process.send_signal(signal.SIGKILL)
    process.wait()


def sequence(out: Path) -> list[Any]:
    document = json.loads((out / "result.json").read_text())
    assert document["status"] == "complete"
    kept = ("number", "design", "objectives", "metrics", "origin", "trajectory", "reason")
    return [{key: row[key] for key in kept} for row in document["evaluations"]]


def test_killed_at_random_moments_it_ends_as_if_undisturbed(railsearch: Cli, tmp_path: Path) -> None:
    words = crossing(tmp_path)
    assert railsearch(*words, "--out", tmp_path / "calm").code == 0
    moments = random.Random(20)
    reached = []
    for evaluations in sorted(moments.sample(range(34), 5)):
        kill_after(tmp_path / "killed", words, evaluations, moments.uniform(0.0, 0.15))
        reached.append(stored(tmp_path / "killed", "rw"))
    assert reached == sorted(reached)
    assert 0 < reached[-1] < 34, "the kills must fall into the run"
    assert started(tmp_path / "killed", words).wait() == 0
    assert sequence(tmp_path / "killed") == sequence(tmp_path / "calm")
    assert stored(tmp_path / "killed") == 34


def test_a_second_process_is_kept_out(tmp_path: Path) -> None:
    words, out = quick(tmp_path, budget=2000), tmp_path / "run"
    process = started(out, words)
    try:
        while stored(out) < 2:
            assert process.poll() is None
            time.sleep(0.02)
        second = started(out, words, subprocess.PIPE)
        _, err = second.communicate()
        assert second.returncode == 2
        assert "in use by another process" in err
    finally:
        process.kill()
        process.wait()


@pytest.mark.parametrize("moment", ["before the study is described", "after it"])
def test_a_kill_around_the_making_of_the_study_leaves_a_folder_that_goes_on(
    railsearch: Cli, tmp_path: Path, moment: str
) -> None:
    words, out = quick(tmp_path), tmp_path / "run"
    process = started(out, words)
    while not (out / ("study.db" if moment.startswith("before") else "run.json")).exists():
        assert process.poll() is None
        time.sleep(0.001)
    process.kill()
    process.wait()
    assert railsearch(*words, "--out", out).code == 0
    assert stored(out) == 24


def test_an_interrupted_run_says_how_to_go_on(railsearch: Cli, tmp_path: Path) -> None:
    words, folder = quick(tmp_path, budget=40), tmp_path / "run"
    process = started(folder, words, subprocess.PIPE)
    while stored(folder) < 4:
        assert process.poll() is None
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate()
    assert process.returncode == 130
    assert out == ""
    assert "the same command goes on" in err
    assert "Traceback" not in err
    assert railsearch(*words, "--out", folder).code == 0
    assert stored(folder) == 40
