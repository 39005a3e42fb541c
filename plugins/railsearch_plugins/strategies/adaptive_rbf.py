"""Strategy `adaptive-rbf`: DYCORS on a transformed objective, with expected improvement in turn."""

from dataclasses import dataclass

from railsearch.hookspecs import Register, hookimpl
from railsearch.interfaces import Capabilities, parameter
from railsearch_plugins.metric_search.adaptive_search import (
    IMPROVEMENT,
    MERIT,
    AdaptiveSearch,
    AdaptiveSearchParameters,
)


@dataclass(frozen=True)
class AdaptiveInterpolantParameters(AdaptiveSearchParameters):
    """What can be set of the search."""

    weights: tuple[float, ...] = parameter(
        (0.3, 0.8),
        meaning="cycle of the weight of the surrogate value in the merit; the rest is the weight of the distance",
        source="own study of 45 variants",
        minimum=0.0,
        maximum=1.0,
    )
    cycle: tuple[str, ...] = parameter(
        (MERIT, IMPROVEMENT),
        meaning="what designs are chosen by in turn: expected improvement, or merit with the next of the weights",
        source="own study of 45 variants",
        choices=(IMPROVEMENT, MERIT),
    )
    transforms: tuple[str, ...] = parameter(
        ("copula", "logarithm", "identity"),
        meaning="transforms of the objective, chosen among by leave-one-out; the first one to begin with",
        source="own study of 45 variants",
    )
    adapt_length_scales: bool = parameter(
        True, meaning="adapt the surrogate's length scales by leave-one-out residuals", source="own study of 45 variants"
    )
    mixed_perturbations: bool = parameter(
        False,
        meaning="perturb by several step sizes and numbers of coordinates at once; otherwise as dycors",
        source="own choice",
    )
    tree_search: bool = parameter(
        False, meaning="in problems with integers, enrich the candidates by branch and bound over the surrogate"
    )


class AdaptiveInterpolantSearch(AdaptiveSearch):
    """DYCORS whose interpolant chooses its transform of the objective, with merit and expected improvement in turn."""

    Parameters = AdaptiveInterpolantParameters
    capabilities = Capabilities(integers=True, batch=True)


@hookimpl
def railsearch_strategies(register: Register) -> None:
    """Register `adaptive-rbf`."""
    register("adaptive-rbf", AdaptiveInterpolantSearch)
