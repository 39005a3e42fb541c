"""What can be set of a polynomial chaos expansion."""

from dataclasses import dataclass

from railsearch.errors import InputError
from railsearch.interfaces import parameter

from .families import BASES


@dataclass(frozen=True)
class PolynomialChaosParameters:
    """Settings of the search for terms."""

    degree: int = parameter(15, meaning="largest degree p that is searched", minimum=1, maximum=50)
    norms: tuple[float, ...] = parameter(
        (0.5, 0.75, 1.0),
        meaning="exponents q of the norms that bound the terms; below 1 interactions are kept lower than main effects",
        source="Blatman & Sudret 2011",
        above=0.0,
        maximum=1.0,
    )
    basis: str = parameter(
        "own",
        meaning="polynomials of inputs that have no classical family: orthonormal for them, or Hermite through Φ⁻¹(F(x))",
        source="Gautschi 2004; Blatman & Sudret 2011",
        choices=BASES,
    )
    candidates_per_point: float = parameter(
        2.0,
        meaning="sets of more candidate terms than this many times the points are not searched",
        source="own choice",
        above=0.0,
    )
    target_error: float = parameter(
        0.0, meaning="corrected leave-one-out error, as a fraction of the variance, at which the search ends", minimum=0.0
    )
    stop_early: bool = parameter(
        False,
        meaning="whether higher degrees are left out once the error has risen twice in a row",
        source="Blatman & Sudret 2011",
    )
    growth: bool = parameter(
        True,
        meaning="whether the best hyperbolic set is then pruned and grown at its borders as long as that lowers the error",
        source="Jakeman, Eldred & Sargsyan 2015",
    )

    def __post_init__(self) -> None:
        if not self.norms:
            raise InputError("norms: one or more are needed, such as 0.5, received none")
