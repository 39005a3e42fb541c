"""Strategies `ga`, `nsga2`, `nsga3`, `de` and `pso`: pymoo's own algorithms behind ask and tell (Blank and Deb 2020)."""

import math
import warnings
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, Generic, Protocol, TypeVar

import numpy as np

from railsearch.hookspecs import Register, hookimpl
from railsearch.interfaces import Capabilities, SearchContext, parameter
from railsearch.pymoo_generations import PymooStrategy, Rounding
from railsearch.sampling import initial_design, random_designs
from railsearch.space import FloatArray

SIZE_MEANING = "designs per generation; if not given, a tenth of the budget, but 10 to 100"
SIZE_SOURCE = "own choice: pymoo's 100 leave two generations of a budget of 200"


@dataclass(frozen=True)
class GeneticParameters:
    """What can be set of a genetic algorithm."""

    population_size: int | None = parameter(None, meaning=SIZE_MEANING, source=SIZE_SOURCE, minimum=2)
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


@dataclass(frozen=True)
class ReferenceDirectionParameters(GeneticParameters):
    """What can be set of NSGA-III, whose crossover keeps children nearer to their parents and spares no pair."""

    population_size: int | None = parameter(
        None, meaning=SIZE_MEANING + "; as many reference directions as fit", source=SIZE_SOURCE, minimum=2
    )
    crossover_probability: float = parameter(
        1.0,
        meaning="probability of simulated binary crossover of a pair",
        source="Deb and Jain 2014",
        minimum=0.0,
        maximum=1.0,
    )
    crossover_eta: float = parameter(
        30.0,
        meaning="distribution index of the crossover; large keeps children near their parents",
        source="Deb and Jain 2014",
        above=1.0,
    )


@dataclass(frozen=True)
class DifferentialEvolutionParameters:
    """What can be set of differential evolution."""

    population_size: int | None = parameter(None, meaning=SIZE_MEANING, source=SIZE_SOURCE, minimum=4)
    base: str = parameter(
        "best",
        meaning="which vector the difference is added to: the best one, or a random one",
        source="Storn and Price 1997; best: own choice, random ones need budgets of thousands",
        choices=("best", "rand"),
    )
    differential_weight: float = parameter(
        0.5, meaning="F, the factor of the difference of two vectors", source="Storn and Price 1997", above=0.0, maximum=2.0
    )
    crossover_rate: float = parameter(
        0.9, meaning="CR, the probability that a coordinate changes", source="Storn and Price 1997", minimum=0.0, maximum=1.0
    )


@dataclass(frozen=True)
class ParticleSwarmParameters:
    """What can be set of a particle swarm; pymoo adapts inertia and accelerations on the way."""

    population_size: int | None = parameter(None, meaning=SIZE_MEANING, source=SIZE_SOURCE, minimum=2)
    inertia: float = parameter(
        0.9, meaning="w, the share of its velocity that a particle keeps, at the start", source="pymoo 0.6", minimum=0.0
    )
    cognitive: float = parameter(
        2.0, meaning="c₁, the pull of a particle's own best design, at the start", source="pymoo 0.6", minimum=0.0
    )
    social: float = parameter(2.0, meaning="c₂, the pull of the best design, at the start", source="pymoo 0.6", minimum=0.0)
    largest_velocity: float = parameter(
        0.2,
        meaning="largest step in a coordinate",
        unit="of the range",
        source="pymoo 0.6",
        above=0.0,
        maximum=1.0,
    )


class PopulationParameters(Protocol):
    """The one parameter that all of them have."""

    @property
    def population_size(self) -> int | None:
        """Designs per generation."""


P = TypeVar("P", bound=PopulationParameters)


class PopulationStrategy(PymooStrategy, ABC, Generic[P]):
    """A pymoo algorithm whose first population is what has been told, filled up with an initial design."""

    def __init__(self, context: SearchContext, parameters: P) -> None:
        super().__init__(context, self._make)
        self._parameters = parameters
        self._size = parameters.population_size or int(np.clip(context.budget // 10, 10, 100))

    @property
    def minimum_budget(self) -> int:
        """The size of the first population."""
        return self._size

    def _make(self, known: FloatArray) -> Any:
        """A new algorithm with a first population of `known` designs (j, d) and others."""
        context = self._context
        wanted = max(self._size - len(known), 0)
        designs = initial_design(context.space, wanted, context.initial_generator, known)
        repeated = random_designs(context.space, wanted - len(designs), context.initial_generator)
        return self._algorithm(np.vstack([known, designs, repeated]))

    @abstractmethod
    def _algorithm(self, first: FloatArray) -> Any:
        """A new algorithm of pymoo with that first population (n, d)."""


class GeneticAlgorithm(PopulationStrategy[GeneticParameters]):
    """Genetic algorithm of pymoo: simulated binary crossover, polynomial mutation, integers by rounding."""

    Parameters = GeneticParameters
    capabilities = Capabilities(integers=True, constraints=True, batch=True)

    def _algorithm(self, first: FloatArray) -> Any:
        from pymoo.algorithms.soo.nonconvex.ga import GA, FitnessSurvival, comp_by_cv_and_fitness

        operators = _genetic_operators(self._parameters, comp_by_cv_and_fitness, Rounding(self._context.space))
        return GA(pop_size=self._size, sampling=first, survival=FitnessSurvival(), output=None, **operators)


class NonDominatedSortingGeneticAlgorithm(PopulationStrategy[GeneticParameters]):
    """NSGA-II of pymoo: non-dominated sorting and crowding distance, integers by rounding (Deb et al. 2002)."""

    Parameters = GeneticParameters
    capabilities = Capabilities(multi_objective=True, integers=True, constraints=True, batch=True)

    def _algorithm(self, first: FloatArray) -> Any:
        from pymoo.algorithms.moo.nsga2 import NSGA2, binary_tournament
        from pymoo.operators.survival.rank_and_crowding import RankAndCrowding

        operators = _genetic_operators(self._parameters, binary_tournament, Rounding(self._context.space))
        return NSGA2(pop_size=self._size, sampling=first, survival=RankAndCrowding(), output=None, **operators)


class ReferenceDirectionGeneticAlgorithm(PopulationStrategy[ReferenceDirectionParameters]):
    """NSGA-III of pymoo: reference directions keep the front spread, integers by rounding (Deb and Jain 2014)."""

    Parameters = ReferenceDirectionParameters
    capabilities = Capabilities(multi_objective=True, integers=True, constraints=True, batch=True)

    def _algorithm(self, first: FloatArray) -> Any:
        from pymoo.algorithms.moo.nsga3 import NSGA3, ReferenceDirectionSurvival

        class QuietSurvival(ReferenceDirectionSurvival):  # type: ignore[misc]
            """pymoo's survival, which switches all warnings of the process off on its way."""

            def _do(self, *arguments: Any, **settings: Any) -> Any:
                with warnings.catch_warnings():
                    return super()._do(*arguments, **settings)

        directions = _reference_directions(self._context.n_objectives, self._size)
        operators = _genetic_operators(self._parameters, _feasible_or_random, Rounding(self._context.space))
        survival = QuietSurvival(directions)
        size = max(self._size, len(directions))
        return NSGA3(directions, pop_size=size, sampling=first, survival=survival, output=None, **operators)


class DifferentialEvolution(PopulationStrategy[DifferentialEvolutionParameters]):
    """Differential evolution of pymoo with binomial crossover, integers by rounding (Storn and Price 1997)."""

    Parameters = DifferentialEvolutionParameters
    capabilities = Capabilities(integers=True, constraints=True, batch=True)

    def _algorithm(self, first: FloatArray) -> Any:
        from pymoo.algorithms.soo.nonconvex.de import DE

        return DE(
            pop_size=len(first),
            sampling=first,
            variant=f"DE/{self._parameters.base}/1/bin",
            F=self._parameters.differential_weight,
            CR=self._parameters.crossover_rate,
            repair=Rounding(self._context.space),
            output=None,
        )


class ParticleSwarm(PopulationStrategy[ParticleSwarmParameters]):
    """Adaptive particle swarm of pymoo, integers by rounding (Kennedy and Eberhart 1995; Zhan et al. 2009)."""

    Parameters = ParticleSwarmParameters
    capabilities = Capabilities(integers=True, constraints=True, batch=True)

    def _algorithm(self, first: FloatArray) -> Any:
        from pymoo.algorithms.soo.nonconvex.pso import PSO

        return PSO(
            pop_size=len(first),
            sampling=first,
            w=self._parameters.inertia,
            c1=self._parameters.cognitive,
            c2=self._parameters.social,
            max_velocity_rate=self._parameters.largest_velocity,
            repair=Rounding(self._context.space),
            output=None,
        )


def _genetic_operators(parameters: GeneticParameters, comparison: Any, rounding: Rounding) -> dict[str, Any]:
    """Operators of an algorithm's own: pymoo's defaults are instances shared between algorithms."""
    from pymoo.core.duplicate import DefaultDuplicateElimination
    from pymoo.operators.crossover.sbx import SBX
    from pymoo.operators.mutation.pm import PM
    from pymoo.operators.selection.tournament import TournamentSelection

    return {
        "selection": TournamentSelection(func_comp=comparison),
        "crossover": SBX(prob=parameters.crossover_probability, eta=parameters.crossover_eta),
        "mutation": PM(eta=parameters.mutation_eta),
        "eliminate_duplicates": DefaultDuplicateElimination(),
        "repair": rounding,
    }


def _feasible_or_random(population: Any, pairs: Any, random_state: Any, **context: Any) -> Any:
    """The winners of tournaments of two: the less infeasible one, else either.

    pymoo's own comparison draws the winner of two equally infeasible ones from a generator without seed, so that no run can
    be repeated once two evaluations have failed.
    """
    violations = population.get("CV")[:, 0][pairs]
    either = random_state.integers(2, size=len(pairs))
    winner = np.where(violations[:, 0] == violations[:, 1], either, np.argmin(violations, axis=1))
    return np.take_along_axis(pairs, winner[:, None], axis=1)


def _reference_directions(n_objectives: int, size: int) -> FloatArray:
    """Directions (r ≤ size, m) of Das and Dennis: as many divisions of the simplex as fit, at least one."""
    from pymoo.util.ref_dirs import get_reference_directions

    divisions = 1
    while n_objectives > 1 and math.comb(divisions + n_objectives, n_objectives - 1) <= size:
        divisions += 1
    directions: FloatArray = get_reference_directions("das-dennis", n_objectives, n_partitions=divisions)
    return directions


@hookimpl
def railsearch_strategies(register: Register) -> None:
    """Register `ga`, `nsga2`, `nsga3`, `de` and `pso`."""
    register("ga", GeneticAlgorithm)
    register("nsga2", NonDominatedSortingGeneticAlgorithm)
    register("nsga3", ReferenceDirectionGeneticAlgorithm)
    register("de", DifferentialEvolution)
    register("pso", ParticleSwarm)
