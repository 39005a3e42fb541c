"""Preference functions: ends, order, points, published values, and errors at the door."""

import dataclasses
import math
import re

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from railsearch.errors import InputError
from railsearch.preferences import AGGREGATIONS, Desirability, Linear, MonotoneSpline, PhysicalProgramming, PiecewiseLinear
from railsearch.preferences.physical_programming import RANGES

VALUES = st.floats(-1e3, 1e3)
LIMITS = (1.0, 2.0, 4.0, 5.0, 9.0)


def score(function, value):
    return float(function.score(np.array([value]))[0])


@st.composite
def points(draw):
    """Points with ascending values and falling or rising scores, not all equal."""
    count = draw(st.integers(2, 6))
    steps = draw(st.lists(st.floats(0.1, 10.0), min_size=count, max_size=count))
    scores = sorted(draw(st.lists(st.floats(0.0, 100.0), min_size=count, max_size=count)))
    assume(scores[-1] - scores[0] > 1e-3)
    values = np.cumsum(steps).tolist()
    return tuple(zip(values, scores if draw(st.booleans()) else scores[::-1], strict=True))


@st.composite
def functions(draw):
    """Any preference function that likes smaller or larger values better."""
    ends = sorted(draw(st.tuples(VALUES, VALUES)))
    assume(ends[1] - ends[0] > 1e-3)
    ends = ends if draw(st.booleans()) else ends[::-1]
    side = "upper" if ends[0] < ends[1] else "lower"
    limits = tuple(np.linspace(*ends, 5).tolist())
    kinds = [
        lambda extended: Linear(*ends, extended=extended),
        lambda extended: Desirability(
            ends[0], **{side: ends[1], f"{side}_exponent": draw(st.floats(0.2, 5.0))}, extended=extended
        ),
        lambda extended: PhysicalProgramming(**{side: limits}, extended=extended),
        lambda extended: PiecewiseLinear(draw(points()), extended=extended),
        lambda extended: MonotoneSpline(draw(points()), extended=extended),
    ]
    return draw(st.sampled_from(kinds))(draw(st.booleans()))


@settings(max_examples=60)
@given(functions(), st.lists(VALUES, min_size=2, max_size=20))
def test_scores_rise_or_fall_all_the_way_and_stay_inside_0_to_100_unless_extended(function, values):
    scores = function.score(np.sort([*values, *function.knots]))
    steps = np.diff(scores) * (1.0 if function.liking == "larger" else -1.0)
    assert np.all(steps >= -1e-9 * (1.0 + np.abs(scores).max()))
    if not function.extended:
        assert scores.min() >= 0.0
        assert scores.max() <= 100.0


@settings(max_examples=60)
@given(functions(), st.lists(VALUES, min_size=1, max_size=20))
def test_inside_its_range_a_function_is_the_same_whether_extended_or_not(function, values):
    inside = np.clip(values, function.knots[0], function.knots[-1])
    both = [dataclasses.replace(function, extended=extended).score(inside) for extended in (False, True)]
    np.testing.assert_allclose(*both, atol=1e-9)


@given(VALUES, VALUES)
def test_linear_is_100_at_best_and_0_at_worst(best, worst):
    assume(abs(best - worst) > 1e-6)
    assert score(Linear(best, worst), best) == 100.0
    assert score(Linear(best, worst), worst) == 0.0
    assert score(Linear(best, worst), 0.5 * (best + worst)) == pytest.approx(50.0, abs=1e-6)


def test_outside_linear_is_clipped_or_goes_on():
    values = np.array([-1.0, 5.0])
    assert Linear(0.0, 2.0).score(values).tolist() == [100.0, 0.0]
    assert Linear(0.0, 2.0, extended=True).score(values).tolist() == [150.0, -150.0]
    assert Linear(2.0, 0.0, extended=True).score(values).tolist() == [-50.0, 250.0]


def test_the_published_optimum_scores_about_82_on_the_cost():
    """C_cap from € 8 500 to € 12 500, optimum at € 9 207; E_max 0.1 to 1.4 N·m, A_max 0.21 to 0.26 m/s² (Shang et al.)."""
    assert score(Linear(8500.0, 12500.0), 9207.0) == pytest.approx(82.325, abs=1e-9)
    energy, acceleration = Linear(0.1, 1.4), Linear(0.21, 0.26)
    assert score(energy, 0.1 + 0.18 * 1.3) == pytest.approx(82.0)
    assert score(acceleration, 0.219) == pytest.approx(82.0)


@settings(max_examples=40)
@given(points())
def test_curves_go_through_their_points(chosen):
    values, scores = np.array(chosen).T
    for kind in (PiecewiseLinear, MonotoneSpline):
        np.testing.assert_allclose(kind(chosen).score(values), scores, atol=1e-9)
        np.testing.assert_allclose(kind(chosen[::-1]).score(values), scores, atol=1e-9)


def test_piecewise_linear_between_points_and_extended_with_its_outermost_slopes():
    chosen = ((0.0, 100.0), (1.0, 80.0), (3.0, 0.0))
    values = np.array([0.5, 2.0, -1.0, 4.0])
    np.testing.assert_allclose(PiecewiseLinear(chosen).score(values), [90.0, 40.0, 100.0, 0.0])
    np.testing.assert_allclose(PiecewiseLinear(chosen, extended=True).score(values), [90.0, 40.0, 120.0, -40.0])


def test_a_spline_through_a_straight_line_is_that_line_and_it_has_no_kinks():
    line = MonotoneSpline(((0.0, 100.0), (1.0, 75.0), (4.0, 0.0)))
    values = np.linspace(0.0, 4.0, 41)
    np.testing.assert_allclose(line.score(values), 100.0 - 25.0 * values, atol=1e-12)
    bent = MonotoneSpline(((0.0, 100.0), (1.0, 80.0), (3.0, 0.0)))
    step = 1e-6
    left, right = (np.diff(bent.score(np.array(pair)))[0] / step for pair in ((1.0 - step, 1.0), (1.0, 1.0 + step)))
    assert left == pytest.approx(right, rel=1e-4)
    assert left < -5.0


def test_desirability_of_derringer_and_suichs_tyre_tread():
    """Abrasion 129.5 (120 to 170), modulus 1300 (1000 to 1300), elongation 465.7 (400, 500, 600), hardness 68 (60 to 75).

    Printed are d = 0.189, 1.000, 0.656, 0.932 and D = 0.583 (Derringer and Suich 1980); the responses are rounded to a
    tenth, which leaves 0.001 of d open.
    """
    tread = (
        (Desirability(170.0, lower=120.0), 129.5),
        (Desirability(1300.0, lower=1000.0), 1300.0),
        (Desirability(500.0, lower=400.0, upper=600.0), 465.7),
        (Desirability(67.5, lower=60.0, upper=75.0), 68.0),
    )
    scores = np.array([[score(function, value) for function, value in tread]])
    np.testing.assert_allclose(scores, [[18.9, 100.0, 65.6, 93.2]], atol=0.15)
    assert AGGREGATIONS["geometric-mean"](scores, np.ones(4))[0] == pytest.approx(58.3, abs=0.15)


def test_exponents_of_desirability():
    function = Desirability(10.0, lower=0.0, upper=30.0, lower_exponent=2.0, upper_exponent=0.5)
    np.testing.assert_allclose(function.score(np.array([5.0, 25.0, 10.0, -1.0, 31.0])), [25.0, 50.0, 100.0, 0.0, 0.0])
    assert function.liking == "between"
    extended = dataclasses.replace(function, extended=True)
    np.testing.assert_allclose(extended.score(np.array([-5.0, 40.0, 10.0])), [-50.0, -50.0, 100.0])
    assert score(Desirability(10.0, lower=0.0, extended=True), 12.0) == pytest.approx(120.0)


@pytest.mark.parametrize("growth", [None, 8.0, 20.0])
def test_class_function_at_the_ends_of_its_ranges(growth):
    """P_k = 100 (1 − z_k/z_5) with z_k = 1 + r + … + r^(k−1)."""
    function = PhysicalProgramming(LIMITS, growth=growth)
    r = growth or function.least_growth
    z = np.array([sum(r**j for j in range(k)) for k in range(1, 6)])
    np.testing.assert_allclose(function.score(np.array(LIMITS)), 100.0 * (1.0 - z / z[-1]), atol=1e-9)
    assert score(function, 9.001) == 0.0
    assert score(function, -100.0) > 99.0


def class_function(values, growth=8.0):
    """z/z_1 of the class function, from the extended score."""
    total = sum(growth**j for j in range(5))
    return total * (1.0 - PhysicalProgramming(LIMITS, growth=growth, extended=True).score(values) / 100.0)


def test_class_function_is_convex_and_smooth():
    values = np.linspace(-3.0, 12.0, 3001)
    z = class_function(values)
    assert np.all(np.diff(z, 2) > -1e-9 * z.max())
    step = 1e-6
    for limit in LIMITS:
        left, right = (np.diff(class_function(np.array(pair)))[0] for pair in ((limit - step, limit), (limit, limit + step)))
        assert left == pytest.approx(right, rel=1e-3)


@pytest.mark.parametrize("k", [1, 2, 3, 4])
def test_class_function_is_messacs_spline_inside_a_range(k):
    """z = T_0 z_(k−1) + T_1 z_k + T̄_0 s_(k−1) + T̄_1 s_k with the polynomials of Messac 1996, slopes taken numerically."""
    low, high = LIMITS[k - 1], LIMITS[k]
    width, step, place = high - low, 1e-5, np.linspace(0.0, 1.0, 11)
    start, end = class_function(np.array([low, high]))
    slopes = [np.diff(class_function(np.array([x - step, x + step])))[0] / (2.0 * step) for x in (low, high)]
    a, b = place**4, (place - 1.0) ** 4
    expected = (
        (a / 2 - b / 2 - 2 * place + 1.5) * start
        + (-a / 2 + b / 2 + 2 * place - 0.5) * end
        + width * (a / 8 - 3 * b / 8 - place / 2 + 3 / 8) * slopes[0]
        + width * (3 * a / 8 - b / 8 - place / 2 + 1 / 8) * slopes[1]
    )
    np.testing.assert_allclose(class_function(low + width * place), expected, rtol=1e-4)


@given(st.integers(2, 6), st.integers(2, 4))
def test_one_versus_others(n_objectives, k):
    """Crossing range k + 1 costs one objective more than crossing range k costs all others."""
    growth = max(1.1 * (n_objectives - 1), PhysicalProgramming(LIMITS).least_growth)
    scores = PhysicalProgramming(LIMITS, growth=growth).score(np.array(LIMITS))
    losses = -np.diff(scores)
    assert losses[k - 1] > (n_objectives - 1) * losses[k - 2]


def test_class_functions_in_both_directions():
    smaller, larger = PhysicalProgramming(LIMITS), PhysicalProgramming(lower=tuple(-limit for limit in LIMITS))
    values = np.linspace(-2.0, 10.0, 50)
    np.testing.assert_allclose(larger.score(-values), smaller.score(values), atol=1e-12)
    between = PhysicalProgramming(LIMITS, tuple(-limit for limit in LIMITS))
    np.testing.assert_allclose(between.score(values), between.score(-values), atol=1e-12)
    np.testing.assert_allclose(between.score(values[values > 0.0]), smaller.score(values[values > 0.0]), atol=1e-9)
    assert (smaller.liking, larger.liking, between.liking) == ("smaller", "larger", "between")
    assert list(smaller.ranges) == list(RANGES)
    assert len(between.ranges) == len(between.knots) + 1
    assert between.ranges[0] == between.ranges[-1] == "unacceptable"


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Linear(0.5, 0.5), "linear: best and worst must differ, received 0.5 for both"),
        (lambda: Linear(math.nan, 0.5), "linear: best: a finite number is needed, received nan"),
        (lambda: Linear(True, 0.5), "linear: best: a finite number is needed, received True"),
        (lambda: PiecewiseLinear(((1.0, 50.0),)), "two points [value, score] or more are needed, received 1"),
        (lambda: PiecewiseLinear(((1.0, 50.0), (1.0, 70.0))), "each value may have one score, received 1 twice"),
        (lambda: PiecewiseLinear(((1.0, 50.0), (2.0, 101.0))), "scores lie in 0 … 100, received 101 at the value 2"),
        (lambda: PiecewiseLinear(((1.0, 50.0), (2.0, 50.0))), "all scores are 50, no value is preferred"),
        (lambda: PiecewiseLinear(((1.0, 50.0), (2.0,))), "points are pairs [value, score], received [2.0]"),
        (lambda: MonotoneSpline(((1.0, 100.0), (2.0, 0.0), (3.0, 9.0))), "received 100 at 1, 0 at 2, 9 at 3; where a value"),
        (lambda: MonotoneSpline(((1.0, 100.0), (math.inf, 0.0))), "points: a finite number is needed, received inf"),
        (lambda: Desirability(1.0), "a limit is needed; give lower, upper, or both"),
        (lambda: Desirability(1.0, lower=1.0), "lower must lie below the target 1, received 1"),
        (lambda: Desirability(1.0, upper=0.5), "upper must lie above the target 1, received 0.5"),
        (lambda: Desirability(1.0, upper=2.0, upper_exponent=0.0), "upper_exponent > 0 is needed, received 0"),
        (lambda: PhysicalProgramming(), "five limits are needed; give upper, lower, or both"),
        (lambda: PhysicalProgramming((1.0, 2.0)), "upper: five limits are needed (highly desirable, desirable"),
        (lambda: PhysicalProgramming((1.0, 2.0, 2.0, 3.0, 4.0)), "limits must ascend"),
        (lambda: PhysicalProgramming(lower=(1.0, 2.0, 3.0, 4.0, 5.0)), "limits must descend"),
        (lambda: PhysicalProgramming(LIMITS, (3.0, 2.0, 1.0, 0.0, -1.0)), "the first lower limit must not lie above"),
        (
            lambda: PhysicalProgramming(LIMITS, growth=1.01),
            "growth: the class function is not convex with these limits and 1.01",
        ),
        (
            lambda: PhysicalProgramming((0.1, 0.2, 0.3, 0.4, 1e99)),
            "growth: at most 1e+12 is needed for scores that",
        ),
        (lambda: PhysicalProgramming((0.0, 1e-80, 1.0, 2.0, 3.0)), "received these limits; bring the limits nearer"),
        (
            lambda: PhysicalProgramming(LIMITS, growth=1e100),
            "received 1e+100; bring the limits nearer to even",
        ),
    ],
)
def test_bad_functions_are_refused(make, message):
    with pytest.raises(InputError, match=re.escape(message)):
        make()
