from pathlib import Path

import numpy as np
import pytest

from railsearch.budget import REPEATS_IN_A_ROW, BudgetedEvaluator
from railsearch.design_problem import DesignProblem
from railsearch.errors import BudgetExhausted, PluginError, StorageError
from railsearch.interfaces import Evaluation, Outcome, Proposal, Quantity
from railsearch.simulation import InProcess
from railsearch.space import FloatArray, Space, Variable
from sample_problems import CountingSphere, Sphere, Troubled


def evaluator(problem: DesignProblem, budget: int, record: list[Evaluation] | None = None) -> BudgetedEvaluator:
    stored: list[Evaluation] = []
    return BudgetedEvaluator(problem, InProcess(problem), budget, record or [], stored.append, np.random.default_rng(0))


def proposal(*values: float) -> Proposal:
    return Proposal(np.array(values, dtype=float), "initial")


def test_the_call_beyond_the_budget_is_refused(tmp_path: Path) -> None:
    problem = CountingSphere(tmp_path / "calls")
    counted = evaluator(problem, 3)
    for count in range(3):
        counted.evaluate(proposal(0.0, 0.0, count, 0))
    with pytest.raises(BudgetExhausted, match="3 evaluations"):
        counted.evaluate(proposal(0.0, 0.0, 3, 0))
    assert problem.calls == counted.spent == 3


def test_a_repeated_design_is_answered_from_memory_and_free(tmp_path: Path) -> None:
    problem = CountingSphere(tmp_path / "calls")
    counted = evaluator(problem, 2)
    first = counted.evaluate(proposal(0.5, -0.0, 0, 0))
    again = counted.evaluate(proposal(0.5, 0.0, 0, 0))
    assert again.repeated
    assert not first.repeated
    assert np.array_equal(again.objectives, first.objectives)
    assert (problem.calls, counted.spent, counted.repeats) == (1, 1, 1)


def test_a_strategy_that_repeats_for_ever_is_given_an_unseen_design() -> None:
    counted = evaluator(Sphere(), 5)
    same = proposal(0.0, 0.0, 0, 0)
    evaluations = [counted.evaluate(same) for _ in range(REPEATS_IN_A_ROW + 2)]
    assert [evaluation.repeated for evaluation in evaluations[1:-1]] == [True] * REPEATS_IN_A_ROW
    unseen = evaluations[-1]
    assert unseen.origin == "unseen"
    assert not np.array_equal(unseen.design, same.design)
    assert counted.spent == 2


def test_a_small_space_ends_when_every_design_is_known() -> None:
    class Corners(DesignProblem):
        def __init__(self) -> None:
            super().__init__("corners", Space((Variable("a", 0, 1, integer=True),)), [Quantity("f")])

        def simulate(self, design: FloatArray) -> Outcome:
            return Outcome(design)

    counted = evaluator(Corners(), 10)
    counted.evaluate(proposal(0.0))
    for _ in range(REPEATS_IN_A_ROW + 1):
        counted.evaluate(proposal(0.0))
    assert counted.exhausted
    assert counted.spent == 2


@pytest.mark.parametrize(
    ("count", "reason"),
    [(-4, "ZeroDivisionError: no ballast"), (-3, "distance is nan"), (-2, "distance is inf"), (-1, "1 values are needed")],
)
def test_a_failure_is_a_charged_result_with_its_reason(count: int, reason: str) -> None:
    counted = evaluator(Troubled(), 2)
    failed = counted.evaluate(proposal(0.0, 0.0, count, 0))
    assert failed.failed
    assert reason in failed.reason
    assert np.isnan(failed.objectives).all()
    assert counted.spent == 1


def test_a_failure_in_the_free_part_keeps_the_metrics() -> None:
    class Careless(Sphere):
        def finish(self, design: FloatArray, outcome: Outcome) -> Outcome:
            raise KeyError("weights")

    failed = evaluator(Careless(), 1).evaluate(proposal(3.0, 4.0, 0, 0))
    assert "KeyError" in failed.reason
    assert failed.metrics == {"norm": 5.0}


def test_a_record_is_replayed_without_a_call(tmp_path: Path) -> None:
    designs = [proposal(0.0, 0.0, count, 0) for count in range(4)]
    first = evaluator(Sphere(), 4)
    done = [first.evaluate(design) for design in designs[:3]]
    problem = CountingSphere(tmp_path / "calls")
    second = evaluator(problem, 4, done)
    assert [second.evaluate(design) for design in designs[:3]] == done
    assert problem.calls == 0
    assert second.evaluate(designs[3]).number == 3
    assert problem.calls == 1


def test_a_record_of_other_designs_is_refused() -> None:
    done = [evaluator(Sphere(), 1).evaluate(proposal(0.0, 0.0, 0, 0))]
    with pytest.raises(StorageError, match="differs from this run at evaluation 1"):
        evaluator(Sphere(), 2, done).evaluate(proposal(0.0, 0.0, 1, 0))


def test_a_proposal_outside_the_space_names_the_strategy_as_the_cause() -> None:
    with pytest.raises(PluginError, match=r"strategy proposed .* count: a whole number"):
        evaluator(Sphere(), 2).evaluate(proposal(0.0, 0.0, 0.5, 0))
