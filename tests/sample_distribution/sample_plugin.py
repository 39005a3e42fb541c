"""A problem that keeps a journal of its true calls and can hang or die, and a strategy that breaks; for worker processes."""

import os
import time
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from railsearch.design_problem import DesignProblem
from railsearch.hookspecs import hookimpl
from railsearch.interfaces import Capabilities, NoParameters, Outcome, Proposal, Quantity, Space, Variable, parameter


@dataclass(frozen=True)
class Behaviour:
    """What the problem does besides adding squares."""

    journal: str = parameter("", meaning="file that gets a line for every true call")
    seconds: float = parameter(0.0, unit="s", meaning="how long a call lasts", minimum=0.0)
    fault: str = parameter(
        "", meaning="hang (where a > 2 m), die or warn where count is 4", choices=("", "hang", "die", "warn")
    )


class Journalled(DesignProblem):
    """f = Σ (x_i − 1)² over three real variables and one integer."""

    def __init__(self, behaviour: Behaviour) -> None:
        variables = [Variable(name, -5.0, 5.0, "m") for name in ("a", "b", "c")]
        super().__init__(
            "journalled",
            Space((*variables, Variable("count", -4, 4, integer=True))),
            [Quantity("distance", "m²")],
            [Quantity("norm", "m")],
            reference=np.zeros(4),
        )
        self.behaviour = behaviour

    @classmethod
    def sections(cls, host: Any) -> Mapping[str, object]:
        return {"behaviour": Behaviour()}

    @classmethod
    def make(cls, host: Any, objectives: Sequence[str], sections: Mapping[str, Any]) -> "Journalled":
        return cls(sections["behaviour"])

    def simulate(self, design: np.ndarray) -> Outcome:
        if self.behaviour.journal:
            with Path(self.behaviour.journal).open("a") as file:
                file.write(f"{os.getpid()} {design.tolist()}\n")
        if design[3] == 4 and design[0] > 2.0 and self.behaviour.fault == "hang":
            time.sleep(3600.0)
        if design[3] == 4 and self.behaviour.fault == "die":
            os._exit(9)
        if design[3] == 4 and self.behaviour.fault == "warn":
            warnings.warn(f"count is {design[3]:g}", stacklevel=1)
        time.sleep(self.behaviour.seconds)
        return Outcome(np.array([np.sum((design - 1.0) ** 2)]), {"norm": float(np.linalg.norm(design))})


class Breaking:
    """Random designs, until it breaks at its tenth."""

    Parameters = NoParameters
    capabilities = Capabilities(integers=True)

    def __init__(self, context: Any, parameters: Any) -> None:
        self._context = context
        self._asked = 0

    def ask(self) -> list[Proposal]:
        self._asked += 1
        if self._asked == 10:
            raise ZeroDivisionError("the tenth is one too many")
        point = self._context.generator.random(self._context.space.dimension)
        return [Proposal(self._context.space.from_unit(point), "random")]

    def tell(self, evaluations: Any) -> None:
        pass


@hookimpl
def railsearch_problems(register: Any) -> None:
    register("journalled", Journalled)


@hookimpl
def railsearch_strategies(register: Any) -> None:
    register("breaking", Breaking)
