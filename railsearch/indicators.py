"""Measures of sets of objective vectors."""

import numpy as np
from numpy.typing import NDArray

from railsearch.space import FloatArray


def non_dominated(objectives: FloatArray) -> NDArray[np.intp]:
    """Rows of `objectives` (n, m), to be minimised, that no other row dominates; of equal rows the first.

    a dominates b if a_i ≤ b_i for all i and a_i < b_i for one (Deb 2001, section 2.4).
    """
    unique, first = np.unique(objectives, axis=0, return_index=True)
    no_worse = np.all(unique[:, None, :] <= unique[None, :, :], axis=2)
    np.fill_diagonal(no_worse, False)
    return np.sort(first[~no_worse.any(axis=0)])
