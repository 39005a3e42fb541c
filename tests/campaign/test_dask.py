"""A campaign in a Dask cluster on the loopback: a worker dies, an evaluation hangs, the scheduler is started again."""

import subprocess
import sys
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest
from campaign_runs import Trial, environment, wait_until

from postgresql_server import free_port
from railsearch.campaign.coordinator import Watcher
from railsearch.campaign.dask_places import DaskPlaces
from railsearch.errors import InputError

pytestmark = [pytest.mark.usefixtures("sample_plugin"), pytest.mark.xdist_group("campaign processes")]


class Cluster:
    """A scheduler and its workers as processes of their own."""

    def __init__(self) -> None:
        self.port = free_port()
        self.scheduler = self._program("dask_scheduler", "--host", "127.0.0.1", "--port", str(self.port))
        self.workers = [self.worker() for _ in range(3)]

    @property
    def address(self) -> str:
        return f"tcp://127.0.0.1:{self.port}"

    def worker(self) -> "subprocess.Popen[bytes]":
        return self._program("dask_worker", self.address, "--nthreads", "1", "--no-nanny", "--death-timeout", "60")

    def restart_scheduler(self) -> None:
        """Kill the scheduler; its workers end with it, as Dask's do; start both again."""
        self.scheduler.kill()
        self.scheduler.wait()
        self.scheduler = self._program("dask_scheduler", "--host", "127.0.0.1", "--port", str(self.port))
        self.workers += [self.worker() for _ in range(2)]

    def close(self) -> None:
        for process in (*self.workers, self.scheduler):
            process.kill()
            process.wait()

    def _program(self, name: str, *words: str) -> "subprocess.Popen[bytes]":
        line = [sys.executable, "-m", f"distributed.cli.{name}", *words, "--no-dashboard"]
        return subprocess.Popen(line, env=environment(), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


@pytest.fixture
def cluster() -> Iterator[Cluster]:
    made = Cluster()
    yield made
    made.close()


def test_the_campaign_ends_complete_and_equal_to_the_serial_one_whatever_dies(cluster: Cluster, tmp_path: Path) -> None:
    trial = Trial(tmp_path / "dask", repetitions=3, seconds=0.03, fault="hang", timeout=1.0)
    serial = Trial(tmp_path / "serial", repetitions=3, fault="hang", timeout=1.0)
    events: list[str] = []

    def disturb(task: object, evaluation: object) -> None:
        if len(trial.calls) > 30 and not events:
            events.append("worker killed")
            cluster.workers[0].kill()
        elif len(trial.calls) > 70 and len(events) == 1:
            events.append("scheduler started again")
            cluster.restart_scheduler()

    wait_until(lambda: _reached(cluster), 60.0)
    assert trial.carry_out(places=DaskPlaces(cluster.address), watcher=Watcher(evaluation=disturb)) == {}
    assert len(events) == 2
    assert serial.carry_out() == {}
    found, expected = trial.found(), serial.found()
    assert found == expected
    assert any("time limit" in reason for rows in found.values() for *_, reason in rows)
    under_way = 1 + 2
    assert trial.evaluations <= len(trial.calls) <= trial.evaluations + under_way


def test_an_address_without_a_scheduler_is_refused() -> None:
    with pytest.raises(InputError, match=r"--dask: no scheduler answers at tcp://127.0.0.1"):
        DaskPlaces(f"tcp://127.0.0.1:{free_port()}", connect_seconds=1.0)


def test_a_cluster_that_stays_without_workers_ends_the_waiting(cluster: Cluster, tmp_path: Path) -> None:
    wait_until(lambda: _reached(cluster), 60.0)
    for worker in cluster.workers:
        worker.kill()
        worker.wait()
    trial, told = Trial(tmp_path), []
    with pytest.raises(InputError, match=r"no worker at tcp://.* for 0.5 s.*All finished evaluations are stored"):
        trial.carry_out(places=DaskPlaces(cluster.address, patience=0.5, notify=told.append))
    assert "has no workers" in told[0]


def _reached(cluster: Cluster) -> bool:
    try:
        with closing(DaskPlaces(cluster.address, connect_seconds=1.0)) as places:
            return len(places.present()) == 3
    except InputError:
        return False
