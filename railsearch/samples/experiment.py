"""Designs of experiments: the designs of a sample, from the distributions of a problem's variables.

Integers are the nearest whole numbers of what their distribution gives; every whole number between the bounds of a variable
without a distribution is equally likely.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from types import MappingProxyType

import numpy as np

from railsearch.design_problem import DesignProblem
from railsearch.distributions import RandomVector, random_vector
from railsearch.errors import InputError
from railsearch.sampling import latin_hypercube, random_points, sobol
from railsearch.seeding import run_generators
from railsearch.space import FloatArray, Variable


class ExperimentDesign(StrEnum):
    """How the designs of an experiment fill the space."""

    RANDOM = "random"
    LHS = "lhs"
    SOBOL = "sobol"

    @property
    def extensible(self) -> bool:
        """Whether a larger sample begins with the designs of a smaller one; a Latin hypercube has a stratum for each."""
        return self is not ExperimentDesign.LHS


class MeasureDesign(StrEnum):
    """Designs from which classical measures of sensitivity are computed: blocks of Saltelli, trajectories of Morris."""

    SALTELLI = "saltelli"
    MORRIS = "morris"

    def number(self, count: int, dimension: int) -> int:
        """The designs of `count` blocks of d + 2, or trajectories of d + 1."""
        return count * (dimension + (2 if self is MeasureDesign.SALTELLI else 1))


@dataclass(frozen=True)
class Experiment:
    """How many designs, how they fill the space, and the seed. Raises InputError for a number that is not positive."""

    design: ExperimentDesign | MeasureDesign
    number: int
    seed: int

    def __post_init__(self) -> None:
        if self.number < 1:
            raise InputError(f"number: an integer ≥ 1 is needed, received {self.number}")


POINTS: Mapping[ExperimentDesign, Callable[[RandomVector, int, np.random.Generator], FloatArray]] = MappingProxyType(
    {ExperimentDesign.RANDOM: random_points, ExperimentDesign.LHS: latin_hypercube, ExperimentDesign.SOBOL: sobol}
)


def designs_of(problem: DesignProblem, experiment: Experiment) -> FloatArray:
    """The designs (n, d) of an experiment; the same in every process.

    Random ones are drawn from the stream that a strategy of a search with this seed has. Raises InputError for a number of
    Saltelli's blocks that is no power of two, and for fewer than two trajectories.
    """
    vector, generator = input_distributions(problem), run_generators(experiment.seed).strategy
    if isinstance(experiment.design, MeasureDesign):
        points = _measure_points(problem, vector, experiment, generator)
    else:
        points = POINTS[experiment.design](vector, experiment.number, generator)
    low, high = np.array([marginal.support for marginal in vector.marginals.values()]).T
    whole = np.clip(np.round(points), np.ceil(low), np.floor(high))
    # Adding zero makes positive zeros of negative ones, as the designs of a search have.
    designs: FloatArray = np.where(problem.space.integer, whole, points) + 0.0
    return designs


def _measure_points(
    problem: DesignProblem, vector: RandomVector, experiment: Experiment, generator: np.random.Generator
) -> FloatArray:
    from railsearch.sensitivity.screening import trajectory_points
    from railsearch.sensitivity.variance_based import saltelli_points

    count = experiment.number // MeasureDesign(experiment.design).number(1, vector.dimension)
    if experiment.design is MeasureDesign.SALTELLI:
        return saltelli_points(vector, count, generator)
    return trajectory_points(problem.space, count, generator)


def input_distributions(problem: DesignProblem) -> RandomVector:
    """The distributions of a problem's variables; uniform ones over the bounds of a problem that states none.

    An integer's reaches half a unit beyond its bounds, so that all whole numbers are equally likely.
    """
    if problem.distributions is not None:
        return problem.distributions
    return random_vector({variable.name: _uniform(variable) for variable in problem.space.variables}, where=problem.name)


def _uniform(variable: Variable) -> Mapping[str, object]:
    margin = 0.5 if variable.integer else 0.0
    return {"distribution": "uniform", "lower": variable.lower - margin, "upper": variable.upper + margin}
