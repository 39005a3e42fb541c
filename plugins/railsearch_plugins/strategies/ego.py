"""Strategy `ego`: efficient global optimisation, Kriging and expected improvement (Jones, Schonlau and Welch 1998).

| symbol | meaning | shape | unit | source |
|---|---|---|---|---|
| x* | best design so far | (d,) | native | |
| EI | expected improvement on the best value | (t,) | of f | Jones et al. 1998 |
| P | probability of success, the mean of 1 and 0 of all evaluations weighted by 1/distance² | (t,) | - | Shepard 1968 |
| σ | standard deviation of a perturbation of x*, σ₀ 2^−k with k = 0 … K | scalars | of the range | own choice |

The largest EI, or EI · P once evaluations have failed, is looked for among random designs and perturbations of x*; the best
of them are polished by EI's gradient with the integers held, and with integers a branch and bound over −log EI joins in. A
batch is made by the Kriging believer (Ginsbourger, Le Riche and Carraro 2010): each design joins the surrogate with its
predicted value before the next is chosen.
"""

from dataclasses import dataclass
from typing import cast

import numpy as np
from scipy.optimize import minimize
from scipy.spatial.distance import cdist

from railsearch.hookspecs import Register, hookimpl
from railsearch.interfaces import (
    Capabilities,
    Proposal,
    SearchContext,
    UncertainSurrogate,
    parameter,
    require_methods,
)
from railsearch.sampling import random_designs
from railsearch.space import FloatArray
from railsearch_plugins.metric_search.believer import believing
from railsearch_plugins.metric_search.candidates import perturbed
from railsearch_plugins.metric_search.parameters import REGULARISED_MEANING, regularised
from railsearch_plugins.metric_search.tree_search import tree_search
from railsearch_plugins.surrogate_search.log_improvement import NegativeLogImprovement
from railsearch_plugins.surrogate_search.models import ResponseModels, surrogate_maker
from railsearch_plugins.surrogate_search.parameters import MultiscaleParameters
from railsearch_plugins.surrogate_search.search import SurrogateSearch, default_initial_size

TOUCHING = 1e-9
"""The least distance in the weights of P."""

POLISHING_ITERATIONS = 30
"""Limit of the quasi-Newton iterations from one start."""


@dataclass(frozen=True)
class EfficientGlobalOptimisationParameters(MultiscaleParameters):
    """What can be set of the search."""

    surrogate: str = parameter(
        "kriging",
        meaning="name of the registered surrogate, one that has a deviation and the gradients of both",
        source="Jones et al. 1998",
    )
    candidates_per_dimension: int = parameter(
        100,
        meaning="candidates per variable, half of them random and half near the best design",
        source="own choice",
        minimum=2,
    )
    surrogate_settings: dict[str, object] | None = parameter(  # noqa: RUF009 - a field, not a value
        None, meaning=f"{REGULARISED_MEANING} if not set"
    )
    perturbed_coordinates: float = parameter(
        3.0,
        meaning="coordinates of the best design perturbed on average, one at least",
        source="own choice",
        above=0.0,
    )
    polished: int = parameter(2, meaning="candidates that are polished by the gradient", source="own choice", minimum=0)
    tree_search_nodes: int = parameter(
        10, meaning="upper limit of the relaxations solved in a branch and bound", source="own choice", minimum=0
    )
    minimum_distance: float = parameter(
        1e-4,
        meaning="nearer than this (unit cube) to an evaluated point nothing is proposed, and nothing joins the surrogate",
        source="own choice: within it a Gaussian process without a nugget is badly determined",
        minimum=1e-5,
        below=1.0,
    )


class EfficientGlobalOptimisation(SurrogateSearch):
    """Proposes where the expected improvement of an uncertain surrogate is largest."""

    Parameters = EfficientGlobalOptimisationParameters
    capabilities = Capabilities(integers=True, batch=True)

    def __init__(self, context: SearchContext, parameters: EfficientGlobalOptimisationParameters) -> None:
        size = parameters.initial_size or default_initial_size(context.space.dimension)
        super().__init__(context, size, parameters.minimum_distance)
        self._parameters = parameters
        settings = regularised(parameters.surrogate, parameters.surrogate_settings)
        make = surrogate_maker(context, parameters.surrogate, settings)
        methods = ("gradient", "deviation", "deviation_gradient")
        require_methods(
            make(), parameters.surrogate, methods, "expected improvement", "choose one that has, such as kriging"
        )
        self._models = ResponseModels([make])

    @property
    def minimum_budget(self) -> int:
        """The size of the initial design: with fewer evaluations there is no search."""
        return self._initial_size

    def _propose(self) -> list[Proposal]:
        """Designs of largest expected improvement; none if the surrogate is not determined, or all is evaluated around."""
        record, space = self._record, self._context.space
        values = np.array([evaluation.objectives for evaluation in record.learnable])
        if not len(values) or not self._models.refresh(record.points, values) or not self._models.surrogates:
            return []
        surrogate = cast(UncertainSurrogate, self._models.surrogates[0])
        incumbent = min(record.successes, key=lambda evaluation: float(evaluation.objectives[0]))
        best, scale = float(incumbent.objectives[0]), float(np.ptp(values)) or 1.0
        evaluated, proposals = space.to_unit(record.designs), list[Proposal]()
        while proposal := self._best(NegativeLogImprovement(surrogate, best, scale), incumbent.design, evaluated):
            proposals.append(proposal)
            if len(proposals) == self._context.batch_size:
                break
            point = space.to_unit(proposal.design)[None, :]
            believed = surrogate.predict(point)
            surrogate = believing(surrogate, point, believed)
            evaluated, best = np.vstack([evaluated, point]), min(best, float(believed[0]))
        return proposals

    def _best(self, improvement: NegativeLogImprovement, incumbent: FloatArray, evaluated: FloatArray) -> Proposal | None:
        """The design of largest expected improvement that is not too near to an evaluated point (n, d)."""
        space = self._context.space
        candidates = self._candidates(incumbent)
        order = np.argsort(self._cost(improvement, space.to_unit(candidates)), kind="stable")
        polished = [self._polished(improvement, candidates[k]) for k in order[: self._parameters.polished]]
        designs = np.vstack([candidates, *polished])
        n_polished = len(designs)
        designs = np.vstack([designs, self._leaves(improvement, designs)])
        points = space.to_unit(designs)
        apart = np.flatnonzero(cdist(points, evaluated).min(axis=1) >= self._parameters.minimum_distance)
        if not len(apart):
            return None
        k = int(apart[np.argmin(self._cost(improvement, points[apart]))])
        return Proposal(designs[k], "expected-improvement" if k < n_polished else "tree-search")

    def _cost(self, improvement: NegativeLogImprovement, points: FloatArray) -> FloatArray:
        """−log(EI · P) at points (t, d), P being the probability that an evaluation does not fail."""
        failures = self._record.failures
        if not failures:
            return improvement.predict(points)
        space, successes = self._context.space, [evaluation.design for evaluation in self._record.successes]
        weights = [
            np.sum(1.0 / np.maximum(cdist(points, space.to_unit(np.array(designs))), TOUCHING) ** 2, axis=1)
            for designs in (successes, failures)
        ]
        probability: FloatArray = weights[0] / (weights[0] + weights[1])
        return improvement.predict(points) - np.log(probability)

    def _candidates(self, incumbent: FloatArray) -> FloatArray:
        """Random designs and perturbations (t, d) of the best design, of every step size as many."""
        space, parameters, generator = self._context.space, self._parameters, self._context.generator
        half = min(parameters.candidates_per_dimension * space.dimension, parameters.maximum_candidates) // 2
        probability = min(parameters.perturbed_coordinates / space.dimension, 1.0)
        share = -(-half // (parameters.sigma_halvings + 1))
        sigmas = parameters.sigma * 0.5 ** np.arange(parameters.sigma_halvings + 1)
        near = [perturbed(space, incumbent, sigma, probability, share, generator) for sigma in sigmas]
        return np.vstack([random_designs(space, half, generator), *near])

    def _polished(self, improvement: NegativeLogImprovement, design: FloatArray) -> FloatArray:
        """The design (1, d) to which the gradient leads from a design (d,), its integers held."""
        space = self._context.space
        start = space.to_unit(design)
        lower, upper = (np.where(space.integer, start, bound) for bound in (0.0, 1.0))

        def value_and_gradient(point: FloatArray) -> tuple[float, FloatArray]:
            row = point[None, :]
            return float(improvement.predict(row)[0]), np.where(space.integer, 0.0, improvement.gradient(row)[0])

        result = minimize(
            value_and_gradient,
            start,
            jac=True,
            method="L-BFGS-B",
            bounds=np.column_stack([lower, upper]),
            options={"maxiter": POLISHING_ITERATIONS},
        )
        return space.from_unit(np.clip(result.x, lower, upper))[None, :]

    def _leaves(self, improvement: NegativeLogImprovement, designs: FloatArray) -> FloatArray:
        """The integer designs (k, d) that a branch and bound meets; none without integers."""
        space, nodes = self._context.space, self._parameters.tree_search_nodes
        if not space.integer.any() or not nodes:
            return np.empty((0, space.dimension))
        return space.from_unit(tree_search(improvement, space, space.to_unit(designs), 1, nodes))


@hookimpl
def railsearch_strategies(register: Register) -> None:
    """Register `ego`."""
    register("ego", EfficientGlobalOptimisation)
