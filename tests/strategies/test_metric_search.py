"""How dycors and lmsrs sample, search, fail and restart, seen from outside through what they propose and fit."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from railsearch.errors import InputError, SurrogateError
from railsearch.interfaces import Evaluation
from railsearch.parameters import make_parameters
from railsearch.plugin_manager import load_plugins
from railsearch.space import Space, Variable
from railsearch.testing import MIXED, REAL, Trial, run_trial
from railsearch_plugins.metric_search.parameters import MetricSearchParameters
from railsearch_plugins.strategies import dycors
from railsearch_plugins.strategies.dycors import DynamicCoordinateSearch
from railsearch_plugins.strategies.lmsrs import LocalMetricSearch
from railsearch_plugins.surrogates.rbf import RadialBasisFunctionInterpolant, RadialBasisFunctionParameters

BOTH = pytest.mark.parametrize("plugin", [DynamicCoordinateSearch, LocalMetricSearch])
NO_TREE = {"tree_search": False}
SIX = Space(tuple(Variable(f"x{k}", -5.0, 5.0) for k in range(6)))


class SpySurrogate(RadialBasisFunctionInterpolant):
    """An interpolant that keeps a diary of the points it was given, per fit."""

    diary: list

    def fit(self, points, values):
        super().fit(points, values)
        self.diary.append([(tuple(p), v) for p, v in zip(points, values, strict=True)])

    def add(self, points, values):
        super().add(points, values)
        self.diary[-1] += [(tuple(p), v) for p, v in zip(points, values, strict=True)]


def spied(diary):
    def surrogate(name, dimension, settings):
        model = SpySurrogate(dimension, RadialBasisFunctionParameters())
        model.diary = diary
        return model

    return surrogate


def constant(design):
    return np.array([3.0])


def origins(evaluations):
    return Counter(evaluation.origin for evaluation in evaluations)


def searched(evaluations):
    return [e for e in evaluations if e.origin in ("perturbation", "tree-search")]


@BOTH
def test_given_designs_count_in_the_initial_design_and_every_evaluation_is_labelled(plugin):
    later = set()
    for seed in range(3):
        evaluations = run_trial(plugin, Trial(MIXED, budget=45, given=1, seed=seed))
        labels = [evaluation.origin for evaluation in evaluations if evaluation.trajectory == 0]
        assert labels[:20] == ["given"] + ["initial"] * 19
        later |= set(labels[20:])
    assert later == {"perturbation", "tree-search"}


def test_there_is_no_tree_search_without_integers_or_when_it_is_switched_off():
    assert origins(run_trial(DynamicCoordinateSearch, Trial(REAL)))["tree-search"] == 0
    assert origins(run_trial(DynamicCoordinateSearch, Trial(MIXED), NO_TREE))["tree-search"] == 0


def test_size_of_the_initial_design():
    wide = Space(tuple(Variable(f"x{k}", 0.0, 1.0) for k in range(12)))
    assert origins(run_trial(LocalMetricSearch, Trial(wide, budget=30)))["initial"] == 26
    assert origins(run_trial(LocalMetricSearch, Trial(wide, budget=30), {"initial_size": 15}))["initial"] == 15
    assert origins(run_trial(LocalMetricSearch, Trial(wide, budget=9)))["initial"] == 9


def test_strategies_at_one_seed_share_their_initial_design():
    first, second = (run_trial(plugin, Trial(MIXED, seed=5)) for plugin in (DynamicCoordinateSearch, LocalMetricSearch))
    assert [e.design.tobytes() for e in first[:20]] == [e.design.tobytes() for e in second[:20]]
    assert [e.design.tobytes() for e in first[20:]] != [e.design.tobytes() for e in second[20:]]


def changed_coordinates(evaluations, number):
    """How many coordinates of an evaluated design differ from the incumbent of its trajectory at that time."""
    subject = evaluations[number]
    before = [e for e in evaluations[:number] if e.trajectory == subject.trajectory]
    incumbent = min(before, key=lambda e: e.objectives[0])
    return int(np.sum(subject.design != incumbent.design))


def test_dycors_perturbs_all_coordinates_at_first_and_one_at_the_end_of_the_budget():
    for seed in range(5):
        evaluations = run_trial(DynamicCoordinateSearch, Trial(SIX, budget=60, seed=seed))
        assert changed_coordinates(evaluations, 20) == 6
        assert changed_coordinates(evaluations, 59) == 1


def test_dycors_perturbs_all_coordinates_again_after_a_restart():
    changes = {"failure_tolerance": 4, "halvings_before_restart": 0}
    evaluations = run_trial(DynamicCoordinateSearch, Trial(SIX, budget=60), changes, objective=constant)
    assert changed_coordinates(evaluations, 20) == 6
    restarted = next(e.number for e in evaluations if e.trajectory == 1 and e.origin == "perturbation")
    assert restarted == 44  # 20 initial ones, 4 failures, 20 initial ones
    assert changed_coordinates(evaluations, restarted) == 6


def test_dycors_counts_evaluations_from_the_restart_and_the_budget_left_there(monkeypatch):
    asked = []

    def recorded(n, n_initial, budget, p_initial):
        asked.append((n, n_initial, budget, p_initial))
        return 1.0

    monkeypatch.setattr(dycors, "perturbation_probability", recorded)
    changes = {"failure_tolerance": 4, "halvings_before_restart": 0, "perturbed_coordinates": 3.0}
    trial = Trial(SIX, budget=66, repeats=True, given=2)
    run_trial(DynamicCoordinateSearch, trial, changes, objective=constant)
    # two failures with every evaluation, so that a restart follows two evaluations after each initial design of 20
    assert asked == [(20 + k, 20, budget, 0.5) for budget in (66, 44, 22) for k in (0, 1)]


def test_lmsrs_perturbs_all_coordinates_always():
    evaluations = run_trial(LocalMetricSearch, Trial(SIX, budget=60))
    assert {changed_coordinates(evaluations, number) for number in range(20, 60)} == {6}


@BOTH
def test_restart_after_seven_halvings_and_a_new_initial_design_cut_at_the_budget(plugin):
    evaluations = run_trial(plugin, Trial(REAL, budget=120), objective=constant)
    by_trajectory = [[e for e in evaluations if e.trajectory == k] for k in range(3)]
    assert [len(part) for part in by_trajectory] == [20 + 7 * 5, 20 + 7 * 5, 10]
    assert origins(by_trajectory[1])["initial"] == 20
    assert origins(by_trajectory[2]) == {"initial": 10}


def test_points_from_before_a_restart_stay_out_of_the_surrogate():
    diary = []
    evaluations = run_trial(LocalMetricSearch, Trial(REAL, budget=100), surrogate=spied(diary), objective=constant)
    assert len(diary) == 2
    earlier = {tuple(REAL.to_unit(e.design)) for e in evaluations if e.trajectory == 0}
    later = {tuple(REAL.to_unit(e.design)) for e in evaluations if e.trajectory == 1}
    assert {point for point, _ in diary[0]} <= earlier
    assert {point for point, _ in diary[1]} <= later


@BOTH
def test_a_space_of_integers_is_walked_through_without_repetition_to_its_last_design(plugin):
    space = Space((Variable("a", 0, 4, integer=True), Variable("b", -1, 2, integer=True), Variable("c", 0, 2, integer=True)))
    for batch_size in (1, 4):
        evaluations = run_trial(plugin, Trial(space, budget=60, batch_size=batch_size), {"initial_size": 8})
        assert len({space.key(evaluation.design) for evaluation in evaluations}) == 60


@st.composite
def spaces(draw):
    """Spaces of one to five variables, the integers with two to five values."""
    kinds = draw(st.lists(st.integers(0, 4), min_size=1, max_size=5))
    return Space(
        tuple(
            Variable(f"x{k}", -1.0, -1.0 + steps, integer=True) if steps else Variable(f"x{k}", -3.0, 7.5)
            for k, steps in enumerate(kinds)
        )
    )


@settings(deadline=None, max_examples=15)
@given(spaces(), st.integers(1, 5), st.integers(0, 1), st.sampled_from([2, 3, 1000]), st.integers(0, 2**31))
def test_no_design_is_proposed_twice_in_any_space(space, batch_size, n_given, failing, seed):
    budget = int(min(35, space.size))
    trial = Trial(space, 1, 0, budget, batch_size, seed, lambda number: number % failing == 1)
    evaluations = run_trial(DynamicCoordinateSearch, replace(trial, given=n_given), {"initial_size": 6})
    assert len({space.key(evaluation.design) for evaluation in evaluations}) == budget


@BOTH
def test_with_every_initial_point_failed_it_goes_on_sampling(plugin):
    evaluations = run_trial(plugin, Trial(REAL, budget=50, fails=lambda number: number < 30))
    assert origins(evaluations[:34]) == {"initial": 34}  # d + 1 = 4 successes determine the tail
    assert origins(evaluations[34:]) == {"perturbation": 16}
    assert len({evaluation.design.tobytes() for evaluation in evaluations}) == 50


def test_failed_evaluations_stay_out_of_the_fit_but_nothing_is_proposed_near_them():
    diary = []
    trial = Trial(REAL, budget=80, fails=lambda number: number % 3 == 1)
    evaluations = run_trial(LocalMetricSearch, trial, surrogate=spied(diary))
    failed = {tuple(REAL.to_unit(e.design)) for e in evaluations if e.failed}
    fitted = {point for points in diary for point, _ in points}
    assert not failed & fitted
    points = REAL.to_unit(np.array([e.design for e in evaluations]))
    for evaluation in searched(evaluations):
        distances = np.linalg.norm(points[: evaluation.number] - points[evaluation.number], axis=1)
        assert distances.min() >= 1e-3


def test_repeated_evaluations_are_failures_to_improve_and_join_the_surrogate_once():
    diary = []
    trial = Trial(REAL, budget=45, repeats=True)
    evaluations = run_trial(LocalMetricSearch, trial, surrogate=spied(diary), objective=constant)
    restarted = next(e.number for e in evaluations if e.trajectory == 1)
    assert restarted == 20 + 18  # 35 failures, two with every evaluation
    assert all(len(set(points)) == len(points) for points in diary)


def test_a_repeat_of_a_better_design_from_before_a_restart_is_no_success():
    context_trial = Trial(REAL, budget=200)
    better = Evaluation(0, REAL.lower, np.array([-9.0]), np.empty(0), {}, "given")
    diary = []

    class Reminded(LocalMetricSearch):
        def tell(self, evaluations):
            super().tell(evaluations)
            if evaluations[0].number == 10:
                super().tell([better])
            if evaluations[0].trajectory == 1:
                super().tell([replace(better, repeated=True)])

    evaluations = run_trial(Reminded, context_trial, surrogate=spied(diary), objective=constant)
    per_trajectory = Counter(e.trajectory for e in evaluations)
    assert per_trajectory[1] == 20 + 18
    assert -9.0 in {value for _, value in diary[0]}
    assert -9.0 not in {value for _, value in diary[1]}


def test_points_almost_alike_do_not_spoil_the_fit():
    designs = np.array([[0.5, 500.0, 1.5e-3], [0.5 + 1e-9, 500.0, 1.5e-3], [0.5, 500.0 + 1e-9, 1.5e-3]])

    class Given(LocalMetricSearch):
        def __init__(self, context, parameters):
            super().__init__(context, parameters)
            values = zip(designs, (2.0, 1.0, 0.5), strict=True)
            self.tell([Evaluation(k, d, np.array([v]), np.empty(0), {}, "given") for k, (d, v) in enumerate(values)])

    evaluations = run_trial(Given, Trial(REAL, budget=30))
    assert origins(evaluations)["perturbation"] == 30 - 17


def test_a_surrogate_that_asks_for_more_points_gets_them():
    class Demanding(RadialBasisFunctionInterpolant):
        def fit(self, points, values):
            if len(points) < 27:
                raise SurrogateError("27 points are needed")
            super().fit(points, values)

    def surrogate(name, dimension, settings):
        return Demanding(dimension, RadialBasisFunctionParameters())

    evaluations = run_trial(LocalMetricSearch, Trial(REAL, budget=35), surrogate=surrogate)
    assert [e.origin for e in evaluations] == ["initial"] * 27 + ["perturbation"] * 8


def test_batches_are_full_and_of_different_designs():
    sizes = []

    class Watched(DynamicCoordinateSearch):
        def ask(self):
            proposals = super().ask()
            sizes.append(len(proposals))
            return proposals

    evaluations = run_trial(Watched, Trial(MIXED, budget=60, batch_size=4))
    assert sizes == [4] * 15
    assert len({e.design.tobytes() for e in evaluations}) == 60


def test_the_weights_cycle_through_all_evaluations_whatever_the_batch():
    weights = []

    class Recorded(tuple):
        def __iter__(self):
            for weight in super().__iter__():
                weights.append(weight)
                yield weight

    for batch_size in (1, 3):
        weights.clear()
        parameters = replace(MetricSearchParameters(), weights=Recorded((0.3, 0.5, 0.8, 0.95)))

        class Cycled(LocalMetricSearch):
            def __init__(self, context, ignored, parameters=parameters):
                super().__init__(context, parameters)

        run_trial(Cycled, Trial(REAL, budget=24, batch_size=batch_size))
        assert weights == [0.3, 0.5, 0.8, 0.95]


def test_surrogate_and_its_settings_are_handed_through():
    asked = []
    registry = load_plugins()

    def surrogate(name, dimension, settings):
        asked.append((name, dimension, settings))
        return registry.surrogate(name, dimension, settings)

    changes = {"surrogate_settings": {"kernel": "linear"}}
    run_trial(LocalMetricSearch, Trial(REAL, budget=25), changes, surrogate)
    first, *others = asked
    assert first == ("rbf", 3, {"kernel": "linear"})
    assert all(entry == first for entry in others)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"weights": []}, "weights: one or more numbers from 0 to 1 are needed"),
        ({"weights": [1.5]}, "weights: allowed is ≥ 0 and ≤ 1, received 1.5"),
        ({"sigma_start": 0.0}, "sigma_start: allowed is > 0 and ≤ 1, received 0.0"),
        ({"initial_size": 0}, "initial_size: allowed is ≥ 1, received 0"),
        ({"minimum_distance": 0.0}, "minimum_distance: allowed is ≥ 1e-05"),
    ],
)
def test_bad_settings_are_refused(values, message):
    with pytest.raises(InputError, match=message):
        make_parameters(MetricSearchParameters, values, "strategy dycors")
