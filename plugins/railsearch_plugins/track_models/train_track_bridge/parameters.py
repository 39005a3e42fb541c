"""Physical data of a train on a ballasted bridge with unit and source per field; both rails together, in one plane.

Shang et al. 2024 = the study of a train-track-bridge system whose means are the defaults here; Manchester = the passenger
vehicle of the Manchester benchmarks (Iwnicki 1999, The Manchester Benchmarks for Rail Vehicle Simulation), its values per
side doubled for the plane; Cantero 2022 = TTB-2D: Train-Track-Bridge interaction simulation tool for Matlab, SoftwareX
20, 101253; Zhai et al. 2004 = Zhai, Wang & Lin, Modelling and experiment of railway ballast vibrations, Journal of Sound
and Vibration 270, 673.
"""

from dataclasses import dataclass

from railsearch.parameters import parameter

STUDY = "Shang et al. 2024"
MANCHESTER = "Manchester"
DOUBLED = "Manchester, both sides"
CODE = "Cantero 2022"
ZHAI = "Zhai et al. 2004"

PASS_BY, ALL = "pass-by", "all"
LEVEL = "none"


@dataclass(frozen=True)
class Vehicle:
    """A carbody on two bogies of two axles, six degrees of freedom; wheelsets belong to the contact."""

    carbody_mass: float = parameter(32000.0, unit="kg", meaning="mass of the carbody", source=MANCHESTER, above=0.0)
    carbody_inertia: float = parameter(1.97e6, unit="kg m²", meaning="pitch of the carbody", source=MANCHESTER, above=0.0)
    bogie_mass: float = parameter(2615.0, unit="kg", meaning="mass of a bogie", source=MANCHESTER, above=0.0)
    bogie_inertia: float = parameter(1476.0, unit="kg m²", meaning="pitch of a bogie", source=MANCHESTER, above=0.0)
    wheelset_mass: float = parameter(1813.0, unit="kg", meaning="mass of a wheelset", source=MANCHESTER, above=0.0)
    primary_stiffness: float = parameter(2.44e6, unit="N/m", meaning="bogie on one axle", source=DOUBLED, above=0.0)
    primary_damping: float = parameter(8e3, unit="N s/m", meaning="bogie on one axle", source=DOUBLED, minimum=0.0)
    secondary_stiffness: float = parameter(860e3, unit="N/m", meaning="carbody on one bogie", source=DOUBLED, above=0.0)
    secondary_damping: float = parameter(40e3, unit="N s/m", meaning="carbody on one bogie", source=DOUBLED, minimum=0.0)
    bogie_distance: float = parameter(
        9.5, unit="m", meaning="from the centre of the carbody to that of a bogie", source=MANCHESTER, above=0.0
    )
    axle_distance: float = parameter(
        1.28, unit="m", meaning="from the centre of a bogie to an axle", source=MANCHESTER, above=0.0
    )
    pitch: float = parameter(25.0, unit="m", meaning="from one vehicle of the train to the next", source=CODE, above=0.0)
    gravity: float = parameter(9.81, unit="m/s²", meaning="acceleration of gravity", source=CODE, above=0.0)


@dataclass(frozen=True)
class Rail:
    """Two rails UIC 60."""

    young_modulus: float = parameter(2.059e11, unit="Pa", meaning="Young's modulus", source=STUDY, above=0.0)
    second_moment: float = parameter(6.434e-5, unit="m⁴", meaning="second moment of area", source=STUDY, above=0.0)
    mass_per_length: float = parameter(121.28, unit="kg/m", meaning="mass per length", source=STUDY, above=0.0)
    damping: float = parameter(
        0.001, meaning="ratio at the first two frequencies of the bridge (Rayleigh)", source=CODE, minimum=0.0, below=1.0
    )

    @property
    def bending_stiffness(self) -> float:
        """EI in N m²."""
        return self.young_modulus * self.second_moment


@dataclass(frozen=True)
class TrainTrackBridgeParameters:
    """A train at constant speed over a simply supported bridge that carries the ballast track of its approaches."""

    speed: float = parameter(140.0 / 3.6, unit="m/s", meaning="speed of the train", source=STUDY, above=0.0)
    vehicles: int = parameter(3, meaning="vehicles of the train", source=STUDY, minimum=1, maximum=16)
    carbody_mass_factor: float = parameter(
        1.0, meaning="factor of the carbody's mass, not of its inertia", source=STUDY, above=0.0
    )
    primary_stiffness_factor: float = parameter(
        1.0, meaning="factor of the primary stiffness, not of its damping", source=STUDY, above=0.0
    )
    secondary_stiffness_factor: float = parameter(
        1.0, meaning="factor of the secondary stiffness, not of its damping", source=STUDY, above=0.0
    )
    pad_stiffness: float = parameter(8e8, unit="N/m", meaning="railpads on a sleeper", source=STUDY, above=0.0)
    pad_damping: float = parameter(4e4, unit="N s/m", meaning="railpads on a sleeper", source=STUDY, minimum=0.0)
    sleeper_mass: float = parameter(272.5, unit="kg", meaning="mass of a sleeper", source=STUDY, above=0.0)
    sleeper_spacing: float = parameter(0.6, unit="m", meaning="sleeper distance", source=STUDY, above=0.0)
    ballast_density: float = parameter(1800.0, unit="kg/m³", meaning="density of the ballast", source=STUDY, above=0.0)
    ballast_modulus: float = parameter(1.2e8, unit="Pa", meaning="modulus of the ballast", source=STUDY, above=0.0)
    ballast_depth: float = parameter(0.45, unit="m", meaning="depth under the sleeper", source=STUDY, above=0.0)
    ballast_angle: float = parameter(
        25.0, unit="deg", meaning="load distribution angle, 15 to 45 usually", source=STUDY, above=0.0, maximum=60.0
    )
    ballast_damping: float = parameter(1.6e5, unit="N s/m", meaning="damping under a sleeper", source=STUDY, minimum=0.0)
    ballast_doubled: bool = parameter(
        False, meaning="double the cone's mass and stiffness, one cone per rail", source="not in the publication"
    )
    ballast_mass: float | None = parameter(
        None, unit="kg", meaning="vibrating mass under a sleeper, instead of the cone's", source="measured", above=0.0
    )
    ballast_stiffness: float | None = parameter(
        None, unit="N/m", meaning="stiffness under a sleeper, instead of the cone's", source="measured", above=0.0
    )
    ballast_shear_stiffness: float = parameter(
        0.0, unit="N/m", meaning="between neighbouring ballast masses; 7.84e7 in the source", source=ZHAI, minimum=0.0
    )
    ballast_shear_damping: float = parameter(
        0.0, unit="N s/m", meaning="between neighbouring ballast masses; 8.0e4 in the source", source=ZHAI, minimum=0.0
    )
    subballast_stiffness: float = parameter(77.5e6, unit="N/m", meaning="ballast mass to ground", source=CODE, above=0.0)
    subballast_damping: float = parameter(3.115e4, unit="N s/m", meaning="ballast mass to ground", source=CODE, minimum=0.0)
    irregularity_spectrum: str = parameter(
        "german",
        meaning="of a generated profile: german, german-low, german-high, fra-1 to fra-6, module:NAME of your own, or none",
        source="Claus & Schiehlen 1998; Lei & Noda 2002",
    )
    irregularity_amplitude: float | None = parameter(
        None,
        unit="m² rad/m",
        meaning="A_v of the spectrum; not given: its own, 7.416e-7 for german; ignored with a file",
        source=STUDY,
        minimum=0.0,
    )
    irregularity_seed: int = parameter(
        1, meaning="seed of the phases; the same for every design", source="chosen", minimum=0
    )
    irregularity_file: str = parameter(
        "", meaning="text file of positions in m from the bridge and heights in m, positive upward", source="measured"
    )
    irregularity_shortest: float = parameter(3.0, unit="m", meaning="shortest wavelength", source=STUDY, above=0.0)
    irregularity_longest: float = parameter(150.0, unit="m", meaning="longest wavelength", source=STUDY, above=0.0)
    irregularity_period: float = parameter(
        600.0, unit="m", meaning="after which a generated profile repeats", source="chosen", above=0.0
    )
    irregularity_fade: float = parameter(
        15.0,
        unit="m",
        meaning="length over which a generated profile fades in, from where the first axle starts",
        source=CODE,
        above=0.0,
    )
    bridge_length: float = parameter(
        50.0, unit="m", meaning="span; rounded to a whole number of elements", source=STUDY, above=0.0
    )
    bridge_mass: float = parameter(69000.0, unit="kg/m", meaning="mass per length", source=STUDY, above=0.0)
    bridge_modulus: float = parameter(35e9, unit="Pa", meaning="Young's modulus", source=STUDY, above=0.0)
    bridge_inertia: float = parameter(51.3, unit="m⁴", meaning="second moment of area", source=STUDY, above=0.0)
    bridge_damping: float = parameter(
        0.02, meaning="damping ratio of the first two modes (Rayleigh)", source=STUDY, minimum=0.0, below=1.0
    )
    contact_stiffness: float | str = parameter(
        "rigid", unit="N/m", meaning="linear Hertz spring per axle, or a rigid contact", source=CODE, above=0.0,
        choices=("rigid",),
    )  # fmt: skip
    approach_length: float = parameter(
        30.0, unit="m", meaning="measured from the first axle there before the bridge", source=STUDY, minimum=0.0
    )
    departure_length: float = parameter(
        30.0, unit="m", meaning="how far the last axle goes beyond the bridge", source=STUDY, minimum=0.0
    )
    start_position: float | None = parameter(
        None,
        unit="m",
        meaning="first axle at the start; not given: irregularity_fade before the approach",
        source=CODE,
        maximum=0.0,
    )
    end_position: float | None = parameter(
        None, unit="m", meaning="first axle at the end; not given: the last axle at departure_length", source=CODE
    )
    margin_sleepers: int = parameter(
        10, meaning="sleepers beyond the outermost axles at start and end", source=CODE, minimum=1
    )
    time_step: float = parameter(
        1e-3, unit="s", meaning="largest time step; the run is divided into whole steps", source=CODE, above=0.0
    )
    elements_per_spacing: int = parameter(
        2, meaning="beam elements per sleeper distance", source=CODE, minimum=1, maximum=64
    )
    sleeper_range: str = parameter(
        PASS_BY,
        meaning="A_s over sleepers within sleeper_margin of the bridge, or over all sleepers and from the start",
        source="chosen; the start under the parked train dominates 'all'",
        choices=(PASS_BY, ALL),
    )
    sleeper_margin: float = parameter(
        20.0, unit="m", meaning="how far from the bridge sleepers are measured", source="chosen", minimum=0.0
    )
    snapshot_time: float | None = parameter(
        None,
        unit="s",
        meaning="time of the snapshot among the histories; not given: the middle of the train at midspan",
        source="chosen",
        minimum=0.0,
    )
    vehicle: Vehicle = Vehicle()
    rail: Rail = Rail()
