"""The counting evaluator: the only way from a proposal to the true function.

It charges one evaluation per new design, refuses the one beyond the budget, answers repeated designs from memory,
records failures as results, and, when a run is continued, answers from the record what is there.
"""

import math
from collections.abc import Generator, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from railsearch.design_problem import DesignProblem
from railsearch.errors import InputError, PluginError, RailsearchError, StorageError
from railsearch.interfaces import Evaluation, Outcome, Proposal
from railsearch.sampling import unseen_design
from railsearch.simulation import Simulated, Simulators
from railsearch.space import FloatArray

REPEATS_IN_A_ROW = 100


class BudgetedEvaluator:
    """Evaluates proposals of one run, at most `budget` different designs.

    record: stored evaluations of the same run, which are not made again; generator: for the unseen designs that end a
    strategy's repetition.
    """

    def __init__(
        self,
        problem: DesignProblem,
        simulators: Simulators,
        budget: int,
        record: Sequence[Evaluation],
        generator: np.random.Generator,
    ) -> None:
        self._problem = problem
        self._simulators = simulators
        self.budget = budget
        self._record = {evaluation.number: evaluation for evaluation in record}
        self._generator = generator
        self._known: dict[bytes, Evaluation] = {}
        self._planned: set[bytes] = set()
        self._repeats_in_a_row = 0
        self.repeats = 0

    @property
    def evaluations(self) -> list[Evaluation]:
        """The finished evaluations in the order in which they were proposed."""
        return sorted(self._known.values(), key=lambda evaluation: evaluation.number)

    @property
    def spent(self) -> int:
        """Evaluations charged so far, those under way included."""
        return len(self._planned)

    @property
    def exhausted(self) -> bool:
        """True when nothing more can be evaluated: the budget is spent, or every design has been evaluated."""
        return self.spent >= min(self.budget, self._problem.space.size)

    def evaluate(
        self, proposals: Sequence[Proposal], overhead: float = 0.0
    ) -> Generator[Evaluation, None, list[Evaluation]]:
        """Evaluate proposals, `overhead` being the strategy's seconds for each.

        Yields every evaluation as it is finished, new or from the record, so that it can be stored before anything else
        happens. Returns those of all proposals in their order, without the ones that the budget does not pay for. A design
        evaluated before is answered from memory, not charged and not yielded; after 100 such in a row a random unseen
        design (origin `unseen`) is evaluated in its place. Raises PluginError for a proposal outside the space,
        StorageError if the record belongs to another sequence of designs.
        """
        charged: dict[int, Proposal] = {}
        answers: list[tuple[bytes, bool]] = []
        for proposal in proposals:
            proposal = replace(proposal, design=self._checked(proposal))
            repeated, chosen = self._chosen(proposal)
            if chosen is None:
                break
            key = self._problem.space.key(chosen.design)
            if not repeated:
                charged[self.spent] = chosen
                self._planned.add(key)
            answers.append((key, repeated))
        for evaluation in self._made(charged, overhead):
            self._known[self._problem.space.key(evaluation.design)] = evaluation
            yield evaluation
        return [replace(self._known[key], repeated=True) if repeated else self._known[key] for key, repeated in answers]

    def _chosen(self, proposal: Proposal) -> tuple[bool, Proposal | None]:
        """Whether a proposal is a repeated one, and what is to be evaluated; None when the budget or the space ends."""
        if self._problem.space.key(proposal.design) in self._planned:
            self._repeats_in_a_row += 1
            if self._repeats_in_a_row <= REPEATS_IN_A_ROW:
                self.repeats += 1
                return True, proposal
            unseen = unseen_design(self._problem.space, self._planned, self._generator)
            if unseen is None:
                return False, None
            proposal = Proposal(unseen, "unseen", proposal.trajectory)
        if self.spent >= self.budget:
            return False, None
        self._repeats_in_a_row = 0
        return False, proposal

    def _made(self, charged: Mapping[int, Proposal], overhead: float) -> Iterator[Evaluation]:
        """The charged evaluations: from the record what it has, then the others as they are finished."""
        for number, proposal in charged.items():
            if number in self._record:
                yield self._replayed(self._record[number], proposal)
        new = [number for number in charged if number not in self._record]
        for position, simulated in self._simulators.simulate([charged[number].design for number in new]):
            number = new[position]
            yield evaluation_of(self._problem, number, charged[number], simulated, overhead)

    def _replayed(self, stored: Evaluation, proposal: Proposal) -> Evaluation:
        same = np.array_equal(stored.design, proposal.design) and stored.origin == proposal.origin
        if not same:
            raise StorageError(
                f"the record differs from this run at evaluation {stored.number + 1}: it was made by other versions of "
                "railsearch, of a plugin or of a library. Use the versions named in the record, or start a new run elsewhere"
            )
        if not stored.failed:
            self._problem.replay(stored)
        return stored

    def _checked(self, proposal: Proposal) -> FloatArray:
        try:
            return self._problem.space.checked(proposal.design)
        except InputError as error:
            raise PluginError(f"the strategy proposed a design that is not allowed ({proposal.origin}): {error}") from None


def evaluation_of(
    problem: DesignProblem, number: int, proposal: Proposal, simulated: Simulated, overhead: float = 0.0
) -> Evaluation:
    """The evaluation that a simulation makes of a proposal: finished by the problem, or failed with a reason.

    number: its place in the record, from 0; overhead: the strategy's seconds for it. Raises what `problem.finish` raises
    for the user to mend.
    """
    outcome, reason = _finished(problem, proposal.design, simulated.outcome)
    return Evaluation(
        number=number,
        design=proposal.design,
        objectives=outcome.objectives,
        constraints=outcome.constraints,
        metrics={name: float(value) for name, value in outcome.metrics.items()},
        origin=proposal.origin,
        trajectory=proposal.trajectory,
        reason=reason,
        duration=simulated.duration,
        overhead=overhead,
    )


def _finished(problem: DesignProblem, design: FloatArray, simulated: Outcome | str) -> tuple[Outcome, str]:
    reason = simulated if isinstance(simulated, str) else _fault(problem.simulated, simulated)
    if isinstance(simulated, str) or reason:
        return _nothing(problem, {}), reason
    try:
        outcome = problem.finish(design, simulated)
    except RailsearchError:
        raise
    except Exception as error:  # noqa: BLE001 - the simulation is done: what follows it must not lose its metrics
        return _nothing(problem, simulated.metrics), f"{type(error).__name__}: {error}"
    reason = _fault(problem, outcome)
    return (_nothing(problem, outcome.metrics), reason) if reason else (outcome, "")


def _nothing(problem: DesignProblem, metrics: Mapping[str, float]) -> Outcome:
    return Outcome(np.full(problem.n_obj, np.nan), metrics, np.full(problem.n_ieq_constr, np.nan))


def _fault(problem: DesignProblem, outcome: Outcome) -> str:
    """The reason why an outcome counts as failed, empty if its numbers are finite and as many as announced."""
    names = [objective.name for objective in problem.objectives]
    constraints = [f"constraint {number + 1}" for number in range(problem.n_ieq_constr)]
    for values, labels in ((outcome.objectives, names), (outcome.constraints, constraints)):
        if np.shape(values) != (len(labels),):
            return f"{len(labels)} values are needed ({', '.join(labels)}), the problem returned shape {np.shape(values)}"
        for label, value in zip(labels, values, strict=True):
            if not math.isfinite(value):
                return f"{label} is {value}"
    return ""
