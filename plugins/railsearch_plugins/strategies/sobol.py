"""Strategy `sobol`: a scrambled Sobol' sequence, the floor that a space-filling design sets (Sobol' 1967; Owen 1998)."""

from collections.abc import Sequence
from typing import Any

from railsearch.hookspecs import Register, hookimpl
from railsearch.interfaces import Capabilities, Evaluation, NoParameters, Proposal, SearchContext
from railsearch.sampling import designs_of_cells, random_designs, unseen_design
from railsearch.space import FloatArray

SKIPPED_IN_A_ROW = 100
"""Points in a row at designs evaluated before after which a random unseen design is proposed."""


class SobolSearch:
    """Proposes the points of a scrambled Sobol' sequence one after another; every value of an integer has an equal cell.

    Points whose design has been proposed or evaluated before are skipped.
    """

    Parameters = NoParameters
    capabilities = Capabilities(multi_objective=True, integers=True, constraints=True, batch=True)

    def __init__(self, context: SearchContext, parameters: NoParameters) -> None:
        self._context = context
        self._sequence: Any = None
        self._seen: set[bytes] = set()

    def ask(self) -> Sequence[Proposal]:
        """As many designs as may be evaluated at once, origin `sobol`."""
        return [self._next() for _ in range(self._context.batch_size)]

    def tell(self, evaluations: Sequence[Evaluation]) -> None:
        """Only which designs have been evaluated is of interest."""
        self._seen |= {self._context.space.key(evaluation.design) for evaluation in evaluations}

    def _next(self) -> Proposal:
        space, generator = self._context.space, self._context.generator
        for _ in range(SKIPPED_IN_A_ROW):
            design: FloatArray = designs_of_cells(space, self._point())[0]
            if space.key(design) not in self._seen:
                return self._proposal(design, "sobol")
        unseen = unseen_design(space, self._seen, generator)
        return self._proposal(random_designs(space, 1, generator)[0] if unseen is None else unseen, "random")

    def _point(self) -> FloatArray:
        """The next point (1, d) of the sequence."""
        from scipy.stats.qmc import Sobol

        if self._sequence is None:
            self._sequence = Sobol(self._context.space.dimension, rng=self._context.generator)
        point: FloatArray = self._sequence.random(1)
        return point

    def _proposal(self, design: FloatArray, origin: str) -> Proposal:
        self._seen.add(self._context.space.key(design))
        return Proposal(design, origin)


@hookimpl
def railsearch_strategies(register: Register) -> None:
    """Register `sobol`."""
    register("sobol", SobolSearch)
