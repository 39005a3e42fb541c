"""Small searches in which a strategy shows what it does: the loop of a run on a cheap problem, with mishaps on the way."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, is_dataclass, replace
from functools import cache, partial
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from railsearch.interfaces import Evaluation, Proposal, SearchContext, Strategy, Surrogate
from railsearch.parameters import make_parameters
from railsearch.plugin_manager import load_plugins
from railsearch.sampling import random_designs, unseen_design
from railsearch.seeding import run_generators
from railsearch.space import FloatArray, Space, Variable
from railsearch.testing.requirement import require

MakeSurrogate = Callable[[str, int, Mapping[str, object]], Surrogate]

REPEATS_IN_A_ROW = 100
"""Proposals of known designs in a row after which a random unseen one is evaluated, as in a run."""

REAL = Space((Variable("x", -1.0, 2.0), Variable("y", 0.0, 1000.0), Variable("z", 1e-3, 2e-3)))
MIXED = Space((Variable("x", -5.0, 5.0), Variable("k", -3.0, 12.0, integer=True), Variable("flag", 0.0, 1.0, integer=True)))
ONE_REAL = Space((Variable("x", -2.0, 3.0),))
ONE_INTEGER = Space((Variable("k", -3.0, 4.0, integer=True),))
TINY = Space((Variable("k", 0.0, 2.0, integer=True), Variable("flag", 0.0, 1.0, integer=True)))


@dataclass(frozen=True)
class Trial:
    """A small search: the space, how many objectives, constraints and evaluations, and what goes wrong on the way.

    fails: whether the evaluation of that number fails; repeats: tell everything twice, the second time as repeated;
    strangers: answer every fifth proposal by a random design in its place; given: designs evaluated before the first ask;
    scale: factor of the objectives, 0 for constant ones; name: what is tried, in words.
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
    scale: float = 1.0
    name: str = "a search"

    @property
    def length(self) -> int:
        """How many evaluations there will be: the budget, or every design of a space that has fewer."""
        return int(min(self.budget, self.space.size))


def run_trial(
    plugin: Any,
    trial: Trial,
    settings: Mapping[str, object] | None = None,
    surrogate: MakeSurrogate | None = None,
    objective: Callable[[FloatArray], FloatArray] | None = None,
) -> list[Evaluation]:
    """Run a strategy class through a trial, on one core as in a run, and hand back the evaluations in their order.

    A design evaluated before is answered from memory and not charged, as in a run. objective: objectives (m,) of a design
    (d,), by default convex ones with different minima; surrogate: makes a surrogate from its name, dimension and settings,
    by default one of the registered ones. Raises AssertionError for a proposal that is not allowed; whatever is raised has a
    note that says in which trial.
    """
    return played_trial(plugin, trial, settings, surrogate, objective)[0]


def played_trial(
    plugin: Any,
    trial: Trial,
    settings: Mapping[str, object] | None = None,
    surrogate: MakeSurrogate | None = None,
    objective: Callable[[FloatArray], FloatArray] | None = None,
) -> tuple[list[Evaluation], list[bytes]]:
    """The evaluations of `run_trial`, and the designs that the strategy proposed, as bytes."""
    try:
        strategy = _strategy(plugin, settings or {}, surrogate or registered_surrogates(), trial)
        with threadpool_limits(1):
            return _play(strategy, _Answers(trial, objective or partial(bowls, trial)), trial)
    except Exception as error:
        error.add_note(f"in the trial “{trial.name}” with {trial}")
        raise


def bowls(trial: Trial, design: FloatArray) -> FloatArray:
    """Convex objectives (m,) with minima at different places."""
    centres = 0.2 + 0.5 * np.arange(trial.n_objectives)
    return trial.scale * np.array([float(np.sum((trial.space.to_unit(design) - centre) ** 2)) for centre in centres])


class _Answers:
    """Evaluates proposals as a run does, with the mishaps of a trial."""

    def __init__(self, trial: Trial, objective: Callable[[FloatArray], FloatArray]) -> None:
        self.evaluations: list[Evaluation] = []
        self._trial = trial
        self._objective = objective
        self._known: dict[bytes, Evaluation] = {}
        self._repeats = 0
        self._generator = np.random.default_rng(trial.seed + 2000)
        self._strangers = random_designs(trial.space, trial.budget + trial.given, np.random.default_rng(trial.seed + 1000))

    @property
    def given(self) -> list[Proposal]:
        """The designs that the user gives."""
        return [Proposal(design, "given") for design in self._strangers[: min(self._trial.given, self._trial.budget)]]

    def to(self, proposals: Sequence[Proposal]) -> list[Evaluation]:
        """The evaluations that answer proposals, as far as the budget goes."""
        told = []
        for proposal in proposals:
            evaluation = self._answer(proposal)
            if evaluation is None:
                break
            told.append(evaluation)
        return told

    def _answer(self, proposal: Proposal) -> Evaluation | None:
        space, number = self._trial.space, len(self.evaluations)
        if self._trial.strangers and number % 5 == 4:
            proposal = Proposal(self._strangers[min(number, self._trial.budget - 1)], "unseen", proposal.trajectory)
        if space.key(proposal.design) in self._known:
            self._repeats += 1
            if self._repeats <= REPEATS_IN_A_ROW:
                return replace(self._known[space.key(proposal.design)], repeated=True)
            unseen = unseen_design(space, set(self._known), self._generator)
            if unseen is None:
                return None
            proposal = Proposal(unseen, "unseen", proposal.trajectory)
        if number >= self._trial.budget:
            return None
        self._repeats = 0
        evaluation = self._evaluated(proposal, number)
        self._known[space.key(evaluation.design)] = evaluation
        self.evaluations.append(evaluation)
        return evaluation

    def _evaluated(self, proposal: Proposal, number: int) -> Evaluation:
        trial, design = self._trial, proposal.design.copy()
        failed = trial.fails(number)
        objectives = np.full(trial.n_objectives, np.nan) if failed else self._objective(design)
        constraints = np.full(trial.n_constraints, np.nan if failed else trial.space.to_unit(design)[0] - 0.9)
        reason = "failed on purpose" if failed else ""
        return Evaluation(number, design, objectives, constraints, {}, proposal.origin, proposal.trajectory, reason)


def _play(strategy: Strategy, answers: _Answers, trial: Trial) -> tuple[list[Evaluation], list[bytes]]:
    proposed: list[bytes] = []
    if trial.given:
        strategy.tell(answers.to(answers.given))
    while len(answers.evaluations) < trial.length:
        proposals = list(strategy.ask())
        _check_proposals(proposals, trial)
        proposed += [proposal.design.tobytes() for proposal in proposals]
        _tell(strategy, answers.to(proposals), trial.repeats)
    return answers.evaluations, proposed


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


def registered_surrogates() -> MakeSurrogate:
    """Makes registered surrogates; the plugins are loaded once, when the first is made."""
    loaded = cache(load_plugins)
    return lambda name, dimension, settings: loaded().surrogate(name, dimension, settings)


def _check_proposals(proposals: Sequence[Proposal], trial: Trial) -> None:
    space = trial.space
    require(len(proposals) > 0, "the strategy proposed nothing although the budget is not spent")
    require(
        len(proposals) <= trial.batch_size, f"{len(proposals)} designs were proposed, a batch is {trial.batch_size} at most"
    )
    for proposal in proposals:
        fault = _fault(proposal, space)
        require(not fault, fault)


def _fault(proposal: Proposal, space: Space) -> str:
    """What is not allowed in a proposal, empty if nothing; in words only then, for writing a design takes the longest."""
    design = proposal.design
    if not (isinstance(design, np.ndarray) and design.dtype == np.float64 and design.shape == (space.dimension,)):
        return f"a design must be a float vector of shape ({space.dimension},), received {design!r}"
    if not np.all((design >= space.lower) & (design <= space.upper)):
        return f"the design {design} lies outside the bounds {space.lower} to {space.upper}"
    if not np.all(design[space.integer] == np.round(design[space.integer])):
        return f"the design {design} has fractions in the integers {space.integer}"
    if not (isinstance(proposal.origin, str) and proposal.origin):
        return "a proposal needs its origin in a word"
    if not (isinstance(proposal.trajectory, int) and proposal.trajectory >= 0):
        return f"trajectory must be an integer ≥ 0, received {proposal.trajectory!r}"
    return ""


def _tell(strategy: Strategy, told: Sequence[Evaluation], repeats: bool) -> None:
    before = [evaluation.design.copy() for evaluation in told]
    strategy.tell(list(told))
    if repeats:
        strategy.tell([replace(evaluation, repeated=True) for evaluation in told])
    unaltered = all(np.array_equal(old, evaluation.design) for old, evaluation in zip(before, told, strict=True))
    require(unaltered, "the strategy altered a design it was told")
