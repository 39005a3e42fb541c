"""What can be set of PC-Kriging."""

from dataclasses import dataclass

from railsearch.interfaces import parameter

from ..gaussian_process.correlation import CORRELATIONS
from ..gaussian_process.estimation import CRITERIA
from ..gaussian_process.parameters import INPUT_BOUNDS, GaussianProcessParameters
from ..polynomial_chaos.parameters import PolynomialChaosParameters

VARIANTS = ("sequential", "optimal")


@dataclass(frozen=True)
class PolynomialChaosKrigingParameters(PolynomialChaosParameters, GaussianProcessParameters):
    """Settings of the expansion, of the process, and which terms of the one are the trend of the other."""

    variant: str = parameter(
        "sequential",
        meaning="trend of all terms that were selected, or of the first so many that have the least leave-one-out error",
        source="Schöbi, Sudret & Wiart 2015",
        choices=VARIANTS,
    )
    correlation: str = parameter(
        "gaussian",
        meaning="correlation function of the ellipsoidal distance",
        source="Rasmussen & Williams 2006",
        choices=tuple(CORRELATIONS),
    )
    estimation: str = parameter(
        "restricted-maximum-likelihood",
        meaning="what the length scales are chosen by; the plain likelihood goes wrong with many terms",
        source="Patterson & Thompson 1971; Bachoc 2013",
        choices=tuple(CRITERIA),
    )
    length_scale_bounds: tuple[float, ...] | None = parameter(
        INPUT_BOUNDS,
        meaning="shortest and longest length scale that may be estimated, as fractions of the range of an input in the data",
        source="own choice: beyond them an input is noise or without effect",
        above=0.0,
    )

    def __post_init__(self) -> None:
        PolynomialChaosParameters.__post_init__(self)
        GaussianProcessParameters.__post_init__(self)
