"""How long Optuna's dashboard takes to show a campaign of hundreds of studies, in headless Chromium.

    python benchmarks/dashboard_loading.py [--cells 450] [--evaluations 200] [--repeats 3]

A synthetic campaign of three problems is written into an SQLite file (one problem has two objectives). Each repeat begins
with a fresh Chromium. A page is there when what it is opened for is in it: the names of all studies, the plots of a study.
Chromium, with its own sandbox off, and optuna-dashboard run on this machine.
"""

import argparse
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

import optuna
from measuring import seconds, spread, yardstick
from synthetic_campaign import STRATEGIES, synthetic_campaign, write_campaign

from browser import Browser, browsing
from postgresql_server import free_port

PROBLEMS = ("rastrigin", "two-spheres", "ackley")
PATIENCE = 120.0
STEP = len(PROBLEMS) * len(STRATEGIES)
SERVER = (
    "import sys; from optuna_dashboard import run_server; run_server(sys.argv[1], host='127.0.0.1', port=int(sys.argv[2]))"
)
SEARCH = "document.querySelector('input[placeholder=\"Search study\"]')"
PLOTS = "document.querySelectorAll('.js-plotly-plot .main-svg').length > 0"


def names(count: int) -> str:
    return f"(document.body.innerText.match(/synthetic\\//g) || []).length === {count}"


@contextmanager
def dashboard(url: str) -> Iterator[str]:
    port = free_port()
    process = subprocess.Popen(
        [sys.executable, "-c", SERVER, url, str(port)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    try:
        base = f"http://127.0.0.1:{port}"
        while process.poll() is None:
            try:
                urllib.request.urlopen(f"{base}/api/meta").close()
                break
            except urllib.error.URLError:
                time.sleep(0.1)
        yield base
    finally:
        process.kill()
        process.wait()


def wait(browser: Browser, condition: str) -> None:
    """Wait until the page, which may be in between two documents, has something."""
    end = time.monotonic() + PATIENCE
    while not browser.value(f"!!document.body && {condition}"):
        if time.monotonic() > end:
            raise TimeoutError(f"not in the page after {PATIENCE:g} s: {condition}")
        time.sleep(0.01)


def opened(browser: Browser, url: str, condition: str) -> float:
    def visit() -> None:
        browser.call("Page.navigate", url=url)
        wait(browser, condition)

    return seconds(visit)


def searched(browser: Browser, text: str, found: int) -> float:
    browser.value(f"{SEARCH}.focus()")

    def search() -> None:
        browser.call("Input.insertText", text=text)
        wait(browser, names(found))

    return seconds(search)


def visit(base: str, studies: int) -> dict[str, float]:
    """Seconds of one visit to every page, by what it shows."""
    repetitions = studies // STEP
    compared = ",".join(str(1 + STEP * repetition) for repetition in range(min(15, repetitions)))
    with tempfile.TemporaryDirectory() as profile, browsing(Path(profile)) as browser:
        return {
            "list of studies, first visit": opened(browser, f"{base}/dashboard/", names(studies)),
            "list of studies, again": opened(browser, f"{base}/dashboard/", names(studies)),
            "searched for a problem and strategy": searched(browser, "two-spheres dycors", repetitions),
            "a study of one objective": opened(browser, f"{base}/dashboard/studies/1", PLOTS),
            "a study of two objectives": opened(browser, f"{base}/dashboard/studies/{1 + len(STRATEGIES)}", PLOTS),
            "15 repetitions compared": opened(browser, f"{base}/dashboard/compare-studies?ids={compared}", PLOTS),
            "memory of the page, MB": browser.value("performance.memory.usedJSHeapSize") / 1e6,
        }


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--cells", type=int, default=450)
    arguments.add_argument("--evaluations", type=int, default=200)
    arguments.add_argument("--repeats", type=int, default=3)
    asked = arguments.parse_args()
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    campaign = synthetic_campaign(PROBLEMS, asked.cells, asked.evaluations)
    studies = len(list(campaign.cells()))
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "study.db"
        write_campaign(f"sqlite:///{file}", campaign)
        print(f"{studies} studies of {asked.evaluations} trials, {file.stat().st_size / 1e6:.0f} MB")
        with dashboard(f"sqlite:///{file}") as base:
            report(base, studies, asked.repeats)


def report(base: str, studies: int, repeats: int) -> None:
    noise, answers, visits = [], [], []
    for _ in range(repeats):
        noise.append(seconds(yardstick))
        answers.append(seconds(lambda: urllib.request.urlopen(f"{base}/api/studies").read()))
        visits.append(visit(base, studies))
    print(f"{repeats} repeats, s")
    for name in visits[0]:
        print(f"{name}: {spread([visited[name] for visited in visits])}")
    print(f"the server's answer with all studies: {spread(answers)}")
    print(f"noise of the machine, s for fixed arithmetic: {spread(noise)}")


if __name__ == "__main__":
    main()
