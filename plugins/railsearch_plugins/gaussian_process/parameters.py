"""The numbers of a Gaussian process."""

from dataclasses import dataclass

from railsearch.errors import InputError
from railsearch.interfaces import parameter

from .correlation import CORRELATIONS

SEARCH_BOUNDS = (0.01, 20.0)
"""Bounds of the length scales on the unit cube of a search."""

INPUT_BOUNDS = (0.01, 200.0)
"""Bounds of the length scales over random inputs, which extend beyond the data: there a linear effect needs longer ones."""


@dataclass(frozen=True)
class GaussianProcessParameters:
    """What can be set of every Gaussian process."""

    correlation: str = parameter(
        "matern-5/2",
        meaning="correlation function of the ellipsoidal distance",
        source="Rasmussen & Williams 2006",
        choices=tuple(CORRELATIONS),
    )
    estimation: str = parameter(
        "maximum-likelihood",
        meaning="what the length scales are chosen by",
        source="Bachoc 2013; Dubrule 1983; Patterson & Thompson 1971 for the restricted likelihood",
        choices=("maximum-likelihood", "restricted-maximum-likelihood", "leave-one-out"),
    )
    length_scales: tuple[float, ...] | None = parameter(
        None,
        meaning="length scales by variable as fractions of its range, or one for all; if not given, they are estimated",
        above=0.0,
    )
    length_scale_bounds: tuple[float, ...] | None = parameter(
        None,
        meaning="shortest and longest length scale that may be estimated, as fractions of the range of a variable; if not "
        "given, 0.01 and 20, or 200 where the inputs are random",
        source="own choice: beyond them a variable is noise or without effect",
        above=0.0,
    )
    length_scale_prior: float | None = parameter(
        None,
        meaning="standard deviation of log-normal length scales about √d/2 that the estimate weighs in; if not given, flat",
        source="own choice; Hvarfner, Hellsten & Nardi 2024 for the growth with √d",
        above=0.0,
    )
    nugget: float = parameter(
        0.0,
        meaning="variance of independent noise in units of the process variance; 0 goes through every point",
        source="Rasmussen & Williams 2006",
        minimum=0.0,
    )
    estimate_nugget: bool = parameter(False, meaning="estimate the nugget together with the length scales, for noisy values")
    starts: int = parameter(
        5,
        meaning="from how many points the length scales are optimised at a fit",
        source="own choice",
        minimum=1,
    )

    def __post_init__(self) -> None:
        bounds = self.length_scale_bounds
        if bounds is not None and (len(bounds) != 2 or not bounds[0] < bounds[1]):
            raise InputError(f"length_scale_bounds: the shortest, then the longest is needed, received {list(bounds)}")
