import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy import stats

from railsearch.errors import InputError
from railsearch.statistics import best_so_far, bootstrap_median_band, quantile_bands

INF, NAN = np.inf, np.nan
CURVES = hnp.arrays(float, st.tuples(st.integers(1, 9), st.integers(1, 4)), elements=st.floats(-1e6, 1e6))


def test_best_so_far_passes_over_failed_evaluations() -> None:
    values = [[NAN, 3.0, NAN, 5.0, -1.0], [2.0, 1.0, 1.0, NAN, 0.0]]
    expected = [[NAN, 3.0, 3.0, 3.0, -1.0], [2.0, 1.0, 1.0, 1.0, 0.0]]
    np.testing.assert_array_equal(best_so_far(values), expected)


@given(CURVES)
def test_best_so_far_is_the_lowest_of_every_beginning(values: np.ndarray) -> None:
    best = best_so_far(values)
    for end in range(values.shape[1]):
        np.testing.assert_array_equal(best[:, end], values[:, : end + 1].min(axis=1))


@given(CURVES, st.lists(st.floats(0.0, 1.0), min_size=1, max_size=4))
def test_quantiles_of_finite_curves_are_those_of_numpy(curves: np.ndarray, levels: list[float]) -> None:
    tolerance = 1e-7 * (1.0 + np.ptp(curves))
    np.testing.assert_allclose(quantile_bands(curves, levels), np.quantile(curves, levels, axis=0), rtol=0, atol=tolerance)


def test_a_run_without_a_value_is_worse_than_all_others() -> None:
    curves = np.array([[NAN, 1.0], [NAN, 2.0], [5.0, 3.0], [INF, 4.0], [7.0, 5.0]])
    bands = quantile_bands(curves, (0.0, 0.25, 0.375, 0.5, 1.0))
    np.testing.assert_array_equal(bands[:, 0], [5.0, 7.0, INF, INF, INF])
    np.testing.assert_array_equal(bands[:, 1], [1.0, 2.0, 2.5, 3.0, 5.0])


def test_a_level_that_falls_on_a_value_up_to_rounding_takes_no_part_of_the_next() -> None:
    curves = np.full((31, 1), INF)
    curves[:4, 0] = [1.0, 2.0, 3.0, 4.0]
    rounded_up = 3.0000000000000004 / 30.0
    assert quantile_bands(curves, [rounded_up])[0, 0] == 4.0


@pytest.mark.parametrize("curves", [np.empty((0, 4)), np.zeros(3)])
def test_curves_are_a_matrix_with_a_run(curves: np.ndarray) -> None:
    with pytest.raises(InputError, match="curves"):
        quantile_bands(curves)
    with pytest.raises(InputError, match="curves"):
        bootstrap_median_band(curves, np.random.default_rng(1))


def test_levels_are_refused_by_name() -> None:
    with pytest.raises(InputError, match="levels"):
        quantile_bands(np.zeros((2, 2)), [1.5])
    with pytest.raises(InputError, match="level"):
        bootstrap_median_band(np.zeros((2, 2)), np.random.default_rng(1), level=1.0)


def exact_median_distribution(runs: int) -> np.ndarray:
    """P(median of a resample = k-th smallest) for an odd number of runs (Efron 1982, section 10.3)."""
    ranks = np.arange(runs + 1) / runs
    at_or_below = stats.binom.sf((runs - 1) // 2, runs, ranks)
    return np.diff(at_or_below)


def test_the_band_is_that_of_the_exact_bootstrap_distribution() -> None:
    ordered = np.arange(1.0, 16.0) ** 2
    cumulative = np.cumsum(exact_median_distribution(15))
    expected = ordered[np.searchsorted(cumulative, [0.05, 0.95])]
    curves = np.random.default_rng(3).permutation(ordered)[:, None]
    band = bootstrap_median_band(curves, np.random.default_rng(4), level=0.9, resamples=20_000)
    np.testing.assert_array_equal(band[:, 0], expected)


def test_the_band_of_an_even_number_of_runs_is_that_of_scipy() -> None:
    sample = np.random.default_rng(5).normal(size=12)
    band = bootstrap_median_band(sample[:, None], np.random.default_rng(6), resamples=50_000)
    interval = stats.bootstrap((sample,), np.median, n_resamples=50_000, method="percentile", rng=7).confidence_interval
    neighbours = np.diff(np.sort(sample)).max() / 20.0
    np.testing.assert_allclose(band[:, 0], [interval.low, interval.high], atol=neighbours)


@pytest.mark.parametrize(("runs", "low", "high"), [(9, 2, 8), (13, 4, 10), (17, 5, 13)])
def test_the_band_covers_the_true_median_as_often_as_theory_says(runs: int, low: int, high: int) -> None:
    """The exact 95 % band reaches from the low-th to the high-th smallest of all runs, P(low ≤ Bin(runs, 1/2) < high)."""
    experiments = 4000
    curves = np.random.default_rng(8).exponential(size=(runs, experiments))
    lower, upper = bootstrap_median_band(curves, np.random.default_rng(9), resamples=4000)
    covered = int(np.sum((lower <= np.log(2.0)) & (np.log(2.0) <= upper)))
    probability = stats.binom.cdf(high - 1, runs, 0.5) - stats.binom.cdf(low - 1, runs, 0.5)
    assert abs(covered - experiments * probability) < 4.0 * np.sqrt(experiments * probability * (1.0 - probability))


def test_the_band_of_runs_without_a_value_is_open_above() -> None:
    curves = np.array([[NAN], [NAN], [1.0], [2.0], [3.0]])
    band = bootstrap_median_band(curves, np.random.default_rng(1))
    assert band[0, 0] == 1.0
    assert band[1, 0] == INF
    assert np.all(bootstrap_median_band(np.full((3, 2), NAN), np.random.default_rng(1)) == INF)


def test_the_band_comes_from_the_generator_alone() -> None:
    curves = np.random.default_rng(2).normal(size=(8, 5))
    once, again = (bootstrap_median_band(curves, np.random.default_rng(11), resamples=50) for _ in range(2))
    other = bootstrap_median_band(curves, np.random.default_rng(12), resamples=50)
    np.testing.assert_array_equal(once, again)
    assert not np.array_equal(once, other)
