"""What is asked of the model itself beside a surrogate: whether extremes are what the surrogate says, classical measures."""

from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from typing import Any

import numpy as np

from railsearch.design_problem import DesignProblem
from railsearch.interfaces import Outcome, Quantity
from railsearch.samples import Samples
from railsearch.sensitivity.extremes import SENSES, ExtremeSurfaces
from railsearch.sensitivity.models import natural_value
from railsearch.sensitivity.screening import ElementaryEffects, effects_along
from railsearch.sensitivity.variance_based import SobolIndices, indices_of_blocks
from railsearch.simulation import Simulators
from railsearch.space import FloatArray, Space


@dataclass(frozen=True)
class ConfirmedExtreme:
    """An extreme of a surrogate, the point (d,) where it has it, and the model's value there, or why there is none."""

    found: float
    point: FloatArray
    simulated: float | str

    def document(self, names: Sequence[str]) -> dict[str, Any]:
        """Plain types, ready for JSON."""
        known = isinstance(self.simulated, float)
        return {
            "surrogate": self.found,
            "model": self.simulated if known else None,
            "reason": None if known else self.simulated,
            "point": dict(zip(names, map(float, self.point), strict=True)),
        }


@dataclass(frozen=True)
class ModelSamples:
    """The model at the points of Saltelli's blocks, and along Morris' trajectories."""

    blocks: Samples
    trajectories: Samples


@dataclass(frozen=True)
class ModelMeasures:
    """Classical measures on the model itself."""

    sobol: SobolIndices
    morris: ElementaryEffects

    def document(self) -> dict[str, Any]:
        """Plain types, ready for JSON."""
        return {"sobol": self.sobol.document(), "morris": self.morris.document()}


def confirmed_extremes(
    problem: DesignProblem, found: Mapping[Quantity, ExtremeSurfaces], simulating: Simulators
) -> dict[str, dict[str, ConfirmedExtreme]]:
    """Simulate where each surrogate has its largest and smallest value; by name of the output and sense.

    Whole numbers are the nearest ones. An evaluation that fails is a reason in place of a value.
    """
    wanted = [(quantity, sense, *_extreme(surfaces, sense)) for quantity, surfaces in found.items() for sense in SENSES]
    confirmed: dict[str, dict[str, ConfirmedExtreme]] = {quantity.name: {} for quantity in found}
    points = [problem.space.rounded(point) for *_, point in wanted]
    with closing(simulating):
        for place, simulated in simulating.simulate(points):
            (quantity, sense, value, _), point = wanted[place], points[place]
            outcome = simulated.outcome
            known = natural_value(problem, quantity, point, outcome) if isinstance(outcome, Outcome) else outcome
            confirmed[quantity.name][sense] = ConfirmedExtreme(value, point, known)
    return confirmed


def model_measures(name: str, space: Space, samples: ModelSamples, generator: np.random.Generator) -> ModelMeasures:
    """Sobol' indices and elementary effects of an output from samples of the model.

    Raises InputError and SimulationError as `sobol_indices` and `elementary_effects`.
    """
    sobol = indices_of_blocks(space.names, samples.blocks.output(name), generator)
    points = samples.trajectories.input_matrix(space.names)
    return ModelMeasures(sobol, effects_along(space, points, samples.trajectories.output(name), generator))


def _extreme(surfaces: ExtremeSurfaces, sense: str) -> tuple[float, FloatArray]:
    """The extreme of all curves and where it is attained."""
    curves = surfaces.curves[sense]
    values = np.concatenate([curve.values for curve in curves])
    points = np.concatenate([curve.points for curve in curves])
    place = int(np.nanargmin(values) if sense == SENSES[1] else np.nanargmax(values))
    return float(values[place]), points[place]
