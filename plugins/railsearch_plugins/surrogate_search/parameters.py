"""What surrogate searches share that perturb good designs by steps of all sizes at once."""

from dataclasses import dataclass

from railsearch.interfaces import parameter
from railsearch_plugins.metric_search.parameters import SurrogateSearchParameters


@dataclass(frozen=True)
class MultiscaleParameters(SurrogateSearchParameters):
    """The sizes and the number of the perturbations."""

    maximum_candidates: int = parameter(
        2000, meaning="upper limit of the number of candidates", source="own choice", minimum=2
    )
    sigma: float = parameter(
        0.2,
        meaning="largest standard deviation of a perturbation, as a fraction of the range of a variable",
        source="Regis & Shoemaker 2013",
        above=0.0,
        maximum=1.0,
    )
    sigma_halvings: int = parameter(
        5,
        meaning="how often it is halved at most, perturbations being of all the sizes between",
        source="own choice",
        minimum=0,
        maximum=50,
    )
