"""Any railsearch strategy as a pymoo algorithm, for any pymoo problem with bounds."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from pymoo.core.algorithm import Algorithm
from pymoo.core.population import Population
from pymoo.core.problem import Problem
from pymoo.util.optimum import filter_optimum
from threadpoolctl import threadpool_limits

from railsearch.design_problem import DesignProblem
from railsearch.errors import CapabilityError
from railsearch.interfaces import Evaluation, Proposal, Quantity
from railsearch.plugin_manager import Registry
from railsearch.run import RunSettings, make_strategy
from railsearch.seeding import checked_seed
from railsearch.space import FloatArray, Space, Variable


class StrategyAlgorithm(Algorithm):  # type: ignore[misc]
    """Asks a strategy, lets pymoo evaluate, tells the strategy; ends at the budget, or where a termination ends it before.

    registry: where the strategy is found by name; budget: evaluations in all; settings: those of the strategy that differ
    from its defaults; given: designs (d,) to evaluate first. The seed is that of `pymoo.optimize.minimize`. At a seed the
    designs are those of a railsearch run, save that pymoo evaluates repeated designs again, and that a problem which raises
    an error ends it; values that are not finite count as failed.
    Setting it up on a problem raises InputError, PluginError or CapabilityError as a run does.
    """

    def __init__(
        self,
        registry: Registry,
        strategy: str,
        budget: int,
        settings: Mapping[str, object] | None = None,
        given: Sequence[FloatArray] = (),
    ) -> None:
        super().__init__(termination=("n_eval", budget))
        self._registry = registry
        self._name = strategy
        self._budget = budget
        self._settings = settings or {}
        self._given = list(given)
        self._strategy: Any = None
        self._proposals: list[Proposal] = []
        self._spent = 0
        self._metrics: list[str] = []
        self._type: Any = float

    def _setup(self, problem: Problem, **kwargs: object) -> None:
        described = problem if isinstance(problem, DesignProblem) else _described(problem)
        settings = RunSettings(self._name, self._budget, checked_seed(self.seed), self._settings)
        self._strategy = make_strategy(self._registry, described, settings, len(self._given))
        self._given = [described.space.checked(design) for design in self._given]
        self._metrics = [metric.name for metric in described.metrics]
        self._type = problem.vtype or float

    def _initialize_infill(self) -> Population:
        if self._given:
            return self._population([Proposal(design, "given") for design in self._given])
        return self._infill()

    def _infill(self) -> Population:
        with threadpool_limits(1):
            return self._population(self._strategy.ask())

    def _initialize_advance(self, infills: Population, **kwargs: object) -> None:
        self._tell(infills)

    def _advance(self, infills: Population, **kwargs: object) -> None:
        self._tell(infills)
        self.pop: Population = Population.merge(self.pop, infills)

    def _set_optimum(self) -> None:
        sound = np.isfinite(self.pop.get("F")).all(axis=1)
        self.opt = filter_optimum(self.pop[sound] if sound.any() else self.pop, least_infeasible=True)

    def _population(self, proposals: Sequence[Proposal]) -> Population:
        self._proposals = list(proposals[: self._budget - self._spent])
        return Population.new(X=np.array([proposal.design for proposal in self._proposals]).astype(self._type))

    def _tell(self, infills: Population) -> None:
        evaluations = []
        for proposal, individual in zip(self._proposals, infills, strict=True):
            evaluations.append(_evaluation(self._spent, proposal, individual, self._metrics))
            self._spent += 1
        with threadpool_limits(1):
            self._strategy.tell(evaluations)
        if self._spent >= self._budget:
            self.termination.terminate()


def _evaluation(number: int, proposal: Proposal, individual: Any, metrics: Sequence[str]) -> Evaluation:
    objectives, constraints = np.array(individual.F, dtype=float), np.array(individual.G, dtype=float)
    sound = bool(np.isfinite(objectives).all() and np.isfinite(constraints).all())
    return Evaluation(
        number=number,
        design=proposal.design,
        objectives=objectives if sound else np.full_like(objectives, np.nan),
        constraints=constraints if sound else np.full_like(constraints, np.nan),
        metrics={name: float(individual.get(name)) for name in metrics},
        origin=proposal.origin,
        trajectory=proposal.trajectory,
        reason="" if sound else "an objective or a constraint is not finite",
    )


def _described(problem: Problem) -> DesignProblem:
    """A plain pymoo problem with its variables x1 … xd, all of its type, and objectives f1 … fm named."""
    if getattr(problem, "vars", None) is not None:
        raise CapabilityError(
            "variables given one by one (vars=…) cannot be handled; state the problem by arrays xl and xu, with vtype=int "
            "where all are integers, or as a railsearch DesignProblem, whose variables may be real or integer"
        )
    if problem.n_eq_constr:
        raise CapabilityError(f"equality constraints cannot be handled, this problem has {problem.n_eq_constr}")
    if problem.xl is None or problem.xu is None:
        raise CapabilityError("bounds xl and xu are needed, this problem has none")
    integer = np.dtype(problem.vtype or float).kind in "iub"
    variables = [
        Variable(f"x{number + 1}", float(lower), float(upper), integer=integer)
        for number, (lower, upper) in enumerate(zip(problem.xl, problem.xu, strict=True))
    ]
    objectives = [Quantity(f"f{number + 1}") for number in range(problem.n_obj)]
    return DesignProblem(type(problem).__name__, Space(tuple(variables)), objectives, n_constraints=problem.n_ieq_constr)
