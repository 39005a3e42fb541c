"""pymoo's algorithms as strategies (Blank and Deb 2020).

Two traps of pymoo are kept out here: its default operators and outputs are instances shared between algorithms, and some
of its algorithms draw from numpy's global generator, which is lent to them and put back.
"""

import copy
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from pymoo.core.algorithm import Algorithm
from pymoo.core.individual import Individual
from pymoo.core.population import Population
from pymoo.core.problem import Problem
from pymoo.core.variable import Integer, Real
from pymoo.problems.static import StaticProblem
from pymoo.termination.max_eval import MaximumFunctionCallTermination

from railsearch.errors import InputError, PluginError
from railsearch.generations import GenerationalStrategy
from railsearch.interfaces import Capabilities, NoParameters, SearchContext
from railsearch.seeding import LentGlobalGenerator
from railsearch.space import FloatArray, Space

MakeAlgorithm = Callable[[FloatArray], Algorithm]
"""Makes a new pymoo algorithm; designs (j, d) that have been evaluated may go into its first population."""


class PymooGenerations:
    """The generations of a pymoo algorithm, driven through its ask and tell.

    The budget takes the place of its termination. An algorithm that cannot go on (a genetic one that finds no new offspring,
    a local search that has converged) is made again with another seed. constrained: whether it can be told of constraints;
    if not, failed evaluations have the worst values and nothing more.
    """

    def __init__(self, context: SearchContext, make: MakeAlgorithm, constrained: bool = True) -> None:
        self.origin = "initial"
        self.trajectory = 0
        self.algorithm: Any = None
        self._context = context
        self._make = make
        self._n_constraints = context.n_constraints + 1 if constrained else 0
        self._infills: Any = None
        self._randomness: LentGlobalGenerator | None = None

    def first(self, known: FloatArray) -> FloatArray:
        """The first population of a new algorithm; `known` designs take the place of its first members."""
        seed = int(self._context.generator.integers(2**32))
        self._randomness = LentGlobalGenerator(seed)
        with self._randomness.lent():
            self.algorithm = self._make(known)
            self._set_up(seed)
            with self._named_failure():
                self._infills = self.algorithm.ask()
        designs = self._designs()
        shared = min(len(known), len(designs))
        designs[:shared] = known[:shared]
        self.origin = "initial"
        return designs

    def advance(self, designs: FloatArray, objectives: FloatArray, constraints: FloatArray) -> FloatArray:
        """Tell the algorithm the values of its population and ask for the next one."""
        assert self._randomness is not None, "the first generation comes first"
        population = self._population()
        for individual, design in zip(population, designs, strict=True):
            individual.X = self._context.space.named(design) if isinstance(individual.X, dict) else design.copy()
        new = [row for row, individual in enumerate(population) if not individual.evaluated]
        with self._randomness.lent(), self._named_failure():
            static = StaticProblem(self.algorithm.problem, F=objectives[new], G=constraints[new][:, : self._n_constraints])
            self.algorithm.evaluator.eval(static, population[new])
            self.algorithm.tell(infills=self._infills)
            self._infills = None if self.algorithm.termination.force_termination else self.algorithm.ask()
        if self._infills is None or len(self._population()) == 0:
            self.trajectory += 1
            return self.first(np.empty((0, self._context.space.dimension)))
        self.origin = "offspring"
        return self._designs()

    def _set_up(self, seed: int) -> None:
        name = type(self.algorithm).__name__
        self.algorithm.termination = MaximumFunctionCallTermination(self._context.budget)
        self.algorithm.output = None
        try:
            self.algorithm.setup(_Box(self._context, self._n_constraints, name), seed=seed)
        except Exception as error:
            raise PluginError(
                f"{name} of pymoo refuses this problem: {error}. One that handles no constraints has to be made a strategy "
                "with constraints=False, since failed evaluations are told as violations of one"
            ) from error

    @contextmanager
    def _named_failure(self) -> Iterator[None]:
        """An error inside the algorithm says whose it is."""
        try:
            yield
        except Exception as error:
            name = type(self.algorithm).__name__
            raise PluginError(f"{name} of pymoo cannot go on: {type(error).__name__}: {error}") from error

    def _population(self) -> Any:
        """What the algorithm asked for; a single individual stands for a population of one."""
        return Population.create(self._infills) if isinstance(self._infills, Individual) else self._infills

    def _designs(self) -> FloatArray:
        """The designs (n, d) of the population, brought inside the bounds, integers rounded."""
        names, vectors = self._context.space.names, [individual.X for individual in self._population()]
        rows = [[x[name] for name in names] if isinstance(x, dict) else x for x in vectors]
        return self._context.space.rounded(np.array(rows, dtype=float))


class PymooStrategy(GenerationalStrategy):
    """A pymoo algorithm asked and told design by design; `make` makes the algorithm."""

    def __init__(self, context: SearchContext, make: MakeAlgorithm, constrained: bool = True) -> None:
        super().__init__(context, PymooGenerations(context, make, constrained))


class Rounding:
    """pymoo's repair: designs brought inside the bounds, integers rounded."""

    def __init__(self, space: Space) -> None:
        self._space = space

    def __call__(self, problem: Any, population: Any, **context: Any) -> Any:
        """The population, repaired in place."""
        population.set("X", self._space.rounded(population.get("X")))
        return population


def strategy_from_algorithm(
    algorithm: Algorithm, multi_objective: bool | None = None, constraints: bool = True
) -> type[PymooStrategy]:
    """A strategy class that runs copies of a pymoo algorithm; see `railsearch.pymoo_strategy`. Raises InputError."""
    if not isinstance(algorithm, Algorithm):
        raise InputError(f"algorithm: an instance of pymoo's Algorithm is needed, received {algorithm!r}")
    if algorithm.problem is not None:
        raise InputError("algorithm: one that has not been set up on a problem is needed; make a new one")
    many = _is_multi_objective(type(algorithm)) if multi_objective is None else multi_objective

    class AlgorithmStrategy(PymooStrategy):
        Parameters = NoParameters
        capabilities = Capabilities(multi_objective=many, integers=True, constraints=constraints, batch=True)

        def __init__(self, context: SearchContext, parameters: NoParameters) -> None:
            super().__init__(context, lambda known: copy.deepcopy(algorithm), constraints)

    name = type(algorithm).__name__
    AlgorithmStrategy.__doc__ = f"{name} of pymoo as it was set up by its user, integers by rounding."
    AlgorithmStrategy.__name__ = AlgorithmStrategy.__qualname__ = f"{name}Strategy"
    return AlgorithmStrategy


def _is_multi_objective(kind: type) -> bool:
    """Whether pymoo keeps the class, or one that it is derived from, among its multi-objective algorithms."""
    return any(base.__module__.startswith("pymoo.algorithms.moo.") for base in kind.__mro__)


class _Box(Problem):  # type: ignore[misc]
    """The bounds, the variables and the numbers of objectives and constraints."""

    def __init__(self, context: SearchContext, n_constraints: int, algorithm: str) -> None:
        space = context.space
        super().__init__(
            n_var=space.dimension,
            n_obj=context.n_objectives,
            n_ieq_constr=n_constraints,
            xl=space.lower,
            xu=space.upper,
        )
        self.vars = {v.name: (Integer if v.integer else Real)(bounds=(v.lower, v.upper)) for v in space.variables}
        self._algorithm = algorithm

    def _evaluate(self, X: Any, out: dict[str, Any], *args: object, **kwargs: object) -> None:
        raise PluginError(
            f"the pymoo algorithm {self._algorithm} evaluates designs outside ask and tell, where no budget can be kept; "
            "use another one"
        )
