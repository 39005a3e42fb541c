"""Threshold formulation: clipping and direct minimisation, safe intervals, states, thresholds out of reach."""

import json

import numpy as np
import pytest
from functions import Differentiable, box, linear, waves

from railsearch.errors import InputError
from railsearch.interfaces import Quantity
from railsearch.sensitivity import (
    ExtremeSurfaces,
    SearchSettings,
    direct_threshold_surfaces,
    extreme_surfaces,
    factors_on,
    margin,
    threshold_surfaces,
)

UNIT = box((0.0, 1.0), (0.0, 1.0), (0.0, 1.0))
COEFFICIENTS = np.array([4.0, 2.0, -1.0])
"""g = 4 x1 + 2 x2 − x3 on the unit cube: from −1 to 6; Ȳmax of x1 is 2 + 4 x1, of x2 4 + 2 x2, of x3 6 − x3."""


def found(model, factors, seed=0):
    return extreme_surfaces(model, factors, np.random.default_rng(seed), output=Quantity("g", "mm"))


def of(surfaces, name, place=0):
    return {factor.name: factor for factor in surfaces.thresholds[place].factors}[name]


@pytest.fixture(scope="module")
def extremes():
    return found(linear(COEFFICIENTS), factors_on(UNIT, 7))


def test_safe_intervals_of_a_linear_function_are_exact(extremes):
    """Ȳmax below 5: x1 < 3/4, x2 < 1/2, never by x3 unless it is 1, where 5 is touched."""
    surfaces = threshold_surfaces(extremes, 5.0)
    assert of(surfaces, "x1").safe == ((0.0, pytest.approx(0.75)),)
    assert of(surfaces, "x2").safe == ((0.0, pytest.approx(0.5)),)
    assert of(surfaces, "x3").safe == ()
    assert surfaces.thresholds[0].critical == ("x1", "x2")
    assert surfaces.thresholds[0].status == "reached"


def test_safe_intervals_of_a_lower_limit_look_at_the_minimum(extremes):
    """Ȳmin above 0.5: −1 + 4 x1 > 0.5 for x1 > 3/8, −1 + 2 x2 > 0.5 for x2 > 3/4, −x3 never."""
    surfaces = threshold_surfaces(extremes, [0.5], limit="lower")
    assert of(surfaces, "x1").safe == ((pytest.approx(0.375), 1.0),)
    assert of(surfaces, "x2").safe == ((pytest.approx(0.75), 1.0),)
    assert of(surfaces, "x3").safe == ()


def test_a_safe_interval_keeps_its_promise_and_outside_it_the_limit_can_be_reached(extremes):
    generator = np.random.default_rng(4)
    (low, high), *_ = of(threshold_surfaces(extremes, 5.0), "x1").safe
    points = generator.random((5000, 3))
    inside = points.copy()
    inside[:, 0] = low + (high - low) * points[:, 0]
    assert (inside @ COEFFICIENTS).max() < 5.0
    assert np.array([high + 1e-6, 1.0, 0.0]) @ COEFFICIENTS > 5.0


@pytest.mark.parametrize(
    "model", [linear(COEFFICIENTS), waves(5.0, 1.0, 0.5), Differentiable(lambda x: x[:, 0] * x[:, 1], None)]
)
def test_clipping_equals_direct_minimisation(model):
    if model.slopes is None:
        model.slopes = lambda x: np.column_stack([x[:, 1], x[:, 0], np.zeros(len(x))])
    factors = factors_on(UNIT, 9)
    surfaces = found(model, factors)
    low, high = (surfaces.extreme(sense) for sense in ("minimum", "maximum"))
    thresholds = low + (high - low) * np.array([-0.2, 0.05, 0.4, 0.8, 0.97, 1.3])
    clipped = threshold_surfaces(surfaces, thresholds)
    direct = direct_threshold_surfaces(model, surfaces, thresholds, np.random.default_rng(5))
    for place in range(len(thresholds)):
        for name in factors.names:
            np.testing.assert_allclose(
                of(clipped, name, place).curve, of(direct, name, place).curve, atol=1e-6 * (high - low)
            )
            assert of(clipped, name, place).safe == of(direct, name, place).safe
    assert (clipped.method, clipped.effort) == ("clipping", None)
    assert direct.method == "direct minimisation"
    assert direct.effort.asked > 0


def test_the_curve_is_the_threshold_where_it_is_reached_and_the_maximum_where_it_is_not(extremes):
    grid = extremes.factors.grids[0]
    np.testing.assert_allclose(of(threshold_surfaces(extremes, 5.0), "x1").curve, np.minimum(2.0 + 4.0 * grid, 5.0))


def test_states_follow_from_both_extremes(extremes):
    """At t = 2.9 g reaches from −1 + 4 x1 to 2 + 4 x1 with x1 held."""
    grid = extremes.factors.grids[0]
    expected = ["reliable" if 2 + 4 * x < 2.9 else "failing" if -1 + 4 * x > 2.9 else "reachable" for x in grid]
    assert set(expected) == {"reliable", "reachable", "failing"}
    assert list(of(threshold_surfaces(extremes, 2.9), "x1").states) == expected
    swapped = {"reliable": "failing", "failing": "reliable", "reachable": "reachable"}
    lower = of(threshold_surfaces(extremes, 2.9, limit="lower"), "x1")
    assert list(lower.states) == [swapped[state] for state in expected]


@pytest.mark.parametrize(
    ("value", "limit", "status", "safe"),
    [
        (6.5, "upper", "never reached", ((0.0, 1.0),)),
        (-1.5, "upper", "always beyond", ()),
        (-1.5, "lower", "never reached", ((0.0, 1.0),)),
        (6.5, "lower", "always beyond", ()),
    ],
)
def test_a_threshold_outside_the_range_of_the_output_is_a_result_that_says_so(extremes, value, limit, status, safe):
    surfaces = threshold_surfaces(extremes, value, limit)
    (threshold,) = surfaces.thresholds
    assert threshold.status == status
    assert threshold.critical == ()
    assert {factor.safe for factor in threshold.factors} == {safe}
    assert surfaces.message(threshold) == f"{value:g} mm is {status}: g lies between -1 and 6 mm"


def test_a_factor_without_influence_is_not_critical():
    surfaces = threshold_surfaces(found(linear([1.0, 0.0, 1.0]), factors_on(UNIT, 5)), 1.5)
    assert surfaces.thresholds[0].critical == ("x1", "x3")
    np.testing.assert_array_equal(of(surfaces, "x2").curve, 1.5)


def test_the_margin_is_positive_where_the_limit_state_fails():
    assert margin([1.0, 3.0], 2.0).tolist() == [-1.0, 1.0]
    assert margin([1.0, 3.0], 2.0, "lower").tolist() == [1.0, -1.0]


def test_the_document_is_plain(extremes):
    document = json.loads(json.dumps(threshold_surfaces(extremes, [5.0, 9.0]).document(), allow_nan=False))
    first, second = document["thresholds"]
    assert (first["value"], first["status"], first["critical"]) == (5.0, "reached", ["x1", "x2"])
    assert first["factors"][0]["safe"] == [[0.0, pytest.approx(0.75)]]
    assert "between -1 and 6 mm" in second["message"]
    direct = direct_threshold_surfaces(
        linear(COEFFICIENTS), extremes, 5.0, np.random.default_rng(0), SearchSettings(check=4)
    )
    assert json.loads(json.dumps(direct.document(), allow_nan=False))["effort"]["check"]["held"]


@pytest.mark.parametrize(
    ("thresholds", "limit", "message"),
    [([], "upper", "one or more"), ([1.0, np.nan], "upper", "finite"), ([1.0], "middle", "upper or lower")],
)
def test_bad_input_is_named(extremes, thresholds, limit, message):
    with pytest.raises(InputError, match=message):
        threshold_surfaces(extremes, thresholds, limit)


def test_extremes_of_one_sense_are_refused(extremes):
    half = ExtremeSurfaces(extremes.factors, extremes.output, {"maximum": extremes.curves["maximum"]}, extremes.effort)
    with pytest.raises(InputError, match="minimum: only the maximum was looked for"):
        threshold_surfaces(half, 1.0)
