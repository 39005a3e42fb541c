"""How much faster two processes carry out a campaign than one, for evaluations that keep a core busy for 50 ms and more.

    python benchmarks/campaign_speedup.py [--seconds 0.05] [--workers 2] [--repeats 3]

The same campaign (dycors and random, 8 cells) is carried out by one process and by several, taking turns; the time is that
of the whole command's work on the cells, the start of the processes included.
"""

import argparse
import statistics
import tempfile
import time
from contextlib import closing
from pathlib import Path

from railsearch.campaign.coordinator import Coordinator
from railsearch.campaign.definition import load_campaign
from railsearch.campaign.places import places_here
from railsearch.campaign.problems import make_problems
from railsearch.campaign.tasks import cell_tasks
from railsearch.plugin_manager import load_plugins
from railsearch.storage import Storage, claims_of

FILE = """
[campaign]
budget = {budget}
repetitions = 4
seed = 1
strategies = ["dycors", "random"]
[[problem]]
name = "ackley"
sections = {{ function = {{ seconds = {seconds} }} }}
"""


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--seconds", type=float, default=0.05)
    arguments.add_argument("--budget", type=int, default=100)
    arguments.add_argument("--workers", type=int, default=2)
    arguments.add_argument("--repeats", type=int, default=3)
    asked = arguments.parse_args()
    ratios = []
    for repeat in range(asked.repeats):
        times = [_seconds(asked.seconds, asked.budget, workers) for workers in (1, asked.workers)]
        ratios.append(times[0] / times[1])
        print(f"repeat {repeat + 1}: {times[0]:.1f} s by one, {times[1]:.1f} s by {asked.workers}: {ratios[-1]:.2f}")
    print(f"speed-up: median {statistics.median(ratios):.2f} ({min(ratios):.2f} to {max(ratios):.2f})")


def _seconds(seconds: float, budget: int, workers: int) -> float:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "campaign.toml"
        file.write_text(FILE.format(budget=budget, seconds=seconds))
        registry = load_plugins()
        campaign = load_campaign(registry, file)
        tasks = cell_tasks(registry, campaign, make_problems(registry, campaign), campaign.cells(), "")
        url = f"sqlite:///{folder}/study.db"
        with closing(Storage(url, claims=claims_of(url))) as storage:
            start = time.perf_counter()
            Coordinator(storage, tasks).carry_out(places_here(registry, workers))
            return time.perf_counter() - start


if __name__ == "__main__":
    main()
