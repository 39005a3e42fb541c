"""soogo 2.1: DYCORS and multistart LMSRS (MSRS), with its default model, the RBF with a median filter, holding the start."""

from collections.abc import Callable

import numpy as np
from serve import Run
from soogo import MedianLpfFilter, RbfModel, multistart_msrs
from soogo import dycors as soogo_dycors

DISTRIBUTIONS = ("soogo", "numpy", "scipy")


def _model(run: Run) -> RbfModel:
    model = RbfModel(iindex=tuple(np.flatnonzero(run.integer).tolist()), filter=MedianLpfFilter())
    model.reserve(run.budget, run.dimension)
    model.update(run.points, run.values)
    return model


def _values(run: Run) -> Callable[[np.ndarray], np.ndarray]:
    return lambda rows: np.array([run.evaluate(row) for row in np.atleast_2d(rows)])


def dycors(run: Run) -> None:
    """`soogo.dycors` on what the start leaves of the budget."""
    left = run.budget - len(run.points)
    soogo_dycors(_values(run), np.column_stack([run.lower, run.upper]), left, surrogateModel=_model(run), seed=run.seed)


def msrs(run: Run) -> None:
    """`soogo.multistart_msrs` on what the start leaves of the budget."""
    left = run.budget - len(run.points)
    multistart_msrs(_values(run), np.column_stack([run.lower, run.upper]), left, surrogateModel=_model(run), seed=run.seed)


ALGORITHMS = {"dycors": dycors, "msrs": msrs}
