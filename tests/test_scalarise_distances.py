"""Weighted sum, Chebyshev and L_p distances: order, Pareto optimality, invariances, closed forms, errors at the door."""

import json
import math
import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import railsearch
from railsearch.errors import InputError
from railsearch.interfaces import Quantity
from railsearch.parameters import make_parameters
from railsearch.scalarise import chebyshev, deviations, lp_distance, weighted_sum
from railsearch_plugins.scalarisers.global_criterion import Chebyshev, LpDistance, WeightedSum

PLUGINS = (WeightedSum, Chebyshev, LpDistance)
FORCE, ENERGY, COMFORT = Quantity("F_max", "N"), Quantity("E_max", "N·m"), Quantity("comfort", "m/s²", maximised=True)
WORST = {"F_max": 6000.0, "E_max": 1.5}
IDEAL = {"F_max": 1000.0, "E_max": 0.5}
EQUAL = np.ones(3)
DEVIATIONS = arrays(float, (6, 3), elements=st.floats(0.0, 10.0))
SIGNED = arrays(float, (6, 3), elements=st.floats(-10.0, 10.0))
WEIGHTS = arrays(float, (3,), elements=st.floats(0.1, 10.0))
# Whole numbers: a design that is better is so by more than rounding.
LATTICE = arrays(float, (25, 3), elements=st.integers(0, 9).map(float))
ORDERS = st.sampled_from([1.0, 1.5, 2.0, 3.0, 4.0])


def made(plugin, values, objectives=(FORCE, ENERGY), worst=WORST):
    return plugin(make_parameters(plugin.Parameters, values, plugin.name), list(objectives), worst)


def dominated(rows, chosen):
    """Whether another row is better in every objective, and whether one is as good in all and better in some."""
    better, as_good = rows < chosen, rows <= chosen
    return bool(better.all(axis=1).any()), bool((as_good.all(axis=1) & better.any(axis=1)).any())


def test_deviations_are_zero_at_the_ideal_point_and_one_at_the_nadir():
    ideal, nadir = np.array([1.0, -2.0]), np.array([3.0, 8.0])
    np.testing.assert_allclose(deviations(np.array([ideal, nadir, [2.0, 18.0]]), ideal, nadir), [[0, 0], [1, 1], [0.5, 2.0]])


@given(SIGNED, WEIGHTS)
def test_order_one_is_the_weighted_sum(rows, weights):
    np.testing.assert_allclose(lp_distance(rows, weights, 1.0), weighted_sum(rows, weights), rtol=1e-9, atol=1e-9)


@given(SIGNED, WEIGHTS)
def test_order_infinity_is_the_chebyshev_distance(rows, weights):
    np.testing.assert_array_equal(lp_distance(rows, weights, math.inf), chebyshev(rows, weights))


@given(DEVIATIONS, WEIGHTS, st.floats(1.0, 50.0), st.floats(1.0, 4.0))
def test_distances_shrink_with_the_order_down_to_chebyshevs(rows, weights, p, factor):
    """max ≤ ‖·‖_q ≤ ‖·‖_p ≤ m^(1/p) max for q ≥ p."""
    largest, wide, narrow = chebyshev(rows, weights), lp_distance(rows, weights, p), lp_distance(rows, weights, factor * p)
    slack = 1e-9 * (1.0 + wide)
    assert np.all(largest <= narrow + slack)
    assert np.all(narrow <= wide + slack)
    assert np.all(wide <= 3.0 ** (1.0 / p) * largest + slack)


def test_order_two_is_the_euclidean_norm():
    rows = np.random.default_rng(1).uniform(0.0, 5.0, (20, 3))
    np.testing.assert_allclose(lp_distance(rows, EQUAL, 2.0), np.linalg.norm(rows, axis=1), rtol=1e-14)


def test_a_value_better_than_the_ideal_counts_with_negative_sign():
    np.testing.assert_allclose(lp_distance(np.array([[3.0, -1.0], [-2.0, 0.0]]), np.ones(2), 2.0), [math.sqrt(8.0), -2.0])


@given(SIGNED, arrays(float, (6, 3), elements=st.floats(0.01, 5.0)), WEIGHTS, ORDERS)
def test_better_in_every_objective_is_better(rows, gains, weights, p):
    for scalarise in (weighted_sum, chebyshev, lambda values, w: lp_distance(values, w, p)):
        assert np.all(scalarise(rows - gains, weights) < scalarise(rows, weights))


@settings(max_examples=50)
@given(LATTICE, WEIGHTS, ORDERS)
def test_a_minimiser_is_pareto_optimal_and_of_the_chebyshev_distance_weakly_so(rows, weights, p):
    values = deviations(rows, np.full(3, -1.0), np.full(3, 9.0))
    for scalars in (weighted_sum(values, weights), lp_distance(values, weights, p)):
        assert dominated(rows, rows[np.argmin(scalars)]) == (False, False)
    weakly, _ = dominated(rows, rows[np.argmin(chebyshev(values, weights))])
    assert not weakly


def test_a_minimiser_of_the_chebyshev_distance_may_be_dominated_weakly():
    rows = np.array([[3.0, 1.0], [3.0, 0.0]])
    assert np.argmin(chebyshev(rows, np.ones(2))) == 0
    assert np.argmin(lp_distance(rows, np.ones(2), 2.0)) == 1


@given(arrays(float, (6, 2), elements=st.floats(0.0, 9e3)), st.floats(1e-3, 1e3), st.floats(-50.0, 50.0), ORDERS)
def test_units_and_origins_of_the_objectives_do_not_matter(rows, scale, shift, p):
    ideal, nadir = np.array([100.0, 5.0]), np.array([6000.0, 7000.0])
    original = lp_distance(deviations(rows, ideal, nadir), np.ones(2), p)
    changed = lp_distance(deviations(scale * rows + shift, scale * ideal + shift, scale * nadir + shift), np.ones(2), p)
    np.testing.assert_allclose(changed, original, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("ratio", [0.5, 1.0, 3.0])
def test_minimisers_on_the_front_of_two_spheres(ratio):
    """On f = (t², (1 − t)²) the weighted sum is least at t = w₂/(w₁ + w₂), the largest term where both are equal.

    The Euclidean one is least where the derivatives of (w t²)² and (1 − t)⁴ are equal: w² t³ = (1 − t)³.
    """
    t = np.linspace(0.0, 1.0, 100_001)
    front, weights = np.column_stack([t**2, (1.0 - t) ** 2]), np.array([ratio, 1.0])
    assert t[np.argmin(weighted_sum(front, weights))] == pytest.approx(1.0 / (1.0 + ratio), abs=2e-5)
    assert t[np.argmin(chebyshev(front, weights))] == pytest.approx(1.0 / (1.0 + math.sqrt(ratio)), abs=2e-5)
    assert t[np.argmin(lp_distance(front, weights, 2.0))] == pytest.approx(1.0 / (1.0 + ratio ** (2.0 / 3.0)), abs=2e-5)


@pytest.mark.parametrize("function", [weighted_sum, chebyshev, lambda values, weights: lp_distance(values, weights, 2.0)])
@pytest.mark.parametrize("weights", [[1.0, -1.0], [0.0, 0.0], [np.nan, 1.0], [1.0]])
def test_weights_that_are_not_allowed_are_refused(function, weights):
    with pytest.raises(InputError, match="weights"):
        function(np.ones((2, 2)), np.array(weights))


def test_an_order_below_one_and_a_nadir_not_above_the_ideal_are_refused():
    with pytest.raises(InputError, match=re.escape("an order 1 ≤ p ≤ ∞ is needed, received 0.5")):
        lp_distance(np.ones((1, 2)), np.ones(2), 0.5)
    with pytest.raises(InputError, match="nadir value must lie above the ideal, received 1 and 2 for objective 2"):
        deviations(np.ones((1, 2)), np.array([0.0, 2.0]), np.ones(2))


def test_by_hand():
    rows = np.array([[3500.0, 0.7]])  # δ = (0.5, 0.2)
    weights = {"F_max": 2.0}
    assert made(WeightedSum, {"ideal": IDEAL, "weights": weights})(rows)[0] == pytest.approx(1.2)
    assert made(Chebyshev, {"ideal": IDEAL, "weights": weights})(rows)[0] == pytest.approx(1.0)
    assert made(LpDistance, {"ideal": IDEAL})(rows)[0] == pytest.approx(math.hypot(0.5, 0.2))
    assert made(LpDistance, {"ideal": IDEAL, "p": "infinity"})(rows)[0] == pytest.approx(0.5)
    raw = {"normalise": False}
    assert made(WeightedSum, raw, worst={})(rows)[0] == pytest.approx(3500.7)
    assert made(Chebyshev, raw | {"ideal": IDEAL}, worst={})(rows)[0] == pytest.approx(2500.0)


@pytest.mark.parametrize("plugin", PLUGINS)
def test_a_maximised_objective_is_given_and_shown_with_its_natural_sign(plugin):
    """Comfort, to be maximised, from −3 (nadir) to −1 (ideal) is discomfort, to be minimised, from 3 to 1."""
    natural = made(
        plugin,
        {"ideal": {"F_max": 1000.0, "comfort": -1.0}, "nadir": {"comfort": -3.0}},
        (FORCE, COMFORT),
        {"F_max": 6000.0},
    )
    mirrored = made(
        plugin,
        {"ideal": {"F_max": 1000.0, "discomfort": 1.0}, "nadir": {"discomfort": 3.0}},
        (FORCE, Quantity("discomfort")),
        {"F_max": 6000.0},
    )
    rows = np.array([[2000.0, 1.5], [4000.0, 2.5]])
    np.testing.assert_array_equal(natural(rows), mirrored(rows))
    assert natural.values["ideal"] == {"F_max": 1000.0, "comfort": -1.0}
    assert natural.values["nadir"] == {"F_max": 6000.0, "comfort": -3.0}
    json.dumps(natural.values, allow_nan=False)


@pytest.mark.parametrize("plugin", PLUGINS)
@pytest.mark.parametrize(
    ("values", "worst", "message"),
    [
        ({}, WORST, ".ideal: the value of F_max, E_max is not known: take the best one that `railsearch sample PROBLEM`"),
        (
            {"ideal": IDEAL},
            {"F_max": 6000.0},
            ".nadir: the value of E_max is not known: take the worst one that `railsearch",
        ),
        (
            {"ideal": {"F_max": 7000.0, "E_max": 0.5}},
            WORST,
            ".ideal.F_max: the ideal value must lie below the nadir value, received 7000 and 6000 N; set ideal or nadir",
        ),
        ({"ideal": {"A_max": 1.0}}, WORST, ".ideal: unknown objective 'A_max', did you mean 'F_max'?; the objectives"),
        ({"nadir": {"F_max": "high"}}, WORST, ".nadir.F_max: a finite number is needed, received 'high'"),
        ({"nadir": {"F_max": math.inf}}, WORST, ".nadir.F_max: a finite number is needed, received inf"),
        ({"weights": {"F_max": -1.0}}, WORST, ".weights.F_max: a weight ≥ 0 is needed, received -1.0"),
        ({"weights": {"F_max": 0, "E_max": 0}}, WORST, ".weights: all weights are zero (F_max, E_max)"),
        ({"weights": {"A_max": 1}}, WORST, ".weights: unknown 'A_max', did you mean 'F_max'?; there are"),
        ({"normalize": True}, WORST, ": unknown parameter 'normalize'; did you mean 'normalise'?"),
        ({"ideal": 3}, WORST, ".ideal: a table is needed, received 3"),
    ],
)
def test_bad_settings_are_refused(plugin, values, worst, message):
    with pytest.raises(InputError, match=re.escape(plugin.name + message)):
        made(plugin, values, worst=worst)


@pytest.mark.parametrize(("p", "received"), [(0.5, "0.5"), (math.inf, "inf"), ("two", "'two'"), (math.nan, "nan")])
def test_an_order_that_is_not_allowed_is_refused_with_what_is(p, received):
    with pytest.raises(InputError, match=rf"lp\.p: .*'infinity'.*received {received}"):
        made(LpDistance, {"ideal": IDEAL, "p": p})


def test_a_maximised_ideal_below_its_nadir_is_refused_in_natural_numbers():
    values = {"ideal": {"F_max": 1000.0, "comfort": -3.0}, "nadir": {"comfort": -1.0}}
    with pytest.raises(
        InputError, match=r"comfort: the ideal value must lie above the nadir value, received -3 and -1 m/s²"
    ):
        made(Chebyshev, values, (FORCE, COMFORT))


def test_problems_are_scalarised_by_name():
    for plugin in PLUGINS:
        settings = {"ideal": {"left": 0.0, "right": 0.0}}
        problem = railsearch.problem("two-spheres", scalariser=plugin.name, scalariser_settings=settings)
        assert problem.n_obj == 1
        assert problem.evaluate(problem.space.lower[None, :])[0, 0] > 0.0
