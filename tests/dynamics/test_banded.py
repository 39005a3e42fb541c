"""The banded factorisation against dense linear algebra, over sizes and profiles."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from railsearch_plugins.dynamics import banded, kernels


def random_band(seed, size, widths):
    """A symmetric positive definite matrix whose row i has widths[i % len] sub-diagonals: dense, and by diagonals."""
    generator = np.random.default_rng(seed)
    dense = np.zeros((size, size))
    for i in range(size):
        for j in range(max(0, i - widths[i % len(widths)]), i):
            dense[i, j] = dense[j, i] = generator.uniform(-1.0, 1.0)
    dense[np.diag_indices(size)] = np.abs(dense).sum(axis=1) + generator.uniform(0.1, 1.0, size)
    band = np.zeros((max([*widths, kernels.WIDE]) + 1, size))
    for k in range(min(band.shape[0], size)):
        band[k, k:] = np.diag(dense, -k)
    return dense, band


def solve(band, load):
    lower = kernels.factorise(band)
    upper, solution = banded.mirrored(lower), load.copy()
    kernels.forward(lower, banded.runs(lower), solution)
    kernels.backward(upper, banded.runs(upper), solution)
    return solution


@settings(max_examples=60, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    size=st.integers(1, 200),
    widths=st.lists(st.integers(0, 11), min_size=1, max_size=70),
)
def test_solution_agrees_with_dense_algebra(seed, size, widths):
    dense, band = random_band(seed, size, widths)
    load = np.random.default_rng(seed + 1).standard_normal(size)
    np.testing.assert_allclose(solve(band, load), np.linalg.solve(dense, load), rtol=1e-10, atol=1e-12)


def test_factor_times_its_transpose_is_the_matrix():
    dense, band = random_band(5, 90, [3, 4, 9, 2])
    factor = kernels.factorise(band)
    lower = np.eye(90)
    for k in range(1, factor.shape[0]):
        lower += np.diag(factor[k, k:], -k)
    np.testing.assert_allclose(lower @ np.diag(1.0 / factor[0]) @ lower.T, dense, rtol=1e-12, atol=1e-12)


def test_reciprocity():
    _, band = random_band(11, 150, [3, 3, 4, 7])
    unit = np.eye(150)
    a, b = solve(band, unit[20]), solve(band, unit[120])
    assert a[120] == pytest.approx(b[20], rel=1e-13)


def test_matrix_that_is_not_positive_definite_gives_no_number():
    _, band = random_band(3, 40, [2])
    band[0, 17] = -1.0
    assert np.isnan(solve(band, np.ones(40))).any()


def test_held_unknowns_are_left_out():
    unknowns = np.array([[-1, 0, 1]])
    band = banded.assemble([(unknowns, np.arange(9.0).reshape(1, 3, 3))], 2, 1)
    np.testing.assert_array_equal(band[0], [4.0, 8.0])
    assert band[1, 1] == 7.0
    assert banded.half_bandwidth([(unknowns, np.empty((1, 3, 3)))]) == 1
