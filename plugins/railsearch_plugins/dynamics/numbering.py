"""Numbering of unknowns in natural order along the track."""

from collections.abc import Sequence

import numpy as np

from railsearch_plugins.dynamics.beam import FloatArray, IntArray


def number_along(bodies: Sequence[tuple[FloatArray, IntArray]]) -> tuple[list[IntArray], int]:
    """Number unknowns by position along the track, which keeps the band narrow.

    bodies: groups of positions (m,) and how many unknowns stand there (m,); at the same position groups come in their
    order. Returns the first unknown of each position (m,), per group, and the number of unknowns.
    """
    positions, counts = (np.concatenate(values) for values in zip(*bodies, strict=True))
    sizes = [values.size for values, _ in bodies]
    order = np.lexsort((np.repeat(np.arange(len(sizes)), sizes), positions))
    first = np.empty_like(counts)
    first[order] = np.cumsum(counts[order]) - counts[order]
    return np.split(first, np.cumsum(sizes)[:-1]), int(counts.sum())
