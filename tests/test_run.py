from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from railsearch.design_problem import ScalarisedProblem
from railsearch.errors import CapabilityError, InputError
from railsearch.interfaces import Capabilities, Evaluation, NoParameters, Proposal, SearchContext
from railsearch.plugin_manager import Entry, Provenance, Registry, load_plugins
from railsearch.run import MemoryRecord, RunSettings, best, front, run_search
from railsearch.simulation import InProcess, Simulated, Simulators
from railsearch.space import FloatArray
from railsearch.storage import StudyDescription, open_run
from sample_problems import MIXED, CountingSphere, Sphere, Troubled, TwoObjectives

SINGLE = ("random", "dycors", "lmsrs", "ga")
EVERY = (*SINGLE, "nsga2")


@pytest.fixture(scope="module")
def registry() -> Registry:
    return load_plugins()


def designs(evaluations: Any) -> list[bytes]:
    return [evaluation.design.tobytes() for evaluation in evaluations]


@pytest.mark.parametrize("strategy", EVERY)
def test_exactly_the_budget_is_spent_by_every_strategy(registry: Registry, strategy: str, tmp_path: Path) -> None:
    problem = CountingSphere(tmp_path / "calls")
    result = run_search(registry, problem, RunSettings(strategy, 47, 5), [problem.reference])
    assert len(result.evaluations) == problem.calls == 47
    assert [evaluation.number for evaluation in result.evaluations] == list(range(47))
    assert result.evaluations[0].origin == "given"
    assert len(set(designs(result.evaluations))) == 47


@pytest.mark.parametrize("strategy", EVERY)
def test_a_run_continued_from_any_length_is_the_undisturbed_one(registry: Registry, strategy: str) -> None:
    settings = RunSettings(strategy, 45, 11)
    whole = run_search(registry, Sphere(), settings, [np.zeros(4)])
    for length in (1, 13, 30, 45):
        record = MemoryRecord()
        record.evaluations = list(whole.evaluations[:length])
        continued = run_search(registry, Sphere(), settings, [np.zeros(4)], record)
        assert designs(continued.evaluations) == designs(whole.evaluations)
        assert continued.replayed == length
        assert [e.origin for e in continued.evaluations] == [e.origin for e in whole.evaluations]


@pytest.mark.parametrize("strategy", EVERY)
def test_a_run_survives_every_kind_of_failure(registry: Registry, strategy: str) -> None:
    result = run_search(registry, Troubled(), RunSettings(strategy, 40, 2, timeout=0.3), [np.zeros(4)])
    assert len(result.evaluations) == 40
    reasons = " ".join(evaluation.reason for evaluation in result.failures)
    assert result.failures
    assert any(word in reasons for word in ("no ballast", "nan", "inf", "values are needed", "time limit", "died"))


def test_the_same_seed_repeats_and_another_differs(registry: Registry) -> None:
    runs = [run_search(registry, Sphere(), RunSettings("dycors", 30, seed)) for seed in (0, 0, 1)]
    assert designs(runs[0].evaluations) == designs(runs[1].evaluations) != designs(runs[2].evaluations)


def test_strategies_with_an_initial_design_share_it_at_one_seed(registry: Registry) -> None:
    runs = [run_search(registry, Sphere(), RunSettings(name, 30, 4), [np.zeros(4)]) for name in ("dycors", "lmsrs")]
    assert designs(runs[0].evaluations[:20]) == designs(runs[1].evaluations[:20])
    assert designs(runs[0].evaluations) != designs(runs[1].evaluations)


def test_one_seed_takes_no_evaluation_back_on_scalarised_problems(registry: Registry, tmp_path: Path) -> None:
    """A continued run learns the aspiration from the record, not from a new simulation of the reference design."""

    class Counted(TwoObjectives):
        calls = 0

        def simulate(self, design: np.ndarray) -> Any:
            type(self).calls += 1
            return super().simulate(design)

    def scalarised() -> ScalarisedProblem:
        base = Counted()
        plugin = registry.get("scalariser", "asf")
        return ScalarisedProblem(base, "asf", plugin(plugin.Parameters(), base.objectives, base.worst))

    description = StudyDescription("two", {"problem": "two"}, ("asf",), 0, "")
    url = f"sqlite:///{tmp_path / 'study.db'}"
    settings = RunSettings("dycors", 26, 3)
    whole = run_search(registry, scalarised(), settings, [Counted().reference], open_run(url, description, MIXED))
    assert Counted.calls == 26
    again = run_search(registry, scalarised(), settings, [Counted().reference], open_run(url, description, MIXED))
    assert Counted.calls == 26
    assert designs(again.evaluations) == designs(whole.evaluations)
    raw = whole.evaluations[7]
    expected = TwoObjectives().simulate(raw.design).objectives
    assert [raw.metrics["left"], raw.metrics["right"]] == expected.tolist()


class OneConstraint(Sphere):
    """The sphere with one constraint."""

    def __init__(self) -> None:
        super().__init__()
        self.n_ieq_constr = 1


def test_capabilities_are_checked_before_anything_is_evaluated(registry: Registry, tmp_path: Path) -> None:
    with pytest.raises(CapabilityError, match=r"2 \(left, right\).*asf.*nsga2"):
        run_search(registry, TwoObjectives(), RunSettings("dycors", 30, 0))
    with pytest.raises(CapabilityError, match="constraints, this problem has 1"):
        run_search(one_strategy(Stubborn), OneConstraint(), RunSettings("one", 30, 0))
    problem = CountingSphere(tmp_path / "calls")
    with pytest.raises(InputError, match="budget: dycors needs at least 20"):
        run_search(registry, problem, RunSettings("dycors", 19, 0))
    with pytest.raises(InputError, match="strategy dycors: unknown parameter 'sigma'"):
        run_search(registry, problem, RunSettings("dycors", 30, 0, {"sigma": 1.0}))
    assert problem.calls == 0


def test_a_refusal_names_the_scalarisers_and_the_strategies_that_would_do(registry: Registry) -> None:
    with pytest.raises(CapabilityError) as caught:
        run_search(registry, TwoObjectives(constrained=True), RunSettings("dycors", 30, 0))
    scalarisers = ", ".join(entry.name for entry in registry.entries("scalariser"))
    assert (
        f"choose one of them if the problem lets you, scalarise them ({scalarisers}), or use a strategy that can ("
        in str(caught.value)
    )
    capabilities = {entry.name: entry.plugin.capabilities for entry in registry.entries("strategy")}
    able = [name for name, can in capabilities.items() if can.multi_objective and can.integers and can.constraints]
    assert "nsga2" in able
    assert "dycors" not in able
    assert str(caught.value).endswith(f"({', '.join(able)})")
    with pytest.raises(CapabilityError, match=r"handles one objective.*use a strategy that can \(none is installed\)"):
        run_search(one_strategy(Stubborn), TwoObjectives(), RunSettings("one", 30, 0))


@pytest.mark.parametrize("budget", [0, -1, 1.5, True])
def test_a_budget_is_a_positive_integer(budget: int) -> None:
    with pytest.raises(InputError, match="budget: an integer ≥ 1"):
        RunSettings("random", budget, 0)


@pytest.mark.parametrize("timeout", [0.0, -1.0, float("nan"), float("inf")])
def test_a_time_limit_is_positive(timeout: float) -> None:
    with pytest.raises(InputError, match="timeout: a positive number"):
        RunSettings("random", 5, 0, timeout=timeout)


def test_a_batch_is_no_larger_than_the_budget(registry: Registry) -> None:
    result = run_search(registry, Sphere(), RunSettings("random", 7, 1, batch_size=10**9))
    assert len(result.evaluations) == 7


def test_batches_are_proposed_and_the_budget_is_still_exact(registry: Registry) -> None:
    result = run_search(registry, Sphere(), RunSettings("dycors", 33, 1, batch_size=4))
    assert len(result.evaluations) == 33


def test_nsga2_keeps_to_the_constraint(registry: Registry) -> None:
    result = run_search(registry, TwoObjectives(constrained=True), RunSettings("nsga2", 120, 1))
    members = front(result.evaluations)
    assert len(members) > 3
    assert all(member.design[0] >= 0.5 for member in members)


@dataclass
class Stubborn:
    """Proposes one design for ever."""

    Parameters = NoParameters
    capabilities = Capabilities(integers=True)
    context: SearchContext
    parameters: NoParameters
    told: list[Evaluation] = field(default_factory=list)

    def ask(self) -> list[Proposal]:
        return [Proposal(np.ones(4), "stubborn")]

    def tell(self, evaluations: Any) -> None:
        self.told += evaluations


def one_strategy(plugin: Callable[..., Any]) -> Registry:
    entry = Entry("strategy", "one", plugin, Provenance("tests", "tests", "0"))
    return Registry({("strategy", "one"): entry}, [])


def test_a_strategy_that_only_repeats_ends_with_random_designs() -> None:
    result = run_search(one_strategy(Stubborn), Sphere(), RunSettings("one", 4, 0))
    assert [evaluation.origin for evaluation in result.evaluations] == ["stubborn", "unseen", "unseen", "unseen"]
    assert result.repeats == 300


def test_a_strategy_that_proposes_nothing_is_an_error() -> None:
    class Silent(Stubborn):
        def ask(self) -> list[Proposal]:
            return []

    with pytest.raises(CapabilityError, match="proposed nothing"):
        run_search(one_strategy(Silent), Sphere(), RunSettings("one", 4, 0))


def made(*objectives: float) -> Evaluation:
    return Evaluation(0, np.zeros(1), np.array(objectives), np.empty(0), {}, "initial")


def test_the_best_of_a_front_is_the_member_whose_worst_objective_is_best() -> None:
    members = [made(1.0, 9.0), made(4.0, 4.0), made(9.0, 1.0), made(9.0, 9.0)]
    assert front(members) == members[:3]
    assert best(members, np.array([10.0, 10.0])) is members[1]
    assert best(members, np.array([100.0, 4.0])) is members[2]
    assert best([made(np.nan)], None) is not None
    assert best([], None) is None


def test_a_problem_without_choices_is_made_by_its_class() -> None:
    assert Sphere.make(load_plugins(), ["distance"], {}).name == "sphere"
    with pytest.raises(InputError, match="sphere always has distance, received F_max"):
        Sphere.make(load_plugins(), ["F_max"], {})


def test_the_reference_design_is_finished_before_any_other_is_begun(registry: Registry) -> None:
    """Otherwise the scalariser would meet other designs before it knows the reference design's objectives."""
    base = TwoObjectives()
    plugin = registry.get("scalariser", "asf")
    problem = ScalarisedProblem(base, "asf", plugin(plugin.Parameters(), base.objectives, base.worst))

    class Backwards(Simulators):
        def simulate(self, designs: Sequence[FloatArray]) -> Iterator[tuple[int, Simulated]]:
            return reversed(list(super().simulate(designs)))

    given = [base.reference, np.array([1.0, 0.0, 1.0, 0.0]), np.array([2.0, 0.0, 1.0, 1.0])]
    settings = RunSettings("random", 8, 1, batch_size=2)
    result = run_search(registry, problem, settings, given, simulating=Backwards([InProcess(problem)]))
    assert not result.failures
    assert [evaluation.origin for evaluation in result.evaluations[:4]] == ["given", "given", "given", "random"]
