"""Polynomials orthonormal for the distribution of an input, and the coordinate in which they are polynomials.

| symbol | meaning | source |
|---|---|---|
| x | value of the input | |
| t(x) | coordinate of the polynomials, with the slope dt/dx | |
| ψ_k | polynomial of degree k in t, E[ψ_j ψ_k] = δ_jk | |
| a_k, b_k | √b_{k+1} ψ_{k+1} = (t − a_k) ψ_k − √b_k ψ_{k−1}, b_0 = 0 | Gautschi 2004, Eq. 1.3.12 |
| Φ, φ | standard normal distribution function and density | |

| marginal | t | ψ | a_k | b_k |
|---|---|---|---|---|
| uniform | −1 … 1 over its range | Legendre | 0 | k²/(4k² − 1) |
| normal | (x − μ)/σ | Hermite | 0 | k |
| lognormal | (ln x − λ)/ζ | Hermite | 0 | k |
| exponential, gamma of shape s | (x − location)/scale | Laguerre, α = s − 1 | 2k + α + 1 | k(k + α) |
| beta | −1 … 1 over its range | Jacobi | Gautschi 2004, table 1.1 | there |
| any other, basis `own` | (x − μ)/σ | its own | discretised Stieltjes procedure | Gautschi 2004, 2.2.3 |
| any, basis `hermite` | Φ⁻¹(F(x)) | Hermite | 0 | k |
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from railsearch.distributions import Marginal
from railsearch.errors import InputError
from railsearch.space import FloatArray

from .stieltjes import nodes_and_weights, stieltjes

BASES = ("own", "hermite")
FARTHEST = 37.0
"""The largest ξ whose probability is a number."""

Map = Callable[[FloatArray], FloatArray]


@dataclass(frozen=True)
class Family:
    """The coordinate t of an input and the recurrence of its orthonormal polynomials up to a degree p.

    a: a_0 … a_p; b: b_0 … b_{p+1}, b_0 = 0.
    """

    name: str
    coordinate: Map
    slope: Map
    a: FloatArray
    b: FloatArray

    @property
    def degree(self) -> int:
        """The largest degree."""
        return len(self.a) - 1

    def over(self, lower: float, span: float) -> "Family":
        """The same polynomials in z = (t − lower)/span."""
        return _affine_family(self.name, -lower / span, 1.0 / span, self.a, self.b)

    def values(self, x: ArrayLike, degree: int) -> FloatArray:
        """ψ_0 … ψ_p (p + 1, n) at x (n,)."""
        t = self.coordinate(np.asarray(x, dtype=float))
        return self._recurrence(t, degree)

    def values_and_slopes(self, x: ArrayLike, degree: int) -> tuple[FloatArray, FloatArray]:
        """ψ_0 … ψ_p and their derivatives by x (p + 1, n) at x (n,)."""
        points = np.asarray(x, dtype=float)
        t = self.coordinate(points)
        values = self._recurrence(t, degree)
        slopes = np.zeros_like(values)
        roots = np.sqrt(self.b)
        for k in range(degree):
            slopes[k + 1] = ((t - self.a[k]) * slopes[k] + values[k] - roots[k] * slopes[k - 1]) / roots[k + 1]
        return values, slopes * self.slope(points)

    def _recurrence(self, t: FloatArray, degree: int) -> FloatArray:
        values = np.zeros((degree + 1, *t.shape))
        values[0] = 1.0
        roots = np.sqrt(self.b)
        for k in range(degree):
            # b_0 = 0 takes ψ_{−1} out, whatever row stands there.
            values[k + 1] = ((t - self.a[k]) * values[k] - roots[k] * values[k - 1]) / roots[k + 1]
        return values


def orthonormal_family(marginal: Marginal, degree: int, basis: str = "own") -> Family:
    """The polynomials up to a degree that are orthonormal for a marginal.

    basis: `own`, polynomials in x, or in ln x for a lognormal; `hermite`, Hermite polynomials in Φ⁻¹(F(x)).
    Raises InputError for another basis, and where a distribution has no moments of twice that degree to speak of.
    """
    if basis not in BASES:
        raise InputError(f"basis: allowed is {' or '.join(map(repr, BASES))}, received {basis!r}")
    classical = None if _is_truncated(marginal) else _CLASSICAL.get(marginal.frozen.dist.name)
    if basis == "hermite" and classical not in (_normal, _lognormal):
        return _mapped(marginal, degree)
    return classical(marginal, degree) if classical else _own(marginal, degree)


def _is_truncated(marginal: Marginal) -> bool:
    low, high = marginal.frozen.support()
    return bool(marginal.lower > low or marginal.upper < high)


def _arguments(marginal: Marginal) -> tuple[tuple[float, ...], float, float]:
    """Shapes, location and scale of a frozen distribution of scipy.stats."""
    frozen = marginal.frozen
    shapes, location, scale = frozen.dist._parse_args(*frozen.args, **frozen.kwds)
    return tuple(map(float, shapes)), float(location), float(scale)


def _affine(centre: float, width: float, x: FloatArray) -> FloatArray:
    return (x - centre) / width


def _affine_family(name: str, centre: float, width: float, a: FloatArray, b: FloatArray) -> Family:
    return Family(name, partial(_affine, centre, width), partial(np.full_like, fill_value=1.0 / width), a, b)


def _hermite(degree: int) -> tuple[FloatArray, FloatArray]:
    return np.zeros(degree + 1), np.arange(degree + 2.0)


def _legendre(marginal: Marginal, degree: int) -> Family:
    k = np.arange(degree + 2.0)
    low, high = marginal.support
    return _affine_family(
        "Legendre", 0.5 * (low + high), 0.5 * (high - low), np.zeros(degree + 1), k**2 / (4.0 * k**2 - 1.0)
    )


def _normal(marginal: Marginal, degree: int) -> Family:
    return _affine_family("Hermite", marginal.mean, marginal.std, *_hermite(degree))


def _lognormal(marginal: Marginal, degree: int) -> Family:
    (deviation,), location, scale = _arguments(marginal)
    coordinate = partial(_logarithm, location, scale, deviation)
    return Family("Hermite in the logarithm", coordinate, partial(_inverse, location, deviation), *_hermite(degree))


def _logarithm(location: float, scale: float, deviation: float, x: FloatArray) -> FloatArray:
    return np.asarray(np.log((x - location) / scale) / deviation)


def _inverse(location: float, deviation: float, x: FloatArray) -> FloatArray:
    return 1.0 / (deviation * (x - location))


def _laguerre(marginal: Marginal, degree: int) -> Family:
    shapes, location, scale = _arguments(marginal)
    alpha = (shapes[0] if shapes else 1.0) - 1.0
    k = np.arange(degree + 2.0)
    return _affine_family("Laguerre", location, scale, 2.0 * k[:-1] + alpha + 1.0, k * (k + alpha))


def _jacobi(marginal: Marginal, degree: int) -> Family:
    """Jacobi: weight (1 − t)^α (1 + t)^β with α + 1 and β + 1 the second and the first shape of the beta distribution."""
    (first, second), location, scale = _arguments(marginal)
    a, b = _jacobi_recurrence(second - 1.0, first - 1.0, degree)
    return _affine_family("Jacobi", location + 0.5 * scale, 0.5 * scale, a, b)


def _jacobi_recurrence(alpha: float, beta: float, degree: int) -> tuple[FloatArray, FloatArray]:
    """Source: Gautschi 2004, table 1.1; a_0 and b_1 in the form that holds for α + β = 0 and −1 as well."""
    total = alpha + beta
    k = np.arange(1.0, degree + 1.0)
    later = (beta**2 - alpha**2) / ((2.0 * k + total) * (2.0 * k + total + 2.0))
    a = np.concatenate([[(beta - alpha) / (total + 2.0)], later])
    k = np.arange(2.0, degree + 2.0)
    numerator = 4.0 * k * (k + alpha) * (k + beta) * (k + total)
    later = numerator / ((2.0 * k + total) ** 2 * (2.0 * k + total + 1.0) * (2.0 * k + total - 1.0))
    first = 4.0 * (1.0 + alpha) * (1.0 + beta) / ((2.0 + total) ** 2 * (3.0 + total))
    return a, np.concatenate([[0.0, first], later])


def _mapped(marginal: Marginal, degree: int) -> Family:
    name = "Hermite through the isoprobabilistic map"
    return Family(name, partial(_standard_normal, marginal), partial(_map_slope, marginal), *_hermite(degree))


def _standard_normal(marginal: Marginal, x: FloatArray) -> FloatArray:
    """ξ, finite at the bounds of a distribution too."""
    return np.clip(marginal.to_standard_normal(x), -FARTHEST, FARTHEST)


def _map_slope(marginal: Marginal, x: FloatArray) -> FloatArray:
    """dξ/dx = f(x)/φ(ξ)."""
    xi = _standard_normal(marginal, x)
    return np.asarray(marginal.pdf(x) * np.sqrt(2.0 * np.pi) * np.exp(0.5 * xi**2))


def _own(marginal: Marginal, degree: int) -> Family:
    mean, std = marginal.mean, marginal.std
    if not (np.isfinite(mean) and np.isfinite(std)):
        raise InputError(f"basis: {marginal} has no variance and so no polynomials of its own; choose the basis 'hermite'")
    nodes, weights = nodes_and_weights(marginal)
    a, b = stieltjes((nodes - mean) / std, weights, degree)
    return _affine_family("its own polynomials", mean, std, a, b)


_CLASSICAL: dict[str, Callable[[Marginal, int], Family]] = {
    "uniform": _legendre,
    "norm": _normal,
    "lognorm": _lognormal,
    "expon": _laguerre,
    "gamma": _laguerre,
    "beta": _jacobi,
}


def families(marginals: Any, degree: int, bases: Any) -> tuple[Family, ...]:
    """A family for each of the marginals with its basis. Raises InputError as `orthonormal_family`."""
    return tuple(orthonormal_family(marginal, degree, basis) for marginal, basis in zip(marginals, bases, strict=True))
