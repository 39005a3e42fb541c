"""Algorithms that work in generations, asked and told design by design.

| symbol | meaning | shape |
|---|---|---|
| n | designs of a generation | scalar |
| d | variables | scalar |
| m | objectives, to be minimised | scalar |
| k | constraints of the problem, ≤ 0 | scalar |
| X | designs of a generation, in native units | (n, d) |
| F | their objectives; for a failed evaluation the worst values seen | (n, m) |
| G | their constraints; the last one is 1 for a failed evaluation and 0 for the others | (n, k + 1) |
"""

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from railsearch.interfaces import Evaluation, Proposal, SearchContext
from railsearch.sampling import random_designs, unseen_design
from railsearch.space import FloatArray

IDLE_GENERATIONS = 20
"""Generations in a row without a single unseen design after which a random unseen one is proposed."""


class Generations(Protocol):
    """An algorithm that hands out a generation at a time and never ends; one that ends starts afresh.

    origin: how the designs of the present generation came about, in a word; trajectory: how often it started afresh.
    """

    origin: str
    trajectory: int

    def first(self, known: FloatArray) -> FloatArray:
        """The first generation X (n, d), which begins with designs `known` (j, d) that have been evaluated."""

    def advance(self, designs: FloatArray, objectives: FloatArray, constraints: FloatArray) -> FloatArray:
        """The generation X (n, d) that follows from X, F and G of the present one.

        `designs` are the present generation, save where another design was evaluated in place of one that was proposed.
        """


class GenerationalStrategy:
    """Ask and tell, design by design, for an algorithm that works in generations.

    Designs told before the first ask join the first generation; a design evaluated before is not proposed again, its values
    are handed on. Failed evaluations count as infeasible, with the worst values seen. Batches never reach into the next
    generation, so that their size changes nothing but the last designs of a budget.
    """

    def __init__(self, context: SearchContext, generations: Generations) -> None:
        self._context = context
        self._generations = generations
        self._told: dict[bytes, Evaluation] = {}
        self._asked: list[int] = []
        self._designs: FloatArray | None = None

    def ask(self) -> Sequence[Proposal]:
        """Designs of the present generation that have not been evaluated."""
        if self._designs is None:
            known = [evaluation.design for evaluation in self._told.values()]
            self._designs = self._generations.first(np.array(known).reshape(-1, self._context.space.dimension))
        for _ in range(IDLE_GENERATIONS):
            self._asked = self._open_places(self._designs)[: self._context.batch_size]
            if self._asked:
                return [self._proposal(self._designs[row]) for row in self._asked]
            self._designs = self._generations.advance(self._designs, *self._values(self._designs))
        return [self._random_proposal()]

    def tell(self, evaluations: Sequence[Evaluation]) -> None:
        """Take in evaluations; one of a design not asked for takes the place of a proposal that was not answered."""
        key = self._context.space.key
        designs = np.empty((0, self._context.space.dimension)) if self._designs is None else self._designs
        asked = {key(designs[row]) for row in self._asked}
        strangers = [evaluation.design for evaluation in evaluations if key(evaluation.design) not in asked]
        self._told |= {key(evaluation.design): evaluation for evaluation in evaluations}
        open_places = [row for row in self._asked if key(designs[row]) not in self._told]
        for row, design in zip(open_places, strangers, strict=False):
            designs[row] = design
        self._asked = []

    def _open_places(self, designs: FloatArray) -> list[int]:
        """The rows of different designs that have not been evaluated."""
        rows: dict[bytes, int] = {}
        for row, design in enumerate(designs):
            rows.setdefault(self._context.space.key(design), row)
        return [row for key, row in rows.items() if key not in self._told]

    def _values(self, designs: FloatArray) -> tuple[FloatArray, FloatArray]:
        """F (n, m) and G (n, k + 1) of a generation that has been evaluated."""
        successes = [evaluation for evaluation in self._told.values() if not evaluation.failed]
        worst = np.zeros(self._context.n_objectives)
        worst_constraints = np.zeros(self._context.n_constraints)
        if successes:
            worst = np.max([success.objectives for success in successes], axis=0)
            worst_constraints = np.max([success.constraints for success in successes], axis=0, initial=0.0)
        evaluations = [self._told[self._context.space.key(design)] for design in designs]
        failed = np.array([evaluation.failed for evaluation in evaluations])
        objectives = [worst if e.failed else e.objectives for e in evaluations]
        constraints = [worst_constraints if e.failed else e.constraints for e in evaluations]
        return np.array(objectives), np.column_stack([np.array(constraints), np.where(failed, 1.0, 0.0)])

    def _proposal(self, design: FloatArray) -> Proposal:
        return Proposal(design.copy(), self._generations.origin, self._generations.trajectory)

    def _random_proposal(self) -> Proposal:
        space, generator = self._context.space, self._context.generator
        design = unseen_design(space, set(self._told), generator)
        chosen = random_designs(space, 1, generator)[0] if design is None else design
        return Proposal(chosen, "random", self._generations.trajectory)
