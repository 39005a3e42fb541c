"""Strategies `ga` and `nsga2`: pymoo's own algorithms behind ask and tell (Blank and Deb 2020; NSGA-II: Deb et al. 2002)."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from railsearch.hookspecs import Register, hookimpl
from railsearch.interfaces import Capabilities, Evaluation, Proposal, SearchContext, parameter
from railsearch.sampling import initial_design, random_designs, unseen_design
from railsearch.space import FloatArray, Space

IDLE_GENERATIONS = 20
"""Generations in a row without a single unseen design after which a random unseen one is proposed."""

Build = Callable[["GeneticParameters", int, FloatArray, Any], Any]
"""Makes a pymoo algorithm from its parameters, population size, first population (k, d) and rounding repair."""


@dataclass(frozen=True)
class GeneticParameters:
    """What can be set of a genetic algorithm."""

    population_size: int | None = parameter(
        None,
        meaning="designs per generation; if not given, a tenth of the budget, but 10 to 100",
        source="own choice: pymoo's 100 leave two generations of a budget of 200",
        minimum=2,
    )
    crossover_probability: float = parameter(
        0.9,
        meaning="probability of simulated binary crossover of a pair",
        source="Deb et al. 2002",
        minimum=0.0,
        maximum=1.0,
    )
    crossover_eta: float = parameter(
        15.0,
        meaning="distribution index of the crossover; large keeps children near their parents",
        source="pymoo 0.6",
        above=1.0,
    )
    mutation_eta: float = parameter(
        20.0,
        meaning="distribution index of the polynomial mutation of each variable with probability 1/d",
        source="Deb et al. 2002",
        above=1.0,
        maximum=100.0,
    )


class PymooStrategy:
    """A generational pymoo algorithm asked and told design by design.

    The designs told before the first ask join the first population; a design evaluated before is not proposed again. Failed
    evaluations count as infeasible, with the worst values seen.
    """

    def __init__(self, context: SearchContext, parameters: GeneticParameters, build: Build) -> None:
        self._context = context
        self._parameters = parameters
        self._build = build
        self._told: dict[bytes, Evaluation] = {}
        self._asked: list[int] = []
        self._algorithm: Any = None
        self._generation: Any = None

    @property
    def minimum_budget(self) -> int:
        """The size of the first population."""
        return self._parameters.population_size or int(np.clip(self._context.budget // 10, 10, 100))

    def ask(self) -> Sequence[Proposal]:
        """Designs of the present generation that have not been evaluated, origin `initial` or `offspring`."""
        if self._algorithm is None:
            self._start()
        for _ in range(IDLE_GENERATIONS):
            self._asked = self._unanswered()[: self._context.batch_size]
            if self._asked:
                origin = "offspring" if self._algorithm.is_initialized else "initial"
                return [Proposal(np.array(self._generation[k].X), origin) for k in self._asked]
            self._advance()
            if self._generation is None:
                break
        return [self._random_proposal()]

    def tell(self, evaluations: Sequence[Evaluation]) -> None:
        """Take in evaluations; one of a design not asked for takes the place of a proposal that was not answered."""
        strangers = []
        for evaluation in evaluations:
            key = self._context.space.key(evaluation.design)
            if key not in {self._key(self._generation[index]) for index in self._asked}:
                strangers.append(evaluation)
            self._told[key] = evaluation
        open_places = [index for index in self._asked if self._key(self._generation[index]) not in self._told]
        for index, evaluation in zip(open_places, strangers, strict=False):
            self._generation[index].X = np.array(evaluation.design)
        self._asked = []

    def _start(self) -> None:
        """Make the algorithm and its first population: what has been told, filled up with an initial design."""
        context = self._context
        size = self.minimum_budget
        given = np.array([evaluation.design for evaluation in self._told.values()]).reshape(-1, context.space.dimension)
        designs = initial_design(context.space, max(size - len(given), 0), context.initial_generator, given)
        self._algorithm = self._build(self._parameters, size, np.vstack([given, designs]), _Rounding(context.space))
        self._algorithm.setup(_pymoo_problem(context), seed=int(context.generator.integers(2**32)))
        self._generation = self._algorithm.ask()

    def _advance(self) -> None:
        """Tell pymoo the values of the generation and ask for the next."""
        from pymoo.problems.static import StaticProblem

        if self._generation is not None:
            objectives, constraints = self._values([self._told[self._key(individual)] for individual in self._generation])
            static = StaticProblem(self._algorithm.problem, F=objectives, G=constraints)
            self._algorithm.evaluator.eval(static, self._generation)
            self._algorithm.tell(infills=self._generation)
        self._generation = self._algorithm.ask()

    def _values(self, evaluations: Sequence[Evaluation]) -> tuple[FloatArray, FloatArray]:
        """Objectives (n, m) and constraints (n, k + 1), the last of which only a failed evaluation violates."""
        successes = [evaluation for evaluation in self._told.values() if not evaluation.failed]
        worst = np.zeros(self._context.n_objectives)
        worst_constraints = np.zeros(self._context.n_constraints)
        if successes:
            worst = np.max([success.objectives for success in successes], axis=0)
            worst_constraints = np.max([success.constraints for success in successes], axis=0, initial=0.0)
        failed = np.array([evaluation.failed for evaluation in evaluations])
        objectives = [worst if e.failed else e.objectives for e in evaluations]
        constraints = [worst_constraints if e.failed else e.constraints for e in evaluations]
        return np.array(objectives), np.column_stack([np.array(constraints), np.where(failed, 1.0, 0.0)])

    def _unanswered(self) -> list[int]:
        """The individuals of the generation that have not been evaluated."""
        if self._generation is None:
            return []
        return [index for index, individual in enumerate(self._generation) if self._key(individual) not in self._told]

    def _random_proposal(self) -> Proposal:
        space, generator = self._context.space, self._context.generator
        design = unseen_design(space, set(self._told), generator)
        return Proposal(random_designs(space, 1, generator)[0] if design is None else design, "random")

    def _key(self, individual: Any) -> bytes:
        return self._context.space.key(individual.X)


class GeneticAlgorithm(PymooStrategy):
    """Genetic algorithm of pymoo: simulated binary crossover, polynomial mutation, integers by rounding."""

    Parameters = GeneticParameters
    capabilities = Capabilities(integers=True, constraints=True, batch=True)

    def __init__(self, context: SearchContext, parameters: GeneticParameters) -> None:
        super().__init__(context, parameters, _genetic_algorithm)


class NonDominatedSortingGeneticAlgorithm(PymooStrategy):
    """NSGA-II of pymoo: non-dominated sorting and crowding distance, integers by rounding."""

    Parameters = GeneticParameters
    capabilities = Capabilities(multi_objective=True, integers=True, constraints=True, batch=True)

    def __init__(self, context: SearchContext, parameters: GeneticParameters) -> None:
        super().__init__(context, parameters, _nsga2)


class _Rounding:
    """pymoo's repair: designs brought inside the bounds, integers rounded."""

    def __init__(self, space: Space) -> None:
        self._space = space

    def __call__(self, problem: Any, population: Any, **context: Any) -> Any:
        population.set("X", self._space.rounded(population.get("X")))
        return population


def _pymoo_problem(context: SearchContext) -> Any:
    """The box and the numbers of objectives and constraints, one more for failed evaluations."""
    from pymoo.core.problem import Problem

    return Problem(
        n_var=context.space.dimension,
        n_obj=context.n_objectives,
        n_ieq_constr=context.n_constraints + 1,
        xl=context.space.lower,
        xu=context.space.upper,
    )


def _genetic_algorithm(parameters: GeneticParameters, size: int, first: FloatArray, rounding: _Rounding) -> Any:
    from pymoo.algorithms.soo.nonconvex.ga import GA, FitnessSurvival, comp_by_cv_and_fitness

    return _algorithm(GA, comp_by_cv_and_fitness, FitnessSurvival(), parameters, size, first, rounding)


def _nsga2(parameters: GeneticParameters, size: int, first: FloatArray, rounding: _Rounding) -> Any:
    from pymoo.algorithms.moo.nsga2 import NSGA2, binary_tournament
    from pymoo.operators.survival.rank_and_crowding import RankAndCrowding

    return _algorithm(NSGA2, binary_tournament, RankAndCrowding(), parameters, size, first, rounding)


def _algorithm(
    kind: Any,
    comparison: Any,
    survival: Any,
    parameters: GeneticParameters,
    size: int,
    first: FloatArray,
    rounding: _Rounding,
) -> Any:
    """An algorithm with operators of its own: pymoo's defaults are instances shared between algorithms."""
    from pymoo.core.duplicate import DefaultDuplicateElimination
    from pymoo.core.termination import NoTermination
    from pymoo.operators.crossover.sbx import SBX
    from pymoo.operators.mutation.pm import PM
    from pymoo.operators.selection.tournament import TournamentSelection

    algorithm = kind(
        pop_size=size,
        sampling=first,
        selection=TournamentSelection(func_comp=comparison),
        crossover=SBX(prob=parameters.crossover_probability, eta=parameters.crossover_eta),
        mutation=PM(eta=parameters.mutation_eta),
        survival=survival,
        eliminate_duplicates=DefaultDuplicateElimination(),
        repair=rounding,
        output=None,
    )
    algorithm.termination = NoTermination()
    return algorithm


@hookimpl
def railsearch_strategies(register: Register) -> None:
    """Register `ga` and `nsga2`."""
    register("ga", GeneticAlgorithm)
    register("nsga2", NonDominatedSortingGeneticAlgorithm)
