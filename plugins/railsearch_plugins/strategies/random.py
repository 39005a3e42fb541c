"""Strategy `random`: uniform random designs, the floor of any comparison."""

from collections.abc import Sequence

from railsearch.hookspecs import Register, hookimpl
from railsearch.interfaces import Capabilities, Evaluation, NoParameters, Proposal, SearchContext
from railsearch.sampling import random_designs


class RandomSearch:
    """Proposes designs drawn uniformly from the box, whatever it is told."""

    Parameters = NoParameters
    capabilities = Capabilities(multi_objective=True, integers=True, constraints=True, batch=True)

    def __init__(self, context: SearchContext, parameters: NoParameters) -> None:
        self._context = context

    def ask(self) -> Sequence[Proposal]:
        """As many random designs as may be evaluated at once, origin `random`."""
        designs = random_designs(self._context.space, self._context.batch_size, self._context.generator)
        return [Proposal(design, "random") for design in designs]

    def tell(self, evaluations: Sequence[Evaluation]) -> None:
        """Nothing is learnt from evaluations."""


@hookimpl
def railsearch_strategies(register: Register) -> None:
    """Register `random`."""
    register("random", RandomSearch)
