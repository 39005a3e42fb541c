"""Terms of a regression taken in one at a time, with the leave-one-out error at every step in closed form.

| symbol | meaning | shape | source |
|---|---|---|---|
| n, m, k | number of points, of candidate terms, of active ones | scalar | |
| y | values | (n,) | |
| Ψ | candidate terms at the points, the constant left out | (n, m) | |
| μ, D | means of the columns of Ψ, lengths of what is left without them | (m,) | |
| X | (Ψ − μ)/D | (n, m) | Efron et al. 2004, Eq. 1.1 |
| Q, R | the constant and an orthonormal basis of the active columns of X = Q R | (n, k + 1), (k, k) | |
| r | residual y − Q Qᵀy of the least-squares fit | (n,) | |
| h | leverages, diagonal of Q Qᵀ | (n,) | |
| T | correction n/(n − k − 1) (1 + tr((ΨᵀΨ)⁻¹)), Ψ with the constant | scalar | Blatman & Sudret 2011, Eq. 25 |
| ε | T mean((r/(1 − h))²)/Var(y) | scalar | Blatman & Sudret 2011, Eq. 23 |

The correction is that of Chapelle, Vapnik & Bengio 2002 with the Gram matrix of the terms as they are, so that it rises for
bad designs.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from railsearch.space import FloatArray

COLLINEAR = 1e-8
"""A column of unit length of which no more than this is left outside of the active ones says nothing new."""

EXACT = 1e-30
"""Relative errors below the square of rounding; no term is needed any more."""


@dataclass(frozen=True)
class SelectionPath:
    """Terms (k,) in the order in which they came in, and ε (k + 1,) of the fits to them, the constant alone first."""

    order: NDArray[np.int64]
    errors: FloatArray

    @property
    def best(self) -> NDArray[np.int64]:
        """The terms of the fit with the least error."""
        return self.order[: int(np.argmin(self.errors))]

    @property
    def error(self) -> float:
        """The least error."""
        return float(np.min(self.errors))


class Candidates:
    """Candidate terms Ψ (n, m) at the points, standardised once for every path through the first of them."""

    def __init__(self, terms: FloatArray) -> None:
        self.means = terms.mean(axis=0)
        centred = np.asfortranarray(terms - self.means)
        lengths = np.sqrt(np.einsum("ij,ij->j", centred, centred))
        varies = lengths > COLLINEAR * np.sqrt(len(terms)) * np.maximum(1.0, np.abs(self.means))
        self.lengths = np.where(varies, lengths, np.inf)
        self.columns = np.divide(centred, self.lengths, out=centred)


class ActiveSet:
    """Q, R, R⁻¹, r, h and ε of the active terms among the first `count` candidates."""

    def __init__(self, candidates: Candidates, values: FloatArray, count: int, most_terms: int) -> None:
        n = len(values)
        self.columns = candidates.columns[:, :count]
        self.open = np.isfinite(candidates.lengths[:count])
        self.order: list[int] = []
        self.capacity = max(0, min(most_terms, count, n - 2))
        self.residual = values - values.mean()
        self.factor = np.zeros((self.capacity, self.capacity))
        self._means, self._lengths = candidates.means, candidates.lengths
        self._variance = float(np.var(values))
        self._basis = np.zeros((n, self.capacity + 1), order="F")
        self._basis[:, 0] = 1.0 / np.sqrt(n)
        self._inverse = np.zeros((self.capacity, self.capacity))
        self._leverage = np.full(n, 1.0 / n)
        self._trace = 1.0 / n

    @property
    def size(self) -> int:
        """k."""
        return len(self.order)

    @property
    def basis(self) -> FloatArray:
        """Q (n, k) without the constant."""
        return self._basis[:, 1 : self.size + 1]

    def enter(self, strength: FloatArray) -> int | None:
        """Take in the open term of the largest positive strength (m,); those that depend on the active ones are closed.

        None if there is none.
        """
        ranked = np.where(self.open, strength, -1.0)
        while True:
            term = int(np.argmax(ranked))
            if not ranked[term] > 0.0:
                return None
            self.open[term], ranked[term] = False, -1.0
            if self._append(term):
                return term

    @property
    def error(self) -> float:
        """ε; infinite where a point determines its own fit."""
        n, k = len(self.residual), self.size
        left = 1.0 - self._leverage
        if np.min(left) <= COLLINEAR:
            return np.inf
        residuals = self.residual / left
        correction = n / (n - k - 1) * (1.0 + self._trace)
        return correction * float(residuals @ residuals) / n / self._variance

    def _append(self, term: int) -> bool:
        """Gram and Schmidt, twice; False if nothing is left of the column."""
        k, column = self.size, self.columns[:, term]
        active = self._basis[:, : k + 1]
        first = active.T @ column
        rest = column - active @ first
        second = active.T @ rest
        rest -= active @ second
        length = float(np.linalg.norm(rest))
        if length < COLLINEAR:
            return False
        self.order.append(term)
        self._extend(rest / length, (first + second)[1:], length)
        return True

    def _extend(self, new: FloatArray, weights: FloatArray, length: float) -> None:
        """A column of Q, R and R⁻¹; tr((ΨᵀΨ)⁻¹) = 1/n + ‖(R D)⁻¹‖² + ‖μᵀ(R D)⁻¹‖²."""
        k = self.size - 1
        self._basis[:, k + 1] = new
        self.factor[:k, k], self.factor[k, k] = weights, length
        self._inverse[:k, k], self._inverse[k, k] = self._inverse[:k, :k] @ weights / -length, 1.0 / length
        self.residual -= new * (new @ self.residual)
        self._leverage += new**2
        column = self._inverse[: k + 1, k] / self._lengths[self.order]
        self._trace += float(column @ column) + float(self._means[self.order] @ column) ** 2


class Steps:
    """The errors along a path, and when it has gone on long enough."""

    def __init__(self, active: ActiveSet, patience: int) -> None:
        self._active = active
        self._patience = patience
        self._errors = [active.error]

    def taken(self) -> bool:
        """Note the last step; whether another one is worth taking."""
        self._errors.append(self._active.error)
        best = int(np.argmin(self._errors))
        full = self._active.size == self._active.capacity
        return not full and self._active.size - best < self._patience and self._errors[-1] > EXACT

    @property
    def path(self) -> SelectionPath:
        """The path that was gone."""
        return SelectionPath(np.array(self._active.order, dtype=np.int64), np.array(self._errors))
