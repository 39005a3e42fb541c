"""Genetic search on cheap functions: what surrogates promise, by pymoo's GA and NSGA-II."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from railsearch.pymoo_generations import Rounding
from railsearch.space import FloatArray, Space

Objectives = Callable[[FloatArray], FloatArray]
"""Objectives (k, m) of designs (k, d) in native units."""


@dataclass(frozen=True)
class Evolution:
    """How long and with how many designs evolution goes on; operators are those of Deb et al. 2002.

    distance: designs nearer than this to one another (unit cube) count as the same, so that a population stays spread.
    """

    size: int
    generations: int
    distance: float
    crossover_probability: float = 0.9
    crossover_eta: float = 15.0
    mutation_eta: float = 20.0


def evolved(
    space: Space, objectives: Objectives, first: FloatArray, evolution: Evolution, generator: np.random.Generator
) -> FloatArray:
    """The last population (k, d) of an evolution that begins with the designs `first` (j, d), integers rounded.

    With one objective it is a GA, otherwise NSGA-II, with simulated binary crossover and polynomial mutation.
    Source: Deb et al. 2002; Blank and Deb 2020.
    """
    n_objectives = objectives(first[:1]).shape[1]
    algorithm = _algorithm(space, n_objectives, first, evolution)
    algorithm.setup(
        _problem(space, objectives, n_objectives),
        termination=("n_gen", evolution.generations + 1),
        seed=int(generator.integers(2**32)),
    )
    while algorithm.has_next():
        algorithm.next()
    return np.array(algorithm.pop.get("X"), dtype=float).reshape(-1, space.dimension)


def _problem(space: Space, objectives: Objectives, n_objectives: int) -> Any:
    from pymoo.core.problem import Problem

    class Promised(Problem):  # type: ignore[misc]
        """What the surrogates predict, as a problem of pymoo."""

        def _evaluate(self, designs: FloatArray, out: dict[str, Any], *args: object, **kwargs: object) -> None:
            out["F"] = objectives(designs)

    return Promised(n_var=space.dimension, n_obj=n_objectives, xl=space.lower, xu=space.upper)


def _algorithm(space: Space, n_objectives: int, first: FloatArray, evolution: Evolution) -> Any:
    """A GA or NSGA-II with operators of its own: pymoo's defaults are instances shared between algorithms."""
    from pymoo.algorithms.moo.nsga2 import NSGA2, binary_tournament
    from pymoo.algorithms.soo.nonconvex.ga import GA, FitnessSurvival, comp_by_cv_and_fitness
    from pymoo.core.duplicate import DefaultDuplicateElimination
    from pymoo.operators.crossover.sbx import SBX
    from pymoo.operators.mutation.pm import PM
    from pymoo.operators.selection.tournament import TournamentSelection
    from pymoo.operators.survival.rank_and_crowding import RankAndCrowding

    single = n_objectives == 1
    return (GA if single else NSGA2)(
        pop_size=evolution.size,
        sampling=first,
        selection=TournamentSelection(func_comp=comp_by_cv_and_fitness if single else binary_tournament),
        crossover=SBX(prob=evolution.crossover_probability, eta=evolution.crossover_eta),
        mutation=PM(eta=evolution.mutation_eta),
        survival=FitnessSurvival() if single else RankAndCrowding(),
        eliminate_duplicates=DefaultDuplicateElimination(
            func=lambda population: space.to_unit(population.get("X")), epsilon=evolution.distance
        ),
        repair=Rounding(space),
        output=None,
    )
