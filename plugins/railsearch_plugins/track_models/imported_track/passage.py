"""One passage over an imported track, by the kernels that its band allows.

| half-bandwidth, envelope | way of a step |
|---|---|
| up to WIDE | compiled steps with a banded factor (`dynamics.moving_contact`) |
| longer, envelope up to MOST_VALUES | factor in its envelope (`dynamics.envelope`) |
| beyond | general sparse LU of scipy, two solutions a step |

A support whose damper is not on ground is seen by the last two only.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from railsearch.errors import InputError
from railsearch_plugins.dynamics import envelope
from railsearch_plugins.dynamics.handed_solver import (
    AnyPassage,
    EnvelopeSolver,
    PairObservation,
    TrackSolver,
)
from railsearch_plugins.dynamics.handed_solver import pass_over as pass_over_any
from railsearch_plugins.dynamics.kernels import WIDE
from railsearch_plugins.dynamics.moving_contact import Contact, Observation, Track, pass_over
from railsearch_plugins.dynamics.vehicles import Vehicle
from railsearch_plugins.single_wheel import irregularity_at, vehicle_matrices
from railsearch_plugins.track_models.imported_track.checks import run_of
from railsearch_plugins.track_models.imported_track.parameters import ImportedTrackParameters
from railsearch_plugins.track_models.imported_track.pattern import (
    Pattern,
    factor,
    sparse_factor,
    static_displacement,
    whole_matrix,
)
from railsearch_plugins.track_models.imported_track.rail import rail_contact
from railsearch_plugins.track_models.imported_track.track import ImportedMatrices, imported

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

ROUTES = ("banded", "envelope", "sparse")
NO_STEPS = np.empty(0, dtype=np.int64)


@dataclass(frozen=True)
class Simulated:
    """A passage, the track it went over with its values (m,) of M, C and K, and the wheel's positions (t,) in m."""

    track: ImportedMatrices
    values: dict[str, FloatArray]
    vehicle: Vehicle
    contact: Contact
    position: FloatArray
    passage: AnyPassage


class SparseSolver:
    """The equations of a step by general sparse LU; every response is a solution of its own."""

    def __init__(self, scaled_mass: Any, stiffness: Any, made: Any) -> None:
        self.scaled_mass = scaled_mass
        self.stiffness = stiffness
        self.made = made

    def product(self, velocity: FloatArray, displacement: FloatArray) -> FloatArray:
        """(2/dt) M v − K u (n,)."""
        return np.asarray(self.scaled_mass @ velocity - self.stiffness @ displacement)

    def solve(self, load: FloatArray) -> FloatArray:
        """A⁻¹ f (n,)."""
        return np.asarray(self.made.solve(load))

    def response(self, unknowns: IntArray, row: FloatArray) -> tuple[int, FloatArray]:
        """A⁻¹ Nᵀ, whole."""
        load = np.zeros(self.stiffness.shape[0])
        np.add.at(load, unknowns, row)
        return 0, self.solve(load)


def simulate_passage(parameters: ImportedTrackParameters, steps: IntArray = NO_STEPS, route: str | None = None) -> Simulated:
    """Run a passage; states of the track are kept at `steps` (k,); `route` is one of ROUTES in place of the fastest.

    Raises InputError for matrices that do not fit together, or that cannot carry the wheel where it starts.
    """
    track = imported(parameters)
    values = track.assembled(parameters.part_factors())
    position = wheel_positions(parameters, track)
    sign = -1.0 if parameters.rail.rotation == "minus slope" else 1.0
    profile = irregularity_at(parameters.irregularity, position)
    contact = rail_contact(track.rail, interpolation_of(parameters, track), position, profile, sign)
    vehicle = vehicle_matrices(parameters.vehicle)
    chosen = route or fastest_route(track)
    taken = {"banded": _banded_passage, "envelope": _any_passage, "sparse": _any_passage}[chosen]
    passage = taken(track, values, vehicle, contact, parameters.passage.time_step, steps, chosen)
    return Simulated(track, values, vehicle, contact, position, passage)


def check_stable(parameters: ImportedTrackParameters) -> None:
    """Raise InputError unless the equations of a step and of the start can be solved with the parts at their factors."""
    track, dt = imported(parameters), parameters.passage.time_step
    values = track.assembled(parameters.part_factors())
    newmark = _newmark(values, dt)
    _, row = factor(newmark, track.pattern) if track.pattern.short else sparse_factor(newmark, track.pattern)
    _check_newmark(row, track.pattern, dt)
    load = np.zeros(track.pattern.size)
    load[track.rail.vertical.max()] = 1.0
    if static_displacement(values["stiffness"], track.pattern, load) is None:
        _refuse_stiffness()


def fastest_route(track: ImportedMatrices) -> str:
    """One of ROUTES by the table at the head of this module."""
    grounded = bool((track.supports.other < 0).all())
    if track.pattern.half_bandwidth <= WIDE and grounded:
        return "banded"
    return "envelope" if track.pattern.short else "sparse"


def wheel_positions(parameters: ImportedTrackParameters, track: ImportedMatrices) -> FloatArray:
    """Wheel at start + n v dt up to the end of the run."""
    start, end = run_of(parameters, track)
    advance = parameters.passage.speed * parameters.passage.time_step
    steps = int(np.floor((end - start) / advance))
    return np.asarray(start + advance * np.arange(steps + 1))


def interpolation_of(parameters: ImportedTrackParameters, track: ImportedMatrices) -> str:
    """The interpolation asked for; 'auto' is 'hermite' with rotations and 'cubic' without."""
    asked = parameters.rail.interpolation
    return asked if asked != "auto" else "hermite" if track.rail.has_rotations else "cubic"


def start_displacement(
    track: ImportedMatrices, stiffness: FloatArray, contact: Contact, static_load: FloatArray
) -> FloatArray:
    """u (n,) under the static loads at the first positions. Raises InputError if the track cannot carry them."""
    load = np.zeros(track.pattern.size)
    np.add.at(load, contact.unknowns[0], static_load[:, None] * contact.rows[0, :, 0])
    if not load.any():
        return load
    displacement = static_displacement(stiffness, track.pattern, load)
    if displacement is None:
        _refuse_stiffness()
    return np.asarray(displacement)


def _refuse_stiffness() -> None:
    raise InputError(
        "imported-track.files.stiffness: a positive definite matrix is needed for the static equilibrium under the wheel, "
        "received one that is singular or indefinite with its parts; hold the track, and keep factors of parts at 0 or above"
    )


def _newmark(values: dict[str, FloatArray], time_step: float) -> FloatArray:
    rate = 2.0 / time_step
    return np.asarray(rate * (rate * values["mass"] + values["damping"]) + values["stiffness"])


def _check_newmark(row: int, pattern: Pattern, time_step: float) -> None:
    if row >= 0:
        raise InputError(
            "imported-track.files: 4 M/dt² + 2 C/dt + K with all parts must be positive definite, received pivots that "
            f"are not, first at unknown {pattern.order[row]} (from 0) with passage.time_step {time_step:g} s; give every "
            "unknown mass or stiffness, and keep factors of parts at 0 or above"
        )


def _banded_passage(
    track: ImportedMatrices,
    values: dict[str, FloatArray],
    vehicle: Vehicle,
    contact: Contact,
    time_step: float,
    steps: IntArray,
    route: str,
) -> AnyPassage:
    pattern = track.pattern
    _check_newmark(factor(_newmark(values, time_step), pattern)[1], pattern, time_step)
    start_displacement(track, values["stiffness"], contact, vehicle.static_load)
    bands = []
    for kind in ("mass", "damping", "stiffness"):
        band = np.zeros((max(pattern.half_bandwidth, WIDE) + 1, pattern.size))
        band[pattern.rows - pattern.columns, pattern.rows] = values[kind]
        bands.append(band)
    observation = Observation(supports=track.supports.unknown, kept=steps)
    made = pass_over(Track(*bands), vehicle, contact, time_step, observation)
    return AnyPassage(
        made.force,
        made.motion,
        made.vehicle_displacement,
        made.vehicle_velocity,
        made.support_integrals,
        made.track_displacement,
        made.track_velocity,
    )


def _any_passage(
    track: ImportedMatrices,
    values: dict[str, FloatArray],
    vehicle: Vehicle,
    contact: Contact,
    time_step: float,
    steps: IntArray,
    route: str,
) -> AnyPassage:
    start = start_displacement(track, values["stiffness"], contact, vehicle.static_load)
    make = _envelope_solver if route == "envelope" else _sparse_solver
    solver = make(track.pattern, values, contact, time_step)
    pairs = np.stack([track.supports.unknown, track.supports.other], axis=1)
    return pass_over_any(solver, vehicle, contact, time_step, start, PairObservation(pairs, steps))


def _envelope_solver(pattern: Pattern, values: dict[str, FloatArray], contact: Contact, time_step: float) -> TrackSolver:
    lower, row = factor(_newmark(values, time_step), pattern)
    _check_newmark(row, pattern, time_step)
    columns = envelope.Columns(*envelope.inverse_columns(*pattern.envelope, lower, np.unique(contact.unknowns)))
    scaled_mass = (2.0 / time_step) * values["mass"]
    return EnvelopeSolver(pattern.rows, pattern.columns, scaled_mass, -values["stiffness"], pattern.envelope, lower, columns)


def _sparse_solver(pattern: Pattern, values: dict[str, FloatArray], contact: Contact, time_step: float) -> TrackSolver:
    made, row = sparse_factor(_newmark(values, time_step), pattern)
    _check_newmark(row, pattern, time_step)
    mass, stiffness = (whole_matrix(values[kind], pattern).tocsr() for kind in ("mass", "stiffness"))
    return SparseSolver((2.0 / time_step) * mass, stiffness, made)
