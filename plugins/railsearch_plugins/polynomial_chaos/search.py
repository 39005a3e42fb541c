"""The search for the terms of an expansion: hyperbolic sets of every norm and degree, then growth at the border.

| symbol | meaning | shape |
|---|---|---|
| X, y | points and values | (n, d), (n,) |
| q, p | exponent of the norm and degree of a hyperbolic set | scalar |
| ε | corrected leave-one-out error, a fraction of the variance | scalar |
"""

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np
from scipy.linalg import qr, solve_triangular

from railsearch.errors import SurrogateError
from railsearch.space import FloatArray

from ..surrogate_data import relative_error
from .active_set import EXACT, Candidates, SelectionPath
from .expansion import Expansion, design_matrix
from .families import Family
from .growth import DROPPED, grown
from .least_angle import forward_path, least_angle_path
from .multi_indices import ROUNDING, IndexArray, hyperbolic_set, q_norms
from .parameters import PolynomialChaosParameters

FEWEST_POINTS = 3
LEAST_PATIENCE = 20
GROWTH_STEPS = 25


@dataclass(frozen=True)
class Trial:
    """A set of candidates that was searched: where it came from, its size, and the best selection from it."""

    origin: str
    candidates: int
    terms: int
    error: float


@dataclass(frozen=True)
class FittedExpansion:
    """An expansion and what is known of it.

    leave_one_out: residuals (n,) of every value from a fit to the others with the same terms; corrected_error: ε, by which
    the terms were chosen; variance: of the values; trials: all sets that were searched.
    """

    expansion: Expansion
    residuals: FloatArray
    leave_one_out: FloatArray
    corrected_error: float
    variance: float
    trials: tuple[Trial, ...]

    @property
    def errors(self) -> Mapping[str, float]:
        """Mean squared errors as fractions of the variance of the values.

        `training` at the points, `leave-one-out`, and this `corrected` for the number of points, by which terms are chosen.
        """
        residuals = {"training": self.residuals, "leave-one-out": self.leave_one_out}
        plain = {name: relative_error(errors, self.variance) for name, errors in residuals.items()}
        return {**plain, "corrected": self.corrected_error}


def fit_expansion(
    families: tuple[Family, ...], points: FloatArray, values: FloatArray, settings: PolynomialChaosParameters
) -> FittedExpansion:
    """Search the terms for points X (n, d) with values y (n,), and fit their coefficients by least squares.

    Raises SurrogateError for fewer than three points.
    """
    if len(points) < FEWEST_POINTS:
        raise SurrogateError(
            f"pce: {FEWEST_POINTS} or more points are needed for a constant, a term and an error, received {len(points)}"
        )
    search = _Search(families, points, values, settings)
    if np.ptp(values) > 0.0:
        search.over_hyperbolic_sets()
        if settings.growth:
            search.at_the_border()
    return search.fitted()


@dataclass
class _Search:
    """The best terms so far, the constant left out, and their error."""

    families: tuple[Family, ...]
    points: FloatArray
    values: FloatArray
    settings: PolynomialChaosParameters
    trials: list[Trial] = field(default_factory=list)
    error: float = np.inf

    def __post_init__(self) -> None:
        self.chosen: IndexArray = np.empty((0, len(self.families)), dtype=np.int64)
        self.limit = max(len(self.families) + 1, int(self.settings.candidates_per_point * len(self.values)))
        self.patience = max(LEAST_PATIENCE, len(self.values) // 10)

    @property
    def finished(self) -> bool:
        """Whether the error is low enough."""
        return self.error <= max(self.settings.target_error, EXACT)

    def over_hyperbolic_sets(self) -> None:
        """Least angle regression over the sets of every norm, by growing degree; sets of the same size are the same."""
        known: set[bytes] = set()
        for q in self.settings.norms:
            if self.finished:
                break
            largest = self._largest_set(q)
            candidates = Candidates(design_matrix(self.families, largest, self.points))
            errors: list[float] = []
            for p, count in _sizes(largest, q, self.settings.degree):
                signature = np.sort(largest[:count] @ self._weights()).tobytes()
                if signature in known:
                    continue
                known.add(signature)
                path = least_angle_path(candidates, self.values, count, len(self.values), self.patience)
                self._note(f"q = {q:g}, p = {p}", path, largest[:count])
                errors.append(path.error)
                if self.finished or (self.settings.stop_early and _rose_twice(errors)):
                    break

    def at_the_border(self) -> None:
        """Prune, grow and select again, from what was selected last, until the error has not fallen twice in a row."""
        current, error, failures = self.chosen, self.error, 0
        variance = float(np.var(self.values))
        for step in range(GROWTH_STEPS):
            if failures == 2 or self.finished:
                break
            coefficients = self._least_squares(current)[0][1:]
            candidates = grown(current, coefficients, DROPPED * error * variance, self.settings.degree)
            columns = Candidates(design_matrix(self.families, candidates, self.points))
            path = forward_path(columns, self.values, len(candidates), len(self.values), self.patience)
            before = self.error
            self._note(f"growth, step {step + 1}", path, candidates)
            current, error = candidates[path.best], path.error
            failures = failures + 1 if self.error == before else 0

    def fitted(self) -> FittedExpansion:
        """The expansion of the best terms."""
        coefficients, basis = self._least_squares(self.chosen)
        residuals = self.values - basis @ (basis.T @ self.values)
        left = np.maximum(1.0 - np.einsum("ij,ij->i", basis, basis), np.finfo(float).eps)
        indices = self._with_constant(self.chosen)
        expansion = Expansion(self.families, indices, coefficients)
        error = self.error if np.isfinite(self.error) else 0.0
        variance = float(np.var(self.values))
        return FittedExpansion(expansion, residuals, residuals / left, error, variance, tuple(self.trials))

    def _least_squares(self, chosen: IndexArray) -> tuple[FloatArray, FloatArray]:
        """Coefficients (k + 1,), of the constant first, and an orthonormal basis (n, k + 1) of the terms."""
        matrix = design_matrix(self.families, self._with_constant(chosen), self.points)
        basis, factor = qr(matrix, mode="economic", check_finite=False)
        return np.asarray(solve_triangular(factor, basis.T @ self.values, check_finite=False)), basis

    def _with_constant(self, chosen: IndexArray) -> IndexArray:
        return np.vstack([np.zeros((1, len(self.families)), dtype=np.int64), chosen])

    def _largest_set(self, q: float) -> IndexArray:
        """The candidates of the highest degree that has few enough, the constant left out; those of degree 1 at least."""
        sets = (hyperbolic_set(len(self.families), p, q, self.limit) for p in range(1, self.settings.degree + 1))
        *_, largest = itertools.takewhile(lambda indices: indices is not None, sets)
        return largest[1:]  # type: ignore[index]

    def _weights(self) -> FloatArray:
        """Numbers by which multi-indices are told apart."""
        return np.asarray(np.sqrt(np.arange(2.0, len(self.families) + 2.0)) * np.pi ** np.arange(len(self.families)))

    def _note(self, origin: str, path: SelectionPath, candidates: IndexArray) -> None:
        self.trials.append(Trial(origin, len(candidates), len(path.best), path.error))
        if path.error < self.error:
            self.error, self.chosen = path.error, candidates[path.best]


def _sizes(largest: IndexArray, q: float, degree: int) -> Iterator[tuple[int, int]]:
    """Degrees p and how many of the candidates, which are sorted by norm, belong to each."""
    norms = q_norms(largest, q)
    for p in range(1, degree + 1):
        count = int(np.searchsorted(norms, p * (1.0 + 10.0 * ROUNDING), side="right"))
        yield p, count
        if count == len(largest):
            return


def _rose_twice(errors: list[float]) -> bool:
    return len(errors) > 2 and errors[-3] < errors[-2] < errors[-1]
