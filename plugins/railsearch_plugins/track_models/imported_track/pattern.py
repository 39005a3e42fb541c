"""The common pattern of sparse symmetric matrices, in an order with a short envelope, and their factorisations on it.

symbol  meaning                                                             shape   unit
p, q    rows and columns of the lower triangle of all matrices together     (m,)    -
order   unknown as exported of every unknown here: as exported or reverse   (n,)    -
        Cuthill–McKee (1969), whichever has the shorter envelope
S       diag(A)^(-1/2), which makes the diagonal of S A S one               (n,)
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse
import scipy.sparse.linalg
from numpy.typing import NDArray
from scipy.sparse.csgraph import reverse_cuthill_mckee

from railsearch.errors import InputError
from railsearch_plugins.dynamics.envelope import Envelope, envelope_of, factorise, in_envelope

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

# Values in an envelope up to which it is factorised (0.4 GB). Beyond, general sparse LU is taken.
MOST_VALUES = 50_000_000

# Negative eigenvalues of S A S that rounding in an export may leave.
ROUNDING = 1e-9


@dataclass(frozen=True)
class Pattern:
    """Lower triangle p, q (m,) of all matrices in their `order` (n,), `place` (n,) its inverse, and its envelope."""

    order: IntArray
    place: IntArray
    rows: IntArray
    columns: IntArray
    envelope: Envelope

    @property
    def size(self) -> int:
        """How many unknowns there are."""
        return self.order.size

    @property
    def half_bandwidth(self) -> int:
        """The largest distance of an entry from the diagonal."""
        return int((self.rows - self.columns).max())

    @property
    def short(self) -> bool:
        """The envelope is short enough to be factorised."""
        return int(self.envelope.offset[-1]) <= MOST_VALUES


def make_pattern(matrices: Sequence[Any]) -> Pattern:
    """The pattern of symmetric sparse matrices (n, n) together, in the order with the shorter envelope."""
    size = matrices[0].shape[0]
    union = scipy.sparse.csr_array(sum((abs(matrix) for matrix in matrices), scipy.sparse.eye_array(size, format="csr")))
    union = scipy.sparse.csr_array(union + union.T)
    ordered = reverse_cuthill_mckee(scipy.sparse.csr_matrix(union), symmetric_mode=True).astype(np.int64)
    return min((_pattern(union, order) for order in (np.arange(size), ordered)), key=lambda p: int(p.envelope.offset[-1]))


def on_pattern(matrix: Any, pattern: Pattern) -> FloatArray:
    """A matrix (n, n) as values (m,) on the pattern, the mean of its halves."""
    symmetric = scipy.sparse.csr_array(0.5 * (matrix + matrix.T))
    return np.asarray(symmetric[pattern.order[pattern.rows], pattern.order[pattern.columns]], dtype=float).ravel()


def whole_matrix(values: FloatArray, pattern: Pattern) -> Any:
    """Values (m,) on the pattern as a sparse matrix (n, n) in CSC, both halves."""
    below = pattern.rows != pattern.columns
    rows = np.concatenate([pattern.rows, pattern.columns[below]])
    columns = np.concatenate([pattern.columns, pattern.rows[below]])
    return scipy.sparse.csc_array((np.concatenate([values, values[below]]), (rows, columns)), shape=(pattern.size,) * 2)


def factor(values: FloatArray, pattern: Pattern) -> tuple[FloatArray, int]:
    """LDLᵀ in the envelope of values (m,), and the first row whose pivot is not positive, −1 if all are."""
    lower, row = factorise(*pattern.envelope, in_envelope(pattern.envelope, pattern.rows, pattern.columns, values))
    return lower, int(row)


def sparse_factor(values: FloatArray, pattern: Pattern) -> tuple[Any, int]:
    """LU of values (m,) without exchanges of rows, and a row whose pivot is not positive, −1 if all are.

    Without exchanges the pivots of a symmetric matrix have the signs of its eigenvalues (Sylvester).
    """
    try:
        made = scipy.sparse.linalg.splu(
            whole_matrix(values, pattern),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
    except RuntimeError:
        return None, 0
    bad = np.flatnonzero(made.U.diagonal() <= 0.0)
    if bad.size:
        return made, int(np.flatnonzero(made.perm_c == bad[0])[0])
    return made, -1


def static_displacement(stiffness: FloatArray, pattern: Pattern, load: FloatArray) -> FloatArray | None:
    """u (n,) of K u = f for K (m,) on the pattern; None if K is not positive definite."""
    from railsearch_plugins.dynamics import envelope

    if not pattern.short:
        made, row = sparse_factor(stiffness, pattern)
        return None if row >= 0 else np.asarray(made.solve(load))
    lower, row = factor(stiffness, pattern)
    if row >= 0:
        return None
    displacement = load.copy()
    envelope.solve(*pattern.envelope, lower, displacement)
    return displacement


def check_semidefinite(name: str, values: FloatArray, pattern: Pattern) -> None:
    """Raise InputError that names an unknown, as exported from 0, unless A (m,) is positive semi-definite.

    S A S + ε has positive pivots if no eigenvalue of S A S is below −ε, and then only; ε is ROUNDING.
    """
    on_diagonal = pattern.rows == pattern.columns
    diagonal, largest = np.zeros(pattern.size), np.zeros(pattern.size)
    diagonal[pattern.rows[on_diagonal]] = values[on_diagonal]
    for side in (pattern.rows, pattern.columns):
        np.maximum.at(largest, side, np.abs(values))
    bad = np.flatnonzero((diagonal < 0.0) | ((diagonal == 0.0) & (largest > 0.0)))
    if bad.size:
        _refuse(name, int(pattern.order[bad[0]]), f"its diagonal is {diagonal[bad[0]]:g} there")
    scale = 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
    scaled = values * scale[pattern.rows] * scale[pattern.columns]
    scaled[on_diagonal] += np.where(scaled[on_diagonal] > 0.0, ROUNDING, 1.0)
    _, row = factor(scaled, pattern) if pattern.short else sparse_factor(scaled, pattern)
    if row >= 0:
        _refuse(name, int(pattern.order[row]), "a combination of it with other unknowns has negative energy")


def _refuse(name: str, unknown: int, why: str) -> None:
    raise InputError(
        f"{name}: a positive semi-definite matrix is needed, received an indefinite one, which shows at unknown {unknown} "
        f"(from 0): {why}; check the signs of springs, dampers and masses and what was exported as this matrix"
    )


def _pattern(union: Any, order: IntArray) -> Pattern:
    place = np.empty_like(order)
    place[order] = np.arange(order.size)
    entries = union.tocoo()
    rows, columns = place[entries.row], place[entries.col]
    lower = rows >= columns
    rows, columns = rows[lower], columns[lower]
    sorting = np.lexsort((columns, rows))
    rows, columns = rows[sorting], columns[sorting]
    return Pattern(order, place, rows, columns, envelope_of(rows, columns, order.size))
