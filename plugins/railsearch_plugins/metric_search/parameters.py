"""The numbers of a metric stochastic response surface search."""

from collections.abc import Mapping
from dataclasses import dataclass

from railsearch.errors import InputError
from railsearch.interfaces import parameter

REGULARISED: Mapping[str, Mapping[str, object]] = {
    "kriging": {"length_scale_prior": 0.5, "starts": 2, "reoptimise_every": 5},
}
"""Settings of a surrogate in a search by improvement: few points must not tell variables apart by chance."""

REGULARISED_MEANING = "parameters of the surrogate; kriging has " + ", ".join(
    f"{name} {value}" for name, value in REGULARISED["kriging"].items()
)


def regularised(surrogate: str, settings: Mapping[str, object] | None) -> dict[str, object]:
    """The settings of a registered surrogate in a search by improvement, the given ones taking precedence."""
    return {**REGULARISED.get(surrogate, {}), **(settings or {})}


@dataclass(frozen=True)
class SurrogateSearchParameters:
    """What can be set of every search that begins with an initial design and goes on with surrogates."""

    initial_size: int | None = parameter(
        None,
        meaning="designs before the search proper, the given ones included; if not given, max(20, 2(d + 1))",
        source="level-crossing study, Shang et al. 2023; Regis & Shoemaker 2013",
        minimum=1,
    )
    surrogate_settings: dict[str, object] | None = parameter(  # noqa: RUF009 - a field, not a value
        None, meaning="parameters of the surrogate that differ from its defaults, for instance {kernel = 'thin-plate'}"
    )


@dataclass(frozen=True)
class MetricSearchParameters(SurrogateSearchParameters):
    """What can be set of every strategy that scores candidates by surrogate value and distance."""

    weights: tuple[float, ...] = parameter(
        (0.3, 0.5, 0.8, 0.95),
        meaning="cycle of the weight of the surrogate value in the merit; the rest is the weight of the distance",
        source="Regis & Shoemaker 2013",
        minimum=0.0,
        maximum=1.0,
    )
    candidates_per_dimension: int = parameter(
        100, meaning="candidates per variable", source="Regis & Shoemaker 2013", minimum=1
    )
    maximum_candidates: int = parameter(
        5000, meaning="upper limit of the number of candidates", source="Regis & Shoemaker 2013", minimum=1
    )
    sigma_start: float = parameter(
        0.2,
        meaning="standard deviation of a perturbation at the start, as a fraction of the range of a variable",
        source="Regis & Shoemaker 2013",
        above=0.0,
        maximum=1.0,
    )
    halvings_before_restart: int = parameter(
        6,
        meaning="the search starts afresh when sigma has fallen below sigma_start / 2^halvings",
        source="Regis & Shoemaker 2013",
        minimum=0,
        maximum=50,
    )
    failure_tolerance: int | None = parameter(
        None,
        meaning="failures in a row after which sigma is halved; if not given, max(d, 5)",
        source="Regis & Shoemaker 2013",
        minimum=1,
    )
    success_tolerance: int = parameter(
        3,
        meaning="successes in a row after which sigma is doubled, never above its start",
        source="Regis & Shoemaker 2013",
        minimum=1,
    )
    improvement_threshold: float = parameter(
        1e-3,
        meaning="a success improves on the incumbent by more than this fraction of its absolute value",
        source="Regis & Shoemaker 2007",
        minimum=0.0,
        below=1.0,
    )
    minimum_distance: float = parameter(
        1e-3,
        meaning="nearer than this (unit cube) to an evaluated point nothing is proposed, and nothing joins the surrogate",
        source="own choice: within it the interpolant stays well determined",
        minimum=1e-5,
        below=1.0,
    )
    tree_search: bool = parameter(
        True,
        meaning="in problems with integers, enrich the candidates by branch and bound over the surrogate",
        source="Müller 2016; Holmström 2008",
    )
    tree_search_nodes: int = parameter(
        200, meaning="upper limit of the relaxations solved in one tree search", source="own choice", minimum=1
    )
    tree_search_starts: int = parameter(
        2,
        meaning="points from which each relaxation is minimised, the lowest known in its box",
        source="own choice: a third costs time and gained nothing on analytic functions",
        minimum=1,
    )
    surrogate: str = parameter("rbf", meaning="name of the registered surrogate", source="Regis & Shoemaker 2007")

    def __post_init__(self) -> None:
        if not self.weights:
            raise InputError("weights: one or more numbers from 0 to 1 are needed, received an empty list")


@dataclass(frozen=True)
class DynamicCoordinateParameters(MetricSearchParameters):
    """What can be set of a search that perturbs fewer and fewer coordinates."""

    perturbed_coordinates: float = parameter(
        20.0,
        meaning="coordinates perturbed on average at first: p0 = min(perturbed_coordinates / d, 1)",
        source="Regis & Shoemaker 2013",
        above=0.0,
    )
