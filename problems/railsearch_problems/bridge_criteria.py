"""What the problems on a train-track-bridge system share: criteria, what is recorded beside them, passages."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from railsearch.design_problem import DesignProblem
from railsearch.errors import InputError
from railsearch.interfaces import Outcome, Quantity, TrackModel, passage_figures
from railsearch.space import FloatArray
from railsearch_problems.crossing_designs import check_corners, chosen_objectives

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TRACK_MODEL = "train-track-bridge"
CRITERIA: Sequence[Quantity] = (
    Quantity("W_z", "", "Sperling index of the carbody accelerations, largest over the vehicles"),
    Quantity("U_r", "m", "largest downward displacement of the rail"),
    Quantity("A_s", "m/s²", "largest vertical acceleration of a sleeper"),
    Quantity("U_d", "m", "largest downward deflection of the deck in the middle of its span"),
)
FURTHER: Sequence[Quantity] = (
    Quantity("carbody_acceleration_max", "m/s²", "largest acceleration at the centre of a carbody"),
    Quantity("contact_force_max", "N", "largest force under a wheel on the bridge"),
    Quantity("contact_force_min", "N", "smallest force under a wheel on the bridge", maximised=True),
    Quantity("bridge_acceleration_max", "m/s²", "largest vertical acceleration of the bridge"),
)


class BridgeProblem(DesignProblem):
    """A problem whose variables are parameters of the track model; a subclass sets the model and the track's parameters."""

    available_objectives: ClassVar[Sequence[Quantity]] = CRITERIA
    model: TrackModel
    track: Any

    def warm_up(self) -> None:
        """Warm the track model up."""
        self.model.warm_up()

    def check(self) -> None:
        """Raise InputError if a passage cannot be simulated with all lower or all upper bounds."""
        check_corners(self.model, self.space, self.parameters)

    def parameters(self, design: FloatArray) -> Any:
        """The track model's parameters with those of a design (d,)."""
        return dataclasses.replace(self.track, **dict(zip(self.space.names, map(float, design), strict=True)))

    def simulate(self, design: FloatArray) -> Outcome:
        """One passage with a design (d,); maximised quantities are negated."""
        measured = self.model.simulate(self.parameters(design)).metrics
        return Outcome(
            np.array([objective.sign * measured[objective.name] for objective in self.objectives]),
            {metric.name: float(metric.sign * measured[metric.name]) for metric in self.metrics},
        )

    def figures(self, designs: Mapping[str, FloatArray]) -> Mapping[str, Figure]:
        """The track model's pictures of labelled designs."""
        return passage_figures(self.model, {label: self.parameters(design) for label, design in designs.items()})


def extremes(quantities: Sequence[Quantity], largest: bool) -> list[Quantity]:
    """Quantities with what is worst for the track as what is wanted, or, unless `largest`, what is best."""
    return [dataclasses.replace(quantity, maximised=quantity.maximised != largest) for quantity in quantities]


def chosen_criteria(names: Sequence[str], maximised: bool = False) -> list[Quantity]:
    """The criteria of these names, to be minimised or maximised. Raises InputError for an unknown or repeated name."""
    return [dataclasses.replace(criterion, maximised=maximised) for criterion in chosen_objectives(CRITERIA, names)]


def reference_values(track: Any, names: Sequence[str], lower: FloatArray, upper: FloatArray) -> FloatArray:
    """The track's own values (d,) of variables. Raises InputError for one outside the variable's range."""
    values = np.array([float(getattr(track, name)) for name in names])
    for name, value, low, high in zip(names, values, lower, upper, strict=True):
        if not low <= value <= high:
            raise InputError(
                f"track.{name}: {value:g} is the reference of a variable whose range is {low:g} to {high:g}; "
                "change one of them"
            )
    return values
