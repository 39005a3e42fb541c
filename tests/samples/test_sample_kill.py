"""A real process is killed at random moments; started again it ends with the file of an undisturbed one."""

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pyarrow.parquet
import pytest

from railsearch.samples import read_samples

COMMAND = (sys.executable, "-m", "railsearch")
SITE = "[function]\ndimension = 4\nintegers = 2\nseconds = 0.05\ncomputing = false\n"
OUT = "s.parquet"
WORDS = ("sample", "ackley", "--n", "30", "--design", "lhs", "--seed", "6", "--parameters", "site.toml", "--out", OUT)


def started(folder: Path, *words: str, pipe: int = subprocess.DEVNULL) -> subprocess.Popen[str]:
    folder.mkdir(exist_ok=True)
    (folder / "site.toml").write_text(SITE, encoding="utf-8")
    return subprocess.Popen([*COMMAND, *WORDS, *words], stdout=pipe, stderr=pipe, text=True, cwd=folder, env=os.environ)


def kept(folder: Path) -> int:
    """The samples in the journal; the first line says what they are."""
    journal = folder / f"{OUT}.journal"
    try:
        return max(journal.read_bytes().count(b"\n") - 1, 0)
    except FileNotFoundError:
        return 0


def reach(process: subprocess.Popen[str], folder: Path, number: int) -> None:
    while kept(folder) < number:
        assert process.poll() is None, "the process ended by itself"
        time.sleep(0.002)


def descendants(pid: int) -> list[int]:
    """The processes that a process has started, and those that they have."""
    children = [int(word) for word in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]
    return [*children, *(found for child in children for found in descendants(child))]


@pytest.fixture(scope="module")
def calm(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a sample that nobody disturbed."""
    folder = tmp_path_factory.mktemp("calm")
    assert started(folder).wait() == 0
    return folder


def test_killed_at_random_moments_it_ends_with_the_file_of_an_undisturbed_one(tmp_path: Path, calm: Path) -> None:
    moments, folder, reached = random.Random(3), tmp_path / "killed", []
    for number in (1, 18):
        process = started(folder)
        reach(process, folder, number)
        time.sleep(moments.uniform(0.0, 0.1))
        process.send_signal(signal.SIGKILL)
        process.wait()
        reached.append(kept(folder))
    assert reached == sorted(reached)
    assert 0 < reached[0] < reached[-1] < 30, "the kills must fall into the sample"
    before = (folder / f"{OUT}.journal").read_bytes()
    final = started(folder)
    reach(final, folder, reached[-1])
    assert (folder / f"{OUT}.journal").read_bytes().startswith(before.rpartition(b"\n")[0])
    assert final.wait() == 0
    undisturbed, killed = (pyarrow.parquet.read_table(place / OUT) for place in (calm, folder))
    assert killed.drop_columns("seconds").equals(undisturbed.drop_columns("seconds"))
    assert killed.schema.equals(undisturbed.schema, check_metadata=True)
    assert sorted(path.name for path in folder.iterdir()) == sorted(path.name for path in calm.iterdir())


def test_two_processes_killed_together_leave_none_behind_and_the_same_samples(tmp_path: Path, calm: Path) -> None:
    folder = tmp_path / "two"
    process = started(folder, "--workers", "2")
    reach(process, folder, 5)
    children = descendants(process.pid)
    assert len(children) >= 2 + 1, "two processes, and what forks them"
    process.send_signal(signal.SIGKILL)
    process.wait()
    deadline = time.monotonic() + 20.0
    while any(alive(child) for child in children) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not any(alive(child) for child in children)
    assert started(folder).wait() == 0
    two, one = read_samples(folder / OUT), read_samples(calm / OUT)
    np.testing.assert_array_equal(two.input_matrix(), one.input_matrix())
    for name in one.outputs:
        np.testing.assert_array_equal(two.output(name), one.output(name))


def test_an_interrupted_sample_says_how_to_go_on(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    process = started(folder, pipe=subprocess.PIPE)
    reach(process, folder, 4)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate()
    assert process.returncode == 130
    assert out == ""
    assert "the same command goes on" in err
    assert "Traceback" not in err


def alive(process: int) -> bool:
    """Whether a process runs; one that nobody has waited for yet does not."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False
