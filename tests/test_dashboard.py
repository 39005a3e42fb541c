"""Runs and campaigns seen in Optuna's dashboard, by headless Chromium."""

import subprocess
import sys
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from command_line import Answer
from postgresql_server import free_port
from test_cli import sample_problems

pytestmark = pytest.mark.system
QUIET = [
    "--headless",
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--hide-scrollbars",
    "--window-size=1400,2400",
    "--virtual-time-budget=30000",
]


def wait_for(url: str, process: subprocess.Popen[bytes]) -> None:
    for _ in range(300):
        assert process.poll() is None, "the dashboard ended"
        try:
            urllib.request.urlopen(url, timeout=5).close()
            return
        except (urllib.error.URLError, OSError):
            time.sleep(0.1)
    raise AssertionError("the dashboard does not answer")


def dashboard(folder: Path) -> Iterator[str]:
    port = free_port()
    command = [
        sys.executable,
        "-m",
        "railsearch",
        "dashboard",
        str(folder),
        "--port",
        str(port),
    ]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        wait_for(f"http://127.0.0.1:{port}/dashboard/", process)
        yield f"http://127.0.0.1:{port}/dashboard"
    finally:
        process.kill()
        process.wait()


def seen(url: str, folder: Path) -> str:
    """The page as Chromium renders it; a screenshot is left beside it."""
    picture = folder / "page.png"
    picture.unlink(missing_ok=True)
    words = ["chromium", *QUIET, f"--user-data-dir={folder / 'profile'}", f"--screenshot={picture}", "--dump-dom", url]
    page = subprocess.run(words, check=True, capture_output=True, text=True, timeout=120).stdout
    assert picture.stat().st_size > 20_000, "the page is not blank"
    return page


@pytest.mark.xdist_group("dashboard")
def test_a_run_with_failures_is_shown_whole(
    railsearch: Callable[..., Answer], install: Callable[..., None], tmp_path: Path
) -> None:
    install(samples=sample_problems)
    words = ("run", "troubled", "--strategy", "random", "--budget", 25, "--seed", 3, "--timeout", 0.4)
    assert railsearch(*words, "--out", tmp_path / "run").code == 0
    for base in dashboard(tmp_path / "run"):
        assert "sphere (distance) / random / seed 3" in seen(f"{base}/", tmp_path)
        note = seen(f"{base}/studies/1/note", tmp_path)
        for word in ("stiffness", "MN/m", "railsearch run troubled", "random", "25 evaluations", "squared distance"):
            assert word in note, word
        table = seen(f"{base}/studies/1/smartSelection", tmp_path)
        for word in ("origin", "trajectory", "norm", "given", "random", "no ballast", "Fail", "Complete"):
            assert word in table, word
        assert "distance" in seen(f"{base}/studies/1", tmp_path)


@pytest.mark.xdist_group("dashboard")
def test_two_objectives_are_named(railsearch: Callable[..., Answer], install: Callable[..., None], tmp_path: Path) -> None:
    install(samples=sample_problems)
    words = ("run", "two", "--strategy", "nsga2", "--budget", 24, "--seed", 1)
    assert railsearch(*words, "--out", tmp_path / "run").code == 0
    for base in dashboard(tmp_path / "run"):
        table = seen(f"{base}/studies/1/smartSelection", tmp_path)
        for word in ("left", "right", "comfort", "offspring"):
            assert word in table, word


@pytest.mark.xdist_group("dashboard")
def test_the_cells_of_a_campaign_are_told_apart(railsearch: Callable[..., Answer], tmp_path: Path) -> None:
    file = tmp_path / "trial.toml"
    file.write_text(
        "[campaign]\nbudget = 12\nrepetitions = 2\nseed = 1\n"
        'strategies = ["random", "nsga2"]\nproblems = ["ackley", "rastrigin"]\n'
    )
    assert railsearch("campaign", file, "--out", tmp_path / "out").code == 0
    for base in dashboard(tmp_path / "out"):
        listed = seen(f"{base}/", tmp_path)
        for problem in ("ackley", "rastrigin"):
            for strategy in ("random", "nsga2"):
                assert f"trial/{problem}/{strategy}/2" in listed
        note = seen(f"{base}/studies/1/note", tmp_path)
        for word in ("Campaign", "trial", "repetition 1", "initial design", "12 evaluations"):
            assert word in note, word
