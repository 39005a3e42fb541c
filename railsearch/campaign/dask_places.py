"""Places in a Dask cluster: every thread of every worker is one; they come and go with the workers.

A request is pinned to the worker that has the run under way. When that worker leaves, the request is given up and the
cell goes on from its record elsewhere. When the scheduler goes, its client waits for it to come back.
"""

from collections.abc import Sequence

from railsearch.campaign.cell_run import Request, Step, advance
from railsearch.campaign.places import Place, PlaceLost
from railsearch.dask_cluster import ClusterLost, DaskCluster


class DaskPlaces:
    """The threads of the workers of a cluster."""

    def __init__(self, cluster: DaskCluster) -> None:
        self._cluster = cluster
        self._places: dict[str, DaskPlace] = {}

    def present(self) -> Sequence[Place]:
        """One place for every thread of every worker. Raises InputError when there has been none for too long."""
        threads = self._cluster.threads()
        wanted = {f"{worker} thread {k + 1}": worker for worker, count in threads.items() for k in range(count)}
        self._places = {
            name: self._places.get(name) or DaskPlace(name, worker, self._cluster) for name, worker in wanted.items()
        }
        return list(self._places.values())

    def close(self) -> None:
        """Leave the cluster."""
        self._cluster.close()


class DaskPlace:
    """One thread of one worker."""

    def __init__(self, name: str, worker: str, cluster: DaskCluster) -> None:
        self.name = name
        self._worker = worker
        self._cluster = cluster

    def advance(self, request: Request) -> Step:
        """Let the worker carry a run on. Raises PlaceLost when it, or the scheduler, goes away meanwhile."""
        try:
            step: Step = self._cluster.call(advance, [request], self._worker)
        except ClusterLost as lost:
            raise PlaceLost(str(lost)) from None
        except Exception as error:  # noqa: BLE001 - a worker without railsearch or the plugins says so in many ways
            raise PlaceLost(f"worker {self._worker} cannot work ({type(error).__name__}: {error})") from None
        return step

    def close(self) -> None:
        """Nothing is held."""
