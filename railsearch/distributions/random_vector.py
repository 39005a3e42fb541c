"""Vectors of independent random inputs.

| symbol | meaning | shape | unit |
|---|---|---|---|
| d, n | number of inputs, of points | scalar | - |
| X | points | (n, d) | the caller's |
| P | F(X), uniform on the unit cube | (n, d) | - |
| Ξ | Φ⁻¹(P), standard normal | (n, d) | - |

Since the inputs are independent, every map acts on one column at a time.
"""

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from railsearch.distributions.families import INDEPENDENT, marginal_from_scipy, marginal_from_table
from railsearch.distributions.marginal import Marginal
from railsearch.errors import InputError
from railsearch.space import FloatArray

NEGLIGIBLE = 1e-9
"""A distribution counts as inside a range if the probability outside is no more: once in 10⁹ points."""


class TruncationWarning(UserWarning):
    """A distribution was cut off at the bounds of a physical range."""


@dataclass(frozen=True)
class RandomVector:
    """Independent inputs by name; points are float arrays (…, d) with the inputs in this order, in the caller's units."""

    marginals: Mapping[str, Marginal]

    def __post_init__(self) -> None:
        if not self.marginals:
            raise InputError("random inputs: one or more are needed, received none")

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the inputs in order."""
        return tuple(self.marginals)

    @property
    def dimension(self) -> int:
        """d."""
        return len(self.marginals)

    @property
    def mean(self) -> FloatArray:
        """Means (d,)."""
        return np.array([marginal.mean for marginal in self.marginals.values()])

    @property
    def std(self) -> FloatArray:
        """Standard deviations (d,)."""
        return np.array([marginal.std for marginal in self.marginals.values()])

    def cdf(self, points: ArrayLike) -> FloatArray:
        """P = F(X) (…, d) for points X (…, d); its inverse is `from_uniform`."""
        return self._by_column(points, lambda marginal, x: marginal.cdf(x))

    def from_uniform(self, points: ArrayLike) -> FloatArray:
        """X = F⁻¹(P) (…, d) for points P (…, d) of the unit cube. Raises InputError outside the cube."""
        unit = np.asarray(points, dtype=float)
        if not ((unit >= 0.0) & (unit <= 1.0)).all():
            raise InputError("points of the unit cube: values from 0 to 1 are needed, received others")
        return self._by_column(unit, lambda marginal, p: marginal.percentile(p))

    def to_standard_normal(self, points: ArrayLike) -> FloatArray:
        """Ξ = Φ⁻¹(F(X)) (…, d) for points X (…, d), infinite at bounds. Raises InputError for values that cannot occur."""
        return self._by_column(self.checked(points), lambda marginal, x: marginal.to_standard_normal(x))

    def from_standard_normal(self, points: ArrayLike) -> FloatArray:
        """X = F⁻¹(Φ(Ξ)) (…, d) for standard normal Ξ (…, d)."""
        return self._by_column(points, lambda marginal, xi: marginal.from_standard_normal(xi))

    def percentiles(self, levels: ArrayLike) -> FloatArray:
        """The percentiles (k, d) of every input at `levels` (k,) from 0 to 1. Raises InputError for other levels."""
        column = np.atleast_1d(np.asarray(levels, dtype=float))[:, None]
        return self.from_uniform(np.broadcast_to(column, (len(column), self.dimension)))

    def ranges(self, level: float = 0.01) -> FloatArray:
        """Bounds (d, 2) of every input: its own, or, unbounded on any side, the percentiles at `level` and 1 − `level`.

        Raises InputError unless 0 < level < 0.5.
        """
        if not 0.0 < level < 0.5:
            raise InputError(f"ranges: a level between 0 and 0.5 is needed, received {level:g}")
        outer = self.percentiles([level, 1.0 - level]).T
        bounds = [marginal.support if marginal.bounded else row for marginal, row in zip(self._columns, outer, strict=True)]
        return np.array(bounds, dtype=float)

    def checked(self, points: ArrayLike) -> FloatArray:
        """The points (…, d) as floats. Raises InputError naming the input of a value that cannot occur."""
        values = self._shaped(points)
        for k, (name, marginal) in enumerate(self.marginals.items()):
            low, high = marginal.support
            column = values[..., k]
            wrong = ~((column >= low) & (column <= high))
            if wrong.any():
                raise InputError(
                    f"{name}: {marginal} has values from {low:g} to {high:g}, received {column[wrong].flat[0]:g}; "
                    "correct the value or the distribution"
                )
        return values

    @property
    def _columns(self) -> tuple[Marginal, ...]:
        return tuple(self.marginals.values())

    def _shaped(self, points: ArrayLike) -> FloatArray:
        values = np.asarray(points, dtype=float)
        if values.shape[-1:] != (self.dimension,):
            raise InputError(
                f"points: {self.dimension} values each are needed ({', '.join(self.names)}), received shape {values.shape}"
            )
        return values

    def _by_column(self, points: ArrayLike, function: Callable[[Marginal, FloatArray], FloatArray]) -> FloatArray:
        values = self._shaped(points)
        return np.stack([function(marginal, values[..., k]) for k, marginal in enumerate(self._columns)], axis=-1)


def random_vector(
    inputs: Mapping[str, Any], correlation: ArrayLike | None = None, where: str = "distributions"
) -> RandomVector:
    """A vector of independent inputs from tables (see `marginal_from_table`), marginals or frozen ones of scipy.stats.

    Raises InputError, beginning with `where`, for what is none of these, for no inputs, and for a `correlation` (d, d)
    other than the identity, with the reason.
    """
    if correlation is not None and not np.array_equal(correlation, np.eye(len(inputs))):
        raise InputError(f"{where}: {INDEPENDENT}")
    return RandomVector({name: _marginal(item, f"{where}.{name}") for name, item in inputs.items()})


def keep_inside(
    vector: RandomVector,
    ranges: Mapping[str, tuple[float, float]],
    *,
    truncate: bool = False,
    negligible: float = NEGLIGIBLE,
) -> RandomVector:
    """The vector, if every input of `ranges` stays inside its physical range but for a `negligible` probability.

    Any other is cut off at the range with `truncate`, and a TruncationWarning names the probability that was cut off;
    otherwise InputError is raised, which names it too. Raises InputError for a range of no input, and where nothing is left.
    """
    unknown = [name for name in ranges if name not in vector.marginals]
    if unknown:
        raise InputError(f"ranges: {', '.join(unknown)} are not among the inputs {', '.join(vector.names)}")
    kept = dict(vector.marginals)
    for name, (low, high) in ranges.items():
        outside = kept[name].probability_outside(low, high)
        if outside > negligible:
            kept[name] = _cut(name, kept[name], low, high, outside, truncate)
    return RandomVector(kept)


def _marginal(item: Any, where: str) -> Marginal:
    if isinstance(item, Marginal):
        return item
    return marginal_from_table(item, where) if isinstance(item, Mapping) else marginal_from_scipy(item, where)


def _cut(name: str, marginal: Marginal, low: float, high: float, outside: float, truncate: bool) -> Marginal:
    fault = f"{name}: {marginal} leaves its physical range, {low:g} to {high:g}, with a probability of {outside:.3g}"
    if not truncate:
        raise InputError(f"{fault}; narrow the distribution, or have it truncated")
    warnings.warn(f"{fault}; it was cut off there", TruncationWarning, stacklevel=3)
    return marginal.truncated(low, high)
