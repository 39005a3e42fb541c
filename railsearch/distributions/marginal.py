"""The distribution of one random input: any continuous one of scipy.stats, also truncated.

| symbol | meaning | unit |
|---|---|---|
| X, x | the input and a value of it | the caller's |
| F, p | cumulative distribution function and a value of it | - |
| a, b | bounds of a truncation | that of x |
| μ, σ | mean and standard deviation of X itself | that of x |
| ξ | standard normal value with Φ(ξ) = F(x) | - |

A truncated X has F_t(x) = (F(x) − F(a))/(F(b) − F(a)). Upper tails are computed from 1 − F, so that neither percentiles nor
ξ lose digits there.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ndtr, ndtri

from railsearch.errors import InputError
from railsearch.space import FloatArray

STANDARD_NORMAL_GRID = np.linspace(-37.0, 37.0, 7401)
"""Values of ξ over which moments are integrated; beyond, the normal density is below the smallest number."""


@dataclass(frozen=True)
class Marginal:
    """The distribution of one input: a frozen continuous one of scipy.stats between the bounds of its truncation.

    `words` says in messages what it is.
    """

    frozen: Any
    words: str
    lower: float = -math.inf
    upper: float = math.inf

    @property
    def support(self) -> tuple[float, float]:
        """The smallest interval that holds every value."""
        low, high = self.frozen.support()
        return max(float(low), self.lower), min(float(high), self.upper)

    @property
    def bounded(self) -> bool:
        """Whether there is a least and a largest value."""
        return all(map(math.isfinite, self.support))

    def cdf(self, x: ArrayLike) -> FloatArray:
        """F (…) at x (…)."""
        values = np.clip(np.asarray(x, dtype=float), *self.support)
        if self._in_upper_tail:
            return np.asarray((self.frozen.sf(self.lower) - self.frozen.sf(values)) / self._kept)
        return np.asarray((self.frozen.cdf(values) - self._below) / self._kept)

    def sf(self, x: ArrayLike) -> FloatArray:
        """1 − F (…) at x (…), with all digits where it is small."""
        values = np.clip(np.asarray(x, dtype=float), *self.support)
        if self._in_lower_tail:
            return np.asarray((self.frozen.cdf(self.upper) - self.frozen.cdf(values)) / self._kept)
        return np.asarray((self.frozen.sf(values) - self._above) / self._kept)

    def pdf(self, x: ArrayLike) -> FloatArray:
        """The probability density dF/dx (…) at x (…)."""
        values, (low, high) = np.asarray(x, dtype=float), self.support
        return np.asarray(np.where((values >= low) & (values <= high), self.frozen.pdf(values) / self._kept, 0.0))

    def percentile(self, p: ArrayLike) -> FloatArray:
        """x (…) with F(x) = p (…)."""
        share = np.asarray(p, dtype=float) * self._kept
        frozen = self.frozen
        values = frozen.isf(frozen.sf(self.lower) - share) if self._in_upper_tail else frozen.ppf(self._below + share)
        return np.asarray(np.clip(values, *self.support))

    def upper_percentile(self, q: ArrayLike) -> FloatArray:
        """x (…) with 1 − F(x) = q (…)."""
        share = np.asarray(q, dtype=float) * self._kept
        frozen = self.frozen
        values = frozen.ppf(frozen.cdf(self.upper) - share) if self._in_lower_tail else frozen.isf(self._above + share)
        return np.asarray(np.clip(values, *self.support))

    def to_standard_normal(self, x: ArrayLike) -> FloatArray:
        """ξ = Φ⁻¹(F(x)) (…), infinite at a bound."""
        below, above = self.cdf(x), self.sf(x)
        return np.asarray(np.where(below <= above, ndtri(below), -ndtri(above)))

    def from_standard_normal(self, xi: ArrayLike) -> FloatArray:
        """x = F⁻¹(Φ(ξ)) (…)."""
        values = np.asarray(xi, dtype=float)
        half = ndtr(-np.abs(values))
        return np.asarray(np.where(values <= 0.0, self.percentile(half), self.upper_percentile(half)))

    @property
    def mean(self) -> float:
        """μ."""
        if not self._truncated:
            return float(self.frozen.mean())
        median = float(self.percentile(0.5))
        return median + self._expectation(lambda x: x - median)

    @property
    def std(self) -> float:
        """σ."""
        if not self._truncated:
            return float(self.frozen.std())
        mean = self.mean
        return math.sqrt(self._expectation(lambda x: (x - mean) ** 2))

    def probability_outside(self, lower: float, upper: float) -> float:
        """The probability of a value below `lower` or above `upper`."""
        return float(self.cdf(lower) + self.sf(upper))

    def truncated(self, lower: float, upper: float) -> "Marginal":
        """The same distribution kept between two bounds. Raises InputError if there is nothing between them."""
        low, high = max(self.lower, lower), min(self.upper, upper)
        if not low < high or not Marginal(self.frozen, self.words, low, high)._kept > 0.0:
            raise InputError(f"nothing of {self.words} lies between {lower:g} and {upper:g}; widen the bounds")
        return Marginal(self.frozen, self.words, low, high)

    def __str__(self) -> str:
        bounds = f" between {self.lower:g} and {self.upper:g}" if self._truncated else ""
        return self.words + bounds

    @property
    def _truncated(self) -> bool:
        low, high = self.frozen.support()
        return bool(self.lower > low or self.upper < high)

    @cached_property
    def _below(self) -> float:
        return float(self.frozen.cdf(self.lower))

    @cached_property
    def _above(self) -> float:
        return float(self.frozen.sf(self.upper))

    @property
    def _in_lower_tail(self) -> bool:
        return self._above > 0.5

    @property
    def _in_upper_tail(self) -> bool:
        return self._below > 0.5

    @cached_property
    def _kept(self) -> float:
        """F(b) − F(a)."""
        if self._in_upper_tail:
            return float(self.frozen.sf(self.lower)) - self._above
        return float(self.frozen.cdf(self.upper)) - self._below if self._in_lower_tail else 1.0 - self._below - self._above

    def _expectation(self, function: Callable[[FloatArray], FloatArray]) -> float:
        """The mean of a function of X: ∫ f(x(ξ)) φ(ξ) dξ, whatever the scale of x.

        The trapezoidal rule converges faster than any power of the step where x(ξ) is smooth (Trefethen & Weideman 2014).
        """
        values = function(self.from_standard_normal(STANDARD_NORMAL_GRID))
        density = np.exp(-0.5 * STANDARD_NORMAL_GRID**2) / math.sqrt(2.0 * math.pi)
        return float(np.sum(values * density) * (STANDARD_NORMAL_GRID[1] - STANDARD_NORMAL_GRID[0]))
