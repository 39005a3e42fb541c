"""The counting evaluator: the only way from a proposal to the true function.

It charges one evaluation per new design, refuses the one beyond the budget, answers repeated designs from memory,
records failures as results, and, when a run is continued, answers from the record until that ends.
"""

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from railsearch.design_problem import DesignProblem
from railsearch.errors import BudgetExhausted, InputError, PluginError, RailsearchError, StorageError
from railsearch.interfaces import Evaluation, Outcome, Proposal
from railsearch.sampling import unseen_design
from railsearch.simulation import Simulator
from railsearch.space import FloatArray

REPEATS_IN_A_ROW = 100


class BudgetedEvaluator:
    """Evaluates proposals of one run, at most `budget` different designs.

    record: stored evaluations of the same run, answered first and in their order; store: called with every new
    evaluation before it is handed back; generator: for the unseen designs that end a strategy's repetition.
    """

    def __init__(
        self,
        problem: DesignProblem,
        simulator: Simulator,
        budget: int,
        record: Sequence[Evaluation],
        store: Callable[[Evaluation], None],
        generator: np.random.Generator,
    ) -> None:
        self._problem = problem
        self._simulator = simulator
        self.budget = budget
        self._record = list(record)
        self._store = store
        self._generator = generator
        self._known: dict[bytes, Evaluation] = {}
        self._repeats_in_a_row = 0
        self.evaluations: list[Evaluation] = []
        self.repeats = 0

    @property
    def spent(self) -> int:
        """Evaluations charged so far."""
        return len(self.evaluations)

    @property
    def exhausted(self) -> bool:
        """True when nothing more can be evaluated: the budget is spent, or every design has been evaluated."""
        return self.spent >= min(self.budget, self._problem.space.size)

    def evaluate(self, proposal: Proposal, overhead: float = 0.0) -> Evaluation:
        """Evaluate a proposal, `overhead` being the strategy's seconds for it.

        A design evaluated before is answered from memory and not charged; after 100 such in a row a random unseen design
        (origin `unseen`) is evaluated in its place. Raises BudgetExhausted, PluginError for a proposal outside the space,
        StorageError if the record belongs to another sequence of designs.
        """
        proposal = replace(proposal, design=self._checked(proposal))
        known = self._known.get(self._problem.space.key(proposal.design))
        if known is not None:
            self._repeats_in_a_row += 1
            if self._repeats_in_a_row <= REPEATS_IN_A_ROW:
                self.repeats += 1
                return replace(known, repeated=True)
            unseen = unseen_design(self._problem.space, set(self._known), self._generator)
            if unseen is None:
                raise BudgetExhausted("every design of the space has been evaluated")
            proposal = Proposal(unseen, "unseen", proposal.trajectory)
        return self._charged(proposal, overhead)

    def _charged(self, proposal: Proposal, overhead: float) -> Evaluation:
        if self.spent >= self.budget:
            raise BudgetExhausted(f"the budget of {self.budget} evaluations is spent")
        self._repeats_in_a_row = 0
        if self.spent < len(self._record):
            evaluation = self._replayed(proposal)
        else:
            evaluation = self._evaluated(proposal, overhead)
            self._store(evaluation)
        self.evaluations.append(evaluation)
        self._known[self._problem.space.key(evaluation.design)] = evaluation
        return evaluation

    def _evaluated(self, proposal: Proposal, overhead: float) -> Evaluation:
        start = time.perf_counter()
        simulated = self._simulator.simulate(proposal.design)
        duration = time.perf_counter() - start
        outcome, reason = self._finished(proposal.design, simulated)
        return Evaluation(
            number=self.spent,
            design=proposal.design,
            objectives=outcome.objectives,
            constraints=outcome.constraints,
            metrics={name: float(value) for name, value in outcome.metrics.items()},
            origin=proposal.origin,
            trajectory=proposal.trajectory,
            reason=reason,
            duration=duration,
            overhead=overhead,
        )

    def _finished(self, design: FloatArray, simulated: Outcome | str) -> tuple[Outcome, str]:
        reason = simulated if isinstance(simulated, str) else _fault(self._problem.simulated, simulated)
        if isinstance(simulated, str) or reason:
            return self._nothing({}), reason
        try:
            outcome = self._problem.finish(design, simulated)
        except RailsearchError:
            raise
        except Exception as error:  # noqa: BLE001 - the simulation is done: what follows it must not lose its metrics
            return self._nothing(simulated.metrics), f"{type(error).__name__}: {error}"
        reason = _fault(self._problem, outcome)
        return (self._nothing(outcome.metrics), reason) if reason else (outcome, "")

    def _nothing(self, metrics: Mapping[str, float]) -> Outcome:
        return Outcome(np.full(self._problem.n_obj, np.nan), metrics, np.full(self._problem.n_ieq_constr, np.nan))

    def _replayed(self, proposal: Proposal) -> Evaluation:
        stored = self._record[self.spent]
        same = np.array_equal(stored.design, proposal.design) and stored.origin == proposal.origin
        if not same:
            raise StorageError(
                f"the record differs from this run at evaluation {self.spent + 1}: it was made by other versions of "
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
