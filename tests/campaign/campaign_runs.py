"""Campaigns that are really carried out in tests: on a journalled problem, in processes that know the sample plugin."""

import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from railsearch.campaign.cells import Campaign, Cell
from railsearch.campaign.coordinator import Coordinator, Watcher
from railsearch.campaign.definition import load_campaign
from railsearch.campaign.places import Places, places_here
from railsearch.campaign.problems import make_problems
from railsearch.campaign.reading import read_campaign
from railsearch.campaign.tasks import cell_tasks
from railsearch.plugin_manager import load_plugins
from railsearch.storage import Patience, Storage, claims_of

DISTRIBUTION = Path(__file__).parent.parent / "sample_distribution"

Key = tuple[str, str, int]


@dataclass(frozen=True)
class Trial:
    """A campaign of the journalled problem in a folder of its own; `text` overrides [campaign]."""

    folder: Path
    strategies: tuple[str, ...] = ("dycors", "random")
    repetitions: int = 2
    budget: int = 25
    seconds: float = 0.0
    fault: str = ""
    timeout: float | None = None

    @property
    def journal(self) -> Path:
        return self.folder / "journal"

    @property
    def calls(self) -> list[str]:
        return self.journal.read_text().splitlines() if self.journal.exists() else []

    @property
    def evaluations(self) -> int:
        return len(self.strategies) * self.repetitions * self.budget

    @property
    def url(self) -> str:
        return f"sqlite:///{self.folder / 'study.db'}"

    def file(self) -> Path:
        self.folder.mkdir(parents=True, exist_ok=True)
        path = self.folder / "campaign.toml"
        limit = "" if self.timeout is None else f"timeout = {self.timeout}"
        path.write_text(f"""
[campaign]
name = "trial"
budget = {self.budget}
repetitions = {self.repetitions}
seed = 3
strategies = {list(self.strategies)}
{limit}
[[problem]]
name = "journalled"
sections = {{ behaviour = {{ journal = "{self.journal}", seconds = {self.seconds}, fault = "{self.fault}" }} }}
""")
        return path

    def campaign(self) -> Campaign:
        return load_campaign(load_plugins(), self.file())

    @contextmanager
    def coordinator(
        self, url: str | None = None, watcher: Watcher | None = None, patience: Patience | None = None
    ) -> Iterator[Coordinator]:
        """A coordinator of all cells, recording at `url` or in the folder."""
        registry, campaign, where = load_plugins(), self.campaign(), url or self.url
        tasks = cell_tasks(registry, campaign, make_problems(registry, campaign), campaign.cells(), "")
        with closing(Storage(where, patience or Patience(60.0), claims_of(where))) as storage:
            yield Coordinator(storage, tasks, campaign.timeout, watcher=watcher)

    def carry_out(
        self,
        workers: int = 1,
        places: Places | None = None,
        url: str | None = None,
        watcher: Watcher | None = None,
    ) -> dict[Cell, str]:
        """Carry the campaign out; the cells that failed."""
        with self.coordinator(url, watcher) as coordinator:
            coordinator.carry_out(places or self.places(workers))
        return coordinator.failed

    def places(self, workers: int = 1) -> Places:
        """This process, or several others."""
        return places_here(load_plugins(), workers)

    def found(self, url: str | None = None) -> dict[Key, list[tuple[bytes, float, str, str]]]:
        """Every evaluation of every cell: design, value, origin and reason, without the times."""
        gathered = read_campaign(load_plugins(), url or self.url, self.campaign())
        return {
            (cell.problem, cell.strategy, cell.repetition): [
                (design.tobytes(), float(np.nan_to_num(value, nan=-1.0)), origin, reason)
                for design, (value,), origin, reason in zip(
                    record.designs, record.objectives, record.origins, record.reasons, strict=True
                )
            ]
            for cell, record in gathered.records.items()
        }


def command(*words: object) -> subprocess.Popen[str]:
    """A railsearch command in a process that knows the sample plugin."""
    return subprocess.Popen(
        [sys.executable, "-m", "railsearch", *map(str, words)],
        env=environment(),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def environment() -> dict[str, str]:
    """This process's environment, the sample plugin installed."""
    path = os.pathsep.join([str(DISTRIBUTION), os.environ.get("PYTHONPATH", "")]).rstrip(os.pathsep)
    return {**os.environ, "PYTHONPATH": path, "COLUMNS": "200"}


def wait_until(condition: Callable[[], bool], seconds: float = 120.0) -> None:
    """Wait for a condition. Raises TimeoutError."""
    deadline = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > deadline:
            raise TimeoutError(f"waited {seconds:g} s in vain")
        time.sleep(0.02)
