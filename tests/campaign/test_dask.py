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
from railsearch.dask_cluster import DaskCluster
from railsearch.dask_simulation import dask_simulators
from railsearch.errors import InputError
from railsearch.interfaces import Evaluation
from railsearch.plugin_manager import load_plugins
from railsearch.run import RunSettings, run_search

# A worker that dies loses what it has under way; a connection that breaks on a busy machine loses what all have.
N_WORKERS = 3

pytestmark = pytest.mark.usefixtures("sample_plugin")


class Cluster:
    """A scheduler and its workers as processes of their own."""

    def __init__(self) -> None:
        self.port = free_port()
        self.scheduler = self._program("dask_scheduler", "--host", "127.0.0.1", "--port", str(self.port))
        self.workers: list[subprocess.Popen[bytes]] = []

    @property
    def address(self) -> str:
        return f"tcp://127.0.0.1:{self.port}"

    def worker(self) -> "subprocess.Popen[bytes]":
        return self._program("dask_worker", self.address, "--nthreads", "1", "--no-nanny", "--death-timeout", "60")

    def fill(self) -> None:
        """Start workers in place of those that died, and wait for all of them."""
        self.workers = [process for process in self.workers if process.poll() is None]
        self.workers += [self.worker() for _ in range(N_WORKERS - len(self.workers))]
        wait_until(self._filled, 60.0)

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

    def _filled(self) -> bool:
        try:
            with closing(DaskCluster(self.address, connect_seconds=1.0)) as client:
                return sum(client.threads().values()) == N_WORKERS
        except InputError:
            return False

    def _program(self, name: str, *words: str) -> "subprocess.Popen[bytes]":
        line = [sys.executable, "-m", f"distributed.cli.{name}", *words, "--no-dashboard"]
        return subprocess.Popen(line, env=environment(), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


@pytest.fixture(scope="module")
def processes() -> Iterator[Cluster]:
    made = Cluster()
    yield made
    made.close()


@pytest.fixture
def cluster(processes: Cluster) -> Cluster:
    """The cluster with all its workers, which have outlived another test or not."""
    processes.fill()
    return processes


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

    assert trial.carry_out(places=DaskPlaces(DaskCluster(cluster.address)), watcher=Watcher(evaluation=disturb)) == {}
    assert len(events) == 2
    assert serial.carry_out() == {}
    found, expected = trial.found(), serial.found()
    assert found == expected
    assert any("time limit" in reason for rows in found.values() for *_, reason in rows)
    assert trial.evaluations <= len(trial.calls) <= trial.evaluations + 2 * N_WORKERS


def test_a_worker_that_dies_is_noticed_while_the_others_go_on(cluster: Cluster, tmp_path: Path) -> None:
    """Its last request would wait for it for ever."""
    trial, killed = Trial(tmp_path, repetitions=2, seconds=0.05), []

    def kill(task: object, evaluation: object) -> None:
        if len(trial.calls) > 20 and not killed:
            killed.append(cluster.workers[0])
            cluster.workers[0].kill()

    trial.carry_out(places=DaskPlaces(DaskCluster(cluster.address)), watcher=Watcher(evaluation=kill))
    assert killed
    assert {len(rows) for rows in trial.found().values()} == {trial.budget}
    assert len(trial.calls) <= trial.evaluations + N_WORKERS


def test_a_batch_of_one_run_is_evaluated_by_the_workers_although_one_dies(cluster: Cluster, tmp_path: Path) -> None:
    from sample_plugin import Behaviour, Journalled

    problem = Journalled(Behaviour(str(tmp_path / "journal"), seconds=0.05))
    settings = RunSettings("ga", 40, 1, batch_size=6)
    journal = tmp_path / "journal"

    def kill(evaluation: Evaluation) -> None:
        if evaluation.number == 14:
            cluster.workers[1].kill()

    with closing(DaskCluster(cluster.address)) as client:
        simulating = dask_simulators(client, problem, None, 6)
        spread = run_search(load_plugins(), problem, settings, watch=kill, simulating=simulating)
    calls = journal.read_text().splitlines()
    alone = run_search(load_plugins(), Journalled(Behaviour()), settings)
    assert [e.design.tobytes() for e in spread.evaluations] == [e.design.tobytes() for e in alone.evaluations]
    assert [e.objectives for e in spread.evaluations] == [e.objectives for e in alone.evaluations]
    assert len({line.split()[0] for line in calls}) == N_WORKERS
    assert 40 <= len(calls) <= 40 + N_WORKERS


def test_an_address_without_a_scheduler_is_refused() -> None:
    with pytest.raises(InputError, match=r"--dask: no scheduler answers at tcp://127.0.0.1"):
        DaskCluster(f"tcp://127.0.0.1:{free_port()}", connect_seconds=1.0)


def test_a_cluster_that_stays_without_workers_ends_the_waiting(cluster: Cluster, tmp_path: Path) -> None:
    for worker in cluster.workers:
        worker.kill()
        worker.wait()
    trial, told = Trial(tmp_path), []
    with pytest.raises(InputError, match=r"no worker at tcp://.* for 0.5 s.*All finished evaluations are stored"):
        trial.carry_out(places=DaskPlaces(DaskCluster(cluster.address, patience=0.5, notify=told.append)))
    assert "has no workers" in told[0]
