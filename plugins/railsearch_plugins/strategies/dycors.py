"""Strategy `dycors`: dynamic coordinate search with response surface models (Regis and Shoemaker 2013)."""

from railsearch.hookspecs import Register, hookimpl
from railsearch.interfaces import Capabilities, SearchContext
from railsearch_plugins.metric_search.candidates import perturbation_probability
from railsearch_plugins.metric_search.parameters import DynamicCoordinateParameters
from railsearch_plugins.metric_search.search import MetricSearch
from railsearch_plugins.metric_search.trajectory import Trajectory


class DynamicCoordinateSearch(MetricSearch):
    """Surrogate search that perturbs fewer and fewer coordinates of the incumbent as the budget runs out."""

    Parameters = DynamicCoordinateParameters
    capabilities = Capabilities(integers=True, batch=True)

    def __init__(self, context: SearchContext, parameters: DynamicCoordinateParameters) -> None:
        super().__init__(context, parameters)
        self._p_initial = min(parameters.perturbed_coordinates / context.space.dimension, 1.0)

    def _probability(self, trajectory: Trajectory) -> float:
        n_initial = trajectory.initial_size or 0
        return perturbation_probability(trajectory.evaluations, n_initial, trajectory.budget, self._p_initial)


@hookimpl
def railsearch_strategies(register: Register) -> None:
    """Register `dycors`."""
    register("dycors", DynamicCoordinateSearch)
