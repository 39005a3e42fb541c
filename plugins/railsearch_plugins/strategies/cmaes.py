"""Strategy `cmaes`: covariance matrix adaptation with increasing populations (Hansen 2016; Auger and Hansen 2005).

pymoo's wrapper hides the generations of the library `cma` in a Python generator and leaves integers to rounding, where the
step size of an integer soon falls below one step and the search stands still. So `cma` is asked and told directly, with its
own treatment of integers: a lower bound of their standard deviations, and centring (Marty et al. 2024).

| symbol | meaning | shape |
|---|---|---|
| λ | designs per generation | scalar |
| σ | step size; its start in units of the ranges | scalar |
| z | coordinates of the search: reals from 0 to 1, integers in whole steps | (d,), but (2,) where d = 1 |
| v | violation of the constraints, Σ max(0, g) | (n,) |
"""

import math
import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np

from railsearch.generations import GenerationalStrategy
from railsearch.hookspecs import Register, hookimpl
from railsearch.interfaces import Capabilities, SearchContext, parameter
from railsearch.sampling import initial_design, random_designs
from railsearch.seeding import LentGlobalGenerator
from railsearch.space import FloatArray, Space


@dataclass(frozen=True)
class CovarianceParameters:
    """What can be set of CMA-ES."""

    population_size: int | None = parameter(
        None, meaning="λ, designs per generation; if not given, 4 + 3 ln d", source="Hansen 2016", minimum=4
    )
    initial_size: int | None = parameter(
        None,
        meaning="designs, the given ones included, the best of which is where the search starts; if not given, λ",
        source="own choice",
        minimum=1,
    )
    sigma_start: float = parameter(
        0.25, meaning="σ at the start", unit="of the range", source="Hansen 2016: 0.2 to 0.5", above=0.0, maximum=1.0
    )
    population_growth: float = parameter(
        2.0, meaning="factor of λ at a restart", source="Auger and Hansen 2005", minimum=1.0, maximum=10.0
    )
    smallest_step: float = parameter(
        1e-6,
        meaning="standard deviations at which the search starts afresh",
        unit="of the range",
        source="own choice",
        above=0.0,
    )


class Coordinates:
    """The map between designs and the coordinates z in which `cma` searches.

    A single variable gets a second coordinate that means nothing, since `cma` knows no covariance of a single one.
    """

    def __init__(self, space: Space) -> None:
        self._space = space
        self._origin = np.where(space.integer, 0.0, space.lower)
        self._unit = np.where(space.integer, 1.0, space.upper - space.lower)
        self._padding = 1 if space.dimension == 1 else 0

    @property
    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Lower and upper bounds of z; every integer gets a cell of the same width."""
        margin = np.where(self._space.integer, 0.5 - 1e-9, 0.0)
        lower, upper = (self.of(designs) for designs in (self._space.lower - margin, self._space.upper + margin))
        upper[self._space.dimension :] = 1.0
        return lower, upper

    def of(self, design: FloatArray) -> FloatArray:
        """The coordinates z of a design (d,)."""
        return np.append((design - self._origin) / self._unit, np.zeros(self._padding))

    def designs(self, z: FloatArray) -> FloatArray:
        """Designs (n, d) at coordinates (n, d), or (n, 2) where d = 1."""
        return self._space.rounded(self._origin + z[:, : self._space.dimension] * self._unit)


class CovarianceGenerations:
    """The generations of CMA-ES: an initial design, then samples about a mean that starts at its best design."""

    def __init__(self, context: SearchContext, parameters: CovarianceParameters) -> None:
        self.origin = "initial"
        self.trajectory = 0
        self._context = context
        self._parameters = parameters
        self._coordinates = Coordinates(context.space)
        self._size = parameters.population_size or 4 + int(3.0 * math.log(context.space.dimension))
        self._evolution: Any = None
        self._samples: list[FloatArray] = []
        self._randomness: LentGlobalGenerator | None = None

    def first(self, known: FloatArray) -> FloatArray:
        """The `known` designs, filled up with an initial design."""
        space, generator = self._context.space, self._context.initial_generator
        wanted = max((self._parameters.initial_size or self._size) - len(known), 0)
        self._randomness = LentGlobalGenerator(int(self._context.generator.integers(2**32)))
        return np.vstack([known, initial_design(space, wanted, generator, known)])

    def advance(self, designs: FloatArray, objectives: FloatArray, constraints: FloatArray) -> FloatArray:
        """λ designs sampled after the mean, the step size and the covariances have learnt from the last ones."""
        assert self._randomness is not None, "the first generation comes first"
        values = ranked_values(objectives[:, 0], constraints)
        with self._randomness.lent(), warnings.catch_warnings(action="ignore"):
            if self._evolution is None:
                self._evolution = self._started(designs[np.argmin(values)])
            else:
                self._evolution.tell(self._answered(designs), values.tolist())
            if self._evolution.stop():
                self._restart()
            self._samples = self._evolution.ask()
        self.origin = "sample"
        return self._coordinates.designs(np.array(self._samples))

    def _answered(self, designs: FloatArray) -> list[FloatArray]:
        """The coordinates that were sampled, or those of a design evaluated in their place."""
        sampled = self._coordinates.designs(np.array(self._samples))
        return [
            sample if np.array_equal(was, design) else self._coordinates.of(design)
            for sample, was, design in zip(self._samples, sampled, designs, strict=True)
        ]

    def _restart(self) -> None:
        """Start afresh from a random design with a larger population."""
        self.trajectory += 1
        self._size = int(self._size * self._parameters.population_growth)
        self._evolution = self._started(random_designs(self._context.space, 1, self._context.generator)[0])

    def _started(self, design: FloatArray) -> Any:
        """A new evolution strategy whose mean is a design; stopped by what does not depend on the scale of the objective."""
        import cma

        lower, upper = self._coordinates.bounds
        settings = {
            "popsize": self._size,
            "bounds": [lower.tolist(), upper.tolist()],
            "CMA_stds": (upper - lower).tolist(),
            "integer_variables": np.flatnonzero(self._context.space.integer).tolist(),
            "randn": lambda *shape: self._context.generator.standard_normal(shape),
            "seed": np.nan,
            "tolx": self._parameters.smallest_step,
            "tolfun": 0.0,
            "tolfunhist": 0.0,
            "tolfunrel": 1e-12,
            "verbose": -9,
        }
        return cma.CMAEvolutionStrategy(self._coordinates.of(design), self._parameters.sigma_start, settings)


class CovarianceMatrixAdaptation(GenerationalStrategy):
    """CMA-ES of the library cma: a normal distribution that learns the objective's shape, restarted once it is small."""

    Parameters = CovarianceParameters
    capabilities = Capabilities(integers=True, constraints=True, batch=True)

    def __init__(self, context: SearchContext, parameters: CovarianceParameters) -> None:
        super().__init__(context, CovarianceGenerations(context, parameters))
        self._first = max(parameters.initial_size or 1, parameters.population_size or 1)

    @property
    def minimum_budget(self) -> int:
        """The initial design, or the population where it is larger, as far as they are given."""
        return self._first


def ranked_values(objective: FloatArray, constraints: FloatArray) -> FloatArray:
    """One value (n,) per design that orders them as Deb (2000) does: feasible ones by f, behind them the others by v.

    objective: f (n,), of which only the order matters to CMA-ES; constraints: g (n, k) ≤ 0.
    """
    violation: FloatArray = np.sum(np.maximum(constraints, 0.0), axis=1)
    feasible = violation == 0.0
    if feasible.all():
        return objective
    if not feasible.any():
        return violation
    worst = float(objective[feasible].max())
    step = max(float(np.ptp(objective[feasible])), abs(worst), np.finfo(float).tiny)
    values: FloatArray = np.where(feasible, objective, worst + step * (1.0 + violation / violation.max()))
    return values


@hookimpl
def railsearch_strategies(register: Register) -> None:
    """Register `cmaes`."""
    register("cmaes", CovarianceMatrixAdaptation)
