"""Cheap problems with known behaviour, for tests; importable from other processes."""

import os
import time
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from railsearch.design_problem import DesignProblem
from railsearch.interfaces import Evaluation, Outcome, Quantity
from railsearch.space import FloatArray, Space, Variable

MIXED = Space(
    (
        Variable("stiffness", -5.0, 5.0, "MN/m"),
        Variable("length", -5.0, 5.0, "m"),
        Variable("count", -4, 4, "", integer=True),
        Variable("rows", -4, 4, "", integer=True),
    )
)


class Sphere(DesignProblem):
    """f = Σ (x_i − 1)² over two real and two integer variables; the minimum 0 is at (1, 1, 1, 1)."""

    def __init__(self) -> None:
        super().__init__("sphere", MIXED, [Quantity("distance", "m²", "squared distance")], reference=np.zeros(4))

    def simulate(self, design: FloatArray) -> Outcome:
        return Outcome(np.array([np.sum((design - 1.0) ** 2)]), {"norm": float(np.linalg.norm(design))})


class CountingSphere(Sphere):
    """Writes a line to a file at every true call."""

    def __init__(self, journal: Path) -> None:
        super().__init__()
        self.journal = journal

    def simulate(self, design: FloatArray) -> Outcome:
        with self.journal.open("a") as file:
            file.write(f"{os.getpid()} {design.tolist()}\n")
        return super().simulate(design)

    @property
    def calls(self) -> int:
        return len(self.journal.read_text().splitlines()) if self.journal.exists() else 0


class Troubled(Sphere):
    """Fails by the integer `count`: −4 raises, −3 gives NaN, −2 infinity, −1 the wrong shape, 3 hangs, 4 dies."""

    def simulate(self, design: FloatArray) -> Outcome:
        count = int(design[2])
        if count == -4:
            raise ZeroDivisionError("no ballast")
        if count in (-3, -2):
            return Outcome(np.array([np.nan if count == -3 else np.inf]))
        if count == -1:
            return Outcome(np.array([1.0, 2.0]))
        if count == 3:
            time.sleep(600.0)
        if count == 4:
            os._exit(3)
        return super().simulate(design)


class TwoObjectives(DesignProblem):
    """f = (x², (x − 2)²) plus the squares of the rest; constrained to x ≥ 0.5 when asked for."""

    available_objectives = (Quantity("left", "N"), Quantity("right", "N·m"))

    def __init__(self, constrained: bool = False, worst: Mapping[str, float] | None = None) -> None:
        super().__init__(
            "two",
            MIXED,
            self.available_objectives,
            (Quantity("left", "N"), Quantity("right", "N·m"), Quantity("comfort", "m/s²", maximised=True)),
            reference=np.array([1.5, 1.0, 0.0, 0.0]),
            worst={"left": 50.0, "right": 80.0} if worst is None else worst,
            n_constraints=int(constrained),
        )

    def simulate(self, design: FloatArray) -> Outcome:
        rest = float(np.sum(design[1:] ** 2))
        values = np.array([design[0] ** 2 + rest, (design[0] - 2.0) ** 2 + rest])
        constraints = np.array([0.5 - design[0]]) if self.n_ieq_constr else np.empty(0)
        return Outcome(values, {"left": values[0], "right": values[1], "comfort": -1.0 - rest}, constraints)


def sphere_evaluation(number: int) -> Evaluation:
    """An evaluation of the sphere at a design that depends on the number."""
    design = np.array([0.1 * number, 1.0, number % 4, 0.0])
    outcome = Sphere().simulate(design)
    return Evaluation(number, design, outcome.objectives, outcome.constraints, outcome.metrics, "initial")
