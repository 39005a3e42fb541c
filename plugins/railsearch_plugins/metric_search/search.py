"""Ask and tell of a metric stochastic response surface search."""

import itertools
from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from railsearch.interfaces import Evaluation, Proposal, SearchContext, Surrogate, require_methods
from railsearch.sampling import initial_design, random_designs
from railsearch.space import FloatArray

from .adaptive_model import AdaptiveModel
from .candidates import perturbed
from .merit import select
from .parameters import MetricSearchParameters
from .trajectory import Trajectory
from .tree_search import tree_search

Choose = Callable[[Surrogate, FloatArray, FloatArray], list[int]]
"""Which of the points (t, d) of the unit cube to evaluate next by a surrogate, none near evaluated ones (n, d)."""


class MetricSearch:
    """Initial design, candidates around the incumbent, merit, step size and restarts.

    A strategy says with which probability a coordinate is perturbed, given the trajectory. Every evaluation of the run
    counts for the distance term and is not proposed again; only those since the last restart that did not fail join the
    surrogate.
    Source: Regis and Shoemaker 2007, 2013.
    """

    def __init__(self, context: SearchContext, parameters: MetricSearchParameters) -> None:
        self._context = context
        self._parameters = parameters
        self._weights = itertools.cycle(parameters.weights)
        self._trajectory = Trajectory(0, context.budget, context.space.dimension, parameters)
        self._initial: list[FloatArray] = []
        self._evaluated: dict[bytes, FloatArray] = {}
        self._check_surrogate()
        self._model = self._new_model()

    @property
    def minimum_budget(self) -> int:
        """The size of the initial design: with fewer evaluations there is no search."""
        return self._parameters.initial_size or max(20, 2 * (self._context.space.dimension + 1))

    def ask(self) -> Sequence[Proposal]:
        """Initial designs as long as there are any, then the candidates of lowest merit."""
        return self._next_initial() if self._initial else self._proposals()

    def tell(self, evaluations: Sequence[Evaluation]) -> None:
        """Take in evaluations in their order, asked for or not, failed ones and repeated ones."""
        space = self._context.space
        for evaluation in evaluations:
            key = space.key(evaluation.design)
            repeated = evaluation.repeated or key in self._evaluated
            value = None if evaluation.failed else float(evaluation.objectives[0])
            self._evaluated[key] = evaluation.design
            self._trajectory.record(evaluation.design, space.to_unit(evaluation.design), value, repeated)

    @abstractmethod
    def _probability(self, trajectory: Trajectory) -> float:
        """The probability with which a coordinate is perturbed."""

    def _proposals(self) -> list[Proposal]:
        """Proposals of the search proper; where it cannot begin or go on, new initial designs."""
        trajectory = self._trajectory
        missing = self._initial_size() - trajectory.evaluations
        if not trajectory.searching and missing > 0:
            return self._sample(missing)
        surrogate = self._model.refresh(trajectory.points, trajectory.values)
        if surrogate is None:
            return self._sample(self._context.batch_size)
        if not trajectory.searching:
            trajectory.begin_search()
        proposals = [] if trajectory.step.exhausted else self._search(surrogate)
        return proposals or self._restart()

    def _search(self, surrogate: Surrogate) -> list[Proposal]:
        """The designs to evaluate next; none if all candidates lie too near to evaluated points."""
        return self._best_of(self._perturbations(), surrogate, self._least_merit)

    def _best_of(self, candidates: FloatArray, surrogate: Surrogate, choose: Choose) -> list[Proposal]:
        """What `choose` takes among candidates (t, d) and, with integers, the leaves of a tree search."""
        space, parameters = self._context.space, self._parameters
        n_perturbed = len(candidates)
        if parameters.tree_search and space.integer.any():
            candidates = np.vstack([candidates, self._leaves(surrogate, candidates)])
        evaluated = space.to_unit(np.array(list(self._evaluated.values())))
        chosen = choose(surrogate, space.to_unit(candidates), evaluated)
        origins = ["perturbation" if k < n_perturbed else "tree-search" for k in chosen]
        return [Proposal(candidates[k], origin, self._trajectory.number) for k, origin in zip(chosen, origins, strict=True)]

    def _least_merit(self, surrogate: Surrogate, points: FloatArray, evaluated: FloatArray) -> list[int]:
        """Indices of the points (t, d) of the unit cube of lowest merit, none near evaluated ones (n, d)."""
        weights, batch_size, distance = self._weights, self._context.batch_size, self._parameters.minimum_distance
        return select(points, surrogate.predict(points), evaluated, weights, batch_size, distance)

    def _perturbations(self) -> FloatArray:
        """Perturbations (t, d) of the incumbent."""
        space, trajectory, generator = self._context.space, self._trajectory, self._context.generator
        probability = self._probability(trajectory)
        return perturbed(space, trajectory.incumbent, trajectory.step.sigma, probability, self._candidates, generator)

    @property
    def _candidates(self) -> int:
        """How many candidates a proposal is chosen among."""
        parameters = self._parameters
        return min(parameters.candidates_per_dimension * self._context.space.dimension, parameters.maximum_candidates)

    def _leaves(self, surrogate: Surrogate, candidates: FloatArray) -> FloatArray:
        """The integer designs (k, d) that the tree search meets."""
        pool = np.vstack([self._context.space.to_unit(candidates), self._trajectory.points])
        starts, nodes = self._parameters.tree_search_starts, self._parameters.tree_search_nodes
        return self._context.space.from_unit(tree_search(surrogate, self._context.space, pool, starts, nodes))

    def _restart(self) -> list[Proposal]:
        """Start afresh: earlier points stay out of the surrogate and are not proposed again."""
        left = self._context.budget - len(self._evaluated)
        self._trajectory = Trajectory(self._trajectory.number + 1, left, self._context.space.dimension, self._parameters)
        self._model = self._new_model()
        return self._sample(self._initial_size())

    def _sample(self, count: int) -> list[Proposal]:
        """Lay in initial designs, cut at the budget; if every design has been seen, a random one keeps the run going."""
        space, generator = self._context.space, self._context.initial_generator
        size = max(1, min(count, self._context.budget - len(self._evaluated)))
        avoided = np.array(list(self._evaluated.values())).reshape(-1, space.dimension)
        known = space.from_unit(self._trajectory.points)
        designs = initial_design(space, size, generator, known, avoided)
        self._initial = list(designs if len(designs) else random_designs(space, 1, generator))
        return self._next_initial()

    def _next_initial(self) -> list[Proposal]:
        size = self._context.batch_size
        batch, self._initial = self._initial[:size], self._initial[size:]
        return [Proposal(design, "initial", self._trajectory.number) for design in batch]

    def _initial_size(self) -> int:
        return min(self.minimum_budget, self._trajectory.budget)

    def _check_surrogate(self) -> None:
        """Refuse an unknown surrogate, and one without the gradient that a tree search needs, before any evaluation."""
        surrogate = self._new_surrogate({})
        if self._parameters.tree_search and self._context.space.integer.any():
            remedy = "set tree_search = false, or take a surrogate with a gradient, such as rbf or kriging"
            require_methods(surrogate, self._parameters.surrogate, ["gradient"], "the tree search", remedy)

    def _new_model(self) -> AdaptiveModel:
        """What the surrogate of a trajectory is kept in: here the surrogate of the objective as it is."""
        return AdaptiveModel(self._new_surrogate)

    def _new_surrogate(self, settings: Mapping[str, object]) -> Surrogate:
        return self._context.surrogate(
            self._parameters.surrogate, {**settings, **(self._parameters.surrogate_settings or {})}
        )
