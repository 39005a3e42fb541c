"""pymoo 0.6.2: its genetic algorithm with its own operators, the start as first population, integers by rounding repair."""

import numpy as np
from pymoo.algorithms.soo.nonconvex.ga import GA
from pymoo.core.problem import ElementwiseProblem
from pymoo.core.repair import Repair
from pymoo.core.termination import NoTermination
from pymoo.optimize import minimize
from serve import Run

DISTRIBUTIONS = ("pymoo", "numpy", "scipy")
PRELOADED = ("scipy.spatial", "scipy.stats", "pymoo.functions.compiled.non_dominated_sorting")


class Asking(ElementwiseProblem):
    """The problem of a run."""

    def __init__(self, run: Run) -> None:
        super().__init__(n_var=run.dimension, n_obj=1, xl=run.lower, xu=run.upper)
        self._run = run

    def _evaluate(self, x: np.ndarray, out: dict, *args: object, **kwargs: object) -> None:
        out["F"] = self._run.evaluate(x)


class Rounding(Repair):
    """Integers rounded, the other variables as they are."""

    def __init__(self, integer: np.ndarray) -> None:
        super().__init__()
        self._integer = integer

    def _do(self, problem: Asking, X: np.ndarray, **kwargs: object) -> np.ndarray:
        return np.where(self._integer, np.round(X), X)


def genetic(run: Run) -> None:
    """Simulated binary crossover, polynomial mutation, tournament selection, duplicates eliminated; no end."""
    algorithm = GA(pop_size=len(run.points), sampling=run.points, repair=Rounding(run.integer))
    minimize(Asking(run), algorithm, NoTermination(), seed=run.seed)


ALGORITHMS = {"ga": genetic}
