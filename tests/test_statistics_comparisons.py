from itertools import combinations, permutations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy import stats

from railsearch.errors import InputError
from railsearch.statistics import friedman, holm, pairwise_comparison, probability_best, vargha_delaney

INF, NAN = np.inf, np.nan
SAMPLE = st.lists(st.one_of(st.integers(-5, 5).map(float), st.just(INF)), min_size=1, max_size=8)

# Ranks of C4.5, C4.5+m, C4.5+cf and C4.5+m+cf on 14 data sets by their area under the curve (Demšar 2006, table 6).
DEMSAR_RANKS = np.array(
    [
        [4, 3, 2, 1],
        [1, 2, 3, 4],
        [4, 1, 2, 3],
        [4, 1, 3, 2],
        [4, 2, 3, 1],
        [1, 2.5, 4, 2.5],
        [3, 2, 4, 1],
        [2.5, 2.5, 4, 1],
        [4, 3, 2, 1],
        [2.5, 2.5, 2.5, 2.5],
        [4, 2.5, 1, 2.5],
        [3, 2, 4, 1],
        [4, 1, 2, 3],
        [3, 1, 4, 2],
    ]
)


def test_holms_adjustment_by_hand() -> None:
    np.testing.assert_allclose(holm([0.01, 0.04, 0.03, 0.005]), [0.03, 0.06, 0.06, 0.02])
    np.testing.assert_allclose(holm([0.6, 0.4]), [0.8, 0.8])
    assert holm([]).size == 0


@given(st.lists(st.floats(0.0, 1.0), min_size=1, max_size=5))
def test_holms_adjustment_is_closed_testing_with_bonferroni(p_values: list[float]) -> None:
    """A hypothesis falls if every intersection of hypotheses that contains it falls (Marcus, Peritz and Gabriel 1976)."""
    p = np.array(p_values)
    sets = [list(s) for size in range(1, p.size + 1) for s in combinations(range(p.size), size)]
    closed = [max(min(1.0, len(s) * p[s].min()) for s in sets if i in s) for i in range(p.size)]
    np.testing.assert_allclose(holm(p), closed, rtol=1e-12)


@pytest.mark.parametrize("p_values", [[0.5, NAN], [-0.1], [1.1], [[0.5]]])
def test_holm_refuses_what_is_no_p_value(p_values: object) -> None:
    with pytest.raises(InputError, match="p_values"):
        holm(p_values)


@given(SAMPLE, SAMPLE)
def test_effect_is_the_share_of_pairs_won(a: list[float], b: list[float]) -> None:
    won = np.mean([[1.0 if x < y else 0.5 if x == y else 0.0 for y in b] for x in a])
    assert vargha_delaney(a, b) == pytest.approx(won, abs=1e-12)
    assert vargha_delaney(a, b) + vargha_delaney(b, a) == pytest.approx(1.0, abs=1e-12)


def test_lower_values_are_better() -> None:
    assert vargha_delaney([1.0, 2.0], [3.0, INF]) == 1.0
    assert vargha_delaney([INF], [INF]) == 0.5


@given(st.lists(SAMPLE, min_size=2, max_size=4))
def test_only_the_order_of_values_counts(samples: list[list[float]]) -> None:
    moved = [np.expm1(np.array(sample)) for sample in samples]
    before, after = pairwise_comparison(samples), pairwise_comparison(moved)
    np.testing.assert_array_equal(before.adjusted, after.adjusted)
    np.testing.assert_array_equal(before.effect, after.effect)


@pytest.mark.parametrize(("second", "arrangements"), [([5.0, 6.0, 7.0, 8.0, 9.0], 7), ([5.0, 6.0, 8.0, 9.0, 10.0], 4)])
def test_p_value_is_that_of_the_tables(second: list[float], arrangements: int) -> None:
    """P(U ≤ 3) = 7/252 and P(U ≤ 2) = 4/252 for samples of five (Mann and Whitney 1947, table I)."""
    comparison = pairwise_comparison([[1.0, 2.0, 3.0, 4.0, 7.5], second])
    assert comparison.p_values[0, 1] == pytest.approx(2.0 * arrangements / 252.0)


@given(SAMPLE.filter(lambda sample: len(sample) <= 6), SAMPLE.filter(lambda sample: len(sample) <= 6))
def test_p_value_counts_all_arrangements_of_the_ranks_with_their_ties(a: list[float], b: list[float]) -> None:
    ranks = stats.rankdata(a + b)
    sums = np.array([sum(chosen) for chosen in combinations(ranks, len(a))])
    middle = len(a) * (len(a) + len(b) + 1) / 2.0
    extreme = np.mean(np.abs(sums - middle) >= abs(ranks[: len(a)].sum() - middle) - 1e-9)
    assert pairwise_comparison([a, b]).p_values[0, 1] == pytest.approx(extreme, rel=1e-12)


@pytest.mark.parametrize("size", [3, 20, 50])
def test_p_value_without_ties_is_scipys(size: int) -> None:
    values = np.random.default_rng(size).normal(size=size + 50)
    a, b = values[:size] + 0.3, values[size:]
    expected = stats.mannwhitneyu(a, b, method="exact").pvalue
    assert pairwise_comparison([a, b]).p_values[0, 1] == pytest.approx(expected, rel=1e-9)


def test_ties_within_a_strategy_do_not_blur_its_distance_from_another() -> None:
    """The smallest p-value there is, 2/C(16, 8), whether the worse runs ended on one value or on eight."""
    best = np.arange(8.0)
    for worst in (np.full(8, INF), np.full(8, 10.0), np.arange(10.0, 18.0)):
        assert pairwise_comparison([best, worst]).p_values[0, 1] == pytest.approx(2.0 / 12870.0, rel=1e-12)


def test_p_value_of_many_runs_is_the_corrected_normal_one() -> None:
    """z = (|U − ab/2| − 1/2)/σ, σ² = ab/12 (n + 1 − Σ(t³ − t)/(n(n − 1))) (Hollander and Wolfe 1999, section 4.1)."""
    generator = np.random.default_rng(5)
    a, b = (list(np.where(values > 8.0, INF, values)) for values in (generator.poisson(4.0, 51), generator.poisson(5.0, 40)))
    won = sum(float(x > y) + 0.5 * float(x == y) for x in a for y in b)
    ties = sum(t**3 - t for t in np.unique(a + b, return_counts=True)[1])
    n = 91
    deviation = np.sqrt(51.0 * 40.0 / 12.0 * (n + 1.0 - ties / (n * (n - 1.0))))
    expected = 2.0 * stats.norm.sf((abs(won - 1020.0) - 0.5) / deviation)
    assert pairwise_comparison([a, b]).p_values[0, 1] == pytest.approx(expected)


def test_comparison_is_a_table_of_all_pairs() -> None:
    generator = np.random.default_rng(4)
    samples = [generator.normal(shift, 1.0, size) for shift, size in ((0.0, 6), (1.0, 7), (5.0, 8))]
    comparison = pairwise_comparison(samples)
    for i, j in combinations(range(3), 2):
        alone = pairwise_comparison([samples[i], samples[j]])
        assert comparison.p_values[i, j] == comparison.p_values[j, i] == alone.adjusted[0, 1]
        assert comparison.effect[i, j] == alone.effect[0, 1] == 1.0 - comparison.effect[j, i]
    pairs = ([0, 0, 1], [1, 2, 2])
    np.testing.assert_array_equal(comparison.adjusted[pairs], holm(comparison.p_values[pairs]))
    np.testing.assert_array_equal(comparison.adjusted, comparison.adjusted.T)
    np.testing.assert_array_equal(np.diag(comparison.effect), 0.5)
    assert comparison.adjusted[0, 2] < 0.01


def test_equal_values_and_single_strategies_show_nothing() -> None:
    comparison = pairwise_comparison([[3.0, 3.0], [3.0, 3.0, 3.0], [3.0]])
    np.testing.assert_array_equal(comparison.adjusted, np.ones((3, 3)))
    np.testing.assert_array_equal(comparison.effect, np.full((3, 3), 0.5))
    assert pairwise_comparison([[INF, INF], [INF]]).p_values[0, 1] == 1.0
    np.testing.assert_array_equal(pairwise_comparison([[1.0, 2.0]]).adjusted, [[1.0]])


@pytest.mark.parametrize("sample", [[], [1.0, NAN], [[1.0]]])
def test_samples_without_a_value_or_with_nan_are_named(sample: list[float]) -> None:
    with pytest.raises(InputError, match="sample 2"):
        pairwise_comparison([[1.0], sample])


def test_identical_strategies_are_rarely_told_apart() -> None:
    """In at most 5 % of campaigns any of the ten pairs differs; for one pair alone the exact test keeps its own level."""
    campaigns = 400
    generator = np.random.default_rng(6)
    found = alone = 0
    for _ in range(campaigns):
        comparison = pairwise_comparison(generator.normal(size=(5, 15)))
        found += bool(np.any(comparison.adjusted < 0.05))
        alone += bool(comparison.p_values[0, 1] < 0.05)
    assert found <= stats.binom.ppf(0.999, campaigns, 0.05)
    assert stats.binom.ppf(0.001, campaigns, 0.045) <= alone <= stats.binom.ppf(0.999, campaigns, 0.05)


def test_identical_strategies_with_ties_and_failed_runs_are_rarely_told_apart() -> None:
    campaigns = 300
    generator = np.random.default_rng(7)
    samples = generator.choice([1.0, 2.0, 3.0, 5.0, INF], size=(campaigns, 4, 15))
    found = sum(bool(np.any(pairwise_comparison(sample).adjusted < 0.05)) for sample in samples)
    assert found <= stats.binom.ppf(0.999, campaigns, 0.05)


def test_demsars_example() -> None:
    """χ²_F = 9.28 (there without the correction for ties), CD = 1.25 at 5 % and 1.12 at 10 % with two groups."""
    result = friedman(DEMSAR_RANKS)
    np.testing.assert_allclose(result.mean_ranks, [3.143, 2.000, 2.893, 1.964], atol=5e-4)
    ties = sum(t**3 - t for row in DEMSAR_RANKS for t in np.unique(row, return_counts=True)[1])
    assert result.statistic is not None
    assert result.statistic * (1.0 - ties / (14 * 4 * 15)) == pytest.approx(9.28, abs=5e-3)
    assert result.p_value == pytest.approx(stats.chi2.sf(result.statistic, 3))
    assert result.critical_difference == pytest.approx(1.25, abs=5e-3)
    assert result.groups == ((3, 1, 2, 0),)
    tenth = friedman(DEMSAR_RANKS, level=0.10)
    assert tenth.critical_difference == pytest.approx(1.12, abs=5e-3)
    assert tenth.groups == ((3, 1, 2), (2, 0))


@pytest.mark.parametrize(("k", "quantile"), [(3, 2.343), (5, 2.728), (7, 2.949), (10, 3.164)])
def test_critical_differences_are_those_of_the_table(k: int, quantile: float) -> None:
    """q_0.05 of Demšar 2006, table 5(a)."""
    result = friedman(np.random.default_rng(1).random((20, k)))
    assert result.critical_difference == pytest.approx(quantile * np.sqrt(k * (k + 1) / 120.0), abs=1e-3)


def test_strategies_always_in_the_same_order_fall_into_overlapping_groups() -> None:
    """Ranks 1 … 6 over 20 problems, CD = 2.850 · √(42/120) = 1.69: each holds together with its neighbours only."""
    order = np.array([4, 0, 5, 2, 1, 3])
    values = np.empty((20, 6))
    values[:, order] = np.arange(6.0)
    result = friedman(values)
    assert result.statistic == pytest.approx(20 * 5)
    assert result.groups == tuple(zip(order.tolist()[:-1], order.tolist()[1:], strict=True))


def test_a_strategy_apart_from_all_is_in_no_group() -> None:
    alike = np.random.default_rng(2).random((30, 3))
    worst = friedman(np.column_stack([alike, np.full(30, INF)]))
    assert [sorted(group) for group in worst.groups] == [[0, 1, 2]]
    best = friedman(np.column_stack([np.full(30, -1.0), alike]))
    assert [sorted(group) for group in best.groups] == [[1, 2, 3]]
    pairs = friedman(np.column_stack([alike, np.full((30, 2), INF)]))
    assert [sorted(group) for group in pairs.groups] == [[0, 1, 2], [3, 4]]


def test_no_pair_differs_if_the_test_as_a_whole_shows_nothing() -> None:
    """The best and the worst mean rank lie more than CD apart here, but χ²_F does not reject (p = 0.094)."""
    ranks = [
        [3, 4, 7, 5, 1, 6, 2, 8],
        [2, 1, 3, 5, 7, 4, 6, 8],
        [7, 4, 6, 2, 5, 1, 3, 8],
        [2, 1, 6, 3, 8, 5, 7, 4],
        [8, 1, 6, 7, 4, 3, 5, 2],
        [7, 2, 3, 4, 6, 8, 1, 5],
        [7, 1, 2, 5, 6, 4, 3, 8],
    ]
    result = friedman(ranks)
    assert result.critical_difference is not None
    assert np.ptp(result.mean_ranks) > result.critical_difference
    assert [sorted(group) for group in result.groups] == [list(range(8))]


@given(hnp.arrays(float, st.tuples(st.integers(2, 6), st.integers(3, 5)), elements=st.integers(-3, 3).map(float)))
def test_ranks_do_not_change_under_monotone_transformations(values: np.ndarray) -> None:
    before, after = friedman(values), friedman(np.exp(values) * np.arange(1.0, len(values) + 1.0)[:, None])
    np.testing.assert_array_equal(before.mean_ranks, after.mean_ranks)
    assert (before.p_value, before.groups) == (after.p_value, after.groups)
    assert before.mean_ranks.sum() == pytest.approx(values.shape[1] * (values.shape[1] + 1) / 2)


def test_ranks_over_three_problems_differ_only_if_all_problems_agree() -> None:
    """Of the 36 ways to rank three strategies on two more problems only the one that agrees everywhere has p < 5 %."""
    rows = [np.array(row) for row in permutations((1.0, 2.0, 3.0))]
    results = [friedman([rows[0], second, third]) for second in rows for third in rows]
    rejected = [number for number, result in enumerate(results) if result.p_value is not None and result.p_value < 0.05]
    assert rejected == [0]


def test_what_cannot_be_tested_says_so() -> None:
    two = friedman([[1.0, 2.0], [3.0, 4.0], [1.0, 5.0]])
    one = friedman([[1.0, 3.0, 2.0]])
    assert "three strategies" in two.untested
    assert "two problems" in one.untested
    np.testing.assert_array_equal(one.mean_ranks, [1.0, 3.0, 2.0])
    for result in (two, one):
        assert (result.statistic, result.p_value, result.critical_difference, result.groups) == (None, None, None, ())


def test_strategies_tied_everywhere_do_not_differ() -> None:
    result = friedman(np.ones((4, 3)))
    assert (result.statistic, result.p_value, result.untested) == (0.0, 1.0, "")
    assert result.groups == ((0, 1, 2),)


@pytest.mark.parametrize("values", [[[1.0, NAN, 2.0]], [1.0, 2.0], np.empty((0, 3))])
def test_friedman_refuses_what_it_cannot_rank(values: object) -> None:
    with pytest.raises(InputError, match="values"):
        friedman(values)
    with pytest.raises(InputError, match="level"):
        friedman(np.ones((3, 3)), level=5)


def test_identical_strategies_are_rarely_ranked_apart() -> None:
    campaigns = 500
    values = np.random.default_rng(8).normal(size=(campaigns, 10, 5))
    results = [friedman(table) for table in values]
    rejected = sum(result.p_value is not None and result.p_value < 0.05 for result in results)
    assert stats.binom.ppf(0.001, campaigns, 0.04) <= rejected <= stats.binom.ppf(0.999, campaigns, 0.05)
    assert sum(len(result.groups[0]) < 5 for result in results) <= rejected


def test_probability_best_is_the_exact_one() -> None:
    """Resamples of {0, 3} have medians 0, 1.5, 1.5, 3 with equal chance; against 1 they win with a chance of 1/4."""
    shares = probability_best([[0.0, 3.0], [1.0]], np.random.default_rng(1), resamples=40_000)
    assert shares.sum() == pytest.approx(1.0)
    assert abs(shares[0] - 0.25) < 4.0 * np.sqrt(0.25 * 0.75 / 40_000)


def test_probability_best_shares_ties_and_ranks_failed_runs_last() -> None:
    shares = probability_best([[2.0, 2.0], [2.0], [INF, INF]], np.random.default_rng(1), resamples=10)
    np.testing.assert_array_equal(shares, [0.5, 0.5, 0.0])
    np.testing.assert_array_equal(probability_best([[INF], [INF, INF]], np.random.default_rng(1), 5), [0.5, 0.5])


def test_probability_best_enumerates_all_resamples_of_small_samples() -> None:
    a, b = np.array([1.0, 4.0, 6.0]), np.array([2.0, 3.0, 7.0])
    medians = [np.median(np.stack(np.meshgrid(s, s, s)).reshape(3, -1), axis=0) for s in (a, b)]
    exact = np.mean(medians[0][:, None] < medians[1][None, :])
    shares = probability_best([a, b], np.random.default_rng(2), resamples=40_000)
    assert abs(shares[0] - exact) < 4.0 * np.sqrt(exact * (1.0 - exact) / 40_000)


def test_probability_best_needs_strategies() -> None:
    with pytest.raises(InputError, match="bootstrap"):
        probability_best([], np.random.default_rng(1))
