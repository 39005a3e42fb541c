"""A problem with distributions whose samples leave the bounds of its search; importable from other processes."""

import types
from collections.abc import Callable
from typing import Any

import numpy as np

from railsearch.design_problem import DesignProblem
from railsearch.distributions import random_vector
from railsearch.errors import SimulationError
from railsearch.hookspecs import hookimpl
from railsearch.interfaces import Outcome, Quantity
from railsearch.space import FloatArray, Space, Variable
from sample_problems import Sphere, Troubled, TwoObjectives

SPACE = Space(
    (
        Variable("load", 40.0, 60.0, "kN", meaning="weight of the train"),
        Variable("sag", -1.0, 1.0, "mm", meaning="initial sag"),
        Variable("seconds", 1, 3, "", integer=True, meaning="a name that the table has itself"),
    )
)
DISTRIBUTIONS = {
    "load": {"distribution": "lognormal", "mean": 50.0, "cov": 0.3},
    "sag": {"distribution": "normal", "mean": 0.0, "std": 1.0},
    "seconds": {"distribution": "triangular", "lower": 0.5, "mode": 3.5, "upper": 3.5},
}
BREAKS = 70.0


class Uncertain(DesignProblem):
    """comfort = −load · seconds, maximised; breaks under a load above 70 kN."""

    available_objectives = (Quantity("comfort", "kN", "the less load the better", maximised=True), Quantity("load", "kN"))

    def __init__(self) -> None:
        super().__init__(
            "uncertain",
            SPACE,
            self.available_objectives,
            [Quantity("gap", "mm")],
            n_constraints=1,
            distributions=random_vector(DISTRIBUTIONS),
        )

    def simulate(self, design: FloatArray) -> Outcome:
        load, sag, factor = design
        if load > BREAKS:
            raise SimulationError(f'the rail breaks,\nsays "{load:.0f} kN"')
        gap = np.nan if sag < -2.0 else 2.0 * sag
        return Outcome(np.array([load * factor, load]), {"gap": gap, "extra": sag**2}, np.array([sag]))


class Hopeless(Sphere):
    """Always fails."""

    def simulate(self, design: FloatArray) -> Outcome:
        raise ValueError("no way")


PROBLEMS = {"uncertain": Uncertain, "ball": Sphere, "troubled": Troubled, "two": TwoObjectives, "hopeless": Hopeless}


def plugin() -> types.ModuleType:
    """The module of a distribution that has problems for samples."""

    @hookimpl
    def railsearch_problems(register: Callable[[str, Any], None]) -> None:
        for name, problem in PROBLEMS.items():
            register(name, problem)

    made = types.ModuleType("samples")
    vars(made)["railsearch_problems"] = railsearch_problems
    return made
