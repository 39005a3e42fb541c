"""Physical data of a level crossing for one rail (half track), with unit and source per field.

Shang et al. 2023 = Shang, Nogal, Teixeira & Wolfert, Engineering Structures 282 (2023) 115740, from which the defaults
are; those of another design problem are in its module. Printed values are for the full track. Here the rail (one rail)
and the railpads (per rail seat) are as printed and everything else is halved; `railpad.reading = "full-track"` halves
the pads too.
"""

from dataclasses import dataclass

from railsearch.parameters import parameter
from railsearch_plugins.single_wheel import HALVED, PRINTED, Irregularity, Vehicle

DESIGN = "reference design of the problem"


@dataclass(frozen=True)
class Geometry:
    """Lengths along the track; the departure side is what remains of the total length."""

    total_length: float = parameter(134.0, unit="m", meaning="length of the modelled track", source=PRINTED, above=0.0)
    approach_length: float = parameter(
        100.0, unit="m", meaning="ballast track before the first interface", source=PRINTED, above=0.0
    )
    slab_length: float = parameter(6.0, unit="m", meaning="length of one slab of the crossing", source=PRINTED, above=0.0)
    slab_count: int = parameter(2, meaning="slabs in line, not connected to one another", source=PRINTED, minimum=1)

    @property
    def crossing_length(self) -> float:
        """Length of all slabs in m."""
        return self.slab_length * self.slab_count

    @property
    def crossing_end(self) -> float:
        """Position of the second interface in m."""
        return self.approach_length + self.crossing_length

    @property
    def departure_length(self) -> float:
        """Length of the ballast track beyond the crossing in m."""
        return self.total_length - self.crossing_end


class Beam:
    """What follows from the section and material of a beam."""

    young_modulus: float
    second_moment: float
    area: float
    density: float

    @property
    def bending_stiffness(self) -> float:
        """EI in N m²."""
        return self.young_modulus * self.second_moment

    @property
    def mass_per_length(self) -> float:
        """ρA in kg/m."""
        return self.density * self.area


@dataclass(frozen=True)
class Rail(Beam):
    """One rail 54E1."""

    young_modulus: float = parameter(210e9, unit="Pa", meaning="Young's modulus", source=PRINTED, above=0.0)
    second_moment: float = parameter(2.337e-5, unit="m⁴", meaning="second moment of area", source=PRINTED, above=0.0)
    area: float = parameter(6.977e-3, unit="m²", meaning="cross-section", source=PRINTED, above=0.0)
    density: float = parameter(7800.0, unit="kg/m³", meaning="density", source=PRINTED, above=0.0)


@dataclass(frozen=True)
class Railpad:
    """Railpad FC9 outside the design zone. The damping of any pad is proportional to its stiffness."""

    stiffness: float = parameter(1120e6, unit="N/m", meaning="stiffness of a railpad", source=PRINTED, above=0.0)
    damping: float = parameter(120e3, unit="N s/m", meaning="damping at that stiffness", source=PRINTED, minimum=0.0)
    reading: str = parameter(
        "per rail seat",
        meaning="what pad values mean; 'full-track' halves all pads, those of the design too, and their damping",
        source="not said in the publication",
        choices=("per rail seat", "full-track"),
    )


@dataclass(frozen=True)
class Sleeper:
    """Half a sleeper NS90."""

    mass: float = parameter(125.5, unit="kg", meaning="mass of half a sleeper", source=HALVED, above=0.0)
    strengthened_mass: float = parameter(
        150.0, unit="kg", meaning="mass of half a strengthened sleeper", source="assumed, 300 kg halved", above=0.0
    )
    spacing: float = parameter(0.6, unit="m", meaning="regular sleeper distance", source=PRINTED, above=0.0)


@dataclass(frozen=True)
class Ballast:
    """Ballast and subgrade under half a sleeper."""

    stiffness: float = parameter(22.5e6, unit="N/m", meaning="stiffness under half a sleeper", source=HALVED, above=0.0)
    damping: float = parameter(48e3, unit="N s/m", meaning="damping under half a sleeper", source=HALVED, minimum=0.0)


@dataclass(frozen=True)
class Strip:
    """Elastic compound with rail strip under the embedded rail; c = 2 ζ √(k ρA of the rail)."""

    type_1_stiffness: float = parameter(27e6, unit="N/m²", meaning="stiffness per metre, Type I", source=HALVED, above=0.0)
    type_2_stiffness: float = parameter(21e6, unit="N/m²", meaning="stiffness per metre, Type II", source=HALVED, above=0.0)
    damping_ratio: float = parameter(0.2, meaning="damping ratio of rail on strip", source=PRINTED, minimum=0.0)


@dataclass(frozen=True)
class Slab(Beam):
    """Half a slab of the crossing, of width (2.37 + 2.23)/4 = 1.15 m and height 0.58 m, on its subgrade."""

    young_modulus: float = parameter(31e9, unit="Pa", meaning="Young's modulus", source=PRINTED, above=0.0)
    density: float = parameter(2500.0, unit="kg/m³", meaning="density", source=PRINTED, above=0.0)
    area: float = parameter(0.667, unit="m²", meaning="cross-section, 1.15 × 0.58", source=HALVED, above=0.0)
    second_moment: float = parameter(
        0.0186982333, unit="m⁴", meaning="second moment of area, 1.15 × 0.58³/12", source=HALVED, above=0.0
    )
    subgrade_stiffness: float = parameter(250e6, unit="N/m²", meaning="subgrade per metre", source=HALVED, above=0.0)
    subgrade_damping: float = parameter(10e3, unit="N s/m²", meaning="subgrade per metre", source=HALVED, minimum=0.0)


@dataclass(frozen=True)
class Zone:
    """What is designed next to the crossing; tuples end at the crossing. All but the strip is mirrored beyond it."""

    pad_stiffness: tuple[float, ...] = parameter(
        (1120e6, 1120e6, 1120e6),
        unit="N/m",
        meaning="pads next to the crossing, the last adjacent to it",
        source=DESIGN,
        above=0.0,
    )
    strengthened_sleepers: int = parameter(
        8, meaning="strengthened sleepers counted from the crossing", source=DESIGN, minimum=0
    )
    sleeper_distances: tuple[float, ...] = parameter(
        (0.6, 0.6, 0.4),
        unit="m",
        meaning="sleeper distances next to the crossing, the last from interface to first sleeper",
        source=DESIGN,
        above=0.0,
    )
    type_2_strip_length: float = parameter(
        0.0, unit="m", meaning="length of Type II strip from the approach side of the crossing", source=DESIGN, minimum=0.0
    )


@dataclass(frozen=True)
class Passage:
    """Motion of the wheel and discretisation in time and space."""

    speed: float = parameter(
        140.0 / 3.6, unit="m/s", meaning="speed of the vehicle", source="Shang et al. 2023, 140 km/h", above=0.0
    )
    time_step: float = parameter(1e-3, unit="s", meaning="time step", source=PRINTED, above=0.0)
    element_length: float = parameter(0.1, unit="m", meaning="largest length of a beam element", source=PRINTED, above=0.0)


@dataclass(frozen=True)
class Windows:
    """Where force and carbody acceleration, and over how many sleepers energy, are measured; edges are inclusive."""

    force_before: float = parameter(
        12.0, unit="m", meaning="start of the force window before the first interface", source=PRINTED, minimum=0.0
    )
    force_after: float | None = parameter(
        None,
        unit="m",
        meaning="end of the force window after the first interface; not given: at the end of the crossing",
        source=PRINTED,
        minimum=0.0,
    )
    energy_sleepers: int = parameter(20, meaning="sleepers before the crossing that are measured", source=PRINTED, minimum=2)


@dataclass(frozen=True)
class LevelCrossingParameters:
    """A level crossing, its transition zones, the vehicle and its passage."""

    geometry: Geometry = Geometry()
    rail: Rail = Rail()
    railpad: Railpad = Railpad()
    sleeper: Sleeper = Sleeper()
    ballast: Ballast = Ballast()
    strip: Strip = Strip()
    slab: Slab = Slab()
    vehicle: Vehicle = Vehicle()  # noqa: RUF009 - frozen
    zone: Zone = Zone()
    passage: Passage = Passage()
    irregularity: Irregularity = Irregularity()  # noqa: RUF009 - frozen
    windows: Windows = Windows()
