"""Fixtures that several test modules share."""

import importlib.metadata
import os
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings
from threadpoolctl import threadpool_limits

from command_line import Answer
from railsearch.cli import main

# Tests run in several processes side by side: more threads than processors wait for each other more than they calculate.
# The variables are for libraries that are loaded later and for processes that are started from here.
threadpool_limits(1)
os.environ.update(dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1"))

settings.register_profile("repeatable", derandomize=True, deadline=None)
settings.load_profile("repeatable")


@pytest.fixture
def railsearch(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Callable[..., Answer]:
    """Run a command line in this process."""
    monkeypatch.setenv("COLUMNS", "200")

    def run(*words: object) -> Answer:
        monkeypatch.setattr(sys, "argv", ["railsearch", *map(str, words)])
        capsys.readouterr()
        with pytest.raises(SystemExit) as ended:
            main()
        out, err = capsys.readouterr()
        return Answer(ended.value.code or 0, out, err)

    return run


@dataclass
class InstalledDistribution:
    """Stands for an installed distribution."""

    metadata: dict[str, str]
    version: str = "1.2"


@dataclass
class InstalledPoint:
    """Stands for an entry point whose module is made on the spot."""

    distribution: str
    load: Callable[[], Any]
    name: str = "plugin"

    @property
    def value(self) -> str:
        """Where the plugin would be."""
        return f"{self.distribution}_module"

    @property
    def dist(self) -> InstalledDistribution:
        """The distribution that it would belong to."""
        return InstalledDistribution({"Name": self.distribution})


@pytest.fixture
def install(monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """Pretend that distributions are installed: install(acme=function that returns the plugin module)."""

    def installed(**loaders: Callable[[], Any]) -> None:
        points = [InstalledPoint(name, load) for name, load in loaders.items()]
        real = importlib.metadata.entry_points

        def entry_points(**selection: str) -> Any:
            return points if selection == {"group": "railsearch"} else real(**selection)

        monkeypatch.setattr(importlib.metadata, "entry_points", entry_points)

    return installed


@pytest.fixture
def sample_plugin(monkeypatch: pytest.MonkeyPatch) -> None:
    """Install the sample plugin here and in the processes that are started from here."""
    distribution = str(Path(__file__).parent / "sample_distribution")
    monkeypatch.syspath_prepend(distribution)
    monkeypatch.setenv("PYTHONPATH", distribution)
