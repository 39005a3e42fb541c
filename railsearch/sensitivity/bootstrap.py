"""How much importances owe to the experimental design: refits to other designs, or to parts of one.

| symbol | meaning | shape |
|---|---|---|
| n, B, d | samples, refits, factors | scalar |
| I^b | importances on the surrogate of refit b | (B, d) |

A part of a design is what is drawn n times with replacement, each point once: some 63 % of the points. Left in twice, as in
the bootstrap of Efron 1979, a point would tell an interpolating surrogate nothing, and its twin would betray it in every
leave-one-out error. The intervals are therefore those of somewhat smaller designs, and a little too wide.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from railsearch.errors import InputError, SurrogateError
from railsearch.projected_gradient import SmoothFunction
from railsearch.space import FloatArray

from .curves import plain
from .extremes import MAXIMUM, check_sense, extreme_surfaces
from .factors import Factors
from .inner_search import SearchSettings
from .strategy_search import Progress, silent

Fit = Callable[[FloatArray, FloatArray], SmoothFunction]
"""A surrogate fitted to points (n, d) in the factors' own units with values (n,)."""


@dataclass(frozen=True)
class ImportanceSpread:
    """Importances of refits: rows (B, d) of those that succeeded; why others failed, by the number of the refit from 1."""

    names: tuple[str, ...]
    sense: str
    importances: FloatArray
    failures: dict[int, str]

    def interval(self, level: float = 0.95) -> FloatArray:
        """Bounds (2, d) between which a share `level` of the refits lies. Raises InputError unless 0 < level < 1."""
        if not 0.0 < level < 1.0:
            raise InputError(f"level: a number between 0 and 1 is needed, received {level!r}")
        outside = 0.5 * (1.0 - level)
        return np.asarray(np.quantile(self.importances, [outside, 1.0 - outside], axis=0))

    def document(self, level: float = 0.95) -> dict[str, Any]:
        """All of it in plain types, ready for JSON."""
        low, high = self.interval(level)
        rows = zip(self.names, np.median(self.importances, axis=0), low, high, strict=True)
        return {
            "extreme": self.sense,
            "level": level,
            "refits": len(self.importances),
            "failures": {str(number): reason for number, reason in self.failures.items()},
            "factors": [
                {"name": name, "median": float(middle), "lower": float(lower), "upper": float(upper)}
                for name, middle, lower, upper in rows
            ],
            "importances": plain(self.importances),
        }


def importances_over_designs(
    designs: Iterable[tuple[FloatArray, FloatArray]],
    fit: Fit,
    factors: Factors,
    generator: np.random.Generator,
    settings: SearchSettings | None = None,
    sense: str = MAXIMUM,
    progress: Progress = silent,
) -> ImportanceSpread:
    """Importances on a surrogate of each of several designs: points (n, d) and values (n,).

    fit: makes a fitted surrogate; progress: called after every refit. A refit that fails is left out and named. Raises
    InputError for another extreme, SurrogateError if every refit failed.
    """
    check_sense(sense)
    prepared = list(designs)
    found, failures = [], {}
    for number, (points, values) in enumerate(prepared, 1):
        try:
            surfaces = extreme_surfaces(fit(points, values), factors, generator, settings, senses=[sense])
            found.append(list(surfaces.importances(sense).values()))
        except Exception as error:  # noqa: BLE001 - whatever a surrogate raises is a failed refit
            failures[number] = f"{type(error).__name__}: {error}"
        progress(number, len(prepared))
    if not found:
        reason = next(iter(failures.values()), "there was no design")
        raise SurrogateError(f"importances: none of {len(prepared)} refits succeeded; the first one failed with {reason}")
    return ImportanceSpread(factors.names, sense, np.array(found), failures)


def bootstrap_importances(
    points: FloatArray,
    values: FloatArray,
    refits: int,
    fit: Fit,
    factors: Factors,
    generator: np.random.Generator,
    settings: SearchSettings | None = None,
    sense: str = MAXIMUM,
    progress: Progress = silent,
) -> ImportanceSpread:
    """Importances on surrogates of B parts of one design: points (n, d) and values (n,), those not finite left out.

    refits: B. Raises InputError for fewer than one refit or arrays that do not fit together, and as
    `importances_over_designs`. Source: Efron 1979, Annals of Statistics 7, 1-26, with each point at most once.
    """
    if isinstance(refits, bool) or not isinstance(refits, int) or refits < 1:
        raise InputError(f"refits: an integer ≥ 1 is needed, received {refits!r}")
    points, values = _checked(points, values, factors.names)
    parts = (np.unique(generator.integers(len(values), size=len(values))) for _ in range(refits))
    designs = [(points[rows], values[rows]) for rows in parts]
    return importances_over_designs(designs, fit, factors, generator, settings, sense, progress)


def _checked(points: FloatArray, values: FloatArray, names: Sequence[str]) -> tuple[FloatArray, FloatArray]:
    points, values = np.asarray(points, dtype=float), np.asarray(values, dtype=float)
    if points.ndim != 2 or points.shape[1] != len(names) or values.shape != (len(points),):
        raise InputError(
            f"samples: points (n, {len(names)}) in the order {', '.join(names)} and values (n,) are needed, received shapes "
            f"{points.shape} and {values.shape}"
        )
    known = np.isfinite(values) & np.isfinite(points).all(axis=1)
    if not known.any():
        raise InputError(f"samples: none of {len(values)} has a finite value; check the simulations")
    return points[known], values[known]
