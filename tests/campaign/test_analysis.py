import json
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sample_campaigns import Searcher, campaign_of, record_of, results_of, synthetic_results

from railsearch.campaign.analysis import campaign_document
from railsearch.campaign.best_designs import front_places
from railsearch.campaign.cells import Cell
from railsearch.campaign.comparison import shown_numbers, smallest_adjusted, thinned
from railsearch.campaign.ranking import probability_best_rank
from railsearch.campaign.results import CampaignResults
from railsearch.design_problem import DesignProblem
from railsearch.indicators import non_dominated
from railsearch.interfaces import Outcome, Quantity
from railsearch.space import FloatArray, Space, Variable
from sample_problems import Sphere, TwoObjectives

CLEAR = {"good": [1.0, 2.0, 3.0, 4.0, 5.0], "fair": [6.0, 7.0, 8.0, 9.0, 10.0], "poor": [20.0, 21.0, 22.0, 23.0, 24.0]}
TIED = {"one": [1.0, 3.0, 5.0, 7.0, 9.0], "other": [2.0, 4.0, 4.5, 6.0, 8.0]}


class Comfort(DesignProblem):
    """One objective that is maximised, over nine designs."""

    def __init__(self) -> None:
        space = Space((Variable("count", 0, 8, "", integer=True),))
        super().__init__("comfort", space, [Quantity("comfort", "m", maximised=True)], reference=np.zeros(1))

    def simulate(self, design: FloatArray) -> Outcome:
        return Outcome(-design)


def only(results: CampaignResults) -> dict[str, Any]:
    (entry,) = campaign_document(results)["problems"]
    return dict(entry)


def changed(results: CampaignResults, scale: float, shift: float) -> CampaignResults:
    records = {
        cell: replace(record, objectives=scale * record.objectives + shift) for cell, record in results.records.items()
    }
    return replace(results, records=records)


# What is said


def test_a_clear_winner_is_named_with_its_uncertainty() -> None:
    document = campaign_document(results_of(Sphere(), CLEAR))
    said = document["conclusion"]
    assert said.startswith("good is best on p, with 4 evaluations: median distance 3 m², quartiles 2 to 4 m²")
    assert "significantly better than both others" in said
    assert "Wilcoxon rank-sum test with Holm's correction at 5 %" in said
    assert said.endswith("in all resamples of the 5 repetitions good has the best median.")
    assert document["notes"] == []


def test_strategies_that_cannot_be_told_apart_are_not_called_different() -> None:
    said = campaign_document(results_of(Sphere(), TIED))["conclusion"]
    assert said.startswith(
        "No strategy is distinguishable from the others on p, with 4 evaluations: other has the best median"
    )
    assert "is not significantly better than any other" in said


def test_strategies_that_share_the_best_median_are_both_named() -> None:
    said = campaign_document(results_of(Sphere(), {"a": [1.0, 2.0, 3.0, 4.0], "b": [2.0, 2.0, 3.0, 3.0]}))["conclusion"]
    assert ": a and b share the best median (distance 2.5 m²" in said


def test_a_winner_is_told_apart_from_some() -> None:
    finals = {**TIED, "poor": CLEAR["poor"]}
    said = campaign_document(results_of(Sphere(), finals))["conclusion"]
    assert said.startswith("other leads on p")
    assert "significantly better than poor, but not distinguishable from one" in said


def test_the_best_median_may_belong_to_a_strategy_that_is_worse_as_a_rule() -> None:
    ease = np.linspace(0.0, 0.01, 61)
    finals = {"a": np.repeat([0.9, 100.0], [31, 30]) + ease, "b": np.repeat([0.5, 1.0], [30, 31]) + ease}
    entry = only(results_of(Sphere(), {name: values.tolist() for name, values in finals.items()}))
    assert entry["pairwise"]["adjusted"][0][1] < 0.05
    assert entry["conclusion"].startswith("No strategy is distinguishable as the best on p")
    assert "a has the best median" in entry["conclusion"]


def test_one_repetition_of_many_problems_concludes_nothing() -> None:
    problems: dict[str, DesignProblem] = {"p": Sphere(), "q": Sphere()}
    results = synthetic_results(problems, {"a": Searcher(0.9), "b": Searcher(0.3), "c": Searcher(0.0)}, 1, 20)
    said = campaign_document(results)["conclusion"]
    assert said.startswith("With one repetition nothing can be concluded on 2 problems")
    assert "may be luck; a difference among 3 strategies can be shown from 5 repetitions on" in said


def test_too_few_repetitions_are_said_to_be_too_few() -> None:
    said = campaign_document(results_of(Sphere(), {"a": [1.0, 2.0, 3.0], "b": [11.0, 12.0, 13.0]}))["conclusion"]
    assert said.startswith("No strategy is distinguishable")
    assert "3 repetitions are too few to show any difference" in said
    assert "a difference among 2 strategies can be shown from 4 repetitions on" in said
    enough = {"a": [1.0, 2.0, 3.0, 4.0], "b": [11.0, 12.0, 13.0, 14.0]}
    assert "a is best" in campaign_document(results_of(Sphere(), enough))["conclusion"]


def test_the_smallest_p_value_is_that_of_complete_separation() -> None:
    entry = only(results_of(Sphere(), CLEAR))
    assert np.min(entry["pairwise"]["adjusted"]) == pytest.approx(smallest_adjusted(3, 5))


@pytest.mark.parametrize(
    ("finals", "words"),
    [
        ({"a": [1.0], "b": [2.0]}, "With one repetition nothing can be concluded on p: a ended best (distance 1 m²)"),
        ({"a": [1.0, 2.0, 3.0]}, "a alone was run on p, so there is nothing to compare it with"),
        ({"a": [math.nan] * 3, "b": [math.nan] * 3}, "No strategy can be called better on p: none found a feasible design"),
    ],
)
def test_what_cannot_be_answered_is_said(finals: dict[str, list[float]], words: str) -> None:
    results = results_of(Sphere(), finals)
    records = {
        cell: replace(record, objectives=np.full((4, 1), np.nan), reasons=["ZeroDivisionError: no ballast"] * 4)
        if np.isnan(record.objectives[-1, 0])
        else record
        for cell, record in results.records.items()
    }
    said = campaign_document(replace(results, records=records))["conclusion"]
    assert words in said
    assert "significantly" not in said


def test_a_campaign_without_a_finished_run_says_so() -> None:
    results = results_of(Sphere(), CLEAR)
    document = campaign_document(replace(results, records={}))
    assert document["conclusion"].startswith("Nothing can be said on p yet")
    assert document["status"] == "incomplete"
    assert document["problems"][0]["design"]["best"] is None
    json.dumps(document, allow_nan=False)


def test_a_winner_over_problems_is_named_with_ranks() -> None:
    problems = {name: Sphere() for name in "uvwxyz"}
    one = results_of(Sphere(), CLEAR)
    records = {replace(cell, problem=label): record for label in problems for cell, record in one.records.items()}
    results = CampaignResults(campaign_of(problems, list(CLEAR), 5, 4), problems, records)
    document = campaign_document(results)
    assert document["ranking"]["mean_ranks"] == [1.0, 2.0, 3.0]
    assert document["ranking"]["wins"] == [6, 0, 0]
    assert document["ranking"]["probability_best"] == pytest.approx([1.0, 0.0, 0.0], abs=1e-3)
    said = document["conclusion"]
    assert said.startswith("good leads on 6 problems, with 4 evaluations each: mean rank 1 of 3, best median on 6 of 6")
    assert "significantly better than every other strategy on u, v, w, x, y and z" in said
    assert "separates it from poor" in said


def test_equal_strategies_are_not_ranked_apart() -> None:
    problems = {"u": Sphere(), "v": Sphere()}
    records = {
        Cell(problem, strategy, number): record_of(Sphere(), [9.0, 9.0, 9.0, float(number)])
        for problem in problems
        for strategy in ("a", "b", "c")
        for number in range(1, 7)
    }
    document = campaign_document(CampaignResults(campaign_of(problems, ["a", "b", "c"], 6, 4), problems, records))
    assert document["conclusion"].startswith("No strategy is distinguishable as the best on 2 problems")
    assert document["ranking"]["mean_ranks"] == [2.0, 2.0, 2.0]


def test_shares_of_the_best_mean_rank() -> None:
    generator = np.random.default_rng(1)
    same = [np.arange(6.0)] * 3
    assert probability_best_rank([same, same], generator) == pytest.approx([1 / 3] * 3, abs=0.05)
    apart = [np.arange(6.0), np.arange(6.0) + 10.0, np.full(6, np.inf)]
    assert probability_best_rank([apart, same], generator)[0] > 0.5
    assert probability_best_rank([apart, apart], generator).tolist() == [1.0, 0.0, 0.0]


# What is computed


def test_curves_and_fixed_budgets_of_a_hand_made_case() -> None:
    entry = only(results_of(Sphere(), {"a": [1.0, 2.0, 3.0, 4.0, 5.0]}, budget=8))
    curve = entry["curves"]["a"]
    assert entry["numbers"] == [1, 2, 3, 4, 5, 6, 7, 8]
    assert curve["median"] == [100.0] * 4 + [3.0] * 4
    assert (curve["lower"][-1], curve["upper"][-1]) == (2.0, 4.0)
    assert 1.0 <= curve["confidence_lower"][-1] <= 3.0 <= curve["confidence_upper"][-1] <= 5.0
    (row,) = entry["fixed_budget"]
    assert [place["evaluations"] for place in row["places"]] == [1, 2, 4, 8]
    assert [place["median"] for place in row["places"]] == [100.0, 100.0, 100.0, 3.0]


def test_failed_and_infeasible_evaluations_do_not_count() -> None:
    problem = TwoObjectives(constrained=True)
    record = record_of(
        problem, [[9.0, 9.0], [math.nan, math.nan], [1.0, 1.0], [4.0, 4.0]], ["", "ValueError: x\nmore", "", ""]
    )
    record = replace(record, constraints=np.array([[0.0], [math.nan], [0.1], [-1.0]]))
    results = CampaignResults(campaign_of({"p": problem}, ["a"], 1, 4), {"p": problem}, {Cell("p", "a", 1): record})
    entry = only(results)
    assert entry["measure"]["box"]["ideal"] == {"left": 4.0, "right": 4.0}
    assert entry["design"]["best"]["number"] == 4
    first = (50.0 - 9.0) / (50.0 - 4.0) * (80.0 - 9.0) / (80.0 - 4.0)
    assert entry["curves"]["a"]["median"] == pytest.approx([first] * 3 + [1.0])
    (cell,) = entry["cells"]
    assert (cell["failed"], cell["infeasible"]) == (1, 1)
    assert cell["reasons"] == [{"reason": "ValueError: x", "count": 1}]
    assert (cell["evaluation_seconds"], cell["overhead_seconds"]) == (0.05, 0.002)


def test_a_curve_begins_with_its_first_feasible_value() -> None:
    record = record_of(Sphere(), [math.nan, 5.0, 7.0, 2.0], ["failed", "", "", ""])
    results = CampaignResults(campaign_of({"p": Sphere()}, ["a"], 1, 4), {"p": Sphere()}, {Cell("p", "a", 1): record})
    assert only(results)["curves"]["a"]["median"] == [None, 5.0, 5.0, 2.0]


def test_a_maximised_objective_keeps_its_natural_sign() -> None:
    problem = Comfort()
    finals = {"low": [-1.0, -2.0, -3.0, -4.0, -5.0], "high": [-11.0, -12.0, -13.0, -14.0, -15.0]}
    entry = only(results_of(problem, finals))
    assert entry["leader"] == "high"
    place = entry["fixed_budget"][1]["places"][-1]
    assert (place["median"], place["lower"], place["upper"]) == (13.0, 12.0, 14.0)
    curve = entry["curves"]["high"]
    assert curve["lower"][-1] < curve["confidence_lower"][-1] + 2.0 <= curve["confidence_upper"][-1] + 2.0
    assert entry["pairwise"]["effect"][1][0] == 1.0, "the higher is better"
    assert entry["design"]["best"]["objectives"] == {"comfort": 15.0}
    assert entry["targets"]["best"] == 15.0


def test_a_space_smaller_than_the_budget_is_complete_when_every_design_is_evaluated() -> None:
    problem = Comfort()
    records = {Cell("p", "a", 1): record_of(problem, [0.0, -1.0, -2.0, -3.0, -4.0, -5.0, -6.0, -7.0, -8.0])}
    document = campaign_document(CampaignResults(campaign_of({"p": problem}, ["a"], 1, 50), {"p": problem}, records))
    assert document["status"] == "complete"
    assert document["problems"][0]["numbers"] == list(range(1, 10))


def test_expected_running_times_of_a_hand_made_case() -> None:
    entry = only(results_of(Sphere(), {"a": [0.0, 0.0], "b": [0.0, 50.0]}, budget=10))
    targets = entry["targets"]
    assert (targets["start"], targets["best"]) == (100.0, 0.0)
    assert targets["expected_running_time"]["a"] == [6.0] * len(targets["values"])
    easy, hard = targets["expected_running_time"]["b"][0], targets["expected_running_time"]["b"][-1]
    assert (easy, hard) == (6.0, 16.0), "the last target is reached once in 6 + 10 evaluations"
    assert targets["ecdf"]["a"] == [0.0] * 5 + [1.0] * 5


@pytest.mark.parametrize(
    ("point", "worst", "expected", "source"),
    [
        ({"left": 13.0, "right": 25.0}, {"left": 7.0, "right": 13.0}, 4.0 / 9.0, "given by the campaign"),
        ({}, {"left": 7.0, "right": 13.0}, 1.0 / 9.0, "the problem's worst known values"),
        ({}, {}, 1.0 / 4.0, "the worst recorded values"),
        ({"left": 1.0, "right": 25.0}, {"left": 7.0}, 1.0 / 4.0, "the worst recorded values"),
    ],
)
def test_hypervolume_is_a_share_of_a_recorded_box(
    point: dict[str, float], worst: dict[str, float], expected: float, source: str
) -> None:
    problem = TwoObjectives(worst=worst)
    campaign = campaign_of({"p": problem}, ["a", "b"], 1, 2, {"p": point})
    records = {
        Cell("p", "a", 1): record_of(problem, [[9.0, 17.0], [5.0, 9.0]]),
        Cell("p", "b", 1): record_of(problem, [[1.0, 3.0], [3.0, 1.0]]),
    }
    entry = only(CampaignResults(campaign, {"p": problem}, records))
    assert entry["measure"]["box"]["source"] == source
    assert entry["measure"]["box"]["ideal"] == {"left": 1.0, "right": 1.0}
    assert entry["fixed_budget"][0]["places"][-1]["median"] == pytest.approx(expected)


def test_a_reference_point_is_given_with_its_natural_sign() -> None:
    class Pair(TwoObjectives):
        def __init__(self) -> None:
            super().__init__()
            self.objectives = (Quantity("left", "N"), Quantity("comfort", "m", maximised=True))

    problem = Pair()
    campaign = campaign_of({"p": problem}, ["a"], 1, 1, {"p": {"left": 10.0, "comfort": 1.0}})
    record = record_of(problem, [[4.0, -7.0]])
    entry = only(CampaignResults(campaign, {"p": problem}, {Cell("p", "a", 1): record}))
    assert entry["measure"]["box"]["reference"] == {"left": 10.0, "comfort": 1.0}
    assert entry["measure"]["box"]["ideal"] == {"left": 4.0, "comfort": 7.0}
    assert entry["fixed_budget"][0]["places"][-1]["median"] == 1.0
    assert entry["attainment"]["a"][1] == [[4.0, 7.0]]


@pytest.mark.parametrize("problem", [Sphere(), TwoObjectives(worst={})], ids=["one", "two"])
def test_units_of_the_objectives_change_no_conclusion(problem: DesignProblem) -> None:
    searchers = {"a": Searcher(0.9), "b": Searcher(0.3, 0.1), "c": Searcher(0.0)}
    results = synthetic_results({"p": problem}, searchers, 6, 30)
    one, other = only(results), only(changed(results, 1024.0, 0.0))
    assert one["pairwise"] == other["pairwise"]
    assert one["probability_best"] == other["probability_best"]
    assert one["targets"]["ecdf"] == other["targets"]["ecdf"]
    if problem.n_obj == 2:
        assert one["curves"] == other["curves"]


def test_the_order_of_strategies_changes_nothing() -> None:
    results = synthetic_results({"p": Sphere()}, {"a": Searcher(0.9), "b": Searcher(0.3), "c": Searcher(0.0)}, 6, 30)
    turned = replace(results, campaign=replace(results.campaign, strategies=results.campaign.strategies[::-1]))
    one, other = only(results), only(turned)
    assert one["leader"] == other["leader"]
    assert one["fixed_budget"] == other["fixed_budget"][::-1]
    assert np.array(one["pairwise"]["adjusted"])[::-1, ::-1] == pytest.approx(np.array(other["pairwise"]["adjusted"]))


def test_the_distance_from_a_known_front() -> None:
    class Known(TwoObjectives):
        def _calc_pareto_front(self) -> FloatArray:
            return np.array([[0.0, 10.0], [10.0, 0.0]])

    problem = Known(worst={})
    rows = {"near": [[10.0, 20.0], [0.0, 10.0], [10.0, 0.0]], "far": [[10.0, 20.0], [2.0, 10.0], [10.0, 0.0]]}
    records = {Cell("p", strategy, 1): record_of(problem, values) for strategy, values in rows.items()}
    entry = only(CampaignResults(campaign_of({"p": problem}, list(rows), 1, 3), {"p": problem}, records))
    # The box is 10 wide in `left`: half of the front is missed by 2, that is by 0.2 of the box.
    assert entry["front_distance"]["near"]["median"] == 0.0
    assert entry["front_distance"]["far"]["median"] == pytest.approx(0.5 * 0.2)
    assert only(results_of(Sphere(), CLEAR))["front_distance"] == {}


def test_attainment_of_two_runs() -> None:
    problem = TwoObjectives()
    rows = {1: [[1.0, 4.0], [3.0, 2.0]], 2: [[2.0, 3.0], [9.0, 9.0]]}
    records = {Cell("p", "a", number): record_of(problem, values) for number, values in rows.items()}
    surfaces = only(CampaignResults(campaign_of({"p": problem}, ["a"], 2, 2), {"p": problem}, records))["attainment"]["a"]
    assert surfaces[0] == surfaces[1] == [[1.0, 4.0], [2.0, 3.0], [3.0, 2.0]]
    assert surfaces[2] == [[2.0, 4.0], [3.0, 3.0]], "both runs attain these"


@given(st.integers(1, 5000))
def test_thinned_corners_are_corners_with_both_ends(count: int) -> None:
    corners = np.column_stack([np.arange(count), -np.arange(count)]).astype(float)
    kept = thinned(corners)
    assert len(kept) == min(count, 100)
    assert kept[0].tolist() == corners[0].tolist()
    assert kept[-1].tolist() == corners[-1].tolist()
    assert np.all(np.diff(kept[:, 0]) > 0.0)


@given(st.integers(1, 100_000))
def test_curves_are_given_at_few_numbers_from_one_to_the_budget(budget: int) -> None:
    numbers = shown_numbers(budget)
    assert (numbers[0], numbers[-1]) == (1, budget)
    assert numbers.size <= 200
    assert np.all(np.diff(numbers) > 0)


# Which design is best


def test_the_best_design_stands_beside_the_reference_design() -> None:
    results = results_of(Sphere(), CLEAR)
    design = only(results)["design"]
    assert design["found_by"] == {"strategy": "good", "repetition": 1}
    assert (design["best"]["number"], design["best"]["objectives"]) == (3, {"distance": 1.0})
    assert design["reference"]["objectives"] == {"distance": 100.0}
    assert design["improvement"]["distance"] == pytest.approx(99.0)
    assert design["searched"] == ["distance"]


def test_the_front_of_all_cells_is_that_of_all_evaluations() -> None:
    problem = TwoObjectives(constrained=True)
    results = synthetic_results({"p": problem}, {"a": Searcher(0.8, 0.1), "b": Searcher(0.0)}, 4, 40)
    places = front_places(results.records)
    found = sorted(tuple(results.records[cell].objectives[row]) for cell, row in places)
    everything = np.concatenate([record.objectives[record.feasible] for record in results.records.values()])
    assert found == sorted(map(tuple, everything[non_dominated(everything)]))
    assert only(results)["design"]["front_size"] == len(places)


# What is missing


def without(results: CampaignResults, *cells: tuple[str, str, int]) -> CampaignResults:
    gone = {Cell(*cell) for cell in cells}
    return replace(results, records={cell: record for cell, record in results.records.items() if cell not in gone})


def test_only_repetitions_that_all_strategies_have_finished_are_compared() -> None:
    results = results_of(Sphere(), CLEAR)
    short = Cell("p", "poor", 2)
    cut = {
        cell: replace(record, objectives=record.objectives[:3], constraints=record.constraints[:3], reasons=[""] * 3)
        if cell == short
        else record
        for cell, record in results.records.items()
    }
    document = campaign_document(without(replace(results, records=cut), ("p", "good", 5)))
    (entry,) = document["problems"]
    assert entry["repetitions"] == [1, 3, 4]
    assert entry["fixed_budget"][0]["places"][-1]["median"] == 3.0
    assert [(cell["begun"], cell["complete"]) for cell in entry["cells"]] == [(4, 4), (5, 5), (5, 4)]
    assert document["status"] == "incomplete"
    assert document["notes"] == [
        "p is incomplete, 13 of 15 runs are finished: 3 of 5 repetitions are complete for all compared strategies, and only "
        "these count."
    ]


def test_a_strategy_without_a_finished_run_is_left_out() -> None:
    results = without(results_of(Sphere(), CLEAR), *(("p", "good", number) for number in range(1, 6)))
    document = campaign_document(results)
    (entry,) = document["problems"]
    assert entry["compared"] == ["fair", "poor"]
    assert "On p, good is left out of the comparison: without a complete run so far." in document["notes"]


def test_a_skipped_strategy_is_not_applicable_and_the_campaign_complete() -> None:
    results = without(results_of(Sphere(), CLEAR), *(("p", "good", number) for number in range(1, 6)))
    document = campaign_document(results, skipped=[("p", "good")])
    (entry,) = document["problems"]
    assert (document["status"], document["planned"], document["complete"]) == ("complete", 10, 10)
    assert entry["not_applicable"] == ["good"]
    assert document["notes"] == ["On p, good is not applicable and was skipped."]


def test_ranks_are_over_the_strategies_that_all_problems_have() -> None:
    problems: dict[str, DesignProblem] = {"p": Sphere(), "q": TwoObjectives()}
    searchers = {"a": Searcher(0.9), "b": Searcher(0.3), "c": Searcher(0.0)}
    results = synthetic_results(problems, searchers, 3, 20)
    document = campaign_document(without(results, *(("q", "a", n) for n in (1, 2, 3))), skipped=[("q", "a")])
    assert document["ranking"]["strategies"] == ["b", "c"]
    assert document["ranking"]["untested"]
    assert "Ranks over the problems leave out a: not compared on every problem." in document["notes"]
    alone = without(results, *((p, s, n) for p, s in (("q", "a"), ("q", "b"), ("p", "c")) for n in (1, 2, 3)))
    apart = campaign_document(alone)
    assert apart["ranking"] is None
    assert apart["conclusion"].startswith("The strategies cannot be ranked over the problems")


def test_the_same_results_give_the_same_strict_json() -> None:
    problems: dict[str, DesignProblem] = {"p": Sphere(), "q": TwoObjectives(constrained=True)}
    results = synthetic_results(problems, {"a": Searcher(0.9, 0.2), "b": Searcher(0.3), "c": Searcher(0.0)}, 4, 30)
    texts = [json.dumps(campaign_document(results), allow_nan=False) for _ in range(2)]
    assert texts[0] == texts[1]
    assert json.loads(texts[0])["seeds"][0]["seed"] == results.records[Cell("p", "a", 1)].identity["seed"]


def test_evaluations_that_failed_at_another_time_limit_are_noted() -> None:
    problem = Sphere()
    reasons = ["", "time limit of 0.1 s exceeded", "time limit of 0.1 s exceeded", "time limit of 5 s exceeded"]
    record = record_of(problem, [4.0, math.nan, math.nan, math.nan], reasons)
    campaign = replace(campaign_of({"p": problem}, ["a"], 1, 4), timeout=5.0)
    notes = campaign_document(CampaignResults(campaign, {"p": problem}, {Cell("p", "a", 1): record}))["notes"]
    (note,) = [text for text in notes if "time limit" in text]
    assert "On p, 2 evaluations failed at a time limit of 0.1 s; the campaign now has 5 s" in note


def test_what_a_strategy_costs_is_its_mean() -> None:
    """Most evaluations of a generation cost nothing, and one costs all."""
    problem = Sphere()
    record = replace(record_of(problem, [4.0, 3.0, 2.0, 1.0]), overheads=np.array([0.0, 0.0, 0.0, 0.4]))
    results = CampaignResults(campaign_of({"p": problem}, ["a"], 1, 4), {"p": problem}, {Cell("p", "a", 1): record})
    (cell,) = only(results)["cells"]
    assert cell["overhead_seconds"] == pytest.approx(0.1)
