"""Strategy `lmsrs`: local metric stochastic response surface search (Regis and Shoemaker 2007)."""

from collections.abc import Sequence

from railsearch.hookspecs import Register, hookimpl
from railsearch.interfaces import Capabilities, Evaluation, Proposal, SearchContext
from railsearch_plugins.metric_search.parameters import MetricSearchParameters
from railsearch_plugins.metric_search.search import MetricSearch


class LocalMetricSearch:
    """Surrogate search that perturbs every coordinate of the incumbent."""

    Parameters = MetricSearchParameters
    capabilities = Capabilities(integers=True, batch=True)

    def __init__(self, context: SearchContext, parameters: MetricSearchParameters) -> None:
        self._search = MetricSearch(context, parameters, lambda trajectory: 1.0)

    @property
    def minimum_budget(self) -> int:
        """The size of the initial design."""
        return self._search.minimum_budget

    def ask(self) -> Sequence[Proposal]:
        """Designs of origin `initial`, then `perturbation` or `tree-search`."""
        return self._search.ask()

    def tell(self, evaluations: Sequence[Evaluation]) -> None:
        """Take in evaluations in their order."""
        self._search.tell(evaluations)


@hookimpl
def railsearch_strategies(register: Register) -> None:
    """Register `lmsrs`."""
    register("lmsrs", LocalMetricSearch)
