"""Ask and tell around a surrogate: the initial design first, then what a strategy makes of its surrogates."""

from abc import abstractmethod
from collections.abc import Sequence

from railsearch.interfaces import Evaluation, Proposal, SearchContext
from railsearch.sampling import initial_design, random_designs
from railsearch.space import FloatArray

from .record import EvaluationRecord


class SurrogateSearch:
    """An initial design of `initial_size` evaluations, the given ones among them, then proposals of the subclass.

    Where the subclass has nothing to propose, because its surrogates are not determined or everything near has been
    evaluated, random designs not seen before keep the run going.
    """

    def __init__(self, context: SearchContext, initial_size: int, minimum_distance: float) -> None:
        self._context = context
        self._record = EvaluationRecord(context.space, minimum_distance)
        self._initial_size = initial_size
        self._initial: list[FloatArray] = []
        self._trajectory = 0

    def ask(self) -> Sequence[Proposal]:
        """Initial designs as long as there are any, then those of the search proper."""
        missing = min(self._initial_size, self._context.budget) - len(self._record.seen)
        if not self._initial and missing > 0:
            self._initial = self._sampled(missing)
        if self._initial:
            return self._next_initial()
        return self._propose() or [
            Proposal(design, "random", self._trajectory) for design in self._sampled(self._context.batch_size)
        ]

    def tell(self, evaluations: Sequence[Evaluation]) -> None:
        """Take in evaluations in their order, asked for or not, failed ones and repeated ones."""
        self._record.add(evaluations)

    @abstractmethod
    def _propose(self) -> list[Proposal]:
        """Up to a batch of designs that have not been evaluated; an empty list if there is no telling."""

    def _next_initial(self) -> list[Proposal]:
        size = self._context.batch_size
        batch, self._initial = self._initial[:size], self._initial[size:]
        return [Proposal(design, "initial", self._trajectory) for design in batch]

    def _sampled(self, count: int) -> list[FloatArray]:
        """Designs of a symmetric Latin hypercube, none of them seen; a random one if every design has been seen."""
        space, generator = self._context.space, self._context.initial_generator
        size = max(1, min(count, self._context.budget - len(self._record.seen)))
        known = space.from_unit(self._record.points)
        designs = initial_design(space, size, generator, known, self._record.designs)
        return list(designs if len(designs) else random_designs(space, 1, generator))


def default_initial_size(dimension: int) -> int:
    """The size max(20, 2(d + 1)) of an initial design. Source: level-crossing study, Shang et al. 2023."""
    return max(20, 2 * (dimension + 1))
