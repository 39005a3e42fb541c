"""Search by expected improvement, and by merit in turn, over perturbations of the incumbent of several kinds."""

import itertools
from collections.abc import Mapping
from dataclasses import dataclass
from typing import cast

import numpy as np
from scipy.spatial.distance import cdist

from railsearch.errors import InputError
from railsearch.interfaces import Proposal, SearchContext, Surrogate, UncertainSurrogate, parameter, require_methods
from railsearch.space import FloatArray

from .adaptive_model import Adaptation, AdaptiveModel
from .believer import believing
from .candidates import perturbation_probability, perturbed, perturbed_reals
from .expected_improvement import expected_improvement
from .merit import merit
from .parameters import DynamicCoordinateParameters
from .search import MetricSearch
from .trajectory import Trajectory
from .transforms import TRANSFORMS

INTERPOLANT = "rbf"
"""The registered surrogate of DYCORS."""

IMPROVEMENT, MERIT = "improvement", "merit"

STEP_SIZES = (2.0, 1.0, 1.0, 0.5, 0.25, 0.125)
"""Standard deviations of mixed perturbations in units of the trajectory's σ, each as likely."""

SMALLEST_FINE_STEP = 0.05
"""The least standard deviation of a fine step in units of the trajectory's σ; the logarithm is uniform from here to σ."""

NEGLIGIBLE = 1e-14
"""Where no expected improvement exceeds this fraction of the spread of the values, the lowest prediction is taken."""


@dataclass(frozen=True)
class AdaptiveSearchParameters(DynamicCoordinateParameters):
    """What can be set of a search by expected improvement among perturbations of the incumbent."""

    cycle: tuple[str, ...] = parameter(
        (IMPROVEMENT,),
        meaning="what designs are chosen by in turn: expected improvement, or merit with the next of the weights",
        source="own choice",
        choices=(IMPROVEMENT, MERIT),
    )
    transforms: tuple[str, ...] = parameter(
        ("identity",),
        meaning="transforms of the objective, chosen among by leave-one-out; the first one to begin with",
        source="own choice",
    )
    adapt_length_scales: bool = parameter(
        False, meaning="adapt the surrogate's length scales by leave-one-out residuals", source="own choice"
    )
    adapt_every: int = parameter(
        10, meaning="evaluations after which transform and length scales are chosen again", source="own choice", minimum=1
    )
    interpolant_from: float = parameter(
        1.0,
        meaning="part of the budget after which every other proposal is dycors': of least merit by the interpolant rbf",
        source="own choice: an interpolant follows a funnel that a smooth process takes for noise",
        minimum=0.0,
        maximum=1.0,
    )
    fine_steps: bool = parameter(
        True,
        meaning="where there are integers, every other proposal by the interpolant moves reals alone, by small steps",
        source="own study of 470 paired runs",
    )
    mixed_perturbations: bool = parameter(
        True,
        meaning="perturb by several step sizes and numbers of coordinates at once; otherwise as dycors",
        source="own choice: expected improvement picks among them",
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in self.transforms:
            if name not in TRANSFORMS:
                raise InputError(f"transforms: unknown '{name}'; there are {', '.join(TRANSFORMS)}")
        if not self.transforms or not self.cycle:
            raise InputError("transforms and cycle: one or more entries are needed, received an empty list")


class AdaptiveSearch(MetricSearch):
    """DYCORS' trajectory, with candidates of several kinds, chosen by expected improvement or by merit in turn.

    In the last part of the budget it takes turns with DYCORS itself, on the same trajectory, and with the same merit
    of designs that differ from the incumbent in the real variables alone: a step of an integer is never small, so that
    without them the real variables would hardly be tuned to the integers that were found.

    A batch is made by the Kriging believer (Ginsbourger, Le Riche and Carraro 2010): each design joins a copy of the
    surrogate with its predicted value before the next is chosen.
    """

    _parameters: AdaptiveSearchParameters

    def __init__(self, context: SearchContext, parameters: AdaptiveSearchParameters) -> None:
        super().__init__(context, parameters)
        self._cycle = itertools.cycle(parameters.cycle)
        self._turn_of_interpolant = itertools.cycle((False, True))
        mixed_variables = bool(context.space.integer.any() and not context.space.integer.all())
        self._turn_of_fine_steps = itertools.cycle((False, parameters.fine_steps and mixed_variables))
        self._p_initial = min(parameters.perturbed_coordinates / context.space.dimension, 1.0)

    def _probability(self, trajectory: Trajectory) -> float:
        n_initial = trajectory.initial_size or 0
        return perturbation_probability(trajectory.evaluations, n_initial, trajectory.budget, self._p_initial)

    def _search(self, surrogate: Surrogate) -> list[Proposal]:
        parameters, trajectory = self._parameters, self._trajectory
        late = len(self._evaluated) >= parameters.interpolant_from * self._context.budget
        if late and next(self._turn_of_interpolant):
            interpolant = AdaptiveModel(self._new_interpolant).refresh(trajectory.points, trajectory.values)
            if interpolant is not None:
                fine = next(self._turn_of_fine_steps)
                candidates = self._fine_perturbations() if fine else self._perturbations()
                return self._best_of(candidates, interpolant, self._least_merit)
        candidates = self._mixed_perturbations() if parameters.mixed_perturbations else self._perturbations()
        return self._best_of(candidates, surrogate, self._most_promising)

    def _fine_perturbations(self) -> FloatArray:
        """Perturbations (t, d) of the incumbent's real variables, of many sizes from σ/20 to σ."""
        space, trajectory, generator = self._context.space, self._trajectory, self._context.generator
        sigma = trajectory.step.sigma * SMALLEST_FINE_STEP ** generator.random(self._candidates)
        return perturbed_reals(space, trajectory.incumbent, sigma, generator)

    def _mixed_perturbations(self) -> FloatArray:
        """Perturbations (t, d) of the incumbent of several step sizes, half of them of p(n) d coordinates on average.

        The rest are of two coordinates on average, and of any number.
        """
        space, trajectory, count = self._context.space, self._trajectory, self._candidates
        dimension, generator = space.dimension, self._context.generator
        probability = np.full(count, self._probability(trajectory))
        quarter = count // 4
        probability[:quarter] = min(2.0 / dimension, 1.0)
        probability[quarter : 2 * quarter] = generator.uniform(1.0 / dimension, 1.0, quarter)
        sigma = trajectory.step.sigma * generator.choice(STEP_SIZES, count)
        return perturbed(space, trajectory.incumbent, sigma, probability, count, generator)

    def _most_promising(self, surrogate: Surrogate, points: FloatArray, evaluated: FloatArray) -> list[int]:
        believer, best = cast(UncertainSurrogate, surrogate), float(np.min(self._model.values))
        spread = float(np.ptp(self._model.values)) or 1.0
        distances = cdist(points, evaluated).min(axis=1)
        chosen: list[int] = []
        while len(chosen) < self._context.batch_size:
            admissible = np.flatnonzero(distances >= self._parameters.minimum_distance)
            if not len(admissible):
                break
            scores = self._scores(believer, points[admissible], distances[admissible], best, spread)
            chosen.append(int(admissible[np.argmin(scores)]))
            point = points[chosen[-1:]]
            distances = np.minimum(distances, cdist(points, point)[:, 0])
            if len(chosen) < self._context.batch_size:
                predicted = believer.predict(point)
                believer, best = believing(believer, point, predicted), min(best, float(predicted[0]))
        return chosen

    def _scores(
        self, surrogate: UncertainSurrogate, points: FloatArray, distances: FloatArray, best: float, spread: float
    ) -> FloatArray:
        """What is minimised next, at points (t, d): the merit, or minus the expected improvement."""
        values, entry = surrogate.predict(points), next(self._cycle)
        if entry == MERIT:
            return merit(values, distances, next(self._weights))
        improvement = expected_improvement(values, surrogate.deviation(points), best)
        return values if improvement.max() <= NEGLIGIBLE * spread else -improvement

    def _new_model(self) -> AdaptiveModel:
        parameters = self._parameters
        adaptation = Adaptation(parameters.transforms, parameters.adapt_length_scales, parameters.adapt_every)
        return AdaptiveModel(self._new_surrogate, adaptation, self._context.generator)

    def _new_interpolant(self, settings: Mapping[str, object]) -> Surrogate:
        return self._context.surrogate(INTERPOLANT, settings)

    def _check_surrogate(self) -> None:
        super()._check_surrogate()
        needed = ["deviation"] + ["leave_one_out_residuals"] * (len(self._parameters.transforms) > 1)
        remedy = "take a surrogate that has them, such as rbf or kriging"
        require_methods(self._new_surrogate({}), self._parameters.surrogate, needed, "expected improvement", remedy)
