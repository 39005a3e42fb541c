"""Strategy `adaptive-kriging`: expected improvement of a Gaussian process among DYCORS' and other perturbations."""

from collections.abc import Mapping
from dataclasses import dataclass

from railsearch.hookspecs import Register, hookimpl
from railsearch.interfaces import Capabilities, Surrogate, parameter
from railsearch_plugins.metric_search.adaptive_search import AdaptiveSearch, AdaptiveSearchParameters
from railsearch_plugins.metric_search.parameters import REGULARISED_MEANING, regularised


@dataclass(frozen=True)
class AdaptiveKrigingParameters(AdaptiveSearchParameters):
    """What can be set of the search."""

    surrogate: str = parameter("kriging", meaning="name of the registered surrogate, one that has a deviation")
    surrogate_settings: dict[str, object] | None = parameter(  # noqa: RUF009 - a field, not a value
        None,
        meaning=f"{REGULARISED_MEANING} if not set",
    )
    interpolant_from: float = parameter(
        0.5,
        meaning="part of the budget after which every other proposal is dycors': of least merit by the interpolant rbf",
        source="own choice: an interpolant follows a funnel that a smooth process takes for noise",
        minimum=0.0,
        maximum=1.0,
    )
    transforms: tuple[str, ...] = parameter(
        ("tail",),
        meaning="transforms of the objective, chosen among by leave-one-out; the first one to begin with",
        source="own study: values far above all others, and they alone, are in the way of a smooth process",
    )
    tree_search: bool = parameter(
        False, meaning="in problems with integers, enrich the candidates by branch and bound over the surrogate"
    )


class AdaptiveKrigingSearch(AdaptiveSearch):
    """Expected improvement of a Gaussian process among perturbations of the incumbent of many sizes, with restarts.

    The process learns values of which those far above all others are compressed (`tail`).
    """

    Parameters = AdaptiveKrigingParameters
    capabilities = Capabilities(integers=True, batch=True)

    def _new_surrogate(self, settings: Mapping[str, object]) -> Surrogate:
        return super()._new_surrogate(regularised(self._parameters.surrogate, settings))


@hookimpl
def railsearch_strategies(register: Register) -> None:
    """Register `adaptive-kriging`."""
    register("adaptive-kriging", AdaptiveKrigingSearch)
