"""Design problem A: the transition zones of a level crossing, tuned for wheel-rail force and ballast damage.

Source, of the reference design too: Shang, Nogal, Teixeira & Wolfert, Engineering Structures 282 (2023) 115740.

| symbol | meaning | unit |
|---|---|---|
| xr1, xr2, xr3 | stiffness of the three railpads next to the crossing; xr3 is adjacent to it | MN/m |
| xn | strengthened sleepers, counted from the crossing | - |
| xs1, xs2, xs3 | sleeper distances next to the crossing; xs3 is from the interface to the first sleeper | 0.1 m |
| xl | Type II strip in the crossing, from its approach side | 0.1 m |
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from railsearch.design_problem import DesignProblem
from railsearch.errors import InputError
from railsearch.hookspecs import hookimpl
from railsearch.interfaces import Host, Outcome, Quantity, TrackModel, passage_figures
from railsearch.parameters import parameter
from railsearch.space import FloatArray
from railsearch_problems.crossing_designs import (
    MEGA,
    PAD_MEANINGS,
    PUBLISHED,
    STRENGTHENED_MEANINGS,
    STRIP_MEANING,
    TRACK_MODEL,
    PadBounds,
    StrengthenedBounds,
    bounded_space,
    check_corners,
    chosen_objectives,
    three_pads,
    whole_steps,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

STEPS_PER_METRE = 10.0
PADS, STRENGTHENED = PadBounds(), StrengthenedBounds()


@dataclass(frozen=True)
class DistanceBounds:
    """Range of a sleeper distance."""

    lower: int = parameter(3, unit="0.1 m", meaning="shortest sleeper distance", source=PUBLISHED, minimum=1)
    upper: int = parameter(7, unit="0.1 m", meaning="longest sleeper distance", source=PUBLISHED, minimum=1)


@dataclass(frozen=True)
class StripBounds:
    """Range of the length of the Type II strip."""

    lower: int = parameter(0, unit="0.1 m", meaning="shortest Type II strip", source=PUBLISHED, minimum=0)
    upper: int = parameter(120, unit="0.1 m", meaning="longest Type II strip", source=PUBLISHED, minimum=1)


@dataclass(frozen=True)
class Bounds:
    """The ranges in which the search looks, by variable."""

    xr1: PadBounds = PADS
    xr2: PadBounds = PADS
    xr3: PadBounds = PADS
    xn: StrengthenedBounds = STRENGTHENED
    xs1: DistanceBounds = DistanceBounds()
    xs2: DistanceBounds = DistanceBounds()
    xs3: DistanceBounds = DistanceBounds()
    xl: StripBounds = StripBounds()


# The worst of 400 random designs of the Dutch case, 5947 N and 1.49 N·m, rounded up.
WORST = {"F_max": 6000.0, "E_max": 1.5}
MEANINGS = {
    **PAD_MEANINGS,
    **STRENGTHENED_MEANINGS,
    "xs1": ("0.1 m", True, "distance from the second to the third sleeper"),
    "xs2": ("0.1 m", True, "distance from the first to the second sleeper"),
    "xs3": ("0.1 m", True, "distance from the interface to the first sleeper"),
    "xl": ("0.1 m", True, STRIP_MEANING),
}


class LevelCrossingProblem(DesignProblem):
    """Transition zones of a level crossing: 8 variables, wheel-rail force against energy dissipated in the ballast.

    Any choice of F_rms, F_max, E_rms and E_max is minimised; F_max and E_max by default. The reference design is the
    `zone` of the track model's parameters.
    """

    available_objectives: ClassVar[Sequence[Quantity]] = (
        Quantity("F_rms", "N", "rms of the wheel-rail force"),
        Quantity("F_max", "N", "maximum minus minimum of the wheel-rail force"),
        Quantity("E_rms", "N·m", "rms of the energy dissipated in the ballast per sleeper"),
        Quantity("E_max", "N·m", "maximum minus minimum of the energy dissipated in the ballast per sleeper"),
    )
    default_objectives: ClassVar[Sequence[str]] = ("F_max", "E_max")

    def __init__(
        self,
        model: TrackModel,
        track: Any,
        bounds: Bounds | None = None,
        objectives: Sequence[str] = (),
    ) -> None:
        bounds = bounds or Bounds()
        super().__init__(
            name="level-crossing",
            space=bounded_space(bounds, MEANINGS),
            objectives=chosen_objectives(self.available_objectives, objectives or self.default_objectives),
            metrics=(*self.available_objectives, Quantity("A_max", "m/s²", "maximum minus minimum carbody acceleration")),
            reference=_design_of(track.zone),
            worst=WORST,
        )
        self.model = model
        self.track = track

    @classmethod
    def sections(cls, host: Host) -> Mapping[str, object]:
        """Track model parameters and bounds of the variables."""
        return {"track": host.track_model(TRACK_MODEL).Parameters(), "variables": Bounds()}

    @classmethod
    def make(cls, host: Host, objectives: Sequence[str], sections: Mapping[str, Any]) -> LevelCrossingProblem:
        """The problem for a site. Raises InputError if the track cannot be built, as it is or at the bounds."""
        made = cls(host.track_model(TRACK_MODEL), sections["track"], sections["variables"], objectives)
        made.check()
        return made

    def check(self) -> None:
        """Raise InputError if the reference design, or the one at all lower or all upper bounds, cannot be built."""
        self.model.check(self.track)
        check_corners(self.model, self.space, self.parameters)

    def warm_up(self) -> None:
        """Warm the track model up."""
        self.model.warm_up()

    def parameters(self, design: FloatArray) -> Any:
        """The track model's parameters with the zone of a design (8,)."""
        pads, strengthened, distances, strip = design[:3], design[3], design[4:7], design[7]
        zone = dataclasses.replace(
            self.track.zone,
            pad_stiffness=tuple(float(pad * MEGA) for pad in pads),
            strengthened_sleepers=int(strengthened),
            sleeper_distances=tuple(float(distance / STEPS_PER_METRE) for distance in distances),
            type_2_strip_length=float(strip / STEPS_PER_METRE),
        )
        return dataclasses.replace(self.track, zone=zone)

    def simulate(self, design: FloatArray) -> Outcome:
        """One passage over the crossing with the transition zones of a design (8,)."""
        metrics = self.model.simulate(self.parameters(design)).metrics
        return Outcome(
            np.array([metrics[objective.name] for objective in self.objectives]),
            {metric.name: float(metrics[metric.name]) for metric in self.metrics},
        )

    def figures(self, designs: Mapping[str, FloatArray]) -> Mapping[str, Figure]:
        """Force over position, energy per sleeper, and a drawing of the zone to scale, for labelled designs."""
        parameters = {label: self.parameters(design) for label, design in designs.items()}
        return passage_figures(self.model, parameters, ("force", "energy", "zone"))


def _design_of(zone: Any) -> FloatArray:
    """The design (8,) that a zone is. Raises InputError if it is not one of this problem's designs."""
    pads = three_pads(zone)
    distances, strip = whole_steps(zone, STEPS_PER_METRE)
    if distances.size != 3:
        raise InputError(f"track.zone.sleeper_distances: this problem needs three, received {distances.size}")
    return np.array([*pads, zone.strengthened_sleepers, *distances, strip], dtype=float)


@hookimpl
def railsearch_problems(register: Callable[[str, Any], None]) -> None:
    """Register the level crossing."""
    register("level-crossing", LevelCrossingProblem)
