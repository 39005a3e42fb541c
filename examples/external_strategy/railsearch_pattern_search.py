"""Pattern search: step along one coordinate at a time, halve the step when stuck (Hooke & Jeeves 1961)."""

from dataclasses import dataclass

import numpy as np

from railsearch.hookspecs import hookimpl
from railsearch.interfaces import Capabilities, Proposal, parameter


@dataclass(frozen=True)
class Parameters:
    """What can be set."""

    step: float = parameter(0.25, meaning="first step", unit="of the range", source="chosen", above=0.0, maximum=1.0)


class PatternSearch:
    """Steps along one coordinate at a time and halves the step when no direction is better."""

    Parameters = Parameters
    capabilities = Capabilities(integers=True)

    def __init__(self, context, parameters):
        self.context, self.step = context, parameters.step
        self.best, self.value, self.moves = None, np.inf, []

    def ask(self):
        """Propose the next step."""
        space = self.context.space
        if self.best is None:
            return [Proposal(space.from_unit(self.context.generator.random(space.dimension)), "initial")]
        if not self.moves:
            self.moves = [sign * row for row in np.eye(space.dimension) for sign in (1.0, -1.0)]
            self.context.generator.shuffle(self.moves)
            self.step = max(self.step / 2.0, 1e-6)
        move = self.step * self.moves.pop()
        smallest = np.where(space.integer, 1.0 / (space.upper - space.lower), 0.0)
        move = np.sign(move) * np.maximum(np.abs(move), smallest * (move != 0.0))
        return [Proposal(space.from_unit(np.clip(space.to_unit(self.best) + move, 0.0, 1.0)), "pattern")]

    def tell(self, evaluations):
        """Move to a better design."""
        for evaluation in evaluations:
            if not evaluation.failed and evaluation.objectives[0] < self.value:
                self.best, self.value = evaluation.design, evaluation.objectives[0]
                self.moves, self.step = [], 2.0 * self.step


@hookimpl
def railsearch_strategies(register):
    """Register the strategy."""
    register("pattern-search", PatternSearch)
