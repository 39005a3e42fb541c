"""Strategy `adaptive-kriging`: expected improvement of a Gaussian process among DYCORS' and other perturbations."""

from dataclasses import dataclass

from railsearch.hookspecs import Register, hookimpl
from railsearch.interfaces import Capabilities, parameter
from railsearch_plugins.metric_search.adaptive_search import AdaptiveSearch, AdaptiveSearchParameters


@dataclass(frozen=True)
class AdaptiveKrigingParameters(AdaptiveSearchParameters):
    """What can be set of the search."""

    surrogate: str = parameter("kriging", meaning="name of the registered surrogate, one that has a deviation")
    tree_search: bool = parameter(
        False, meaning="in problems with integers, enrich the candidates by branch and bound over the surrogate"
    )


class AdaptiveKrigingSearch(AdaptiveSearch):
    """Expected improvement of a Gaussian process among perturbations of the incumbent of many sizes, with restarts."""

    Parameters = AdaptiveKrigingParameters
    capabilities = Capabilities(integers=True, batch=True)


@hookimpl
def railsearch_strategies(register: Register) -> None:
    """Register `adaptive-kriging`."""
    register("adaptive-kriging", AdaptiveKrigingSearch)
