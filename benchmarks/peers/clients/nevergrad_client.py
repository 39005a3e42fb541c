"""Nevergrad 1.0.12: NGOpt, which chooses an algorithm by the problem; the start is suggested to it first."""

import nevergrad
import numpy as np
from serve import Run

DISTRIBUTIONS = ("nevergrad", "cma", "numpy", "scipy")


def _variable(lower: float, upper: float, integer: bool) -> nevergrad.p.Scalar:
    scalar = nevergrad.p.Scalar(lower=lower, upper=upper)
    return scalar.set_integer_casting() if integer else scalar


def ngopt(run: Run) -> None:
    """NGOpt for the budget of the run, one evaluation at a time; the start counts as its first evaluations."""
    box = zip(run.lower.tolist(), run.upper.tolist(), run.integer, strict=True)
    space = nevergrad.p.Tuple(*(_variable(*variable) for variable in box))
    space.random_state = np.random.RandomState(run.seed)
    optimizer = nevergrad.optimizers.NGOpt(parametrization=space, budget=run.budget, num_workers=1)
    for point in run.points.tolist():
        optimizer.suggest(tuple(int(x) if integer else x for x, integer in zip(point, run.integer, strict=True)))
    while True:
        candidate = optimizer.ask()
        optimizer.tell(candidate, run.evaluate(candidate.value))


ALGORITHMS = {"ngopt": ngopt}
