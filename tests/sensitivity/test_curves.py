"""What is read off curves: variances, importances, slopes, intervals."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from railsearch.sensitivity.curves import (
    intervals_above,
    intervals_below,
    local_sensitivity,
    plain,
    shares,
    weighted_variance,
)
from railsearch.sensitivity.factors import trapezoidal_weights


def test_the_weighted_variance_of_a_line_tends_to_that_of_a_uniform_variable():
    """(b − a)²/12, however unevenly the grid is spaced; without weights a logarithmic grid gives another."""
    grid = np.geomspace(1.0, 1000.0, 4000)
    assert weighted_variance(grid, trapezoidal_weights(grid)) == pytest.approx(999.0**2 / 12.0, rel=1e-5)
    assert weighted_variance(grid, np.ones(len(grid))) < 0.7 * 999.0**2 / 12.0


def test_missing_values_are_left_out_of_a_variance():
    curve, weights = np.array([1.0, np.nan, 3.0]), np.array([1.0, 5.0, 1.0])
    assert weighted_variance(curve, weights) == pytest.approx(1.0)
    assert weighted_variance(np.full(3, np.nan), weights) == 0.0


def test_importances_sum_to_one_or_are_all_zero():
    assert shares(np.array([3.0, 1.0])).tolist() == [0.75, 0.25]
    assert shares(np.zeros(3)).tolist() == [0.0, 0.0, 0.0]


def test_the_local_sensitivity_of_a_parabola_is_exact_inside():
    grid = np.array([0.0, 0.5, 2.0, 3.0])
    np.testing.assert_allclose(local_sensitivity(grid, grid**2)[1:-1], 2.0 * grid[1:-1])
    assert np.isnan(local_sensitivity(grid, np.array([1.0, np.nan, 2.0, 3.0]))[0])


@given(st.floats(0.01, 0.99), st.integers(2, 40))
def test_a_line_crosses_a_threshold_where_it_should(threshold, points):
    grid = np.geomspace(1.0, 10.0, points)
    rising = (grid - 1.0) / 9.0
    ((low, high),) = intervals_below(grid, rising, threshold)
    assert (low, high) == (1.0, pytest.approx(1.0 + 9.0 * threshold))
    ((low, high),) = intervals_above(grid, rising, threshold)
    assert (low, high) == (pytest.approx(1.0 + 9.0 * threshold), pytest.approx(10.0))


def test_intervals_of_a_curve_that_goes_up_and_down():
    grid, curve = np.arange(7.0), np.array([0.0, 2.0, 0.0, 0.0, 2.0, 2.0, 0.0])
    assert intervals_below(grid, curve, 1.0) == [(0.0, 0.5), (1.5, 3.5), (5.5, 6.0)]
    assert intervals_above(grid, curve, 1.0) == [(0.5, 1.5), (3.5, 5.5)]
    assert intervals_below(grid, curve, 3.0) == [(0.0, 6.0)]
    assert intervals_below(grid, curve, 0.0) == [], "touching is reaching"


def test_an_interval_ends_where_nothing_is_known():
    grid, curve = np.arange(5.0), np.array([0.0, 0.0, np.nan, 0.0, 2.0])
    assert intervals_below(grid, curve, 1.0) == [(0.0, 1.0), (3.0, 3.5)]


def test_plain_numbers_have_none_for_what_is_not_finite():
    assert plain(np.array([[1.0, np.nan], [np.inf, 2.0]])) == [[1.0, None], [None, 2.0]]
