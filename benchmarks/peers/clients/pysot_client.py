"""pySOT 0.3.3: DYCORS and SRBF with its own cubic RBF with a linear tail (Eriksson, Bindel and Shoemaker 2019).

Its symmetric Latin hypercube is replaced by the start; after a restart it makes its own. The spent budget ends it from
outside: it counts a design that it repeats, the benchmark does not.
"""

import numpy as np
from poap.controller import SerialController
from pySOT.experimental_design import SymmetricLatinHypercube
from pySOT.optimization_problems import OptimizationProblem
from pySOT.strategy import DYCORSStrategy, SRBFStrategy
from pySOT.surrogate import CubicKernel, LinearTail, RBFInterpolant
from serve import Run

DISTRIBUTIONS = ("pySOT", "POAP", "numpy", "scipy")


class Box(OptimizationProblem):
    """The variables of a run."""

    def __init__(self, run: Run) -> None:
        self.dim = run.dimension
        self.lb = run.lower
        self.ub = run.upper
        self.int_var = np.flatnonzero(run.integer)
        self.cont_var = np.flatnonzero(~run.integer)

    def eval(self, x: np.ndarray) -> float:
        """Values come from the run."""
        raise NotImplementedError


class StartDesign(SymmetricLatinHypercube):
    """The start at first, symmetric Latin hypercubes of as many points after a restart."""

    def __init__(self, run: Run) -> None:
        super().__init__(run.dimension, len(run.points))
        self._first = run.points

    def generate_points(self, lb: np.ndarray, ub: np.ndarray, int_var: np.ndarray) -> np.ndarray:
        """Points (n, d) in the units of the problem."""
        if self._first is None:
            return super().generate_points(lb, ub, int_var)
        first, self._first = self._first, None
        return first.copy()


class EndlessDYCORS(DYCORSStrategy):
    """DYCORS whose budget sets its probabilities and does not end it."""

    def check_termination(self) -> None:
        """Nothing to check: the budget is enforced from outside."""


class EndlessSRBF(SRBFStrategy):
    """SRBF that is ended from outside."""

    def check_termination(self) -> None:
        """Nothing to check: the budget is enforced from outside."""


def _search(strategy: type[SRBFStrategy], run: Run) -> None:
    np.random.seed(run.seed)  # noqa: NPY002 - pySOT draws from numpy's global generator
    box = Box(run)
    surrogate = RBFInterpolant(run.dimension, run.lower, run.upper, kernel=CubicKernel(), tail=LinearTail(run.dimension))
    controller = SerialController(run.evaluate)
    controller.strategy = strategy(
        max_evals=run.budget, opt_prob=box, exp_design=StartDesign(run), surrogate=surrogate, asynchronous=True
    )
    controller.run()


def dycors(run: Run) -> None:
    """Dynamic coordinate search, asynchronous strategy on one evaluation at a time."""
    _search(EndlessDYCORS, run)


def srbf(run: Run) -> None:
    """Metric stochastic response surface."""
    _search(EndlessSRBF, run)


ALGORITHMS = {"dycors": dycors, "srbf": srbf}
