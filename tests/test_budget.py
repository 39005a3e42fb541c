from collections.abc import Iterator, Sequence
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from railsearch.budget import REPEATS_IN_A_ROW, BudgetedEvaluator
from railsearch.design_problem import DesignProblem
from railsearch.errors import PluginError, StorageError
from railsearch.interfaces import Evaluation, Outcome, Proposal, Quantity
from railsearch.simulation import InProcess, Simulated, Simulators, simulators
from railsearch.space import FloatArray, Space, Variable
from sample_problems import CountingSphere, Sphere, Troubled


class Evaluator(BudgetedEvaluator):
    """Evaluates one proposal after the other; None is what the budget does not pay for."""

    def one(self, proposal: Proposal) -> Evaluation | None:
        answers = answered(self, [proposal])
        return answers[0] if answers else None


def answered(counted: BudgetedEvaluator, proposals: list[Proposal], finished: list[int] | None = None) -> list[Evaluation]:
    steps = counted.evaluate(proposals)
    while True:
        try:
            evaluation = next(steps)
        except StopIteration as ended:
            return ended.value
        if finished is not None:
            finished.append(evaluation.number)


def evaluator(problem: DesignProblem, budget: int, record: list[Evaluation] | None = None) -> Evaluator:
    return Evaluator(problem, Simulators([InProcess(problem)]), budget, record or [], np.random.default_rng(0))


def proposal(*values: float) -> Proposal:
    return Proposal(np.array(values, dtype=float), "initial")


def test_the_call_beyond_the_budget_is_refused(tmp_path: Path) -> None:
    problem = CountingSphere(tmp_path / "calls")
    counted = evaluator(problem, 3)
    for count in range(3):
        counted.one(proposal(0.0, 0.0, count, 0))
    assert counted.one(proposal(0.0, 0.0, 3, 0)) is None
    assert problem.calls == counted.spent == 3


def test_a_repeated_design_is_answered_from_memory_and_free(tmp_path: Path) -> None:
    problem = CountingSphere(tmp_path / "calls")
    counted = evaluator(problem, 2)
    first = counted.one(proposal(0.5, -0.0, 0, 0))
    again = counted.one(proposal(0.5, 0.0, 0, 0))
    assert again.repeated
    assert not first.repeated
    assert np.array_equal(again.objectives, first.objectives)
    assert (problem.calls, counted.spent, counted.repeats) == (1, 1, 1)


def test_a_strategy_that_repeats_for_ever_is_given_an_unseen_design() -> None:
    counted = evaluator(Sphere(), 5)
    same = proposal(0.0, 0.0, 0, 0)
    evaluations = [counted.one(same) for _ in range(REPEATS_IN_A_ROW + 2)]
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
    counted.one(proposal(0.0))
    for _ in range(REPEATS_IN_A_ROW + 1):
        counted.one(proposal(0.0))
    assert counted.exhausted
    assert counted.spent == 2


@pytest.mark.parametrize(
    ("count", "reason"),
    [(-4, "ZeroDivisionError: no ballast"), (-3, "distance is nan"), (-2, "distance is inf"), (-1, "1 values are needed")],
)
def test_a_failure_is_a_charged_result_with_its_reason(count: int, reason: str) -> None:
    counted = evaluator(Troubled(), 2)
    failed = counted.one(proposal(0.0, 0.0, count, 0))
    assert failed.failed
    assert reason in failed.reason
    assert np.isnan(failed.objectives).all()
    assert counted.spent == 1


def test_a_failure_in_the_free_part_keeps_the_metrics() -> None:
    class Careless(Sphere):
        def finish(self, design: FloatArray, outcome: Outcome) -> Outcome:
            raise KeyError("weights")

    failed = evaluator(Careless(), 1).one(proposal(3.0, 4.0, 0, 0))
    assert "KeyError" in failed.reason
    assert failed.metrics == {"norm": 5.0}


def test_a_record_is_replayed_without_a_call(tmp_path: Path) -> None:
    designs = [proposal(0.0, 0.0, count, 0) for count in range(4)]
    first = evaluator(Sphere(), 4)
    done = [first.one(design) for design in designs[:3]]
    problem = CountingSphere(tmp_path / "calls")
    second = evaluator(problem, 4, done)
    assert [second.one(design) for design in designs[:3]] == done
    assert problem.calls == 0
    assert second.one(designs[3]).number == 3
    assert problem.calls == 1


def test_a_record_of_other_designs_is_refused() -> None:
    done = [evaluator(Sphere(), 1).one(proposal(0.0, 0.0, 0, 0))]
    with pytest.raises(StorageError, match="differs from this run at evaluation 1"):
        evaluator(Sphere(), 2, done).one(proposal(0.0, 0.0, 1, 0))


def test_a_proposal_outside_the_space_names_the_strategy_as_the_cause() -> None:
    with pytest.raises(PluginError, match=r"strategy proposed .* count: a whole number"):
        evaluator(Sphere(), 2).one(proposal(0.0, 0.0, 0.5, 0))


def batch(*counts: int) -> list[Proposal]:
    return [proposal(0.0, 0.0, count, 0) for count in counts]


class Backwards(Simulators):
    """Finishes the last design of a batch first."""

    def simulate(self, designs: Sequence[FloatArray]) -> Iterator[tuple[int, Simulated]]:
        return reversed(list(super().simulate(designs)))


def test_a_batch_is_answered_in_its_order_whatever_the_order_of_finishing() -> None:
    problem, finished = Sphere(), []
    counted = BudgetedEvaluator(problem, Backwards([InProcess(problem)]), 9, [], np.random.default_rng(0))
    answers = answered(counted, batch(0, 1, 0, 2), finished)
    assert finished == [2, 1, 0]
    assert [answer.design[2] for answer in answers] == [0, 1, 0, 2]
    assert [answer.repeated for answer in answers] == [False, False, True, False]
    assert [evaluation.number for evaluation in counted.evaluations] == [0, 1, 2]
    assert (counted.spent, counted.repeats) == (3, 1)


def test_a_batch_is_cut_exactly_at_the_budget(tmp_path: Path) -> None:
    problem = CountingSphere(tmp_path / "calls")
    counted = evaluator(problem, 3)
    answers = answered(counted, batch(0, 1, 0, 2, 3, 4))
    assert [answer.design[2] for answer in answers] == [0, 1, 0, 2]
    assert problem.calls == counted.spent == 3
    assert counted.exhausted


def test_a_batch_that_was_stopped_in_its_middle_is_completed(tmp_path: Path) -> None:
    """Of four evaluations the last two were finished first and stored; only the others are made."""
    whole = answered(evaluator(Sphere(), 4), batch(0, 1, 2, 3))
    problem = CountingSphere(tmp_path / "calls")
    continued = evaluator(problem, 4, [whole[3], whole[2]])
    answers = answered(continued, batch(0, 1, 2, 3))
    assert [answer.objectives[0] for answer in answers] == [answer.objectives[0] for answer in whole]
    assert problem.calls == 2


def test_processes_side_by_side_give_what_one_process_gives() -> None:
    problem = Sphere()
    alone = answered(evaluator(problem, 8), batch(*range(-4, 5)))
    with closing(simulators(problem, workers=3)) as three:
        counted = BudgetedEvaluator(problem, three, 8, [], np.random.default_rng(0))
        together = answered(counted, batch(*range(-4, 5)))
    assert [(e.number, e.objectives.tobytes(), e.design.tobytes()) for e in together] == [
        (e.number, e.objectives.tobytes(), e.design.tobytes()) for e in alone
    ]
