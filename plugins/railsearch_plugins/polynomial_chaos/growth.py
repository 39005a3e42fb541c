"""Sets of terms that follow the function: pruned to what matters and grown at the border.

| symbol | meaning | shape | source |
|---|---|---|---|
| Λ | lower set of multi-indices: with α it has every α − e_i | | Jakeman et al. 2015, Eq. 11 |
| c | coefficients of the terms | (m,) | |
| ε | corrected leave-one-out error, a fraction of the variance | scalar | |

Terms with c² below a fraction of ε Var(y) are dropped, the rest is completed to a lower set, and every α is added whose
backward neighbours α − e_i are all in the set (Jakeman, Eldred & Sargsyan 2015, section 4.2).
"""

import numpy as np
from numpy.typing import NDArray

from railsearch.space import FloatArray

from .multi_indices import IndexArray

DROPPED = 0.1
"""Terms with a smaller c² than this fraction of ε Var(y) are dropped; own choice, between 0.03 and 0.3, which do alike on a
truss; without dropping, a grown set of 100 points can be worse than the one it came from."""


def grown(indices: IndexArray, coefficients: FloatArray, floor: float, degree: int) -> IndexArray:
    """The candidates (k, d) for the next selection, the constant left out, by growing total degree.

    floor: terms with c² below it are dropped; degree: the largest of an input.
    """
    kept = {tuple(int(k) for k in row) for row in indices[coefficients**2 >= floor]}
    lower = _completed(kept, indices.shape[1])
    border = {
        ahead
        for index in lower
        for ahead in _forward(index, degree)
        if ahead not in lower and all(behind in lower for behind in _backward(ahead))
    }
    return _sorted(lower | border)


def _completed(kept: set[tuple[int, ...]], dimension: int) -> set[tuple[int, ...]]:
    """The least lower set that holds them."""
    lower, open_ = {(0,) * dimension}, list(kept)
    while open_:
        index = open_.pop()
        if index not in lower:
            lower.add(index)
            open_.extend(_backward(index))
    return lower


def _backward(index: tuple[int, ...]) -> list[tuple[int, ...]]:
    return [(*index[:i], k - 1, *index[i + 1 :]) for i, k in enumerate(index) if k]


def _forward(index: tuple[int, ...], degree: int) -> list[tuple[int, ...]]:
    return [(*index[:i], k + 1, *index[i + 1 :]) for i, k in enumerate(index) if k < degree]


def _sorted(chosen: set[tuple[int, ...]]) -> IndexArray:
    every: NDArray[np.int64] = np.array(sorted(chosen, key=lambda index: (sum(index), [-k for k in index])), dtype=np.int64)
    return every[1:]
