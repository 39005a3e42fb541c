"""One seeded loop: ask, evaluate, tell, until the budget ends.

A continued run is a replay: the strategy starts from its seed, asks again, and is told the stored results in their order,
with no evaluation spent, until the record ends.
"""

import functools
import time
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from typing import Protocol, cast

import numpy as np
from threadpoolctl import threadpool_limits

from railsearch.budget import BudgetedEvaluator
from railsearch.design_problem import DesignProblem
from railsearch.errors import CapabilityError, InputError
from railsearch.indicators import non_dominated
from railsearch.interfaces import Capabilities, Evaluation, Finding, Proposal, SearchContext, Strategy, Surrogate
from railsearch.parameters import make_parameters
from railsearch.plugin_manager import Registry
from railsearch.seeding import run_generators
from railsearch.simulation import Simulators, check_timeout, simulators
from railsearch.space import FloatArray

Watch = Callable[[Evaluation], None]


class Record(Protocol):
    """Where the evaluations of a run are kept."""

    def load(self) -> list[Evaluation]:
        """The stored evaluations in their order."""

    def append(self, evaluation: Evaluation) -> None:
        """Store one more."""


class MemoryRecord:
    """A record that lasts as long as the process."""

    def __init__(self) -> None:
        self.evaluations: list[Evaluation] = []

    def load(self) -> list[Evaluation]:
        """The evaluations so far."""
        return list(self.evaluations)

    def append(self, evaluation: Evaluation) -> None:
        """Keep one more."""
        self.evaluations.append(evaluation)


@dataclass(frozen=True)
class RunSettings:
    """How to search: strategy and its settings, budget in evaluations, seed, designs per batch, seconds per evaluation.

    initial_seed: that of the initial design where it is to be shared by runs of different seeds; default: the seed.
    Raises InputError for a budget, batch or time limit that is not positive.
    """

    strategy: str
    budget: int
    seed: int
    strategy_settings: Mapping[str, object] = field(default_factory=dict)
    batch_size: int = 1
    timeout: float | None = None
    initial_seed: int | None = None
    workers: int = 1

    def __post_init__(self) -> None:
        for name, value in (("budget", self.budget), ("batch", self.batch_size), ("workers", self.workers)):
            if isinstance(value, bool) or not isinstance(value, int) or value < 1:
                raise InputError(f"{name}: an integer ≥ 1 is needed, received {value!r}")
        check_timeout(self.timeout)
        if self.workers > self.batch_size:
            raise InputError(
                f"workers: {self.workers} would find no more than the {self.batch_size} designs of a batch to evaluate at a "
                f"time; propose {self.workers} at a time (batch), or use fewer workers"
            )


@dataclass(frozen=True)
class RunResult:
    """The evaluations of a run in order, how many came from the record, how many repeats were not charged, and findings."""

    evaluations: tuple[Evaluation, ...]
    replayed: int
    repeats: int
    findings: tuple[Finding, ...] = ()

    @property
    def failures(self) -> list[Evaluation]:
        """The failed evaluations."""
        return [evaluation for evaluation in self.evaluations if evaluation.failed]


def run_search(
    registry: Registry,
    problem: DesignProblem,
    settings: RunSettings,
    given: Sequence[FloatArray] = (),
    record: Record | None = None,
    watch: Watch = lambda evaluation: None,
    simulating: Simulators | None = None,
) -> RunResult:
    """Search `problem` with a registered strategy until the budget is spent, or every design has been evaluated.

    given: designs (d,) to evaluate first, inside the budget; record: where evaluations are kept and a run is continued from;
    watch: called with every evaluation, stored or new; simulating: what carries the evaluations out, by default this process
    or `settings.workers` others. Raises InputError, CapabilityError or PluginError before anything is evaluated,
    StorageError if the record cannot be written or belongs to another run.
    """
    record = record or MemoryRecord()
    stored = record.load()
    known = {evaluation.number for evaluation in stored}
    steps = search(registry, problem, settings, given, stored, simulating)
    with closing(steps):
        while True:
            try:
                evaluation = next(steps)
            except StopIteration as ended:
                result: RunResult = ended.value
                return result
            if evaluation.number not in known:
                record.append(evaluation)
            watch(evaluation)


def search(
    registry: Registry,
    problem: DesignProblem,
    settings: RunSettings,
    given: Sequence[FloatArray] = (),
    stored: Sequence[Evaluation] = (),
    simulating: Simulators | None = None,
) -> Generator[Evaluation, None, RunResult]:
    """The loop itself: yields every evaluation as it is finished, and goes on when it is asked for the next one.

    Arguments and errors are those of `run_search`; stored: what the record of a continued run has.
    """
    strategy = make_strategy(registry, problem, settings, len(given))
    made = simulating or simulators(problem, settings.timeout, settings.workers)
    with closing(made), threadpool_limits(1):
        if len(stored) < settings.budget:
            made.warm_up()
        generator = run_generators(settings.seed, settings.initial_seed).unseen
        evaluator = BudgetedEvaluator(problem, made, settings.budget, stored, generator)
        if given:
            first = [Proposal(problem.space.checked(design), "given") for design in given]
            # The reference design comes alone: a scalariser may need its objectives before those of any other.
            told = yield from evaluator.evaluate(first[:1])
            told += yield from evaluator.evaluate(first[1:])
            strategy.tell(told)
        while not evaluator.exhausted:
            yield from _step(strategy, evaluator)
    findings = tuple(getattr(strategy, "findings", ()))
    return RunResult(tuple(evaluator.evaluations), min(len(stored), evaluator.spent), evaluator.repeats, findings)


def make_strategy(registry: Registry, problem: DesignProblem, settings: RunSettings, n_given: int = 0) -> Strategy:
    """The strategy of a run at its start. Raises an error if it, its settings and the budget do not suit the problem."""
    plugin = registry.get("strategy", settings.strategy)
    parameters = make_parameters(plugin.Parameters, settings.strategy_settings, f"strategy {settings.strategy}")
    check_capabilities(registry, settings.strategy, plugin.capabilities, problem, settings.batch_size)
    generators = run_generators(settings.seed, settings.initial_seed)
    context = SearchContext(
        space=problem.space,
        n_objectives=problem.n_obj,
        n_constraints=problem.n_ieq_constr,
        budget=settings.budget,
        batch_size=min(settings.batch_size, settings.budget),
        generator=generators.strategy,
        initial_generator=generators.initial,
        surrogate=functools.partial(_surrogate, registry, problem.space.dimension),
        responses=problem.responses,
    )
    strategy = cast(Strategy, plugin(context, parameters))
    needed = max(n_given, getattr(strategy, "minimum_budget", 1))
    if settings.budget < needed:
        raise InputError(
            f"budget: {settings.strategy} needs at least {needed} evaluations for its start on this problem "
            f"({n_given} of them given), received {settings.budget}"
        )
    return strategy


def check_capabilities(
    registry: Registry, name: str, capabilities: Capabilities, problem: DesignProblem, batch_size: int
) -> None:
    """Raise CapabilityError if a strategy cannot handle a problem, with what can be done about it."""
    reason = _refusal(capabilities, problem, batch_size)
    if not reason:
        return
    strategies = registry.entries("strategy")
    able = [entry.name for entry in strategies if not _refusal(entry.plugin.capabilities, problem, batch_size)]
    remedy = f"use a strategy that can ({_listed(able)})"
    if problem.n_obj > 1 and not capabilities.multi_objective:
        scalarisers = [entry.name for entry in registry.entries("scalariser")]
        remedy = f"choose one of them if the problem lets you, scalarise them ({_listed(scalarisers)}), or {remedy}"
    raise CapabilityError(f"strategy {name} {reason}: {remedy}")


def front(evaluations: Sequence[Evaluation]) -> list[Evaluation]:
    """The feasible evaluations that no other one dominates; with one objective the best one (the first of equals)."""
    feasible = [evaluation for evaluation in evaluations if evaluation.feasible]
    if not feasible:
        return []
    objectives = np.array([evaluation.objectives for evaluation in feasible])
    if objectives.shape[1] == 1:
        return [feasible[int(np.argmin(objectives[:, 0]))]]
    return [feasible[row] for row in non_dominated(objectives)]


def best(evaluations: Sequence[Evaluation], reference: FloatArray | None = None) -> Evaluation | None:
    """The best evaluation; with several objectives the member of the front whose worst objective is best.

    Objectives are measured as f/f_reference where the reference design's are given (m,) and positive, otherwise by their
    place between the front's best and worst values.
    """
    members = front(evaluations)
    if len(members) < 2:
        return members[0] if members else None
    objectives = np.array([evaluation.objectives for evaluation in members])
    if reference is not None and np.all(reference > 0.0):
        scaled = objectives / reference
    else:
        spread = np.ptp(objectives, axis=0)
        scaled = (objectives - objectives.min(axis=0)) / np.where(spread > 0.0, spread, 1.0)
    return members[int(np.argmin(scaled.max(axis=1)))]


def _step(strategy: Strategy, evaluator: BudgetedEvaluator) -> Iterator[Evaluation]:
    start = time.perf_counter()
    proposals = strategy.ask()
    if not proposals:
        raise CapabilityError("the strategy proposed nothing although there is budget left")
    overhead = (time.perf_counter() - start) / len(proposals)
    strategy.tell((yield from evaluator.evaluate(proposals, overhead)))


def _refusal(capabilities: Capabilities, problem: DesignProblem, batch_size: int) -> str:
    """Why strategies with these capabilities cannot handle a problem; empty if they can."""
    if problem.n_obj > 1 and not capabilities.multi_objective:
        names = ", ".join(objective.name for objective in problem.objectives)
        return f"handles one objective, not several, and this problem has {problem.n_obj} ({names})"
    if problem.space.integer.any() and not capabilities.integers:
        integers = ", ".join(variable.name for variable in problem.space.variables if variable.integer)
        return f"does not handle integer variables, this problem has {integers}"
    if problem.n_ieq_constr and not capabilities.constraints:
        return f"does not handle constraints, this problem has {problem.n_ieq_constr}"
    if batch_size > 1 and not capabilities.batch:
        return f"proposes one design at a time, a batch of {batch_size} was asked for"
    return ""


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names) or "none is installed"


def _surrogate(registry: Registry, dimension: int, name: str, settings: Mapping[str, object]) -> Surrogate:
    return registry.surrogate(name, dimension, settings)
