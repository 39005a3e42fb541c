"""Extreme formulation: the extreme surface of every factor, and how much of the extremes' movement is its doing.

| symbol | meaning | shape | unit |
|---|---|---|---|
| g(x) | output | scalar | of the output |
| x_ij | value at which factor i is held | (n_i,) | SI |
| Ȳ_i(x_ij) | max or min of g over all other factors in their bounds, X_i = x_ij | (n_i,) | of the output |
| I_i | Var_j(Ȳ_i)/Σ_i Var_j(Ȳ_i) | (d,) | - |

Source: Shang, Nogal, Teixeira & Wolfert 2024, Reliability Engineering & System Safety 243, 109818.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from railsearch.errors import InputError
from railsearch.interfaces import Quantity
from railsearch.projected_gradient import SmoothFunction
from railsearch.space import FloatArray

from .curves import local_sensitivity, plain, shares, weighted_variance
from .factors import Factors
from .inner_problems import InnerProblems
from .inner_search import Extreme, GlobalCheck, InnerSearch, SearchSettings, solved
from .models import BoxModel, ExactModel

MAXIMUM, MINIMUM = SENSES = ("maximum", "minimum")
SIGNS: Mapping[str, float] = {MAXIMUM: -1.0, MINIMUM: 1.0}
"""What the output is multiplied by to be minimised."""

FEWEST_DESCENTS = 1600
"""Descents from sampled points, over all inner problems of an extreme."""

FLAT = 1e-7
"""A curve with a standard deviation below this fraction of the output's range is as flat as extremes are exact."""

OUTPUT = Quantity("g", meaning="output of the model")


@dataclass(frozen=True)
class Curve:
    """An extreme surface: Ȳ (n,), NaN where none was found, and the points (n, d) where it is attained, SI units."""

    values: FloatArray
    points: FloatArray


@dataclass(frozen=True)
class Effort:
    """What was spent, and how sure the extremes are.

    asked: points at which the model was asked, for an exact one true evaluations; failures: those that failed; exact:
    whether the model was the true one; check: the comparison with sampled points, None where there was none; solver: the
    strategy that solved the inner problems, or the batched projected gradients.
    """

    asked: int
    failures: int
    exact: bool
    check: GlobalCheck | None
    solver: str = "projected gradients"


@dataclass(frozen=True)
class ExtremeSurfaces:
    """The extreme surfaces of all factors, by sense (`maximum`, `minimum`) and in the order of the factors."""

    factors: Factors
    output: Quantity
    curves: Mapping[str, tuple[Curve, ...]]
    effort: Effort

    @property
    def senses(self) -> tuple[str, ...]:
        """Which extremes there are."""
        return tuple(self.curves)

    @property
    def unsolved(self) -> int:
        """Inner problems without any extreme, because every evaluation failed."""
        return sum(int(np.isnan(curve.values).sum()) for curves in self.curves.values() for curve in curves)

    def surface(self, name: str, sense: str = MAXIMUM) -> Curve:
        """The curve of a factor. Raises InputError for an unknown factor, and an extreme that was not looked for."""
        return self._of(sense)[self.factors.index(name)]

    def extreme(self, sense: str = MAXIMUM) -> float:
        """The extreme of all curves, NaN where there is none. Raises InputError as `surface`."""
        values = np.concatenate([curve.values for curve in self._of(sense)])
        sign = SIGNS[sense]
        return sign * float(np.nanmin(sign * values)) if np.isfinite(values).any() else float("nan")

    def variances(self, sense: str = MAXIMUM, weighted: bool = True) -> dict[str, float]:
        """Var_j(Ȳ_i) by factor, grid values weighted by the distance of their neighbours or all alike.

        Unit: that of the output, squared. Raises InputError as `surface`.
        """
        weights = self.factors.weights if weighted else tuple(np.ones(len(grid)) for grid in self.factors.grids)
        found = zip(self.factors.names, self._of(sense), weights, strict=True)
        return {name: weighted_variance(curve.values, shares) for name, curve, shares in found}

    def importances(self, sense: str = MAXIMUM, weighted: bool = True) -> dict[str, float]:
        """I_i by factor, 0 for all where no curve varies by more than rounding. Raises InputError as `surface`."""
        variances = self.variances(sense, weighted)
        values = np.concatenate([curve.values for curves in self.curves.values() for curve in curves])
        rounding = (FLAT * float(np.nanmax(values) - np.nanmin(values))) ** 2 if np.isfinite(values).any() else 0.0
        found = np.array(list(variances.values()))
        return dict(zip(variances, map(float, shares(np.where(found > rounding, found, 0.0))), strict=True))

    def local_sensitivity(self, name: str, sense: str = MAXIMUM) -> FloatArray:
        """dȲ_i/dx_i (n_i,) at the grid values. Unit: the output's over the factor's. Raises InputError as `surface`."""
        return local_sensitivity(self.factors.grids[self.factors.index(name)], self.surface(name, sense).values)

    def document(self) -> dict[str, Any]:
        """All of it in plain types, ready for JSON; None where there is no value."""
        effort = asdict(self.effort)
        return {
            "output": {"name": self.output.name, "unit": self.output.unit, "meaning": self.output.meaning},
            "extremes": {sense: plain(np.array([self.extreme(sense)]))[0] for sense in self.senses},
            "importances": {sense: self.importances(sense) for sense in self.senses},
            "factors": [self._factor_document(name) for name in self.factors.names],
            "effort": {**effort, "unsolved": self.unsolved},
        }

    def _factor_document(self, name: str) -> dict[str, Any]:
        place = self.factors.index(name)
        variable = self.factors.space.variables[place]
        found: dict[str, Any] = {
            "name": name,
            "unit": variable.unit,
            "lower": variable.lower,
            "upper": variable.upper,
            "spacing": self.factors.spacings[place],
            "grid": plain(self.factors.grids[place]),
        }
        for sense in self.senses:
            curve = self.surface(name, sense)
            found[sense] = {
                "values": plain(curve.values),
                "points": plain(curve.points),
                "variance": self.variances(sense)[name],
                "local_sensitivity": plain(self.local_sensitivity(name, sense)),
            }
        return found

    def _of(self, sense: str) -> tuple[Curve, ...]:
        check_sense(sense)
        if sense not in self.curves:
            raise InputError(f"{sense}: only the {' and '.join(self.curves)} was looked for; look for both")
        return self.curves[sense]


def extreme_surfaces(
    model: SmoothFunction,
    factors: Factors,
    generator: np.random.Generator,
    settings: SearchSettings | None = None,
    output: Quantity = OUTPUT,
    senses: Sequence[str] = SENSES,
) -> ExtremeSurfaces:
    """Find Ȳ_i(x_ij) = max and min of g(x) with X_i = x_ij, for all factors and grid values at once.

    model: a surrogate (`predict` and `gradient` at points (k, d) in the factors' own units), or an `ExactModel`; generator:
    draws the samples of starts and of the global check; settings: how much work it may be, by default 1600 descents or more
    for each extreme; output: name and unit of g; senses: which extremes; thresholds need both. Raises InputError for integer
    factors and for no or other extremes,
    SurrogateError where a surrogate is not finite, SimulationError if all evaluations of the first sample failed.
    Source: Shang et al. 2024; spectral projected gradients: Birgin, Martínez & Raydan 2000.
    """
    check_senses(senses)
    chosen, asker = settings or _settings_for(factors), Asker(model, factors)
    problems = InnerProblems(factors)
    goals = [Extreme(SIGNS[sense]) for sense in senses]
    searches, check = solved(asker.box, problems, goals, chosen, generator)
    curves = {
        sense: _curves(factors, problems, SIGNS[sense], search) for sense, search in zip(senses, searches, strict=True)
    }
    return ExtremeSurfaces(factors, output, curves, asker.effort(check if chosen.check else None))


def _settings_for(factors: Factors) -> SearchSettings:
    """The defaults, with more starts where few inner problems have few solutions to hand on to one another."""
    starts, usual = -(-FEWEST_DESCENTS // factors.number_of_values), SearchSettings()
    return replace(usual, starts=max(usual.starts, starts), sample=max(usual.sample, starts))


class Asker:
    """A model on the box of the factors, and what was asked of it since. Raises InputError for integer factors."""

    def __init__(self, model: SmoothFunction, factors: Factors) -> None:
        whole = [variable.name for variable in factors.space.variables if variable.integer]
        if whole:
            raise InputError(
                f"{', '.join(whole)}: projected gradients need factors with real values, these take whole numbers; let a "
                "strategy solve the inner problems"
            )
        self.box = BoxModel(model, factors.space)
        self._exact = model if isinstance(model, ExactModel) else None
        self._evaluations, self._failures = self._counts()

    def effort(self, check: GlobalCheck | None) -> Effort:
        """What was spent until now."""
        evaluations, failures = self._counts()
        asked = self.box.asked if self._exact is None else evaluations - self._evaluations
        return Effort(asked, failures - self._failures, self.box.exact, check)

    def _counts(self) -> tuple[int, int]:
        return (0, 0) if self._exact is None else (self._exact.evaluations, self._exact.failures)


def check_sense(sense: str) -> None:
    """Raise InputError for anything but `maximum` and `minimum`."""
    if sense not in SENSES:
        raise InputError(f"extreme: {' or '.join(SENSES)} is needed, received {sense!r}")


def check_senses(senses: Sequence[str]) -> None:
    """Raise InputError for no extremes, and for one that is neither `maximum` nor `minimum`."""
    if not senses:
        raise InputError(f"extremes: one or both of {' and '.join(SENSES)} are needed, received none")
    for sense in senses:
        check_sense(sense)


def _curves(factors: Factors, problems: InnerProblems, sign: float, search: InnerSearch) -> tuple[Curve, ...]:
    points = factors.space.from_unit(search.points)
    held = np.concatenate(factors.grids)
    # Exactly the grid value: the map to the unit box and back may change the last digit.
    points[np.arange(len(held)), problems.factor] = held
    values = np.where(np.isfinite(search.merits), sign * search.merits, np.nan)
    points[np.isnan(values)] = np.nan
    return tuple(Curve(*pair) for pair in zip(problems.split(values), problems.split(points), strict=True))
