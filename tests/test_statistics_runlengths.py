import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from railsearch.errors import InputError
from railsearch.statistics import best_so_far, expected_running_time, relative_targets, runlength_ecdf, runlengths

INF, NAN = np.inf, np.nan
CURVES = np.array([[NAN, 8.0, 8.0, 2.0], [9.0, 6.0, 5.0, 5.0], [NAN, NAN, NAN, NAN]])


def test_targets_divide_the_way_from_the_median_start_to_the_best() -> None:
    curves = np.array([[NAN, 9.0, 4.0], [10.0, 10.0, 0.0], [17.0, 7.0, 5.0]])
    targets = relative_targets(curves, count=4, precision=0.01)
    assert (targets.start, targets.best) == (10.0, 0.0)
    np.testing.assert_allclose(targets.fractions, 10.0 ** np.array([-0.5, -1.0, -1.5, -2.0]))
    np.testing.assert_allclose(targets.values, 10.0 * targets.fractions)


def test_a_better_value_known_from_elsewhere_counts_and_a_worse_one_does_not() -> None:
    curves = np.array([[10.0, 2.0]])
    np.testing.assert_allclose(relative_targets(curves, 1, 0.5, best_known=-10.0).values, [0.0])
    np.testing.assert_allclose(relative_targets(curves, 1, 0.5, best_known=5.0).values, [6.0])


@given(
    hnp.arrays(float, (4, 6), elements=st.floats(-100.0, 100.0).map(lambda value: round(value, 3))),
    st.sampled_from([1e-3, 0.5, 7.0, 1e4]),
    st.sampled_from([-1e3, -1.0, 0.0, 250.0]),
)
def test_targets_and_runlengths_do_not_change_with_scale_and_shift(values: np.ndarray, scale: float, shift: float) -> None:
    curves = best_so_far(values)
    targets = relative_targets(curves, count=3, precision=0.1)
    moved = relative_targets(scale * curves + shift, count=3, precision=0.1)
    size = scale * 100.0 + abs(shift)
    np.testing.assert_allclose(moved.values, scale * targets.values + shift, rtol=0, atol=1e-12 * size)
    clear = np.abs(curves[:, :, None] - targets.values).min(axis=(0, 1)) > 1e-9 * size / scale
    before, after = runlengths(curves, targets.values), runlengths(scale * curves + shift, moved.values)
    np.testing.assert_array_equal(before[:, clear], after[:, clear])


@given(hnp.arrays(float, (5, 4), elements=st.floats(-1e3, 1e3)))
def test_the_best_run_reaches_all_targets_and_easier_ones_no_later(values: np.ndarray) -> None:
    curves = best_so_far(values)
    targets = relative_targets(curves)
    assert np.all(np.diff(targets.values) <= 0.0)
    lengths = runlengths(curves, targets.values)
    assert np.isfinite(lengths[curves[:, -1].argmin()]).all() or targets.start < targets.best
    assert np.all(lengths[:, :-1] <= lengths[:, 1:])


def test_problems_without_a_value_or_without_progress_have_none_or_equal_targets() -> None:
    assert relative_targets(np.full((2, 3), NAN)).values.size == 0
    np.testing.assert_array_equal(relative_targets(np.full((2, 3), 7.0), count=2).values, [7.0, 7.0])


@pytest.mark.parametrize(("count", "precision"), [(0, 0.1), (3, 0.0), (3, 1.0)])
def test_targets_refuse_a_count_and_a_precision_that_make_none(count: int, precision: float) -> None:
    with pytest.raises(InputError, match="targets"):
        relative_targets(CURVES, count, precision)


def test_runlengths_count_from_one_and_equality_reaches() -> None:
    expected = [[2.0, 4.0, INF], [1.0, 3.0, INF], [INF, INF, INF]]
    np.testing.assert_array_equal(runlengths(CURVES, np.array([9.0, 5.0, 1.0])), expected)


def test_expected_running_time_by_hand() -> None:
    lengths = np.array([[10.0, INF, INF], [30.0, 50.0, INF], [20.0, INF, INF]])
    np.testing.assert_allclose(expected_running_time(lengths, 100), [20.0, 250.0, INF])


def test_a_success_beyond_the_budget_is_none_and_unequal_budgets_are_added() -> None:
    lengths = np.array([[10.0], [80.0], [INF]])
    np.testing.assert_allclose(expected_running_time(lengths, 50), [110.0])
    np.testing.assert_allclose(expected_running_time(lengths, [50, 100, 7]), [(10.0 + 80.0 + 7.0) / 2.0])


def test_expected_running_time_is_the_mean_cost_of_restarting_until_success() -> None:
    generator = np.random.default_rng(5)
    lengths = np.where(generator.random(40) < 0.4, generator.integers(1, 100, 40).astype(float), INF)
    drawn = generator.choice(lengths, (20_000, 60))
    successes = np.isfinite(drawn)
    assert successes.any(axis=1).all()
    first = successes.argmax(axis=1)
    costs = 100.0 * first + drawn[np.arange(len(drawn)), first]
    expected = expected_running_time(lengths[:, None], 100)[0]
    assert abs(costs.mean() - expected) < 4.0 * costs.std() / np.sqrt(len(costs))


def test_the_ecdf_by_hand() -> None:
    lengths = np.array([[1.0, 4.0], [2.0, INF]])
    np.testing.assert_array_equal(runlength_ecdf(lengths, [0, 1, 2, 3, 4, 1000]), [0.0, 0.25, 0.5, 0.5, 0.75, 0.75])


@given(hnp.arrays(float, (4, 5), elements=st.one_of(st.integers(1, 50).map(float), st.just(INF))))
def test_the_ecdf_rises_to_the_fraction_ever_reached(lengths: np.ndarray) -> None:
    fractions = runlength_ecdf(lengths, np.arange(51))
    assert np.all(np.diff(fractions) >= 0.0)
    assert fractions[0] == 0.0
    assert fractions[-1] == np.isfinite(lengths).mean()


def test_an_ecdf_of_nothing_is_refused() -> None:
    with pytest.raises(InputError, match="runlengths"):
        runlength_ecdf(np.empty((3, 0)), [1])
