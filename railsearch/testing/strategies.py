"""What a strategy has to fulfil."""

import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, is_dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from railsearch.interfaces import Capabilities, Evaluation, Proposal, SearchContext, Strategy, Surrogate
from railsearch.parameters import make_parameters
from railsearch.plugin_manager import load_plugins
from railsearch.sampling import random_designs
from railsearch.seeding import run_generators
from railsearch.space import FloatArray, Space, Variable
from railsearch.testing.requirement import require

MakeSurrogate = Callable[[str, int, Mapping[str, object]], Surrogate]

REAL = Space((Variable("x", -1.0, 2.0), Variable("y", 0.0, 1000.0), Variable("z", 1e-3, 2e-3)))
MIXED = Space((Variable("x", -5.0, 5.0), Variable("k", -3.0, 12.0, integer=True), Variable("flag", 0.0, 1.0, integer=True)))


@dataclass(frozen=True)
class Trial:
    """A small search: the space, how many objectives, constraints and evaluations, and what goes wrong on the way.

    fails: whether the evaluation of that number fails; repeats: tell everything twice, the second time as repeated;
    strangers: answer every fifth proposal by a random design in its place; given: designs evaluated before the first ask.
    """

    space: Space
    n_objectives: int = 1
    n_constraints: int = 0
    budget: int = 40
    batch_size: int = 1
    seed: int = 1
    fails: Callable[[int], bool] = lambda number: False
    repeats: bool = False
    strangers: bool = False
    given: int = 0


def check_strategy(
    plugin: Any, settings: Mapping[str, object] | None = None, surrogate: MakeSurrogate | None = None
) -> None:
    """Check a strategy class, made with `settings` of its parameters, in the trials that its capabilities allow.

    Same seed, same proposals to the last bit; another seed, others; nothing depends on or touches global randomness; bounds,
    whole integers and float vectors; batches no larger than asked for; budgets from one evaluation on; failed, repeated
    and foreign evaluations survived; nothing that was told is altered.
    surrogate: makes a surrogate from its name, dimension and settings; by default one of the registered ones.
    Raises AssertionError with an explanation.
    """
    run = partial(run_trial, plugin, settings=settings, surrogate=surrogate or load_plugins().surrogate)
    for base in _base_trials(plugin.capabilities):
        _check_reproducible(run, base)
        for trial in _disturbed(base, plugin.capabilities):
            run(trial)


def run_trial(
    plugin: Any,
    trial: Trial,
    settings: Mapping[str, object] | None = None,
    surrogate: MakeSurrogate | None = None,
    objective: Callable[[FloatArray], FloatArray] | None = None,
) -> list[Evaluation]:
    """Run a strategy class through a trial, on one core as in a run, and hand back the evaluations in their order.

    objective: objectives (m,) of a design (d,), by default convex ones with different minima; surrogate: as in
    `check_strategy`. Raises AssertionError for a proposal that is not allowed.
    """
    strategy = _strategy(plugin, settings or {}, surrogate or load_plugins().surrogate, trial)
    with threadpool_limits(1):
        return _run_trial(strategy, trial, objective or partial(_bowls, trial))


def _run_trial(strategy: Strategy, trial: Trial, objective: Callable[[FloatArray], FloatArray]) -> list[Evaluation]:
    evaluations: list[Evaluation] = []
    evaluate = partial(_evaluated, trial, objective)
    strangers = random_designs(trial.space, trial.budget + trial.given, np.random.default_rng(trial.seed + 1000))
    for design in strangers[: min(trial.given, trial.budget)]:
        evaluations.append(evaluate(Proposal(design, "given"), len(evaluations)))
    if evaluations:
        strategy.tell(list(evaluations))
    while len(evaluations) < trial.budget:
        proposals = list(strategy.ask())
        _check_proposals(proposals, trial)
        told: list[Evaluation] = []
        for proposal in proposals[: trial.budget - len(evaluations)]:
            number = len(evaluations) + len(told)
            foreign = trial.strangers and number % 5 == 4
            chosen = Proposal(strangers[number], "unseen", proposal.trajectory) if foreign else proposal
            told.append(evaluate(chosen, number))
        _tell(strategy, told, trial.repeats)
        evaluations += told
    return evaluations


def _strategy(plugin: Any, settings: Mapping[str, object], surrogate: MakeSurrogate, trial: Trial) -> Strategy:
    generators = run_generators(trial.seed)
    context = SearchContext(
        space=trial.space,
        n_objectives=trial.n_objectives,
        n_constraints=trial.n_constraints,
        budget=trial.budget,
        batch_size=trial.batch_size,
        generator=generators.strategy,
        initial_generator=generators.initial,
        surrogate=lambda name, values: surrogate(name, trial.space.dimension, values),
    )
    parameters = make_parameters(plugin.Parameters, settings, "strategy")
    require(is_dataclass(parameters), "the Parameters of a strategy must be a frozen dataclass")
    strategy: Strategy = plugin(context, parameters)
    return strategy


def _base_trials(capabilities: Capabilities) -> Iterator[Trial]:
    spaces = [REAL] + [MIXED] * capabilities.integers
    objectives = [1] + [2] * capabilities.multi_objective
    constraints = [0] + [1] * capabilities.constraints
    for space, n_objectives, n_constraints in itertools.product(spaces, objectives, constraints):
        yield Trial(space, n_objectives, n_constraints)


def _disturbed(base: Trial, capabilities: Capabilities) -> Iterator[Trial]:
    """The trial with other budgets, batches, failures, and evaluations that were not asked for."""
    for budget in (1, 2, 7):
        yield replace(base, budget=budget)
        yield replace(base, budget=budget, given=1)
    yield replace(base, fails=lambda number: True)
    yield replace(base, fails=lambda number: number < 25)
    yield replace(base, fails=lambda number: number % 3 == 0)
    yield replace(base, repeats=True)
    yield replace(base, strangers=True, given=3)
    if capabilities.batch:
        yield replace(base, batch_size=4)
        yield replace(base, batch_size=7, strangers=True, repeats=True, fails=lambda number: number % 4 == 0)


def _check_reproducible(run: Callable[[Trial], list[Evaluation]], trial: Trial) -> None:
    before = _global_state()
    first = _designs(run(trial))
    require(_global_state() == before, "the strategy draws from numpy's global generator; use context.generator")
    second, other = (_designs(run(replace(trial, seed=seed))) for seed in (trial.seed, trial.seed + 1))
    require(first == second, "two runs from the same seed propose different designs; use context.generator only")
    require(first != other, "runs from different seeds propose the same designs")


def _global_state() -> bytes:
    state: Any = np.random.get_state()  # noqa: NPY002 - what must not change
    return bytes(state[1].tobytes()) + str(state[2:]).encode()


def _designs(evaluations: Sequence[Evaluation]) -> list[bytes]:
    return [evaluation.design.tobytes() for evaluation in evaluations]


def _check_proposals(proposals: Sequence[Proposal], trial: Trial) -> None:
    space = trial.space
    require(len(proposals) > 0, "the strategy proposed nothing although the budget is not spent")
    require(
        len(proposals) <= trial.batch_size, f"{len(proposals)} designs were proposed, a batch is {trial.batch_size} at most"
    )
    for proposal in proposals:
        design = proposal.design
        vector = isinstance(design, np.ndarray) and design.dtype == np.float64 and design.shape == (space.dimension,)
        require(vector, f"a design must be a float vector of shape ({space.dimension},), received {design!r}")
        inside = bool(np.all((design >= space.lower) & (design <= space.upper)))
        require(inside, f"the design {design} lies outside the bounds {space.lower} to {space.upper}")
        whole = bool(np.all(design[space.integer] == np.round(design[space.integer])))
        require(whole, f"the design {design} has fractions in the integers {space.integer}")
        require(isinstance(proposal.origin, str) and bool(proposal.origin), "a proposal needs its origin in a word")
        natural = isinstance(proposal.trajectory, int) and proposal.trajectory >= 0
        require(natural, f"trajectory must be an integer ≥ 0, received {proposal.trajectory!r}")


def _evaluated(trial: Trial, objective: Callable[[FloatArray], FloatArray], proposal: Proposal, number: int) -> Evaluation:
    failed = trial.fails(number)
    objectives = np.full(trial.n_objectives, np.nan) if failed else objective(proposal.design)
    constraints = np.full(trial.n_constraints, np.nan if failed else trial.space.to_unit(proposal.design)[0] - 0.9)
    reason = "failed on purpose" if failed else ""
    return Evaluation(
        number, proposal.design.copy(), objectives, constraints, {}, proposal.origin, proposal.trajectory, reason
    )


def _bowls(trial: Trial, design: FloatArray) -> FloatArray:
    """Convex objectives (m,) with minima at different places."""
    centres = 0.2 + 0.5 * np.arange(trial.n_objectives)
    return np.array([float(np.sum((trial.space.to_unit(design) - centre) ** 2)) for centre in centres])


def _tell(strategy: Strategy, told: Sequence[Evaluation], repeats: bool) -> None:
    before = [evaluation.design.copy() for evaluation in told]
    strategy.tell(list(told))
    if repeats:
        strategy.tell([replace(evaluation, repeated=True) for evaluation in told])
    unaltered = all(np.array_equal(old, evaluation.design) for old, evaluation in zip(before, told, strict=True))
    require(unaltered, "the strategy altered a design it was told")
