"""Distributions by name and parameters, as plain tables state them.

| symbol | meaning | unit |
|---|---|---|
| μ, σ | mean and standard deviation of the variable itself, not of its logarithm | that of x |
| δ | coefficient of variation σ/|μ| | - |
| γ | Euler's constant | - |
| u, s | location and scale of a Gumbel distribution | that of x |
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Protocol

import numpy as np

from railsearch.distributions.marginal import Marginal
from railsearch.errors import InputError
from railsearch.parameters import make_parameters, parameter

LOWER, UPPER = "lower bound", "upper bound"
MEAN, STD = "mean of the variable itself", "its standard deviation, unless cov is given"
COV = "its coefficient of variation std/|mean|, unless std is given"

INDEPENDENT = (
    "correlated inputs are refused: designs, polynomial bases, Sobol' indices and the ranges of one input at a time stand "
    "on independent inputs; state the independent causes of the correlation as inputs, or leave it out"
)


@dataclass(frozen=True)
class Uniform:
    """Uniform between two bounds."""

    lower: float = parameter(meaning=LOWER)
    upper: float = parameter(meaning=UPPER)

    def frozen(self) -> Any:
        """The distribution of scipy.stats."""
        _check_order(lower=self.lower, upper=self.upper)
        return _stats().uniform(self.lower, self.upper - self.lower)


@dataclass(frozen=True)
class Normal:
    """Normal."""

    mean: float = parameter(meaning=MEAN)
    std: float | None = parameter(None, meaning=STD, above=0.0)
    cov: float | None = parameter(None, meaning=COV, above=0.0)

    def frozen(self) -> Any:
        """The distribution of scipy.stats."""
        return _stats().norm(self.mean, _deviation(self.mean, self.std, self.cov))


@dataclass(frozen=True)
class Lognormal:
    """Lognormal: ln X has variance ln(1 + δ²) and mean ln μ less half of it."""

    mean: float = parameter(meaning=MEAN, above=0.0)
    std: float | None = parameter(None, meaning=STD, above=0.0)
    cov: float | None = parameter(None, meaning=COV, above=0.0)

    def frozen(self) -> Any:
        """The distribution of scipy.stats."""
        variance = math.log1p((_deviation(self.mean, self.std, self.cov) / self.mean) ** 2)
        return _stats().lognorm(math.sqrt(variance), scale=self.mean * math.exp(-0.5 * variance))


@dataclass(frozen=True)
class GumbelMaximum:
    """Gumbel for maxima, F = exp(−exp(−(x − u)/s)), s = σ√6/π and u = μ − γs."""

    mean: float = parameter(meaning=MEAN)
    std: float | None = parameter(None, meaning=STD, above=0.0)
    cov: float | None = parameter(None, meaning=COV, above=0.0)

    def frozen(self) -> Any:
        """The distribution of scipy.stats."""
        scale = _gumbel_scale(self.mean, self.std, self.cov)
        return _stats().gumbel_r(self.mean - np.euler_gamma * scale, scale)


@dataclass(frozen=True)
class GumbelMinimum:
    """Gumbel for minima, F = 1 − exp(−exp((x − u)/s)), s = σ√6/π and u = μ + γs."""

    mean: float = parameter(meaning=MEAN)
    std: float | None = parameter(None, meaning=STD, above=0.0)
    cov: float | None = parameter(None, meaning=COV, above=0.0)

    def frozen(self) -> Any:
        """The distribution of scipy.stats."""
        scale = _gumbel_scale(self.mean, self.std, self.cov)
        return _stats().gumbel_l(self.mean + np.euler_gamma * scale, scale)


@dataclass(frozen=True)
class Beta:
    """Beta between two bounds, density proportional to (x − lower)^(alpha − 1) (upper − x)^(beta − 1)."""

    alpha: float = parameter(meaning="first shape", above=0.0)
    beta: float = parameter(meaning="second shape", above=0.0)
    lower: float = parameter(0.0, meaning=LOWER)
    upper: float = parameter(1.0, meaning=UPPER)

    def frozen(self) -> Any:
        """The distribution of scipy.stats."""
        _check_order(lower=self.lower, upper=self.upper)
        return _stats().beta(self.alpha, self.beta, self.lower, self.upper - self.lower)


@dataclass(frozen=True)
class Triangular:
    """Triangular between two bounds."""

    lower: float = parameter(meaning=LOWER)
    mode: float = parameter(meaning="where the density is largest")
    upper: float = parameter(meaning=UPPER)

    def frozen(self) -> Any:
        """The distribution of scipy.stats."""
        _check_order(lower=self.lower, upper=self.upper)
        if not self.lower <= self.mode <= self.upper:
            raise InputError(
                f"mode: must lie between lower and upper, {self.lower:g} and {self.upper:g}, received {self.mode:g}"
            )
        width = self.upper - self.lower
        return _stats().triang((self.mode - self.lower) / width, self.lower, width)


class Family(Protocol):
    """Parameters of a distribution."""

    def frozen(self) -> Any:
        """The distribution of scipy.stats. Raises InputError for parameters that do not fit together."""


FAMILIES: Mapping[str, type[Family]] = MappingProxyType(
    {
        "uniform": Uniform,
        "normal": Normal,
        "lognormal": Lognormal,
        "gumbel-max": GumbelMaximum,
        "gumbel-min": GumbelMinimum,
        "beta": Beta,
        "triangular": Triangular,
    }
)
SCIPY = "scipy.stats."
NAME, TRUNCATE_BELOW, TRUNCATE_ABOVE = "distribution", "truncate_below", "truncate_above"


@dataclass(frozen=True)
class Truncation:
    """Bounds at which a distribution is cut off."""

    truncate_below: float | None = parameter(None, meaning="least value that is kept")
    truncate_above: float | None = parameter(None, meaning="largest value that is kept")

    @property
    def bounds(self) -> tuple[float, float]:
        """Both bounds, infinite where there is none."""
        below, above = self.truncate_below, self.truncate_above
        return -math.inf if below is None else below, math.inf if above is None else above


def marginal_from_table(table: Mapping[str, object], where: str) -> Marginal:
    """The distribution that a plain table states: its name under `distribution`, its parameters, and its truncation.

    The name is one of FAMILIES, or `scipy.stats.NAME` of any continuous distribution with its shapes, `loc` and `scale`.
    `truncate_below` and `truncate_above` cut any of them off. Raises InputError, beginning with `where`, for unknown names
    and parameters, for values that are not allowed, and for a truncation that leaves nothing.
    """
    cuts = make_parameters(Truncation, {key: table[key] for key in (TRUNCATE_BELOW, TRUNCATE_ABOVE) if key in table}, where)
    settings = {key: value for key, value in table.items() if key not in (NAME, TRUNCATE_BELOW, TRUNCATE_ABOVE)}
    try:
        marginal = Marginal(_frozen(table.get(NAME), settings, where), _words(table.get(NAME), settings))
        return marginal if cuts == Truncation() else marginal.truncated(*cuts.bounds)
    except InputError as error:
        begun = str(error).startswith((f"{where}:", f"{where}."))
        raise InputError(str(error) if begun else f"{where}: {error}") from None


def marginal_from_scipy(frozen: Any, where: str) -> Marginal:
    """A frozen continuous distribution of scipy.stats as a marginal.

    Raises InputError for anything else: a discrete one, one that is not frozen, one of several variables.
    """
    needed = ("cdf", "sf", "pdf", "ppf", "isf", "mean", "std", "support", "args")
    if not all(hasattr(frozen, method) for method in needed):
        reason = f"; {INDEPENDENT}" if hasattr(frozen, "dim") else ", such as scipy.stats.norm(0.0, 1.0)"
        raise InputError(
            f"{where}: a table, or a frozen continuous distribution of scipy.stats of one variable, is needed, received "
            f"{type(frozen).__name__}{reason}"
        )
    positional = {f"argument {k}": value for k, value in enumerate(frozen.args, start=1)}
    words = _words(SCIPY + frozen.dist.name, {**positional, **frozen.kwds})
    median = np.asarray(frozen.ppf(0.5))
    if median.shape or not np.isfinite(median):
        raise InputError(f"{where}: {words} is not the distribution of one variable; correct its parameters")
    return Marginal(frozen, words)


def _frozen(name: object, settings: Mapping[str, object], where: str) -> Any:
    """The distribution of scipy.stats that is stated."""
    if isinstance(name, str) and name in FAMILIES:
        return make_parameters(FAMILIES[name], settings, where).frozen()
    if not isinstance(name, str) or not name.startswith(SCIPY):
        known = f"{', '.join(FAMILIES)}, and {SCIPY}NAME"
        given = "must be given" if name is None else f"unknown '{name}'"
        raise InputError(f"{where}: {NAME}: {given}; there are {known}")
    family = getattr(_stats(), name.removeprefix(SCIPY), None)
    if not isinstance(family, _stats().rv_continuous):
        raise InputError(f"{where}: {NAME}: scipy.stats has no continuous distribution '{name.removeprefix(SCIPY)}'")
    for key, value in settings.items():
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            raise InputError(f"{where}.{key}: a finite number is needed, received {value!r}")
    try:
        frozen = family(**settings)
    except TypeError as error:
        raise InputError(f"{where}: {name}: {error}; it takes {_shapes(family)}") from None
    return marginal_from_scipy(frozen, where).frozen


def _words(name: object, settings: Mapping[str, object]) -> str:
    shown = {key: f"{value:g}" if isinstance(value, int | float) else repr(value) for key, value in settings.items()}
    return f"{name}({', '.join(f'{key}={value}' for key, value in shown.items())})"


def _shapes(family: Any) -> str:
    return ", ".join(filter(None, [family.shapes, "loc", "scale"]))


def _stats() -> Any:
    """scipy.stats, which takes half a second to import, when it is needed."""
    from scipy import stats

    return stats


def _deviation(mean: float, std: float | None, cov: float | None) -> float:
    """The standard deviation, from itself or from the coefficient of variation."""
    if (std is None) == (cov is None):
        raise InputError(f"std or cov: one of them is needed, received {'neither' if std is None else 'both'}")
    deviation = std if cov is None else cov * abs(mean)
    if not deviation:
        raise InputError("cov: a mean of zero has no coefficient of variation; give std")
    return deviation


def _gumbel_scale(mean: float, std: float | None, cov: float | None) -> float:
    return _deviation(mean, std, cov) * math.sqrt(6.0) / math.pi


def _check_order(lower: float, upper: float) -> None:
    if not lower < upper:
        raise InputError(f"lower, upper: the lower bound must lie below the upper one, received {lower:g} and {upper:g}")
