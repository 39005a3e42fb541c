"""Strategy `lmsrs`: local metric stochastic response surface search (Regis and Shoemaker 2007)."""

from railsearch.hookspecs import Register, hookimpl
from railsearch.interfaces import Capabilities
from railsearch_plugins.metric_search.parameters import MetricSearchParameters
from railsearch_plugins.metric_search.search import MetricSearch
from railsearch_plugins.metric_search.trajectory import Trajectory


class LocalMetricSearch(MetricSearch):
    """Surrogate search that perturbs every coordinate of the incumbent."""

    Parameters = MetricSearchParameters
    capabilities = Capabilities(integers=True, batch=True)

    def _probability(self, trajectory: Trajectory) -> float:
        return 1.0


@hookimpl
def railsearch_strategies(register: Register) -> None:
    """Register `lmsrs`."""
    register("lmsrs", LocalMetricSearch)
