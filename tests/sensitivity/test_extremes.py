"""Extreme formulation: functions with known extreme surfaces, invariances, the global check, bad input."""

import json

import numpy as np
import pytest
from functions import Differentiable, box, linear, wave_extremes, waves

from railsearch.errors import InputError, SimulationError, SurrogateError
from railsearch.sampling import latin_hypercube
from railsearch.sensitivity import (
    FRUGAL,
    SENSES,
    ExactModel,
    SearchSettings,
    extreme_surfaces,
    factors_on,
)
from railsearch.sensitivity.inner_problems import InnerProblems
from railsearch.sensitivity.inner_search import Extreme, InnerSearch
from railsearch.sensitivity.models import BoxModel
from railsearch.space import Space, Variable
from railsearch_plugins.polynomial_chaos.estimator import PolynomialChaosRegressor
from railsearch_problems.truss import Truss, closed_form

FOUR = box((0.0, 2.0), (-1.0, 1.0), (1.0, 4.0), (-3.0, -1.0))


def found(model, factors, seed=0, settings=None):
    return extreme_surfaces(model, factors, np.random.default_rng(seed), settings)


def test_a_linear_function_has_its_extremes_in_corners():
    """Ȳ_i = c_i x_i + Σ max or min of the others, attained at bounds; I_i = (c_i r_i)²/Σ; dȲ/dx = c."""
    coefficients = np.array([3.0, -2.0, 0.5, 1.0])
    factors = factors_on(FOUR, 5)
    surfaces = found(linear(coefficients, 7.0), factors)
    for sense, pick in (("maximum", np.maximum), ("minimum", np.minimum)):
        ends = pick(coefficients * FOUR.lower, coefficients * FOUR.upper)
        for i, name in enumerate(FOUR.names):
            curve = surfaces.surface(name, sense)
            expected = 7.0 + coefficients[i] * factors.grids[i] + ends.sum() - ends[i]
            np.testing.assert_allclose(curve.values, expected, rtol=1e-12)
            np.testing.assert_array_equal(curve.points[:, i], factors.grids[i])
            np.testing.assert_allclose(7.0 + curve.points @ coefficients, curve.values, rtol=1e-12)
            np.testing.assert_allclose(surfaces.local_sensitivity(name, sense), coefficients[i], rtol=1e-9)
        moved = (coefficients * (FOUR.upper - FOUR.lower)) ** 2
        assert list(surfaces.importances(sense).values()) == pytest.approx(moved / moved.sum())
        assert surfaces.extreme(sense) == pytest.approx(7.0 + ends.sum())


def test_a_separable_function_with_curvature_inside():
    """g = Σ a_i (x_i − m_i)²: minimum at m where it lies inside, maximum at the farther bound."""
    scales, middle = np.array([1.0, 2.0, 0.1, 5.0]), np.array([0.5, 3.0, 2.0, -1.5])
    model = Differentiable(lambda x: ((x - middle) ** 2) @ scales, lambda x: 2.0 * scales * (x - middle))
    factors = factors_on(FOUR, 8)
    surfaces = found(model, factors)
    lowest = scales * (np.clip(middle, FOUR.lower, FOUR.upper) - middle) ** 2
    highest = scales * np.maximum((FOUR.lower - middle) ** 2, (FOUR.upper - middle) ** 2)
    for i, name in enumerate(FOUR.names):
        own = scales[i] * (factors.grids[i] - middle[i]) ** 2
        for sense, others in (("minimum", lowest), ("maximum", highest)):
            values = surfaces.surface(name, sense).values
            np.testing.assert_allclose(values, own + others.sum() - others[i], atol=1e-9 * highest.sum())


def test_an_interaction_changes_the_branch_along_the_curve():
    """g = x1 x2 on [−1, 1]²: Ȳmax(x) = |x|, Ȳmin(x) = −|x|."""
    model = Differentiable(lambda x: x[:, 0] * x[:, 1], lambda x: x[:, ::-1])
    factors = factors_on(box((-1.0, 1.0), (-1.0, 1.0)), 20)
    surfaces = found(model, factors, settings=SearchSettings(sample=1, exchanges=0, check=0))
    for name, grid in zip(factors.names, factors.grids, strict=True):
        np.testing.assert_allclose(surfaces.surface(name).values, np.abs(grid), atol=1e-12)
        np.testing.assert_allclose(surfaces.surface(name, "minimum").values, -np.abs(grid), atol=1e-12)


def test_many_local_optima_are_searched_to_the_global_one():
    factors = factors_on(box(*[(-np.pi, np.pi)] * 4), 15)
    surfaces = found(waves(), factors)
    low, high = wave_extremes(-np.pi, np.pi)
    own = np.cos(9.0 * factors.grids[0]) + 0.3 * factors.grids[0]
    for name in factors.names:
        np.testing.assert_allclose(surfaces.surface(name).values, own + 3.0 * high, atol=1e-6)
        np.testing.assert_allclose(surfaces.surface(name, "minimum").values, own + 3.0 * low, atol=1e-6)
    check = surfaces.effort.check
    assert (check.held, check.settled) == (True, True)


def test_the_global_check_rescues_a_bad_start():
    """A narrow peak of height 3 at 0.7 beside a broad one of height 1: one start, nothing learnt from one another."""

    def parts(x):
        y = x[:, 1]
        return np.exp(-2.0 * (y + 0.5) ** 2), 3.0 * np.exp(-800.0 * (y - 0.7) ** 2)

    def slopes(x):
        broad, narrow = parts(x)
        return np.column_stack([np.full(len(x), 0.1), -4.0 * (x[:, 1] + 0.5) * broad - 1600.0 * (x[:, 1] - 0.7) * narrow])

    model = Differentiable(lambda x: 0.1 * x[:, 0] + sum(parts(x)), slopes)
    factors = factors_on(box((-1.0, 1.0), (-1.0, 1.0)), 12)
    poor = {"sample": 1, "exchanges": 0, "sweeps": 0}
    expected = 0.1 * factors.grids[0] + parts(np.array([[0.0, 0.7]]))[1] + parts(np.array([[0.0, 0.7]]))[0]
    unchecked = found(model, factors, settings=SearchSettings(**poor, check=0))
    assert unchecked.effort.check is None
    assert np.min(unchecked.surface("x1").values - expected) < -1.0, "the start is bad"
    checked = found(model, factors, settings=SearchSettings(**poor, check=256))
    np.testing.assert_allclose(checked.surface("x1").values, expected, atol=1e-4)
    assert checked.effort.check.rescued > 0
    assert checked.effort.check.held
    assert checked.effort.check.rounds > 1, "after a rescue another sample is drawn"


def narrow_peak(place, height=1.0):
    """height exp(−800 (x_last − place)²) + 0.01 x1, which no descent finds from afar."""

    def peak(x):
        return height * np.exp(-800.0 * (x[:, -1] - place) ** 2)

    def slopes(x):
        found = np.zeros_like(x)
        found[:, 0], found[:, -1] = 0.01, -1600.0 * (x[:, -1] - place) * peak(x)
        return found

    return Differentiable(lambda x: peak(x) + 0.01 * x[:, 0], slopes)


def begun(model, space, settings, start):
    """A search for the maximum on 9 grid values, begun from points (R, k, d) that `start` makes of those at 0.1."""
    factors = factors_on(space, 9)
    problems = InnerProblems(factors)
    search = InnerSearch(BoxModel(model, factors.space), Extreme(-1.0), problems, settings, 1.0)
    sample = problems.held(np.full((problems.number, space.dimension), 0.1), np.arange(problems.number))[:, None]
    sample = start(sample)
    search.begin(sample, model.predict(sample.reshape(-1, space.dimension)).reshape(sample.shape[:2]))
    return factors, search


def test_travelling_takes_a_solution_along_the_whole_curve():
    """One problem is given the narrow peak; all others reach it from there, none of them by itself."""

    def start(sample):
        sample[4, 0, 1] = 0.69
        return sample

    square = box((0.0, 1.0), (0.0, 1.0))
    factors, search = begun(narrow_peak(0.7), square, SearchSettings(exchanges=0), start)
    np.testing.assert_allclose(-search.merits[:9], 1.0 + 0.01 * factors.grids[0], atol=1e-6)
    assert search.settled
    _, stopped = begun(narrow_peak(0.7), square, SearchSettings(exchanges=0, sweeps=2), start)
    assert np.flatnonzero(stopped.merits[:9] < -0.9).tolist() == [2, 3, 4, 5, 6], "two grid values on either side"
    assert not stopped.settled


def test_an_exchange_takes_a_solution_to_the_curves_of_other_factors():
    """One problem with x1 held is given the peak in x3; those with x2 held get it from there, without travelling."""

    def start(sample):
        sample[4, 0, 2] = 0.69
        return sample

    cube = box((0.0, 1.0), (0.0, 1.0), (0.0, 1.0))
    for exchanges, reached in ((0, 1), (1, 18)):
        settings = SearchSettings(exchanges=exchanges, sweeps=0)
        _, search = begun(narrow_peak(0.7), cube, settings, start)
        assert np.sum(search.merits[:18] < -0.9) == reached


def test_of_several_starts_the_best_end_counts():
    """Two starts end in peaks of heights 1 and 2, in either order of their sampled values."""
    low, high = narrow_peak(0.2), narrow_peak(0.8, 2.0)
    model = Differentiable(lambda x: low.function(x) + high.function(x), lambda x: low.slopes(x) + high.slopes(x))
    for near_low, near_high in ((0.2, 0.75), (0.23, 0.8)):
        settings = SearchSettings(starts=2, sample=2, exchanges=0, sweeps=0)

        def start(sample, near_low=near_low, near_high=near_high):
            both = np.repeat(sample, 2, axis=1)
            both[:9, 0, 1], both[:9, 1, 1] = near_low, near_high
            return both

        factors, search = begun(model, box((0.0, 1.0), (0.0, 1.0)), settings, start)
        np.testing.assert_allclose(-search.merits[:9], 2.0 + 0.02 * factors.grids[0], atol=1e-6)


def test_points_hold_exactly_the_grid_values_however_they_are_rounded():
    space = box((0.1, 0.7), (1.3e11, 2.9e11), (-1.0 / 3.0, 1.0 / 7.0))
    factors = factors_on(space, 40)
    surfaces = found(linear([1.0, 1e-11, 1.0]), factors)
    there_and_back = space.from_unit(space.to_unit(np.column_stack(factors.grids)))
    assert not np.array_equal(there_and_back, np.column_stack(factors.grids)), "rounding would show"
    for place, name in enumerate(factors.names):
        np.testing.assert_array_equal(surfaces.surface(name).points[:, place], factors.grids[place])


def test_slopes_on_the_unit_box_are_those_of_its_coordinates():
    model = BoxModel(waves(), FOUR)
    points = np.random.default_rng(3).uniform(0.1, 0.9, (5, 4))
    values, slopes = model.predict_with_gradient(points)
    np.testing.assert_array_equal(values, model.predict(points))
    for k in range(4):
        step = 1e-6 * np.eye(4)[k]
        numeric = (model.predict(points + step) - model.predict(points - step)) / 2e-6
        np.testing.assert_allclose(slopes[:, k], numeric, atol=1e-6)
    assert model.asked == 5 * 10


def test_no_point_of_another_sample_is_more_extreme():
    factors = factors_on(box(*[(-np.pi, np.pi)] * 3), 10)
    model, generator = waves(4.0, 1.0, 0.2), np.random.default_rng(9)
    surfaces = found(model, factors)
    for i, name in enumerate(factors.names):
        points = factors.space.from_unit(generator.random((10, 500, 3)))
        points[:, :, i] = factors.grids[i][:, None]
        values = model.function(points.reshape(-1, 3)).reshape(10, 500)
        assert np.all(values.max(axis=1) <= surfaces.surface(name).values)
        assert np.all(values.min(axis=1) >= surfaces.surface(name, "minimum").values)


def test_importances_do_not_depend_on_order_output_scale_or_input_units():
    coefficients = np.array([3.0, -2.0, 0.5, 1.0])
    model = Differentiable(
        lambda x: np.exp(0.2 * x @ coefficients),
        lambda x: np.exp(0.2 * x @ coefficients)[:, None] * 0.2 * coefficients,
    )
    base = found(model, factors_on(FOUR, 9))
    order = np.array([2, 0, 3, 1])
    permuted = Space(tuple(FOUR.variables[k] for k in order))
    back = np.argsort(order)
    turned = Differentiable(lambda x: model.function(x[:, back]), lambda x: model.slopes(x[:, back])[:, order])
    scaled = Differentiable(lambda x: 5.0 - 1e3 * model.function(x), lambda x: -1e3 * model.slopes(x))
    factor = np.array([1e3, 1.0, 1e-6, 1.0])
    units = box(*zip(FOUR.lower * factor, FOUR.upper * factor, strict=True))
    other = Differentiable(lambda x: model.function(x / factor), lambda x: model.slopes(x / factor) / factor)
    for sense, opposite in (SENSES, SENSES[::-1]):
        expected = base.importances(sense)
        assert found(turned, factors_on(permuted, 9)).importances(sense) == pytest.approx(expected, abs=1e-6)
        assert found(scaled, factors_on(FOUR, 9)).importances(opposite) == pytest.approx(expected, abs=1e-6)
        rescaled = found(other, factors_on(units, 9, "equal")).importances(sense)
        assert rescaled == pytest.approx(expected, abs=1e-6)


def test_one_extreme_alone_is_cheaper_and_the_same():
    both, one = linear(np.ones(4)), linear(np.ones(4))
    whole = found(both, factors_on(FOUR, 5))
    half = extreme_surfaces(one, factors_on(FOUR, 5), np.random.default_rng(0), senses=["minimum"])
    assert half.senses == ("minimum",)
    assert half.importances("minimum") == pytest.approx(whole.importances("minimum"))
    assert one.asked < both.asked
    with pytest.raises(InputError, match="only the minimum was looked for"):
        half.importances("maximum")
    for senses, message in (((), "none"), (("largest",), "maximum or minimum")):
        with pytest.raises(InputError, match=message):
            extreme_surfaces(one, factors_on(FOUR, 5), np.random.default_rng(0), senses=senses)


def test_the_same_seed_gives_the_same_bits_and_another_one_the_same_numbers():
    factors = factors_on(box(*[(-np.pi, np.pi)] * 3), 10)
    first, again, other = (found(waves(4.0), factors, seed) for seed in (1, 1, 2))
    for name in factors.names:
        assert first.surface(name).values.tobytes() == again.surface(name).values.tobytes()
        assert first.surface(name).points.tobytes() == again.surface(name).points.tobytes()
        np.testing.assert_allclose(first.surface(name).values, other.surface(name).values, atol=1e-7)


def test_a_constant_function_has_no_important_factor():
    surfaces = found(linear(np.zeros(4), 2.5), factors_on(FOUR, 4))
    assert set(surfaces.importances().values()) == {0.0}
    assert surfaces.extreme("maximum") == surfaces.extreme("minimum") == 2.5


def test_differences_find_what_derivatives_find_and_evaluations_are_counted():
    coefficients = np.array([3.0, -2.0, 0.5, 1.0])
    smooth = Differentiable(lambda x: np.sin(x @ coefficients), lambda x: np.cos(x @ coefficients)[:, None] * coefficients)
    counted = linear(np.zeros(4))
    exact = ExactModel(lambda x: counted.predict(x) + smooth.function(x), FOUR)
    factors = factors_on(FOUR, 6)
    by_differences, by_derivatives = found(exact, factors, settings=FRUGAL), found(smooth, factors)
    for name in FOUR.names:
        np.testing.assert_allclose(by_differences.surface(name).values, by_derivatives.surface(name).values, atol=1e-9)
    effort = by_differences.effort
    assert (effort.exact, effort.asked, effort.failures) == (True, counted.asked, 0)
    further = found(exact, factors, settings=FRUGAL).effort
    assert further.asked == counted.asked - effort.asked, "each analysis counts its own evaluations"
    assert by_derivatives.effort.exact is False


def test_differences_stay_inside_the_box_and_agree_with_derivatives():
    generator, asked = np.random.default_rng(2), []

    def function(x):
        asked.append(x)
        return np.sin(x).sum(axis=1)

    points = FOUR.from_unit(np.vstack([generator.random((20, 4)), np.zeros(4), np.ones(4)]))
    values, slopes = ExactModel(function, FOUR).predict_with_gradient(points)
    np.testing.assert_allclose(slopes, np.cos(points), atol=1e-5)
    np.testing.assert_allclose(values, np.sin(points).sum(axis=1))
    everything = np.vstack(asked)
    assert np.all((everything >= FOUR.lower) & (everything <= FOUR.upper))


def test_failed_evaluations_are_counted_and_gone_around():
    """The model fails where x1 > 1.5: the extremes are those of the rest, and of what is held there there are none."""
    model = ExactModel(lambda x: np.where(x[:, 0] > 1.5, np.nan, x.sum(axis=1)), FOUR)
    factors = factors_on(FOUR, 5)
    surfaces = found(model, factors, settings=SearchSettings(check=16))
    assert surfaces.effort.failures == model.failures > 0
    own = surfaces.surface("x1").values
    np.testing.assert_allclose(own[:4], factors.grids[0][:4] + 1.0 + 4.0 - 1.0)
    assert np.isnan(own[4])
    assert np.isnan(surfaces.surface("x1").points[4]).all()
    assert surfaces.unsolved == 2, "the maximum and the minimum at that grid value"
    np.testing.assert_allclose(surfaces.surface("x2").values, 1.5 + factors.grids[1] + 4.0 - 1.0, atol=0.1)
    document = json.loads(json.dumps(surfaces.document(), allow_nan=False))
    assert document["factors"][0]["maximum"]["values"][4] is None
    assert document["effort"]["unsolved"] == 2


def test_the_document_has_names_units_curves_and_counts():
    space = Space((Variable("mass", 2.0e4, 4.0e4, "kg"), Variable("gap", 0.0, 1.0, "mm")))
    surfaces = found(linear([1e-4, 1.0]), factors_on(space, 3))
    document = json.loads(json.dumps(surfaces.document(), allow_nan=False))
    mass = document["factors"][0]
    assert (mass["name"], mass["unit"], mass["spacing"]) == ("mass", "kg", "logarithmic")
    np.testing.assert_allclose(mass["maximum"]["values"], 1e-4 * np.array(mass["grid"]) + 1.0)
    assert document["importances"]["maximum"] == pytest.approx(surfaces.importances())
    assert document["extremes"] == pytest.approx({"maximum": 5.0, "minimum": 2.0})
    assert document["effort"]["check"]["held"] is True


def test_a_surrogate_that_is_not_finite_is_named_with_the_point():
    model = Differentiable(lambda x: np.where(x[:, 0] > 1.9, np.inf, x[:, 0]), lambda x: np.ones_like(x))
    with pytest.raises(SurrogateError, match="not finite at x1 = 2, x2"):
        found(model, factors_on(FOUR, 5))


def test_a_model_that_always_fails_is_refused():
    with pytest.raises(SimulationError, match="all 80 evaluations"):
        found(ExactModel(lambda x: np.full(len(x), np.nan), FOUR), factors_on(FOUR, 5), settings=FRUGAL)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: SearchSettings(starts=3, sample=2), "sample: an integer ≥ 3"),
        (lambda: SearchSettings(rounds=0), "rounds: an integer ≥ 1"),
        (lambda: SearchSettings(tolerance=0.0), "tolerance"),
        (lambda: ExactModel(np.sum, FOUR, step=0.6), "step"),
        (lambda: found(ExactModel(lambda x: x, FOUR), factors_on(FOUR, 3)), "one value for each of .* shape"),
        (
            lambda: found(linear([1.0]), factors_on(Space((Variable("n", 0.0, 5.0, integer=True),)), 3)),
            "n: .* whole numbers",
        ),
        (lambda: found(linear(np.ones(4)), factors_on(FOUR, 3)).surface("x9"), "unknown factor 'x9'"),
        (lambda: found(linear(np.ones(4)), factors_on(FOUR, 3)).surface("x1", "largest"), "maximum or minimum"),
    ],
)
def test_bad_input_is_named(make, message):
    with pytest.raises(InputError, match=message):
        make()


def test_a_curve_that_is_flat_but_for_rounding_counts_as_flat():
    """sin of a sum that passes π/2 and −π/2 whatever factor is held: every curve is 1 or −1 to the last digits."""
    model = Differentiable(
        lambda x: np.sin(3.0 * x.sum(axis=1)), lambda x: np.tile(3.0 * np.cos(3.0 * x.sum(axis=1)), (4, 1)).T
    )
    surfaces = found(model, factors_on(FOUR, 6))
    for sense in SENSES:
        assert set(surfaces.importances(sense).values()) == {0.0}


def test_few_grid_values_miss_no_extreme_of_a_rough_surrogate():
    """49 terms through 50 samples in 10 inputs; on 2 or 5 grid values the searches of all seeds agree."""
    truss = Truss()
    points = latin_hypercube(truss.distributions, 50, np.random.default_rng(1))
    rough = PolynomialChaosRegressor(inputs=truss.distributions).fit(points, closed_form(points))
    for count in (2, 5):
        factors = factors_on(truss.space, count)
        found = [extreme_surfaces(rough, factors, np.random.default_rng(seed)).curves["maximum"] for seed in range(6)]
        curves = np.array([[curve.values for curve in curves] for curves in found])
        assert np.ptp(curves, axis=0).max() < 1e-6 * np.ptp(curves)
