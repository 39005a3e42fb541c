"""Where the matrices of an imported track are, what is known of its rail and supports, and the passage over it.

A file is named as `FILE` or `FILE#NAME`, NAME being that of an array in a .npz or .mat file; `SAMPLE/FILE` is a file of the
sample track that comes with railsearch: 24 m of a level crossing.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from railsearch.errors import InputError
from railsearch.parameters import make_parameters, parameter
from railsearch_plugins.single_wheel import PRINTED, Irregularity, Vehicle

SAMPLE = "SAMPLE/"
MATRICES = ("mass", "damping", "stiffness")
EXPORTED = "exported from a finite element program"


@dataclass(frozen=True)
class PartFiles:
    """Matrices of a part of the track that are added, times its factor, to those of the whole."""

    mass: str = parameter("", unit="kg", meaning="file of the part's mass matrix at factor 1", source=EXPORTED)
    damping: str = parameter("", unit="N s/m", meaning="file of its damping matrix at factor 1", source=EXPORTED)
    stiffness: str = parameter("", unit="N/m", meaning="file of its stiffness matrix at factor 1", source=EXPORTED)

    def __post_init__(self) -> None:
        if not (self.mass or self.damping or self.stiffness):
            raise InputError("a file of mass, damping or stiffness is needed, received none")


@dataclass(frozen=True)
class Files:
    """Matrices and tables of the track."""

    mass: str = parameter(SAMPLE + "mass.mtx", unit="kg", meaning="file of the mass matrix", source=EXPORTED)
    damping: str = parameter(SAMPLE + "damping.mtx", unit="N s/m", meaning="file of the damping matrix", source=EXPORTED)
    stiffness: str = parameter(SAMPLE + "stiffness.mtx", unit="N/m", meaning="file of the stiffness matrix", source=EXPORTED)
    rail: str = parameter(
        SAMPLE + "rail.csv",
        meaning="table of the rail nodes: position [m], vertical unknown, rotation unknown; the last column may be missing",
        source=EXPORTED,
    )
    supports: str = parameter(
        SAMPLE + "supports.csv",
        meaning="table of supports whose energy is wanted: position [m], unknown, damping [N s/m] and, if the damper is not "
        "on ground, the unknown at its other end",
        source=EXPORTED,
    )
    first_unknown: int = parameter(
        0, meaning="number of the first row of the matrices in the tables: 0, or 1 as in MATLAB", minimum=0, maximum=1
    )


@dataclass(frozen=True)
class Rail:
    """How the rail is read between its nodes."""

    interpolation: str = parameter(
        "auto",
        meaning="of the rail between nodes: 'hermite' needs rotations; 'cubic' and 'linear' go through the vertical "
        "unknowns; 'auto' is hermite with rotations and cubic without",
        choices=("auto", "hermite", "cubic", "linear"),
    )
    rotation: str = parameter(
        "slope",
        meaning="what a rotation is: the slope dw/dx of the vertical displacement w, or its negative",
        choices=("slope", "minus slope"),
    )


@dataclass(frozen=True)
class Passage:
    """Motion of the wheel in the direction of ascending positions."""

    speed: float = parameter(
        140.0 / 3.6, unit="m/s", meaning="speed of the vehicle", source=f"{PRINTED}, 140 km/h", above=0.0
    )
    time_step: float = parameter(1e-3, unit="s", meaning="time step", source=PRINTED, above=0.0)
    start: float | None = parameter(
        None, unit="m", meaning="where the wheel starts at rest; not given: on the first rail node"
    )
    end: float | None = parameter(
        None, unit="m", meaning="position that the wheel does not pass; not given: the last rail node"
    )


@dataclass(frozen=True)
class Windows:
    """Where force and carbody acceleration, and over which supports energy, are measured; edges are inclusive."""

    force_from: float | None = parameter(
        None, unit="m", meaning="begin of the force window; not given: the start of the run"
    )
    force_to: float | None = parameter(None, unit="m", meaning="its end; not given: the end of the run")
    energy_from: float | None = parameter(None, unit="m", meaning="first support measured; not given: the first of all")
    energy_to: float | None = parameter(None, unit="m", meaning="last support measured; not given: the last of all")


SAMPLE_PARTS: Mapping[str, Mapping[str, str]] = MappingProxyType(
    {
        f"pad_{rank}": MappingProxyType({kind: f"{SAMPLE}pad_{rank}.{kind}.mtx" for kind in ("damping", "stiffness")})
        for rank in (1, 2, 3)
    }
)
SAMPLE_FACTORS: Mapping[str, float] = MappingProxyType({f"pad_{rank}": 1120.0 for rank in (1, 2, 3)})


@dataclass(frozen=True)
class ImportedTrackParameters:
    """An imported track, the vehicle and its passage."""

    files: Files = Files()
    rail: Rail = Rail()
    parts: dict[str, Any] | None = parameter(  # noqa: RUF009 - a field, not a value
        None, meaning="by name: files of the mass, damping and stiffness of parts that are added, times their factors"
    )
    factors: dict[str, Any] | None = parameter(  # noqa: RUF009 - a field, not a value
        None, meaning="by name of the part: what its matrices are multiplied by; 1 for parts not named"
    )
    vehicle: Vehicle = Vehicle()  # noqa: RUF009 - frozen
    passage: Passage = Passage()
    irregularity: Irregularity = Irregularity()  # noqa: RUF009 - frozen
    windows: Windows = Windows()

    def __post_init__(self) -> None:
        parts = {name: _part(name, table) for name, table in self.named_parts().items()}
        for name, factor in (self.factors or {}).items():
            if name not in parts:
                raise InputError(f"factors: unknown part '{name}'; there are {', '.join(parts) or 'none'}")
            if isinstance(factor, bool) or not isinstance(factor, int | float) or not abs(factor) < float("inf"):
                raise InputError(f"factors.{name}: a finite number is needed, received {factor!r}")

    @property
    def is_sample(self) -> bool:
        """The matrices are those of the sample track."""
        return self.files.stiffness.startswith(SAMPLE)

    def named_parts(self) -> Mapping[str, Any]:
        """The parts as given; those of the sample come with it."""
        if self.parts is not None:
            return self.parts
        return SAMPLE_PARTS if self.is_sample else {}

    def part_files(self) -> dict[str, PartFiles]:
        """The files of the parts by name."""
        return {name: _part(name, table) for name, table in self.named_parts().items()}

    def part_factors(self) -> dict[str, float]:
        """The factor of every part by name."""
        known = SAMPLE_FACTORS if self.is_sample and self.parts is None else {}
        given = self.factors or {}
        return {name: float(given.get(name, known.get(name, 1.0))) for name in self.named_parts()}


def _part(name: str, table: object) -> PartFiles:
    if not isinstance(table, Mapping):
        raise InputError(f"parts.{name}: a table of files is needed, received {table!r}")
    return make_parameters(PartFiles, table, f"parts.{name}")
