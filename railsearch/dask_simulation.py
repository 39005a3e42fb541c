"""Simulations in a Dask cluster, for the batches of one run."""

import functools
import pickle
import threading

from railsearch.dask_cluster import LOOK_AGAIN, ClusterLost, DaskCluster
from railsearch.design_problem import DesignProblem
from railsearch.errors import InputError
from railsearch.simulation import InProcess, SeparateProcess, Simulated, Simulator, Simulators
from railsearch.space import FloatArray


class DaskSimulator:
    """Simulates at any free worker; a design whose worker or scheduler went away is simulated again elsewhere."""

    def __init__(self, cluster: DaskCluster, problem: bytes, timeout: float | None) -> None:
        self._cluster = cluster
        self._problem = problem
        self._timeout = timeout
        self._closing = threading.Event()

    def warm_up(self) -> None:
        """The workers warm themselves up with their first design."""

    def simulate(self, design: FloatArray) -> Simulated:
        """Simulate a design (d,). There is no outcome if it killed worker after worker, or railsearch is not there."""
        while True:
            try:
                simulated: Simulated = self._cluster.call(simulate_here, [self._problem, self._timeout, design])
                return simulated
            except ClusterLost as lost:
                if self._closing.wait(LOOK_AGAIN):
                    return Simulated(str(lost), 0.0)
                self._cluster.threads()
            except Exception as error:  # noqa: BLE001 - whatever the worker raises is a failed evaluation
                return Simulated(f"{type(error).__name__}: {error}", 0.0)

    def close(self) -> None:
        """Wait for the cluster no longer."""
        self._closing.set()


def dask_simulators(cluster: DaskCluster, problem: DesignProblem, timeout: float | None, at_a_time: int) -> Simulators:
    """Simulators in a cluster for `at_a_time` designs. Raises InputError for a problem that cannot travel."""
    try:
        pickled = pickle.dumps(problem)
    except (AttributeError, TypeError, pickle.PicklingError) as error:
        raise InputError(f"--dask: the problem cannot travel to the workers ({error})") from None
    return Simulators([DaskSimulator(cluster, pickled, timeout) for _ in range(at_a_time)])


def simulate_here(problem: bytes, timeout: float | None, design: FloatArray) -> Simulated:
    """Simulate a design (d,) of a pickled problem in this worker."""
    return _simulator(problem, timeout, threading.get_ident()).simulate(design)


@functools.lru_cache(maxsize=8)
def _simulator(problem: bytes, timeout: float | None, thread: int) -> Simulator:
    made: DesignProblem = pickle.loads(problem)
    simulator = InProcess(made) if timeout is None else SeparateProcess(made, timeout)
    simulator.warm_up()
    return simulator
