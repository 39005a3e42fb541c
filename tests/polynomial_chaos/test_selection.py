"""Sets of terms, the order in which they come in, and their leave-one-out error."""

import itertools

import numpy as np
import pytest
from sklearn.linear_model import lars_path

from railsearch_plugins.polynomial_chaos.active_set import Candidates
from railsearch_plugins.polynomial_chaos.growth import grown
from railsearch_plugins.polynomial_chaos.least_angle import forward_path, least_angle_path
from railsearch_plugins.polynomial_chaos.multi_indices import hyperbolic_set, q_norms

SELECTIONS = pytest.mark.parametrize("selection", [least_angle_path, forward_path])


def correlated(n=60, m=25, seed=0):
    """Columns with a common part and means of their own, and values of some of them with noise."""
    generator = np.random.default_rng(seed)
    terms = generator.normal(size=(n, m)) + 0.7 * generator.normal(size=(n, 1)) + np.linspace(-2.0, 5.0, m)
    return terms, 3.0 + terms[:, :8] @ np.linspace(2.0, -1.0, 8) + 0.3 * generator.normal(size=n)


@pytest.mark.parametrize(("dimension", "degree", "q", "size"), [(10, 9, 0.5, 571), (16, 15, 0.5, 9081), (10, 9, 1.0, 92378)])
def test_sizes_of_hyperbolic_sets_as_published(dimension, degree, q, size):
    assert len(hyperbolic_set(dimension, degree, q, 100_000)) == size
    assert hyperbolic_set(dimension, degree, q, size - 1) is None


@pytest.mark.parametrize("q", [0.3, 0.5, 0.8, 1.0])
def test_a_hyperbolic_set_holds_every_index_within_the_norm_once_and_by_growing_norm(q):
    every = np.array(list(itertools.product(range(6), repeat=3)))
    expected = {tuple(index) for index in every if sum(k**q for k in index if k) ** (1.0 / q) <= 5.0 + 1e-9}
    indices = hyperbolic_set(3, 5, q, 1000)
    assert len(indices) == len(expected)
    assert {tuple(index) for index in indices} == expected
    assert not indices[0].any()
    assert np.all(np.diff(q_norms(indices, q)) > -1e-7)


@pytest.mark.parametrize("seed", range(3))
def test_least_angle_regression_goes_the_way_of_scikit_learns(seed):
    """As far as scikit-learn keeps the equal correlations that define it, which it loses late on some of these data."""
    generator = np.random.default_rng(seed)
    terms = generator.normal(size=(80, 20))
    values = terms[:, :8] @ np.linspace(2.0, -1.0, 8) + generator.normal(size=80)
    candidates = Candidates(terms)
    columns, rest = candidates.columns, values - values.mean()
    _, order, coefficients = lars_path(columns, rest, method="lar")
    left = np.abs(columns.T @ (rest[:, None] - columns @ coefficients))
    sound = [bool(np.ptp(left[order[:k], k]) < 1e-8) for k in range(1, len(order))]
    common = (*sound, False).index(False) + 1
    assert common > 12
    path = least_angle_path(candidates, values, 20, 20, patience=20)
    assert list(path.order[:common]) == list(order[:common])


@pytest.mark.parametrize("seed", range(3))
def test_least_angle_regression_moves_towards_the_least_squares_fit_until_another_term_is_as_correlated(seed):
    """Efron et al. 2004, Eq. 2.19 and section 3.1, on correlated columns: a fit γ ŷ + (1 − γ) μ has (1 − γ) C left."""
    terms, values = correlated(seed=seed)
    columns, rest = Candidates(terms).columns, values - values.mean()
    order = list(least_angle_path(Candidates(terms), values, 25, 25, patience=25).order)
    fit = np.zeros(60)
    for k in range(1, 25):
        active, others = columns[:, order[:k]], order[k:]
        ahead = active @ np.linalg.lstsq(active, rest)[0] - fit
        largest = np.max(np.abs(active.T @ (rest - fit)))
        assert np.abs(active.T @ (rest - fit)) == pytest.approx(np.full(k, largest), rel=1e-6)
        c, a = columns.T @ (rest - fit), columns.T @ ahead
        ends = {j: min(g for g in ends_of(largest, c[j], a[j]) if g > 0.0) for j in others}
        assert order[k] == min(ends, key=ends.get)
        fit = fit + ends[order[k]] * ahead


def ends_of(largest, c, a):
    """Where ± (c − γ a) = (1 − γ) C."""
    return (largest - c) / (largest - a), (largest + c) / (largest + a)


def test_forward_selection_lowers_the_squares_most_at_every_step():
    """Against least-squares fits to every set with one term more."""
    terms, values = correlated(m=25)
    path = forward_path(Candidates(terms), values, 25, 25, patience=25)
    for k in range(20):
        sums = {j: squares(terms[:, [*path.order[:k], j]], values) for j in set(range(25)) - set(path.order[:k])}
        assert path.order[k] == min(sums, key=sums.get)


def squares(columns, values):
    matrix = np.column_stack([np.ones(len(values)), columns])
    return np.sum((values - matrix @ np.linalg.lstsq(matrix, values)[0]) ** 2)


@SELECTIONS
def test_the_error_is_that_of_refits_without_each_point_corrected(selection):
    """Chapelle's factor with the inverse of the whole Gram matrix, the constant included."""
    terms, values = correlated(n=40, m=12)
    path = selection(Candidates(terms), values, 12, 12, patience=12)
    for k in (0, 1, 5, 12):
        matrix = np.column_stack([np.ones(40), terms[:, path.order[:k]]])
        left_out = [values[i] - matrix[i] @ refit(np.delete(matrix, i, 0), np.delete(values, i)) for i in range(40)]
        factor = 40.0 / (40.0 - k - 1.0) * (1.0 + np.trace(np.linalg.inv(matrix.T @ matrix)))
        assert path.errors[k] == pytest.approx(factor * np.mean(np.square(left_out)) / np.var(values), rel=1e-9)


def refit(matrix, values):
    return np.linalg.lstsq(matrix, values)[0]


@SELECTIONS
def test_columns_that_say_nothing_new_are_passed_over(selection):
    terms, values = correlated(m=8)
    repeated = np.column_stack([terms[:, 0], np.full(60, 7.0), terms, terms[:, 1] - 2.0 * terms[:, 2]])
    path = selection(Candidates(repeated), values, 11, 11, patience=11)
    assert len(path.order) == 8
    assert 1 not in path.order
    assert np.isfinite(path.errors).all()


@SELECTIONS
def test_a_path_ends_when_nothing_is_left_to_explain(selection):
    terms, _ = correlated(m=25)
    path = selection(Candidates(terms), 3.0 + 2.0 * terms[:, 4] - terms[:, 7], 25, 25, patience=25)
    assert set(path.best) == {4, 7} or path.error < 1e-25
    assert len(path.order) < 25


@SELECTIONS
def test_a_path_ends_after_patience(selection):
    generator = np.random.default_rng(1)
    path = selection(Candidates(generator.normal(size=(200, 100))), generator.normal(size=200), 100, 100, patience=7)
    assert len(path.order) == len(path.best) + 7


def test_growth_completes_what_is_kept_and_adds_the_border():
    """From x₁² x₂ and a small x₃: the box under (2, 1, 0) and every index whose backward neighbours are all in it."""
    indices = np.array([[2, 1, 0], [0, 0, 1]])
    candidates = {tuple(index) for index in grown(indices, np.array([1.0, 1e-4]), floor=1e-6, degree=5)}
    box = set(itertools.product(range(3), range(2), [0])) - {(0, 0, 0)}
    assert candidates == box | {(3, 0, 0), (0, 2, 0), (0, 0, 1)}


def test_growth_stays_within_the_degree():
    candidates = grown(np.array([[3, 0]]), np.ones(1), floor=0.0, degree=3)
    assert {tuple(index) for index in candidates} == {(1, 0), (2, 0), (3, 0), (0, 1)}
