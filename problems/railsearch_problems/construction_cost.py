"""Construction cost of a level crossing's transition zones, in closed form.

| symbol | meaning | shape | unit |
|---|---|---|---|
| xs | sleeper spacing next to the crossing | (n,) | 0.05 m |
| xn | strengthened sleepers | (n,) | - |
| N | sleepers that are laid, strengthened or not | scalar | - |
| C_spacing | cost that depends on the spacing, by the spacing | (k,) | € |
| c, c_s | price of a sleeper, of a strengthened one | scalar | € |
| C_cap | construction cost | (n,) | € |

Sources: Shang, Binnekamp & Wolfert, Life-Cycle of Structures and Infrastructure Systems (2023) 949-956; ratios of
C_spacing to the standard spacing after Ortega et al. 2021.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from railsearch.errors import InputError
from railsearch.parameters import parameter
from railsearch.space import FloatArray

PRINTED = "Shang, Binnekamp & Wolfert 2023"


@dataclass(frozen=True)
class Prices:
    """What the parts of a transition zone cost."""

    spacings: tuple[int, ...] = parameter(
        (10, 11, 12, 13, 14),
        unit="0.05 m",
        meaning="sleeper spacings that have a cost, ascending",
        source=PRINTED,
        minimum=1,
    )
    spacing_costs: tuple[float, ...] = parameter(
        (3413.0, 3207.0, 3000.0, 2767.7, 2562.2),
        unit="€",
        meaning="cost of each of these spacings",
        source=f"{PRINTED}; ratios after Ortega et al. 2021",
        minimum=0.0,
    )
    sleepers: int = parameter(15, meaning="sleepers that are laid, strengthened or not", source=PRINTED, minimum=0)
    sleeper: float = parameter(400.0, unit="€", meaning="price of a sleeper", source=PRINTED, minimum=0.0)
    strengthened_sleeper: float = parameter(
        600.0, unit="€", meaning="price of a strengthened sleeper", source=PRINTED, minimum=0.0
    )

    def __post_init__(self) -> None:
        if len(self.spacings) != len(self.spacing_costs) or not self.spacings:
            raise InputError(
                f"spacing_costs: one cost for each of the {len(self.spacings)} spacings is needed, "
                f"received {len(self.spacing_costs)}"
            )
        if list(self.spacings) != sorted(set(self.spacings)):
            raise InputError(f"spacings: each once and ascending is needed, received {list(self.spacings)}")


def construction_cost(spacing: ArrayLike, strengthened: ArrayLike, prices: Prices) -> FloatArray:
    """The construction cost C_cap = C_spacing(xs) + c (N − xn) + c_s xn.

    spacing: xs (n,) in 0.05 m; strengthened: xn (n,); prices: c, c_s, N and C_spacing. Gives C_cap (n,) in €.
    Raises InputError for a spacing that has no cost and for more strengthened sleepers than are laid.
    Source: Shang, Binnekamp & Wolfert 2023.
    """
    xs, xn = np.broadcast_arrays(np.asarray(spacing, dtype=float), np.asarray(strengthened, dtype=float))
    check_priced(xs, xn, prices)
    by_spacing = np.asarray(prices.spacing_costs)[np.searchsorted(prices.spacings, xs)]
    return np.asarray(by_spacing + prices.sleeper * (prices.sleepers - xn) + prices.strengthened_sleeper * xn)


def check_priced(spacing: FloatArray, strengthened: FloatArray, prices: Prices) -> None:
    """Raise InputError for a spacing (n,) that has no cost, or more strengthened sleepers (n,) than are laid."""
    unknown = spacing[~np.isin(spacing, prices.spacings)]
    if unknown.size:
        known = ", ".join(map(str, prices.spacings))
        raise InputError(
            f"cost.spacings: there are costs for {known} (0.05 m), received {unknown[0]:g}; "
            "give its cost, or narrow variables.xs"
        )
    wrong = strengthened[(strengthened < 0) | (strengthened > prices.sleepers)]
    if wrong.size:
        raise InputError(
            f"cost.sleepers: {prices.sleepers} sleepers are laid, received {wrong[0]:g} strengthened ones; "
            "raise cost.sleepers, or lower variables.xn.upper"
        )
