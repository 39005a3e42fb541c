"""The strategies of the peers benchmark, installed for tests, and a peer that is none."""

import sys
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from railsearch_peers import conversation, peer

from railsearch.plugin_manager import Registry, load_plugins

HERE = Path(__file__).resolve().parent
PEERS = HERE.parent.parent / "benchmarks" / "peers"


@pytest.fixture
def registry(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> Registry:
    """All plugins, those of the distribution in benchmarks/peers among them, which is installed for one test."""
    project = tomllib.loads((PEERS / "pyproject.toml").read_text())["project"]
    folder = tmp_path_factory.mktemp("site") / f"railsearch_peers-{project['version']}.dist-info"
    folder.mkdir()
    (folder / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: {project['version']}\n")
    points = project["entry-points"]["railsearch"]
    (folder / "entry_points.txt").write_text("\n".join(["[railsearch]", *(f"{k} = {v}" for k, v in points.items())]))
    monkeypatch.syspath_prepend(str(folder.parent))
    return load_plugins()


@pytest.fixture
def fake_peer(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[], int]]:
    """Every peer is the fake client, in this interpreter; how many processes of it have been started."""
    started = []

    def start(command: list[str]) -> conversation.Conversation:
        started.append(command)
        return conversation.started(command)

    monkeypatch.setenv("PYTHONPATH", str(HERE / "fake_clients"))
    monkeypatch.setattr(peer, "peer_command", lambda name: [sys.executable, str(conversation.CLIENTS / "serve.py"), name])
    monkeypatch.setattr(peer, "started", start)
    yield lambda: len(started)
    while conversation.idle("fake_client"):
        conversation.idle("fake_client").pop().end()


@pytest.fixture
def settings() -> Callable[..., dict[str, object]]:
    """Settings of the strategy `peer` for an algorithm of the fake client."""

    def made(algorithm: str, patience: float = 60.0) -> dict[str, object]:
        return {"peer": "fake_client", "version": np.__version__, "algorithm": algorithm, "patience": patience}

    return made
