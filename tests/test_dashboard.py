"""Runs and campaigns seen in Optuna's dashboard, by headless Chromium."""

import subprocess
import sys
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import pytest

from browser import Browser, browsing
from command_line import Answer
from postgresql_server import free_port
from test_cli import sample_problems

pytestmark = pytest.mark.system
WITHIN = 60.0


def wait_for(url: str, process: subprocess.Popen[bytes]) -> None:
    for _ in range(300):
        assert process.poll() is None, "the dashboard ended"
        try:
            urllib.request.urlopen(url, timeout=5).close()
            return
        except (urllib.error.URLError, OSError):
            time.sleep(0.1)
    raise AssertionError("the dashboard does not answer")


@contextmanager
def dashboard(folder: Path) -> Iterator[str]:
    """The address of the dashboard of a run or a campaign, in a process of its own."""
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


def check_seen(browser: Browser, picture: Path, url: str, *words: str) -> None:
    """Check that a page comes to show these words; a picture of it is left."""
    browser.open(url, 1400, 2400)
    end, missing = time.monotonic() + WITHIN, list(words)
    while missing and time.monotonic() < end:
        text = browser.value("document.documentElement.outerHTML")
        missing = [word for word in missing if word not in text]
        time.sleep(0.1)
    assert not missing, f"{url} does not show {missing}"
    browser.screenshot(picture)
    assert picture.stat().st_size > 20_000, "the page is blank"


def test_a_run_with_failures_is_shown_whole(
    railsearch: Callable[..., Answer], install: Callable[..., None], tmp_path: Path
) -> None:
    install(samples=sample_problems)
    words = ("run", "troubled", "--strategy", "random", "--budget", 25, "--seed", 3, "--timeout", 0.4)
    assert railsearch(*words, "--out", tmp_path / "run").code == 0
    with dashboard(tmp_path / "run") as base, browsing(tmp_path / "profile") as browser:
        seen = partial(check_seen, browser, tmp_path / "page.png")
        seen(f"{base}/", "sphere (distance) / random / seed 3")
        told = ("stiffness", "MN/m", "railsearch run troubled", "random", "25 evaluations", "squared distance")
        seen(f"{base}/studies/1/note", *told)
        table = ("origin", "trajectory", "norm", "given", "random", "no ballast", "Fail", "Complete")
        seen(f"{base}/studies/1/smartSelection", *table)
        seen(f"{base}/studies/1", "distance")


def test_two_objectives_are_named(railsearch: Callable[..., Answer], install: Callable[..., None], tmp_path: Path) -> None:
    install(samples=sample_problems)
    words = ("run", "two", "--strategy", "nsga2", "--budget", 24, "--seed", 1)
    assert railsearch(*words, "--out", tmp_path / "run").code == 0
    with dashboard(tmp_path / "run") as base, browsing(tmp_path / "profile") as browser:
        table = ("left", "right", "comfort", "offspring")
        check_seen(browser, tmp_path / "page.png", f"{base}/studies/1/smartSelection", *table)


def test_the_cells_of_a_campaign_are_told_apart(railsearch: Callable[..., Answer], tmp_path: Path) -> None:
    file = tmp_path / "trial.toml"
    file.write_text(
        "[campaign]\nbudget = 12\nrepetitions = 2\nseed = 1\n"
        'strategies = ["random", "nsga2"]\nproblems = ["ackley", "rastrigin"]\n'
    )
    assert railsearch("campaign", file, "--out", tmp_path / "out").code == 0
    with dashboard(tmp_path / "out") as base, browsing(tmp_path / "profile") as browser:
        seen = partial(check_seen, browser, tmp_path / "page.png")
        cells = [f"trial/{problem}/{name}/2" for problem in ("ackley", "rastrigin") for name in ("random", "nsga2")]
        seen(f"{base}/", *cells)
        seen(f"{base}/studies/1/note", "Campaign", "trial", "repetition 1", "initial design", "12 evaluations")
