"""Design problem B: the transition zones of a level crossing, for ballast damage, riding comfort and construction cost.

Source: Shang, Binnekamp & Wolfert, Life-Cycle of Structures and Infrastructure Systems (2023) 949-956.

| symbol | meaning | unit |
|---|---|---|
| xs | sleeper spacing in the stretch next to the crossing | 0.05 m |
| xn | strengthened sleepers, counted from the crossing | - |
| xr1, xr2, xr3 | stiffness of the three railpads next to the crossing; xr3 is adjacent to it | MN/m |
| xl | Type II strip in the crossing, from its approach side | 0.05 m |
| E_max | largest difference of the energy dissipated in the ballast between adjacent sleepers | N·m |
| A_max | maximum minus minimum carbody acceleration | m/s² |
| C_cap | construction cost, see `construction_cost` | € |
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from railsearch.design_problem import DesignProblem
from railsearch.errors import InputError
from railsearch.hookspecs import hookimpl
from railsearch.interfaces import Host, Outcome, Quantity, TrackModel, passage_figures
from railsearch.parameters import amend_parameters, parameter
from railsearch.space import FloatArray
from railsearch_problems.construction_cost import PRINTED, Prices, check_priced, construction_cost
from railsearch_problems.crossing_designs import (
    MEGA,
    PAD_MEANINGS,
    SAME_LENGTH,
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

STEPS_PER_METRE = 20.0
PADS, STRENGTHENED = PadBounds(upper=1000.0), StrengthenedBounds(upper=15)


@dataclass(frozen=True)
class SpacingBounds:
    """Range of the sleeper spacing."""

    lower: int = parameter(10, unit="0.05 m", meaning="shortest sleeper spacing", source=PRINTED, minimum=1)
    upper: int = parameter(14, unit="0.05 m", meaning="longest sleeper spacing", source=PRINTED, minimum=1)


@dataclass(frozen=True)
class StripBounds:
    """Range of the length of the Type II strip."""

    lower: int = parameter(0, unit="0.05 m", meaning="shortest Type II strip", source=PRINTED, minimum=0)
    upper: int = parameter(120, unit="0.05 m", meaning="longest Type II strip", source=PRINTED, minimum=1)


@dataclass(frozen=True)
class Bounds:
    """The ranges in which the search looks, by variable."""

    xs: SpacingBounds = SpacingBounds()
    xn: StrengthenedBounds = STRENGTHENED
    xr1: PadBounds = PADS
    xr2: PadBounds = PADS
    xr3: PadBounds = PADS
    xl: StripBounds = StripBounds()


@dataclass(frozen=True)
class Layout:
    """Where the sleeper spacing is designed; beyond it, sleepers have their regular distance."""

    stretch: float = parameter(
        5.0, unit="m", meaning="stretch next to the crossing that whole sleeper spacings fill", source=PRINTED, above=0.0
    )

    def bays(self, spacing: float) -> int:
        """How many bays of `spacing` in m the stretch holds."""
        return math.floor(self.stretch / spacing + SAME_LENGTH)


# Track of design problem B. Its reference design is no measure at all: the ballast track as it is, up to the crossing.
TRACK: Mapping[str, Any] = {
    "geometry": {"total_length": 128.0, "slab_count": 1},
    "railpad": {"stiffness": 78e6, "damping": 120e3 * 78 / 1120},
    "zone": {"pad_stiffness": (78e6,) * 3, "strengthened_sleepers": 0, "sleeper_distances": (0.6,) * 8},
    "passage": {"element_length": 0.05},
}
# The worst of 400 random designs (seed 1), 1.304 N·m and 0.2042 m/s², and the dearest one, rounded up.
WORST = {"E_max": 1.31, "A_max": 0.205, "C_cap": 12500.0}
MEANINGS = {
    "xs": ("0.05 m", True, "sleeper spacing in the stretch next to the crossing"),
    **STRENGTHENED_MEANINGS,
    **PAD_MEANINGS,
    "xl": ("0.05 m", True, STRIP_MEANING),
}


class LevelCrossingPreferenceProblem(DesignProblem):
    """Transition zones of a level crossing: 6 variables, ballast damage against riding comfort against cost.

    Any choice of E_max, A_max and C_cap is minimised; all three by default. E_max is the largest difference between
    adjacent sleepers. The reference design is the `zone` of the track model's parameters: by default, no measure.
    """

    available_objectives: ClassVar[Sequence[Quantity]] = (
        Quantity("E_max", "N·m", "largest difference of the energy dissipated in the ballast between adjacent sleepers"),
        Quantity("A_max", "m/s²", "maximum minus minimum carbody acceleration"),
        Quantity("C_cap", "€", "construction cost"),
    )
    default_objectives: ClassVar[Sequence[str]] = ("E_max", "A_max", "C_cap")

    def __init__(
        self,
        model: TrackModel,
        track: Any,
        bounds: Bounds | None = None,
        objectives: Sequence[str] = (),
        layout: Layout | None = None,
        prices: Prices | None = None,
    ) -> None:
        self.layout = layout or Layout()
        super().__init__(
            name="level-crossing-preference",
            space=bounded_space(bounds or Bounds(), MEANINGS),
            objectives=chosen_objectives(self.available_objectives, objectives or self.default_objectives),
            metrics=(
                *self.available_objectives,
                Quantity("E_rms", "N·m", "rms of the energy dissipated in the ballast per sleeper"),
                Quantity("F_max", "N", "maximum minus minimum of the wheel-rail force"),
            ),
            reference=_design_of(track.zone, self.layout),
            worst=WORST,
        )
        self.model = model
        self.track = track
        self.prices = prices or Prices()

    @classmethod
    def sections(cls, host: Host) -> Mapping[str, object]:
        """Track model parameters, bounds of the variables, the stretch with the chosen spacing, and prices."""
        track = amend_parameters(host.track_model(TRACK_MODEL).Parameters(), TRACK, "track")
        return {"track": track, "variables": Bounds(), "layout": Layout(), "cost": Prices()}

    @classmethod
    def make(cls, host: Host, objectives: Sequence[str], sections: Mapping[str, Any]) -> LevelCrossingPreferenceProblem:
        """The problem for a site. Raises InputError if the track cannot be built or priced, as it is or at the bounds."""
        made = cls(
            host.track_model(TRACK_MODEL),
            sections["track"],
            sections["variables"],
            objectives,
            sections["layout"],
            sections["cost"],
        )
        made.check()
        return made

    def check(self) -> None:
        """Raise InputError if the reference design or one at the bounds cannot be built, or one has no price."""
        self.model.check(self.track)
        lower, upper = self.space.lower, self.space.upper
        _check_stretch(self.layout, upper[0])
        check_corners(self.model, self.space, self.parameters)
        check_priced(np.arange(lower[0], upper[0] + 1.0), np.array([lower[1], upper[1]]), self.prices)

    def warm_up(self) -> None:
        """Warm the track model up."""
        self.model.warm_up()

    def construction_cost(self, designs: FloatArray) -> FloatArray:
        """C_cap (n,) in € of designs (n, 6), without a simulation."""
        return construction_cost(designs[:, 0], designs[:, 1], self.prices)

    @property
    def exact_objectives(self) -> Mapping[str, Callable[[FloatArray], FloatArray]]:
        """C_cap, in closed form."""
        return {"C_cap": self.construction_cost}

    def parameters(self, design: FloatArray) -> Any:
        """The track model's parameters with the zone of a design (6,)."""
        spacing = float(design[0] / STEPS_PER_METRE)
        zone = dataclasses.replace(
            self.track.zone,
            pad_stiffness=tuple(float(pad * MEGA) for pad in design[2:5]),
            strengthened_sleepers=int(design[1]),
            sleeper_distances=(spacing,) * self.layout.bays(spacing),
            type_2_strip_length=float(design[5] / STEPS_PER_METRE),
        )
        return dataclasses.replace(self.track, zone=zone)

    def simulate(self, design: FloatArray) -> Outcome:
        """One passage over the crossing with the transition zones of a design (6,), and what they cost."""
        measured = self.model.simulate(self.parameters(design)).metrics
        known = {
            **measured,
            "E_max": measured["E_adjacent"],
            "C_cap": float(self.construction_cost(design[None, :])[0]),
        }
        return Outcome(
            np.array([known[objective.name] for objective in self.objectives]),
            {metric.name: float(known[metric.name]) for metric in self.metrics},
        )

    def figures(self, designs: Mapping[str, FloatArray]) -> Mapping[str, Figure]:
        """Energy per sleeper, carbody acceleration over position, and a drawing of the zone to scale."""
        parameters = {label: self.parameters(design) for label, design in designs.items()}
        pictures = passage_figures(self.model, parameters, ("energy-adjacent", "acceleration", "zone"))
        return {name.removesuffix("-adjacent"): figure for name, figure in pictures.items()}


def _check_stretch(layout: Layout, longest: float) -> None:
    spacing = longest / STEPS_PER_METRE
    if layout.bays(spacing) < 1:
        raise InputError(
            f"layout.stretch: one sleeper spacing must fit in, and variables.xs.upper is {spacing:g} m, "
            f"received {layout.stretch:g} m; lengthen the stretch or lower that bound"
        )


def _design_of(zone: Any, layout: Layout) -> FloatArray:
    """The design (6,) that a zone is. Raises InputError if it is not one of this problem's designs."""
    pads = three_pads(zone)
    distances, strip = whole_steps(zone, STEPS_PER_METRE)
    spacings = np.unique(distances)
    if spacings.size != 1 or distances.size != layout.bays(spacings[0] / STEPS_PER_METRE):
        raise InputError(
            f"track.zone.sleeper_distances: this problem needs one distance for all whole bays of the {layout.stretch:g} m "
            f"next to the crossing (layout.stretch), for instance {Layout().bays(0.6)} of 0.6 m in 5 m, "
            f"received {zone.sleeper_distances} m"
        )
    return np.array([spacings[0], zone.strengthened_sleepers, *pads, strip], dtype=float)


@hookimpl
def railsearch_problems(register: Callable[[str, Any], None]) -> None:
    """Register the level crossing with preferences."""
    register("level-crossing-preference", LevelCrossingPreferenceProblem)
