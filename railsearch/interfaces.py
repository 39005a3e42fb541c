"""What a track model, surrogate, strategy and scalariser is, and the frozen records that flow between them.

A plugin is a class of one of these shapes, registered under a name through a hook (see hookspecs.py). Its nested
`Parameters` is a frozen dataclass of `parameter(...)` fields (see parameters.py), or `NoParameters`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol, cast

import numpy as np
from numpy.typing import NDArray

from railsearch.errors import CapabilityError
from railsearch.parameters import NoParameters, parameter
from railsearch.space import FloatArray, Space, Variable

if TYPE_CHECKING:  # half a second of scipy that only those who have random vectors need
    from matplotlib.figure import Figure

    from railsearch.distributions import RandomVector

__all__ = ["NoParameters", "Space", "Variable", "parameter"]


@dataclass(frozen=True)
class Quantity:
    """A named result with its unit; `maximised` ones are stored negated and shown with their natural sign."""

    name: str
    unit: str = ""
    meaning: str = ""
    maximised: bool = False

    @property
    def sign(self) -> float:
        """What a natural value is multiplied by to be minimised, and a stored one to be shown."""
        return -1.0 if self.maximised else 1.0


@dataclass(frozen=True)
class Capabilities:
    """What a strategy can handle; checked against the problem before a run starts."""

    multi_objective: bool = False
    integers: bool = False
    constraints: bool = False
    batch: bool = False


@dataclass(frozen=True)
class Response:
    """What a track model returns: metrics by name, and histories by name when they were asked for."""

    metrics: Mapping[str, float]
    histories: Mapping[str, NDArray[Any]] = field(default_factory=dict)


@dataclass(frozen=True)
class Outcome:
    """What a problem returns for one design: objectives (m,) to be minimised, constraints (k,) ≤ 0, metrics by name."""

    objectives: FloatArray
    metrics: Mapping[str, float] = field(default_factory=dict)
    constraints: FloatArray = field(default_factory=lambda: np.empty(0))


@dataclass(frozen=True)
class Proposal:
    """A design (d,) in native units that a strategy wants evaluated, and how it came about.

    `trajectory` counts the restarts before it: designs of one trajectory share an incumbent.
    """

    design: FloatArray
    origin: str
    trajectory: int = 0


@dataclass(frozen=True)
class Evaluation:
    """One evaluated design. A failed one has NaN objectives (m,) and constraints (k,), and a reason.

    number: place in the record, from 0; duration and overhead: seconds in the evaluation, and in the strategy before it;
    repeated: the design had been evaluated before, nothing was charged.
    """

    number: int
    design: FloatArray
    objectives: FloatArray
    constraints: FloatArray
    metrics: Mapping[str, float]
    origin: str
    trajectory: int = 0
    reason: str = ""
    duration: float = 0.0
    overhead: float = 0.0
    repeated: bool = False

    @property
    def failed(self) -> bool:
        return bool(self.reason)

    @property
    def feasible(self) -> bool:
        return not self.failed and bool(np.all(self.constraints <= 0.0))

    @property
    def violation(self) -> float:
        """Σ max(0, constraint): 0 of a feasible design, NaN of a failed evaluation."""
        return float("nan") if self.failed else float(np.sum(np.maximum(self.constraints, 0.0)))


class Surrogate(Protocol):
    """A cheap model of an expensive function on the unit cube [0, 1]^d. Made as `cls(dimension, parameters)`.

    One whose `add` does not give what a fit to all points gives says in an attribute `add_tolerance` by which fraction of
    the spread of the values the predictions may differ. One that does not meet the values it was fitted to says
    `interpolates = False`. One that cannot carry out a method raises SurrogateError there
    and names the method in an attribute `lacks`.
    """

    Parameters: type

    def fit(self, points: FloatArray, values: FloatArray) -> None:
        """Fit to points (n, d) with values (n,). Raises SurrogateError if they do not determine the model."""

    def add(self, points: FloatArray, values: FloatArray) -> None:
        """Add points (k, d) with values (k,) to a fitted model."""

    def predict(self, points: FloatArray) -> FloatArray:
        """Predicted values (k,) at points (k, d)."""

    def gradient(self, points: FloatArray) -> FloatArray:
        """Derivatives (k, d) of the prediction at points (k, d)."""


class UncertainSurrogate(Surrogate, Protocol):
    """A surrogate that says how far it may be off; expected improvement needs one."""

    def deviation(self, points: FloatArray) -> FloatArray:
        """Standard deviations (k,) of the prediction at points (k, d), in the unit of the values."""

    def deviation_gradient(self, points: FloatArray) -> FloatArray:
        """Derivatives (k, d) of the standard deviation at points (k, d)."""


class RandomInputSurrogate(Surrogate, Protocol):
    """A surrogate that makes use of the distributions of the inputs where they are known: in a sensitivity analysis.

    One without `for_inputs` is made there on the unit cube, like in a search, which is the box of the samples.
    """

    @classmethod
    def for_inputs(cls, inputs: RandomVector, parameters: Any) -> Surrogate:
        """A surrogate whose points are those of the random inputs, in their own units, in place of the unit cube's."""


def lacking(surrogate: Surrogate, methods: Sequence[str]) -> list[str]:
    """Those of the methods (`gradient`, `deviation`, `deviation_gradient`) that a surrogate cannot carry out."""
    lacks = getattr(surrogate, "lacks", ())
    return [method for method in methods if method in lacks or not hasattr(surrogate, method)]


def require_methods(surrogate: Surrogate, name: str, methods: Sequence[str], purpose: str, remedy: str) -> None:
    """Raise CapabilityError unless the surrogate called `name` has all methods that `purpose` needs."""
    missing = lacking(surrogate, methods)
    if missing:
        raise CapabilityError(f"surrogate {name} has no {' and no '.join(missing)}, which {purpose} needs: {remedy}")


@dataclass(frozen=True)
class Responses:
    """The r expensive responses behind the objectives, for strategies that would rather model them than the objectives.

    values: responses (r,) of an evaluation that did not fail; objectives: the objectives (n, m) that follow from designs
    (n, d) and responses (n, r), with all that is known without a simulation: exact objectives, a scalariser.
    """

    quantities: tuple[Quantity, ...]
    values: Callable[[Evaluation], FloatArray]
    objectives: Callable[[FloatArray, FloatArray], FloatArray]


@dataclass(frozen=True)
class Finding:
    """A number, other than a design, that a strategy has found and a user wants to see, for instance a surrogate's error."""

    name: str
    value: float
    unit: str = ""
    meaning: str = ""


@dataclass(frozen=True)
class SearchContext:
    """All that a strategy is given. `budget` counts every evaluation of the run, the given designs included.

    generator: the strategy's own randomness; initial_generator: for the initial design only; batch_size: how many
    designs may be proposed at once; surrogate: makes a registered surrogate by name with settings; responses: what the
    objectives are made of, None where that is not known.
    """

    space: Space
    n_objectives: int
    n_constraints: int
    budget: int
    batch_size: int
    generator: np.random.Generator
    initial_generator: np.random.Generator
    surrogate: Callable[[str, Mapping[str, object]], Surrogate]
    responses: Responses | None = None


class Strategy(Protocol):
    """Ask and tell on designs in native units. Made as `cls(context, parameters)`; no evaluation happens inside.

    The run evaluates the given designs first and tells them (origin `given`), so `tell` comes before the first `ask`
    when there are any, and may at any time bring designs that were not asked for, failed ones, and repeated ones.
    A strategy that cannot begin with fewer evaluations than some number says so in an attribute `minimum_budget`; one that
    finds more than designs has it in an attribute `findings`, a sequence of `Finding`, for results and reports.
    """

    Parameters: type
    capabilities: Capabilities

    def ask(self) -> Sequence[Proposal]:
        """One or more designs to evaluate next, inside the bounds, integers whole."""

    def tell(self, evaluations: Sequence[Evaluation]) -> None:
        """Receive the evaluations of the last proposals, in the order in which they were made."""


class TrackModel(Protocol):
    """A simulation of a vehicle on a track. Made as `cls()`; `metrics` and `histories` describe what it returns.

    A history called `time` (t,) is what others of t rows are plotted over in reports.
    """

    Parameters: type
    metrics: Sequence[Quantity]
    histories: Sequence[Quantity]

    def warm_up(self) -> None:
        """Do what is done once per process (compilation), so that it counts in no simulation's time."""

    def check(self, parameters: Any) -> None:
        """Raise InputError for parameters that are not allowed, without simulating."""

    def simulate(self, parameters: Any, histories: bool = False) -> Response:
        """Simulate one passage. Raises InputError for parameters not allowed, SimulationError if it diverges."""


@dataclass(frozen=True)
class Passage:
    """A passage that was simulated: the track model's parameters, and its response with histories."""

    parameters: Any
    response: Response


class DrawnTrackModel(TrackModel, Protocol):
    """A track model that draws its passages, for reports."""

    def figures(self, passages: Mapping[str, Passage], names: Sequence[str] = ()) -> Mapping[str, Figure]:
        """Figures by name of one labelled passage, or of several that they compare; a figure's label is its caption.

        names: which figures and in which order; none: the model's own choice. Raises InputError for an unknown one.
        """


def passage_figures(model: TrackModel, parameters: Mapping[str, Any], names: Sequence[str] = ()) -> Mapping[str, Figure]:
    """The figures of a track model for labelled parameters, each simulated once; none if the model does not draw."""
    drawing = drawing_model(model)
    if drawing is None:
        return {}
    simulated = {label: Passage(track, model.simulate(track, histories=True)) for label, track in parameters.items()}
    return drawing.figures(simulated, names)


def drawing_model(model: TrackModel) -> DrawnTrackModel | None:
    """The model itself, if it draws its passages."""
    return cast(DrawnTrackModel, model) if hasattr(model, "figures") else None


@dataclass(frozen=True)
class TrackExport:
    """A track in the form that the track model `imported-track` reads.

    matrices: mass, damping and stiffness (n, n), sparse, in kg, N s/m and N/m; parts: by name, matrices that are added times
    `factors`; rail: position in m, vertical unknown and rotation (k, 3), −1 where held; supports: position in m, unknown,
    damping in N s/m and, if need be, the unknown at its other end (s, 3 or 4); settings: further sections of its parameters.
    """

    matrices: Mapping[str, Any]
    rail: FloatArray
    supports: FloatArray
    settings: Mapping[str, Mapping[str, object]]
    parts: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    factors: Mapping[str, float] = field(default_factory=dict)


class ExportingTrackModel(TrackModel, Protocol):
    """A track model whose matrices can be taken elsewhere, and back."""

    def export(self, parameters: Any, parts: bool = False) -> TrackExport:
        """The track with these parameters; with `parts`, what is designed stands apart. Raises InputError."""


class Scalariser(Protocol):
    """Many objectives into one. Made as `cls(parameters, objectives, worst)`, worst: {objective: worst known value}.

    Values in `parameters` and `values` have their natural sign; `worst` and arrays are as minimised. One that goes by
    preference functions has an attribute `preferences` with them (see railsearch.preferences), for tables and figures.
    """

    Parameters: type

    @property
    def ready(self) -> bool:
        """False as long as the objectives of the reference design are needed and unknown."""

    @property
    def values(self) -> Mapping[str, object]:
        """The numbers in use, in plain types, for the record."""

    def prepare(self, reference: FloatArray) -> None:
        """Receive the objectives (m,) of the reference design."""

    def __call__(self, objectives: FloatArray) -> FloatArray:
        """Scalars (n,) of objectives (n, m)."""


class Host(Protocol):
    """Where plugins get one another by name."""

    def track_model(self, name: str) -> TrackModel: ...

    def surrogate(self, name: str, dimension: int, settings: Mapping[str, object]) -> Surrogate: ...
