"""Strategy `hypervolume-improvement`: one surrogate per objective, designs by the hypervolume they are predicted to add.

| symbol | meaning | shape | unit | source |
|---|---|---|---|---|
| x | designs of the front found so far | (p, d) | native | |
| p(n) | probability with which a coordinate of such a design is perturbed | scalar | - | Regis and Shoemaker 2013 |
| σ | standard deviation of a perturbation, σ₀ 2^−k with k drawn from 0 … K | scalar | of the range | own choice |
| ΔHV | predicted or expected hypervolume gain of a candidate | (t,) | - | Emmerich et al. 2006, 2011 |
| u | merit, w of the gain and 1 − w of the distance to evaluated points | (t,) | - | Regis and Shoemaker 2007 |

Candidates are perturbations of the front's designs and the designs of an NSGA-II on the surrogates, as in GOMORS (Akhtar and
Shoemaker 2016); the choice by hypervolume is that of SMS-EGO and of expected hypervolume improvement (Ponweiser et al. 2008;
Emmerich et al. 2011). A front that hardly grows any more is taken for a local one: the search starts afresh, as DYCORS does.
"""

import itertools
from dataclasses import dataclass

import numpy as np

from railsearch.errors import InputError
from railsearch.hookspecs import Register, hookimpl
from railsearch.interfaces import Capabilities, Evaluation, Proposal, SearchContext, parameter, require_methods
from railsearch.space import FloatArray
from railsearch_plugins.metric_search.candidates import perturbation_probability, perturbed
from railsearch_plugins.surrogate_search.evolution import Evolution, evolved
from railsearch_plugins.surrogate_search.front import Candidates, Front, best_of, front_of, recent_gain, select_by_gain
from railsearch_plugins.surrogate_search.models import ResponseModels, surrogate_maker
from railsearch_plugins.surrogate_search.parameters import MultiscaleParameters
from railsearch_plugins.surrogate_search.search import SurrogateSearch, default_initial_size


@dataclass(frozen=True)
class HypervolumeImprovementParameters(MultiscaleParameters):
    """What can be set of the search."""

    surrogate: str = parameter(
        "rbf", meaning="name of the registered surrogate of every objective", source="Akhtar & Shoemaker 2016"
    )
    gain: str = parameter(
        "predicted",
        meaning="hypervolume gain of the prediction itself, or expected gain, for which the surrogate needs a deviation",
        source="Ponweiser et al. 2008; Emmerich et al. 2011",
        choices=("predicted", "expected"),
    )
    weights: tuple[float, ...] = parameter(
        (1.0, 0.8),
        meaning="cycle of the weight of the gain among candidates that gain; the rest is the weight of the distance",
        source="own choice",
        minimum=0.0,
        maximum=1.0,
    )
    reference_margin: float = parameter(
        0.1,
        meaning="how far the reference point lies beyond the front, found or predicted, in parts of its ranges",
        source="Ishibuchi et al. 2018",
        above=0.0,
    )
    parents: int = parameter(
        10, meaning="designs of the front that are perturbed for a proposal", source="own choice", minimum=1
    )
    candidates_per_dimension: int = parameter(
        100, meaning="perturbations per variable", source="Regis & Shoemaker 2013", minimum=1
    )
    perturbed_coordinates: float = parameter(
        20.0,
        meaning="coordinates perturbed on average at first: p0 = min(perturbed_coordinates / d, 1)",
        source="Regis & Shoemaker 2013",
        above=0.0,
    )
    evolution_interval: int = parameter(
        5, meaning="evaluations after which NSGA-II goes on from its last population", source="own choice", minimum=1
    )
    evolution_generations: int = parameter(20, meaning="generations for which it does", source="own choice", minimum=1)
    evolution_size: int = parameter(40, meaning="designs of its population", source="own choice", minimum=2)
    restart_after: int = parameter(
        40,
        meaning="the search starts afresh, earlier designs left out of its surrogates, after so many that gain too little",
        source="own choice",
        minimum=1,
    )
    restart_gain: float = parameter(
        5e-3,
        meaning="what they must gain together, as a part of the hypervolume of the front since the last start",
        source="own choice",
        minimum=0.0,
        below=1.0,
    )
    minimum_distance: float = parameter(
        1e-3,
        meaning="nearer than this (unit cube) to an evaluated point nothing is proposed, and nothing joins the surrogates",
        source="own choice: within it the interpolant stays well determined",
        minimum=1e-5,
        below=1.0,
    )

    def __post_init__(self) -> None:
        if not self.weights:
            raise InputError("weights: one or more numbers from 0 to 1 are needed, received an empty list")


class HypervolumeImprovementSearch(SurrogateSearch):
    """Multi-objective surrogate search without scalarising; with one objective, the gain is the improvement."""

    Parameters = HypervolumeImprovementParameters
    capabilities = Capabilities(multi_objective=True, integers=True, batch=True)

    def __init__(self, context: SearchContext, parameters: HypervolumeImprovementParameters) -> None:
        size = parameters.initial_size or default_initial_size(context.space.dimension)
        super().__init__(context, size, parameters.minimum_distance)
        self._parameters = parameters
        make = surrogate_maker(context, parameters.surrogate, parameters.surrogate_settings)
        if parameters.gain == "expected":
            remedy = "choose one that has, such as kriging"
            require_methods(make(), parameters.surrogate, ("deviation",), "expected improvement", remedy)
        self._make = make
        self._weights = itertools.cycle(parameters.weights)
        self._begin()

    @property
    def minimum_budget(self) -> int:
        """The size of the initial design: with fewer evaluations there is no search."""
        return self._initial_size

    def _propose(self) -> list[Proposal]:
        """The candidates that gain most; none if they all lie too near to evaluated points, or nothing could be fitted."""
        record, space, parameters = self._record, self._context.space, self._parameters
        learnable = record.learnable[self._learnable_before :]
        values = np.array([evaluation.objectives for evaluation in learnable])
        if not len(values) or not self._models.refresh(record.points[self._learnable_before :], values):
            return []
        promising = self._promising()
        front = front_of(self._successes, self._predicted(promising))
        if self._stagnates(front):
            return self._restart()
        designs = np.vstack([self._perturbations(front), promising])
        n_perturbed = len(designs) - len(promising)
        points = space.to_unit(designs)
        chosen = select_by_gain(
            self._candidates(points),
            front,
            space.to_unit(record.designs),
            self._weights,
            self._context.batch_size,
            parameters.minimum_distance,
            parameters.reference_margin,
        )
        origins = ["perturbation" if k < n_perturbed else "evolution" for k in chosen]
        return [Proposal(designs[k], origin, self._trajectory) for k, origin in zip(chosen, origins, strict=True)]

    @property
    def _successes(self) -> list[Evaluation]:
        """The successful evaluations since the last start."""
        return self._record.successes[self._successes_before :]

    def _begin(self) -> None:
        """Forget what has been learnt; what has been evaluated is not proposed again."""
        self._models = ResponseModels([self._make] * self._context.n_objectives)
        self._population = np.empty((0, self._context.space.dimension))
        self._evolved_at = -np.inf
        self._begun_at = len(self._record.seen)
        self._learnable_before, self._successes_before = len(self._record.learnable), len(self._record.successes)

    def _stagnates(self, front: Front) -> bool:
        """Whether the last designs of the search have gained too little, and the budget allows for another one."""
        parameters, n = self._parameters, len(self._record.seen)
        searched = n - self._begun_at - self._initial_size
        if searched < parameters.restart_after or self._context.budget - n < 2 * self._initial_size:
            return False
        gain = recent_gain(self._successes, front, parameters.restart_after, parameters.reference_margin)
        return gain < parameters.restart_gain

    def _restart(self) -> list[Proposal]:
        """Start afresh with another initial design."""
        self._trajectory += 1
        self._begin()
        self._initial = self._sampled(self._initial_size)
        return self._next_initial()

    def _candidates(self, points: FloatArray) -> Candidates:
        expected = self._parameters.gain == "expected"
        return Candidates(points, self._models.predict(points), self._models.deviation(points) if expected else None)

    def _perturbations(self, front: Front) -> FloatArray:
        """Perturbations (t, d) of designs of the front drawn with replacement, each with a step size of its own."""
        context, parameters = self._context, self._parameters
        dimension, generator = context.space.dimension, context.generator
        total = min(parameters.candidates_per_dimension * dimension, parameters.maximum_candidates)
        n = len(self._record.seen) - self._begun_at
        p_initial = min(parameters.perturbed_coordinates / dimension, 1.0)
        n_initial, left = min(self._initial_size, n), context.budget - self._begun_at
        probability = perturbation_probability(n, n_initial, left, p_initial)
        parents = generator.integers(len(front.designs), size=parameters.parents)
        sigmas = parameters.sigma * 0.5 ** generator.integers(parameters.sigma_halvings + 1, size=parameters.parents)
        share = -(-total // parameters.parents)
        return np.vstack(
            [
                perturbed(context.space, front.designs[parent], sigma, probability, share, generator)
                for parent, sigma in zip(parents, sigmas, strict=True)
            ]
        )

    def _promising(self) -> FloatArray:
        """The last population (k, d) of an NSGA-II on the surrogates, which goes on with every few evaluations."""
        space, parameters, n = self._context.space, self._parameters, len(self._record.seen)
        if n - self._evolved_at >= parameters.evolution_interval:
            best = [evaluation.design for evaluation in best_of(self._successes)]
            first = np.unique(np.vstack([*best, self._population]), axis=0)
            evolution = Evolution(parameters.evolution_size, parameters.evolution_generations, parameters.minimum_distance)
            self._population = evolved(space, self._predicted, first, evolution, self._context.generator)
            self._evolved_at = n
        return self._population

    def _predicted(self, designs: FloatArray) -> FloatArray:
        return self._models.predict(self._context.space.to_unit(designs))


@hookimpl
def railsearch_strategies(register: Register) -> None:
    """Register `hypervolume-improvement`."""
    register("hypervolume-improvement", HypervolumeImprovementSearch)
