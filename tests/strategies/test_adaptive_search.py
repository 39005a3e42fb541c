"""Adaptive searches: the choice of transform and length scales, and expected improvement as what is maximised."""

import copy
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.spatial.distance import cdist
from scipy.stats import norm, spearmanr

from railsearch.errors import CapabilityError, InputError
from railsearch.parameters import make_parameters
from railsearch.space import Space, Variable
from railsearch.testing import Trial, run_trial
from railsearch_plugins.metric_search.adaptive_model import SPREAD, Adaptation, AdaptiveModel
from railsearch_plugins.metric_search.adaptive_search import AdaptiveSearchParameters
from railsearch_plugins.metric_search.expected_improvement import expected_improvement
from railsearch_plugins.metric_search.merit import merit
from railsearch_plugins.metric_search.transforms import TRANSFORMS, tail
from railsearch_plugins.strategies.adaptive_kriging import AdaptiveKrigingSearch
from railsearch_plugins.strategies.adaptive_rbf import AdaptiveInterpolantSearch
from railsearch_plugins.surrogates.kriging import Kriging, KrigingParameters
from railsearch_plugins.surrogates.rbf import RadialBasisFunctionInterpolant, RadialBasisFunctionParameters

ALL = ("copula", "logarithm", "identity")


def make_rbf(settings):
    return RadialBasisFunctionInterpolant(4, make_parameters(RadialBasisFunctionParameters, settings, "rbf"))


def points_of(n, seed=0):
    return np.random.default_rng(seed).random((n, 4))


def bowl(points):
    return np.sum((points - 0.4) ** 2, axis=1)


values_lists = st.lists(st.floats(-1e6, 1e6), min_size=3, max_size=30).map(np.array)


@pytest.mark.parametrize("name", TRANSFORMS)
@given(values=values_lists)
def test_a_transform_keeps_the_order_and_is_finite(name, values):
    transformed = TRANSFORMS[name](values)(values)
    order = np.argsort(values, kind="stable")
    assert np.isfinite(transformed).all()
    assert np.all(np.diff(transformed[order]) >= 0.0)
    ties = np.diff(values[order]) == 0.0
    assert np.all(np.diff(transformed[order])[ties] == 0.0)


def test_normal_scores_depend_on_ranks_alone_and_are_symmetric():
    values = np.array([3.0, 1.0, 1e9, 2.0, -5.0])
    scores = TRANSFORMS["copula"](values)(values)
    np.testing.assert_allclose(scores, norm.ppf((np.array([3, 1, 4, 2, 0]) + 0.5) / 5.0))
    assert np.sum(scores) == pytest.approx(0.0, abs=1e-12)


def test_the_logarithm_is_of_the_excess_over_the_least_value():
    values = np.array([7.0, 8.0, 10.0])
    np.testing.assert_allclose(TRANSFORMS["logarithm"](values)(values), np.log(np.array([0.1, 1.1, 3.1])))
    constant = np.full(5, 2.0)
    np.testing.assert_array_equal(TRANSFORMS["logarithm"](constant)(constant), constant)


def test_only_values_far_above_all_others_are_compressed():
    values = np.array([1.0, 2.0, 3.0, 4.0, 63.0, 63.0 + 60.0 * (np.e - 1.0), 1e9])
    transformed = tail(values[:5])(values)
    np.testing.assert_array_equal(transformed[:5], values[:5])
    assert transformed[5] == pytest.approx(123.0)
    assert transformed[6] == pytest.approx(3.0 + 60.0 * (1.0 + np.log((1e9 - 3.0) / 60.0)))
    slope = (tail(values[:5])(np.array([63.0 + 1e-6]))[0] - 63.0) / 1e-6
    assert slope == pytest.approx(1.0, abs=1e-4), "no kink where the compression begins"
    for flat in (np.array([2.0, 2.0, 2.0, 9.0]), np.empty(0)):
        np.testing.assert_array_equal(tail(flat)(flat), flat)


@pytest.mark.parametrize(("best", "value", "deviation"), [(0.0, 1.0, 0.7), (0.0, -1.0, 0.3), (2.0, 2.0, 5.0)])
def test_expected_improvement_is_the_integral_that_it_stands_for(best, value, deviation):
    def integrand(y):
        return (best - y) * norm.pdf(y, value, deviation)

    expected, _ = quad(integrand, value - 12.0 * deviation, best, points=[value] if value < best else None)
    found = expected_improvement(np.array([value]), np.array([deviation]), best)[0]
    assert found == pytest.approx(expected, rel=1e-7)


def test_expected_improvement_without_deviation_is_the_improvement_itself():
    found = expected_improvement(np.array([-1.0, 1.0]), np.zeros(2), 0.0)
    np.testing.assert_array_equal(found, [1.0, 0.0])


def test_an_exponential_is_seen_through_a_transform_and_a_bowl_as_it_is():
    points = points_of(60)
    steep, plain = (AdaptiveModel(make_rbf, Adaptation(ALL)) for _ in range(2))
    steep.refresh(points, np.exp(30.0 * bowl(points)))
    plain.refresh(points, bowl(points))
    assert steep.transform in ("copula", "logarithm")
    assert plain.transform == "identity"


def test_a_variable_without_effect_gets_a_longer_length_scale():
    points, seen = points_of(60), []

    def make(settings):
        seen.append(np.array(settings.get("length_scales", ())))
        return make_rbf(settings)

    model = AdaptiveModel(make, Adaptation(length_scales=True, every=1), np.random.default_rng(0))
    for n in range(50, 60):
        model.refresh(points[:n], np.sin(9.0 * points[:n, 0]))
    scales = seen[-1]
    assert scales[0] < 0.5 * min(scales[1:])
    assert np.mean(scales) == pytest.approx(1.0)
    assert np.ptp(np.log(scales)) <= 2.0 * np.log(SPREAD) + 1e-9


def test_the_choice_is_made_again_only_every_so_often():
    points, fits = points_of(60), []

    def make(settings):
        fits.append(settings)
        return make_rbf(settings)

    model = AdaptiveModel(make, Adaptation(ALL, every=10))
    counts = []
    for n in range(30, 60):
        before = len(fits)
        model.refresh(points[:n], bowl(points[:n]))
        counts.append(len(fits) - before)
    assert counts == ([4] + [1] * 9) * 3


def test_as_it_is_points_are_added_and_the_surrogate_is_that_of_a_fit():
    points = points_of(40)
    model, made = AdaptiveModel(lambda settings: made.append(1) or make_rbf(settings)), []
    for n in (20, 25, 40, 40):
        surrogate = model.refresh(points[:n], bowl(points[:n]))
    fitted = make_rbf({})
    fitted.fit(points, bowl(points))
    queries = points_of(9, seed=5)
    assert len(made) == 1
    np.testing.assert_allclose(surrogate.predict(queries), fitted.predict(queries), rtol=1e-9)


@pytest.mark.parametrize("height", [1.0, 1e6])
def test_a_model_is_fitted_anew_only_where_its_values_change(height):
    points, made = points_of(60), []
    values = np.where(np.arange(60) % 9 == 4, height, 1.0) * (1.0 + bowl(points))
    model = AdaptiveModel(lambda settings: made.append(1) or make_rbf(settings), Adaptation(("tail",), every=10))
    counts = []
    for n in range(30, 60):
        surrogate, before = model.refresh(points[:n], values[:n]), len(made)
        counts.append(before)
    compressed = tail(values[:50])(values[:59])
    np.testing.assert_array_equal(model.values, compressed)
    assert np.array_equal(compressed, values[:59]) == (height == 1.0)
    fitted = make_rbf({})
    fitted.fit(points[:59], compressed)
    queries = points_of(9, seed=5)
    np.testing.assert_allclose(surrogate.predict(queries), fitted.predict(queries), rtol=1e-9)
    assert counts == ([1] * 30 if height == 1.0 else [1] * 10 + [2] * 10 + [3] * 10)


def test_too_few_points_determine_no_model():
    assert AdaptiveModel(make_rbf, Adaptation(ALL)).refresh(points_of(3), bowl(points_of(3))) is None


SPACE = Space((Variable("x", -2.0, 3.0), Variable("y", 0.0, 1.0), Variable("k", 0.0, 9.0, integer=True)))


def valley(design):
    x, y, k = design
    return np.array([(x - 0.7) ** 2 + np.sin(5.0 * y) + 0.1 * (k - 4.0) ** 2])


def watched(base, settings=None, batch_size=1, budget=45):
    """What the search chose among what: surrogates, points, evaluated points, present values and chosen indices."""
    choices = []

    class Watched(base):
        def _most_promising(self, surrogate, points, evaluated):
            chosen = super()._most_promising(surrogate, points, evaluated)
            choices.append((copy.deepcopy(surrogate), points, evaluated, self._model.values, chosen))
            return chosen

    evaluations = run_trial(Watched, Trial(SPACE, budget=budget, batch_size=batch_size), settings, objective=valley)
    return choices, evaluations


@pytest.mark.parametrize("plugin", [AdaptiveKrigingSearch, AdaptiveInterpolantSearch])
def test_what_is_proposed_has_the_largest_expected_improvement_of_all_candidates(plugin):
    choices, _ = watched(plugin, {"cycle": ["improvement"], "surrogate": "rbf"})
    surrogate, points, evaluated, values, chosen = choices[-1]
    admissible = cdist(points, evaluated).min(axis=1) >= 1e-3
    improvement = expected_improvement(surrogate.predict(points), surrogate.deviation(points), values.min())
    assert improvement[chosen[0]] == improvement[admissible].max() > 0.0


def test_a_weight_in_the_cycle_means_the_merit_and_the_turns_go_round():
    choices, _ = watched(
        AdaptiveInterpolantSearch, {"cycle": ["merit", "improvement"], "weights": [0.3], "transforms": ["identity"]}
    )
    for turn, (surrogate, points, evaluated, values, chosen) in enumerate(choices):
        distances = cdist(points, evaluated).min(axis=1)
        free = np.flatnonzero(distances >= 1e-3)
        predicted = surrogate.predict(points[free])
        improvement = expected_improvement(predicted, surrogate.deviation(points[free]), values.min())
        scores = -improvement if turn % 2 else merit(predicted, distances[free], 0.3)
        assert chosen[0] == free[np.argmin(scores)]
    assert len(choices) > 10


def test_late_in_the_budget_every_other_design_has_the_least_merit_by_the_interpolant():
    turns = []

    class Watched(AdaptiveKrigingSearch):
        def _best_of(self, candidates, surrogate, choose):
            proposals = super()._best_of(candidates, surrogate, choose)
            if choose == self._least_merit:
                trajectory, space = self._trajectory, self._context.space
                interpolant = self._context.surrogate("rbf", {})
                interpolant.fit(trajectory.points, trajectory.values)
                points, evaluated = space.to_unit(candidates), space.to_unit(np.array(list(self._evaluated.values())))
                scores = merit(interpolant.predict(points), cdist(points, evaluated).min(axis=1), 0.95)
                assert space.to_unit(proposals[0].design) == pytest.approx(points[np.argmin(scores)])
            turns.append((len(self._evaluated), choose == self._least_merit))
            return proposals

    settings = {"interpolant_from": 0.6, "weights": [0.95], "minimum_distance": 1e-5}
    run_trial(Watched, Trial(SPACE, budget=50), settings, objective=valley)
    early, late = ([by_merit for spent, by_merit in turns if (spent >= 30) == is_late] for is_late in (False, True))
    assert not any(early)
    assert late == [k % 2 == 1 for k in range(len(late))]
    assert len(early) > 5 < len(late)


REALS_AND_INTEGERS = {
    "mixed": (SPACE, {}, True),
    "mixed, told not to": (SPACE, {"fine_steps": False}, False),
    "real": (Space(SPACE.variables[:2]), {}, False),
    "integer": (Space(tuple(Variable(name, 0.0, 20.0, integer=True) for name in "kmn")), {}, False),
}


@pytest.mark.parametrize(("space", "settings", "fine"), REALS_AND_INTEGERS.values(), ids=REALS_AND_INTEGERS)
def test_every_other_turn_of_the_interpolant_moves_the_real_variables_alone_where_there_are_integers(space, settings, fine):
    turns = []

    class Watched(AdaptiveKrigingSearch):
        def _best_of(self, candidates, surrogate, choose):
            if choose == self._least_merit:
                incumbent, sigma = self._trajectory.incumbent, self._trajectory.step.sigma
                steps = (candidates - incumbent) / (space.upper - space.lower) / sigma
                turns.append((steps[:, space.integer].any(), steps[:, ~space.integer]))
            return super()._best_of(candidates, surrogate, choose)

    settings = {"interpolant_from": 0.5, "minimum_distance": 1e-5, **settings}
    run_trial(Watched, Trial(space, budget=50), settings, objective=lambda x: np.array([np.sum((x - 0.7) ** 2)]))
    assert len(turns) >= 8
    is_fine = [space.integer.any() and not moves_integers for moves_integers, _ in turns]
    assert is_fine == [fine and turn % 2 == 1 for turn in range(len(turns))]
    if fine:
        sizes = np.abs(np.vstack([steps for _, steps in turns[1::2]]))
        assert (sizes > 0.0).all()
        logarithm_of_normal = -(np.euler_gamma + np.log(2.0)) / 2.0
        assert np.mean(np.log(sizes)) == pytest.approx(logarithm_of_normal + np.log(0.05) / 2.0, abs=0.05)


@pytest.mark.parametrize("batch_size", [2, 5])
def test_designs_of_a_batch_are_apart_and_the_second_is_chosen_as_if_the_first_were_known(batch_size):
    settings = {"surrogate": "rbf", "transforms": ["identity"], "cycle": ["improvement"]}
    choices, _ = watched(AdaptiveKrigingSearch, settings, batch_size)
    surrogate, points, evaluated, values, chosen = choices[0]
    assert len(chosen) == batch_size
    assert cdist(points[chosen], points[chosen])[np.triu_indices(batch_size, 1)].min() >= 1e-3
    believer, first = copy.deepcopy(surrogate), points[chosen[:1]]
    predicted = surrogate.predict(first)
    believer.add(first, predicted)
    best = min(values.min(), predicted[0])
    free = cdist(points, np.vstack([evaluated, first])).min(axis=1) >= 1e-3
    improvement = expected_improvement(believer.predict(points), believer.deviation(points), best)
    assert improvement[chosen[1]] == improvement[free].max()


def late_steps(mixed):
    """Steps of candidates from the incumbent near the end of a run in 12 variables, in units of σ; 0 is no step."""
    steps = []

    class Watched(AdaptiveKrigingSearch):
        def _best_of(self, candidates, surrogate, choose):
            trajectory = self._trajectory
            steps.append((candidates - trajectory.incumbent) / trajectory.step.sigma)
            return super()._best_of(candidates, surrogate, choose)

    space = Space(tuple(Variable(f"x{k}", 0.0, 1.0) for k in range(12)))
    settings = {"surrogate": "rbf", "mixed_perturbations": mixed, "sigma_start": 0.02, "interpolant_from": 1.0}
    run_trial(Watched, Trial(space, budget=60), settings, objective=lambda x: np.array([np.sum((x - 0.5) ** 2)]))
    return np.vstack(steps[-5:])


def test_mixed_perturbations_are_of_many_sizes_and_of_few_and_many_coordinates():
    mixed, plain = late_steps(True), late_steps(False)
    many = [np.mean(np.sum(steps != 0.0, axis=1) > 7) for steps in (mixed, plain)]
    assert many[0] > 0.05
    assert many[1] < 0.01
    large, small = ([np.mean(test(np.abs(steps[steps != 0.0]))) for steps in (mixed, plain)] for test in (
        lambda size: size > 3.2, lambda size: size < 0.02
    ))  # fmt: skip
    assert large[0] > 0.008 > large[1]
    assert small[0] > 1.5 * small[1]


def test_the_score_is_the_rank_correlation_of_all_points_and_of_the_better_half():
    points = points_of(40)
    values = np.sin(5.0 * points).sum(axis=1)
    fitted = make_rbf({})
    fitted.fit(points, values)
    predicted, better = values - fitted.leave_one_out_residuals(), values <= np.median(values)
    expected = spearmanr(values, predicted).statistic + spearmanr(values[better], predicted[better]).statistic
    assert AdaptiveModel(make_rbf)._score(points, values) == pytest.approx(expected)


def test_between_equals_the_present_transform_stays(monkeypatch):
    monkeypatch.setattr(AdaptiveModel, "_score", lambda self, points, transformed: 1.0)
    model = AdaptiveModel(make_rbf, Adaptation(ALL))
    for present in ALL:
        model.transform = present
        model._adapt(points_of(20), bowl(points_of(20)))
        assert model.transform == present


@pytest.mark.parametrize("seed", range(12))
def test_length_scales_never_raise_the_error_that_is_weighted_towards_the_best_points(seed):
    points = points_of(40, seed)
    values = bowl(points) + 0.3 * np.random.default_rng(seed).standard_normal(40)
    scales = AdaptiveModel(make_rbf, Adaptation(length_scales=True), np.random.default_rng(seed))._moved_scales(
        points, values
    )
    weights = 1.0 / (1.0 + 4.0 * np.argsort(np.argsort(values)) / 40.0)
    errors = []
    for settings in ({}, {"length_scales": scales.tolist()}):
        fitted = make_rbf(settings)
        fitted.fit(points, values)
        errors.append(np.sum(weights * fitted.leave_one_out_residuals() ** 2))
    assert errors[1] <= errors[0]


def test_kriging_chooses_among_transforms_too():
    """By its leave-one-out residuals, as the interpolant does."""
    settings = {"transforms": ["identity", "copula"], "adapt_every": 2, "interpolant_from": 1.0}
    assert len(run_trial(AdaptiveKrigingSearch, Trial(SPACE, budget=28), settings)) == 28


@pytest.mark.parametrize(("settings", "prior"), [({}, 0.5), ({"surrogate_settings": {"length_scale_prior": 2.0}}, 2.0)])
def test_kriging_is_regularised_unless_it_is_told_otherwise(settings, prior):
    seen = []

    def make(name, dimension, given):
        seen.append((name, given["length_scale_prior"]))
        return Kriging(dimension, make_parameters(KrigingParameters, given, "surrogate kriging"))

    run_trial(AdaptiveKrigingSearch, Trial(SPACE, budget=24), {**settings, "interpolant_from": 1.0}, surrogate=make)
    assert set(seen) == {("kriging", prior)}


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"transforms": ["root"]}, "transforms: unknown 'root'; there are copula, logarithm, identity, tail"),
        ({"transforms": []}, "one or more entries"),
        ({"cycle": ["improvment"]}, "improvment"),
        ({"cycle": []}, "one or more entries"),
    ],
)
def test_faults_are_named(settings, message):
    with pytest.raises(InputError, match=re.escape(message)):
        make_parameters(AdaptiveSearchParameters, settings, "strategy adaptive-rbf")


def test_a_surrogate_without_deviation_is_refused_at_the_door():
    settings = {"surrogate": "sklearn.neighbors.KNeighborsRegressor"}
    with pytest.raises(CapabilityError, match="no deviation, which expected improvement needs: take a surrogate"):
        run_trial(AdaptiveKrigingSearch, Trial(SPACE), settings)
    with pytest.raises(CapabilityError, match="leave_one_out_residuals"):
        run_trial(AdaptiveInterpolantSearch, Trial(SPACE), {"surrogate": "pck"})
