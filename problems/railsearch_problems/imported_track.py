"""A design problem on an imported track: variables of the site file scale parts of its matrices.

K = K₀ + Σ f_i K_i with f_i = scale · x_i, and C and M alike: a variable x scales all matrices of one part, or of several.
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
from railsearch.parameters import make_parameters, parameter
from railsearch.space import FloatArray, Space, Variable
from railsearch_problems.crossing_designs import check_corners, chosen_objectives

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TRACK_MODEL = "imported-track"
SAMPLE_VARIABLE = {"lower": 50.0, "upper": 1200.0, "unit": "MN/m", "meaning": "stiffness of a railpad next to the crossing"}
SAME_FACTOR = 1e-9


@dataclass(frozen=True)
class DesignVariable:
    """A design variable that scales parts of the track."""

    lower: float = parameter(meaning="its lower bound, in its unit")
    upper: float = parameter(meaning="its upper bound, in its unit")
    parts: tuple[str, ...] = parameter((), meaning="parts whose factor is scale times the variable; none: that of its name")
    scale: float = parameter(1.0, meaning="factor of the parts where the variable is 1", above=0.0)
    unit: str = parameter("", meaning="its unit")
    integer: bool = parameter(False, meaning="whole numbers alone")
    meaning: str = parameter("", meaning="what it is, for tables and reports")


@dataclass(frozen=True)
class Design:
    """What is searched."""

    variables: dict[str, Any] | None = parameter(  # noqa: RUF009 - a field, not a value
        None, meaning="by name: lower, upper, parts, scale, unit, integer and meaning of every design variable"
    )

    def __post_init__(self) -> None:
        self.made()

    def made(self) -> dict[str, DesignVariable]:
        """The variables by name. Raises InputError for what is not allowed."""
        return {
            name: make_parameters(DesignVariable, _table(name, table), f"variables.{name}")
            for name, table in (self.variables or {}).items()
        }


class ImportedTrackProblem(DesignProblem):
    """Parts of an imported track, tuned: any choice of F_rms, F_max, E_rms, E_max, E_adjacent and A_max is minimised.

    The variables are those of the section [design.variables] of a site file; the reference design is what the factors of the
    track's parts are. Without a site file it is a sample: three railpads on either side of a short crossing.
    """

    available_objectives: ClassVar[Sequence[Quantity]] = (
        Quantity("F_rms", "N", "rms of the wheel-rail force"),
        Quantity("F_max", "N", "maximum minus minimum of the wheel-rail force"),
        Quantity("E_rms", "N·m", "rms of the energy dissipated per support"),
        Quantity("E_max", "N·m", "maximum minus minimum of the energy dissipated per support"),
        Quantity("E_adjacent", "N·m", "largest difference of that energy between neighbouring supports"),
        Quantity("A_max", "m/s²", "maximum minus minimum of the carbody acceleration"),
    )
    default_objectives: ClassVar[Sequence[str]] = ("F_max", "E_max")

    def __init__(self, model: TrackModel, track: Any, design: Design | None = None, objectives: Sequence[str] = ()) -> None:
        self.design_variables = _variables(track, design or Design())
        factors = track.part_factors()
        super().__init__(
            name=TRACK_MODEL,
            space=Space(tuple(_variable(name, made) for name, made in self.design_variables.items())),
            objectives=chosen_objectives(self.available_objectives, objectives or self.default_objectives),
            metrics=self.available_objectives,
            reference=np.array([_reference(name, made, factors) for name, made in self.design_variables.items()]),
        )
        self.model = model
        self.track = track

    @classmethod
    def sections(cls, host: Host) -> Mapping[str, object]:
        """Track model parameters and design variables."""
        return {"track": host.track_model(TRACK_MODEL).Parameters(), "design": Design()}

    @classmethod
    def make(cls, host: Host, objectives: Sequence[str], sections: Mapping[str, Any]) -> ImportedTrackProblem:
        """The problem for a site. Raises InputError if the track cannot be simulated, as it is or at the bounds."""
        made = cls(host.track_model(TRACK_MODEL), sections["track"], sections["design"], objectives)
        made.model.check(made.track)
        check_corners(made.model, made.space, made.parameters)
        return made

    def warm_up(self) -> None:
        """Warm the track model up."""
        self.model.warm_up()

    def parameters(self, design: FloatArray) -> Any:
        """The track model's parameters with the factors of a design (d,)."""
        factors = self.track.part_factors()
        for value, variable in zip(design, self.design_variables.values(), strict=True):
            factors |= dict.fromkeys(variable.parts, float(variable.scale * value))
        return dataclasses.replace(self.track, factors=factors)

    def simulate(self, design: FloatArray) -> Outcome:
        """One passage over the track with a design (d,)."""
        metrics = self.model.simulate(self.parameters(design)).metrics
        return Outcome(
            np.array([metrics[objective.name] for objective in self.objectives]),
            {metric.name: float(metrics[metric.name]) for metric in self.metrics},
        )

    def figures(self, designs: Mapping[str, FloatArray]) -> Mapping[str, Figure]:
        """Force over position and energy per support for labelled designs."""
        return passage_figures(self.model, {label: self.parameters(design) for label, design in designs.items()})


def _table(name: str, table: object) -> Mapping[str, Any]:
    if not isinstance(table, Mapping):
        raise InputError(f"variables.{name}: a table with lower and upper is needed, received {table!r}")
    return table


def _variables(track: Any, design: Design) -> dict[str, DesignVariable]:
    """The variables with their parts. Raises InputError for none, an unknown part and one that two variables scale."""
    parts, made = list(track.part_factors()), design.made()
    if design.variables is None and track.is_sample:
        made = {name: make_parameters(DesignVariable, SAMPLE_VARIABLE, name) for name in parts}
    if not made:
        raise InputError(
            "design.variables: one or more variables are needed, received none; add [design.variables.NAME] with lower and "
            f"upper for the parts {', '.join(parts) or '(none yet: export some and name them in [track.parts])'}"
        )
    taken: dict[str, str] = {}
    for name, variable in made.items():
        made[name] = variable = dataclasses.replace(variable, parts=variable.parts or (name,))
        for part in variable.parts:
            if part not in parts:
                raise InputError(
                    f"design.variables.{name}.parts: unknown part '{part}'; there are {', '.join(parts) or 'none'}"
                )
            if part in taken:
                raise InputError(
                    f"design.variables.{name}.parts: '{part}' is scaled by {taken[part]} already; "
                    "one variable may scale a part"
                )
            taken[part] = name
    return made


def _variable(name: str, made: DesignVariable) -> Variable:
    return Variable(name, made.lower, made.upper, made.unit, made.integer, made.meaning)


def _reference(name: str, made: DesignVariable, factors: Mapping[str, float]) -> float:
    """The variable's value that the factors of its parts make. Raises InputError if they differ."""
    values = [factors[part] / made.scale for part in made.parts]
    if max(values) - min(values) > SAME_FACTOR * max(map(abs, values)):
        raise InputError(
            f"design.variables.{name}.parts: the parts of a variable have the same factor in the reference design, received "
            f"{', '.join(f'{part} = {factors[part]:g}' for part in made.parts)}; set them in [track.factors]"
        )
    return values[0]


@hookimpl
def railsearch_problems(register: Callable[[str, Any], None]) -> None:
    """Register the imported track."""
    register("imported-track", ImportedTrackProblem)
