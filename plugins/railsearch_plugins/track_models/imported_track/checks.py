"""What must hold between the parameters of an imported track and its files, and warnings about their units."""

import dataclasses
import warnings

import numpy as np
from numpy.typing import NDArray

from railsearch.errors import InputError
from railsearch.parameters import make_parameters
from railsearch_plugins.single_wheel import check_irregularity, check_vehicle
from railsearch_plugins.track_models.imported_track.parameters import ImportedTrackParameters
from railsearch_plugins.track_models.imported_track.pattern import static_displacement
from railsearch_plugins.track_models.imported_track.track import ImportedMatrices, imported

FloatArray = NDArray[np.float64]

MODEL = "imported-track"
SAME_PLACE = 1e-9
MOST_STEPS = 1e6
# What railway tracks do not leave: distance of rail nodes in m, deflection under a wheel in m, frequency in Hz.
LONGEST_SPACING = 2.0
DEFLECTION = (1e-5, 5e-2)
FREQUENCY = (3.0, 3e3)


class UnitWarning(UserWarning):
    """Numbers of an imported track that no railway track has: units are likely to be mixed."""


def checked(parameters: ImportedTrackParameters) -> tuple[ImportedTrackParameters, ImportedMatrices]:
    """The parameters themselves and the track that they name, if every field is in its range and they fit together.

    Raises InputError that names the field or file, the value received and what is allowed.
    """
    sound = make_parameters(ImportedTrackParameters, dataclasses.asdict(parameters), MODEL)
    track = imported(sound)
    _check_rail(sound, track)
    run = run_of(sound, track)
    check_vehicle(sound.vehicle, MODEL)
    check_irregularity(sound.irregularity, run, MODEL)
    _check_steps(sound, run)
    _check_windows(sound, track, run)
    return sound, track


def run_of(parameters: ImportedTrackParameters, track: ImportedMatrices) -> tuple[float, float]:
    """Start and end of the run in m. Raises InputError unless the rail nodes cover it."""
    first, last = float(track.rail.position[0]), float(track.rail.position[-1])
    passage = parameters.passage
    start = first if passage.start is None else passage.start
    end = last if passage.end is None else passage.end
    if not (first - SAME_PLACE <= start < end <= last + SAME_PLACE):
        raise InputError(
            f"{MODEL}.passage.start, end: the rail nodes of {parameters.files.rail} must cover the run, from {first:g} to "
            f"{last:g} m, received a run from {start:g} to {end:g} m; shorten the run or export more rail nodes"
        )
    return start, end


def windows_of(parameters: ImportedTrackParameters, track: ImportedMatrices) -> tuple[float, float, float, float]:
    """The force window and the first and last position of measured supports, in m."""
    windows, (start, end) = parameters.windows, run_of(parameters, track)
    supports = track.supports.position
    given = (windows.force_from, windows.force_to, windows.energy_from, windows.energy_to)
    usual = (start, end, float(supports[0]), float(supports[-1]))
    return tuple(u if g is None else g for g, u in zip(given, usual, strict=True))  # type: ignore[return-value]


def measured_supports(parameters: ImportedTrackParameters, track: ImportedMatrices) -> NDArray[np.bool_]:
    """Mask (s,) of the supports whose energy is measured, edges included."""
    _, _, first, last = windows_of(parameters, track)
    position = track.supports.position
    return np.asarray((position >= first - SAME_PLACE) & (position <= last + SAME_PLACE))


def warn_of_units(parameters: ImportedTrackParameters, track: ImportedMatrices) -> None:
    """Warn (UnitWarning) of rail nodes, deflections under the wheel and frequencies that no railway track has.

    The frequency is Rayleigh's quotient √(uᵀK u/uᵀM u)/2π of the shape u under a load on the rail amid the run.
    """
    start, end = run_of(parameters, track)
    middle = int(np.argmin(np.abs(track.rail.position - 0.5 * (start + end)) + 1e9 * (track.rail.vertical < 0)))
    load, values = np.zeros(track.pattern.size), track.assembled(parameters.part_factors())
    load[track.rail.vertical[middle]] = parameters.vehicle.static_load
    shape = static_displacement(values["stiffness"], track.pattern, load)
    _warn_unless(
        float(np.diff(track.rail.position).max()), (0.0, LONGEST_SPACING), "rail nodes up to", "m apart", "positions in m"
    )
    if shape is None:
        return
    deflection = float(shape[track.rail.vertical[middle]])
    energy, inertia = load @ shape, _quadratic(values["mass"], track, shape)
    units = "M in kg, K in N/m"
    _warn_unless(deflection, DEFLECTION, "a deflection under the wheel of", "m", units)
    if inertia > 0.0:
        frequency = float(np.sqrt(energy / inertia) / (2.0 * np.pi))
        _warn_unless(frequency, FREQUENCY, "a frequency of the track under the wheel of", "Hz", units)


def _quadratic(values: FloatArray, track: ImportedMatrices, shape: FloatArray) -> float:
    rows, columns = track.pattern.rows, track.pattern.columns
    twice = np.where(rows == columns, 1.0, 2.0)
    return float((twice * values * shape[rows] * shape[columns]).sum())


def _warn_unless(value: float, allowed: tuple[float, float], what: str, unit: str, units: str) -> None:
    if not allowed[0] <= value <= allowed[1]:
        warnings.warn(
            f"{MODEL}: {what} {value:.3g} {unit} is not that of a railway track, {allowed[0]:g} to {allowed[1]:g} {unit} "
            f"is; are the units SI ({units})?",
            UnitWarning,
            stacklevel=4,
        )


def _check_rail(parameters: ImportedTrackParameters, track: ImportedMatrices) -> None:
    asked, files = parameters.rail.interpolation, parameters.files
    if asked == "hermite" and not track.rail.has_rotations:
        raise InputError(
            f"{MODEL}.rail.interpolation: 'hermite' needs a column of rotations in {files.rail}, received none; "
            "use 'cubic', or export the rotations"
        )


def _check_steps(parameters: ImportedTrackParameters, run: tuple[float, float]) -> None:
    passage = parameters.passage
    steps = (run[1] - run[0]) / (passage.speed * passage.time_step)
    if not 2.0 <= steps <= MOST_STEPS:
        raise InputError(
            f"{MODEL}.passage.time_step: a run of {run[1] - run[0]:g} m at {passage.speed:g} m/s must take 2 to "
            f"{MOST_STEPS:g} steps, received {passage.time_step:g} s, which makes {steps:g}; change the time step"
        )


def _check_windows(parameters: ImportedTrackParameters, track: ImportedMatrices, run: tuple[float, float]) -> None:
    first, last, energy_first, energy_last = windows_of(parameters, track)
    least = 2.0 * parameters.passage.speed * parameters.passage.time_step
    if not (run[0] - SAME_PLACE <= first and last <= run[1] + SAME_PLACE and last - first >= least):
        raise InputError(
            f"{MODEL}.windows.force_from, force_to: the force window must lie in the run from {run[0]:g} to {run[1]:g} m "
            f"and hold two time steps ({least:g} m), received {first:g} to {last:g} m; move the window or lengthen the run"
        )
    count = int(np.count_nonzero(measured_supports(parameters, track)))
    if count < 2:
        raise InputError(
            f"{MODEL}.windows.energy_from, energy_to: two or more supports must be measured, received {count} between "
            f"{energy_first:g} and {energy_last:g} m; widen the window"
        )
