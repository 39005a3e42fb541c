"""Samplers of Optuna behind ask and tell, each with a study of its own in memory (Akiba et al. 2019).

What Optuna is told:

- A failed evaluation is a failed trial, which no sampler looks at. Samplers that rank trials by their constraints (TPE,
  NSGA-II) are told instead that it violates a constraint and has the worst values seen, as soon as there is a value.
- A design that was not asked for is a finished trial; of NSGA-II's population it becomes a member.
- A design evaluated before is not proposed again. Where it belongs to a population (CMA-ES, NSGA-II) its values are told
  once more; elsewhere its trial is dropped and another one asked for. After 20 such in a row a random unseen design is
  proposed.
"""

import importlib.util
import warnings
from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, ClassVar, Generic, TypeVar

import numpy as np

from railsearch.errors import PluginError
from railsearch.interfaces import Evaluation, Proposal, SearchContext
from railsearch.sampling import random_designs, unseen_design
from railsearch.space import FloatArray, Variable

if TYPE_CHECKING:
    from optuna.distributions import BaseDistribution
    from optuna.samplers import BaseSampler
    from optuna.study import Study
    from optuna.trial import Trial

REPEATS_IN_A_ROW = 20
"""Trials in a row that repeat evaluated designs after which a random unseen design is proposed."""

P = TypeVar("P")


class OptunaStrategy(ABC, Generic[P]):
    """A sampler of Optuna asked and told design by design.

    requires: module and remedy, if the sampler needs something that railsearch does not install; ranks_failures: failed
    evaluations are told as infeasible; repeats_count: the values of a repeated design are told again.
    """

    requires: ClassVar[tuple[str, str] | None] = None
    ranks_failures: ClassVar[bool] = False
    repeats_count: ClassVar[bool] = False

    def __init__(self, context: SearchContext, parameters: P) -> None:
        if self.requires and importlib.util.find_spec(self.requires[0]) is None:
            raise PluginError(
                f"this strategy needs the module {self.requires[0]}, which is not installed: {self.requires[1]}"
            )
        self._context = context
        self._parameters = parameters
        self._study: Study | None = None
        self._distributions: dict[str, BaseDistribution] = {}
        self._told: dict[bytes, Evaluation] = {}
        self._waiting: dict[bytes, Trial] = {}
        self._worst: list[float] | None = None

    @abstractmethod
    def _sampler(self, seed: int) -> "BaseSampler":
        """A new sampler of Optuna."""

    def ask(self) -> Sequence[Proposal]:
        """As many unseen designs as may be evaluated at once, origin `sample`; `random` where the sampler repeats itself."""
        with _quiet():
            study = self._study or self._start()
            return [self._proposal(study) for _ in range(self._context.batch_size)]

    def tell(self, evaluations: Sequence[Evaluation]) -> None:
        """Take in evaluations, whether they were asked for or not; a repeated one is known already."""
        with _quiet():
            for evaluation in evaluations:
                key = self._context.space.key(evaluation.design)
                if key in self._told:
                    continue
                self._told[key] = evaluation
                if not evaluation.failed:
                    self._worst = np.maximum(evaluation.objectives, self._worst or evaluation.objectives).tolist()
                if self._study is not None:
                    self._record(self._study, self._waiting.pop(key, None), evaluation)
            for trial in self._waiting.values():
                _drop(self._study, trial)
        self._waiting = {}

    def _start(self) -> "Study":
        """Make the study and tell it what has been told."""
        import optuna

        self._distributions = {variable.name: _distribution(variable) for variable in self._context.space.variables}
        sampler = self._sampler(int(self._context.generator.integers(2**32)))
        study = optuna.create_study(directions=["minimize"] * self._context.n_objectives, sampler=sampler)
        for evaluation in self._told.values():
            self._record(study, None, evaluation)
        self._study = study
        return study

    def _proposal(self, study: "Study") -> Proposal:
        space = self._context.space
        for _ in range(REPEATS_IN_A_ROW):
            trial = study.ask(self._distributions)
            design = space.rounded([float(trial.params[name]) for name in space.names])
            key = space.key(design)
            if key not in self._told and key not in self._waiting:
                self._waiting[key] = trial
                return Proposal(design, "sample")
            if self.repeats_count and key in self._told:
                self._finish(study, trial, self._told[key])
            else:
                _drop(study, trial)
        unseen = unseen_design(space, {*self._told, *self._waiting}, self._context.generator)
        return Proposal(random_designs(space, 1, self._context.generator)[0] if unseen is None else unseen, "random")

    def _member(self, study: "Study", design: FloatArray) -> "Trial | None":
        """A trial that makes a design which was not asked for a member of the population, if there is one."""
        return None

    def _record(self, study: "Study", trial: "Trial | None", evaluation: Evaluation) -> None:
        """Tell the study an evaluation; without a trial it is one that was not asked for."""
        from optuna.trial import TrialState, create_trial

        values = self._values(evaluation)
        if trial is None and values is not None:
            trial = self._member(study, evaluation.design)
        if trial is not None:
            self._finish(study, trial, evaluation)
            return
        study.add_trial(
            create_trial(
                state=TrialState.FAIL if values is None else TrialState.COMPLETE,
                values=values,
                params=self._params(evaluation.design),
                distributions=self._distributions,
                constraints=None if values is None else self._constraints(evaluation),
            )
        )

    def _finish(self, study: "Study", trial: "Trial", evaluation: Evaluation) -> None:
        values = self._values(evaluation)
        if values is None:
            _drop(study, trial)
            return
        for name, value in self._constraints(evaluation).items():
            trial.set_constraint(name, value)
        study.tell(trial, values)

    def _values(self, evaluation: Evaluation) -> list[float] | None:
        """What the study is told of the objectives, in floats of Python's own; None for a failed trial."""
        if not evaluation.failed:
            return [float(value) for value in evaluation.objectives]
        return self._worst if self.ranks_failures else None

    def _constraints(self, evaluation: Evaluation) -> dict[str, float]:
        """The constraints by name, one more for failed evaluations where they are ranked."""
        values = np.zeros(self._context.n_constraints) if evaluation.failed else evaluation.constraints
        constraints = {f"g{number + 1}": float(value) for number, value in enumerate(values)}
        return constraints | ({"failed": float(evaluation.failed)} if self.ranks_failures else {})

    def _params(self, design: FloatArray) -> dict[str, Any]:
        return dict(self._context.space.named(design))


@contextmanager
def _quiet() -> Iterator[None]:
    """No messages and warnings of Optuna inside: experimental features are in use, and every trial would be a line."""
    import optuna

    level = optuna.logging.get_verbosity()
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    try:
        with warnings.catch_warnings(action="ignore"):
            yield
    finally:
        optuna.logging.set_verbosity(level)


def _distribution(variable: Variable) -> "BaseDistribution":
    from optuna.distributions import FloatDistribution, IntDistribution

    if variable.integer:
        return IntDistribution(int(variable.lower), int(variable.upper))
    return FloatDistribution(float(variable.lower), float(variable.upper))


def _drop(study: "Study | None", trial: "Trial") -> None:
    """Close a trial without a result."""
    from optuna.trial import TrialState

    assert study is not None, "a trial has a study"
    study.tell(trial, state=TrialState.FAIL)
