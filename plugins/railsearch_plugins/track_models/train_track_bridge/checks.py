"""What must hold between the parameters of a train on a bridge, and the critical speed of its track."""

import dataclasses

from railsearch.errors import InputError
from railsearch.parameters import make_parameters
from railsearch_plugins.dynamics import beam
from railsearch_plugins.track_irregularity import spectrum_named
from railsearch_plugins.track_models.train_track_bridge.ballast import ballast_values
from railsearch_plugins.track_models.train_track_bridge.layout import (
    ROUNDING,
    axle_offsets,
    element_length,
    meshed_span,
    run_of_first_axle,
)
from railsearch_plugins.track_models.train_track_bridge.parameters import LEVEL, TrainTrackBridgeParameters
from railsearch_plugins.track_models.train_track_bridge.profile import measured_profile

# Beyond any track that a train runs on; heights in mm are found out by it.
HIGHEST = 0.2
# What fits in a gigabyte or so; far beyond what converges.
MOST_STEPS = 1e5
MOST_ELEMENTS = 1e5


def checked(parameters: TrainTrackBridgeParameters) -> TrainTrackBridgeParameters:
    """The parameters themselves, if every field is in its range and they fit together.

    Raises InputError that names the field, the value received and what is allowed.
    """
    sound = make_parameters(TrainTrackBridgeParameters, dataclasses.asdict(parameters), "train-track-bridge")
    _check_vehicle(sound)
    _check_bridge(sound)
    _check_run(sound)
    _check_speed(sound)
    _check_discretisation(sound)
    _check_irregularity(sound)
    return sound


def critical_speed(parameters: TrainTrackBridgeParameters) -> float:
    """The speed in m/s at which the train outruns the waves of the track off the bridge.

    Of the rail on a Winkler foundation: pad, ballast and sub-ballast in series; rail, sleeper and ballast move along.
    """
    mass, stiffness = ballast_values(parameters)
    series = 1.0 / (1.0 / parameters.pad_stiffness + 1.0 / stiffness + 1.0 / parameters.subballast_stiffness)
    spacing, rail = parameters.sleeper_spacing, parameters.rail
    moving = rail.mass_per_length + (parameters.sleeper_mass + mass) / spacing
    return beam.critical_speed(series / spacing, rail.bending_stiffness, moving)


def _require(holds: bool, field: str, rule: str, value: object, remedy: str) -> None:
    if not holds:
        raise InputError(f"train-track-bridge.{field}: {rule}, received {value}; {remedy}")


def _check_vehicle(parameters: TrainTrackBridgeParameters) -> None:
    vehicle = parameters.vehicle
    _require(
        vehicle.axle_distance < vehicle.bogie_distance,
        "vehicle.axle_distance",
        f"the bogies, {vehicle.bogie_distance:g} m from the centre, must not overlap",
        f"{vehicle.axle_distance:g} m",
        "bring the axles of a bogie together",
    )
    length = float(axle_offsets(vehicle, 1)[-1])
    _require(
        vehicle.pitch > length or parameters.vehicles == 1,
        "vehicle.pitch",
        f"the vehicles, {length:g} m from first to last axle, must not overlap",
        f"{vehicle.pitch:g} m",
        "lengthen the pitch",
    )


def _check_bridge(parameters: TrainTrackBridgeParameters) -> None:
    element = element_length(parameters)
    _require(
        parameters.bridge_length >= element,
        "bridge_length",
        f"the span must hold at least one element of {element:g} m",
        f"{parameters.bridge_length:g} m",
        "lengthen the span or raise elements_per_spacing",
    )
    _require(
        0.5 * parameters.bridge_length <= meshed_span(parameters),
        "bridge_length",
        "its middle must lie on the meshed span",
        f"{parameters.bridge_length:g} m",
        "raise elements_per_spacing",
    )


def _check_run(parameters: TrainTrackBridgeParameters) -> None:
    start, end = run_of_first_axle(parameters)
    _require(
        start <= 0.0,
        "start_position",
        "the first axle must start before the bridge, at 0 m or less",
        f"{start:g} m",
        "start earlier",
    )
    _require(end > 0.0, "end_position", "the first axle must reach the bridge", f"{end:g} m", "let the run end later")
    duration, time = (end - start) / parameters.speed, parameters.snapshot_time
    _require(
        time is None or time <= duration * (1.0 + ROUNDING),
        "snapshot_time",
        f"the snapshot must lie within the run, which takes {duration:.4g} s",
        f"{time} s",
        "give an earlier time or leave it out",
    )


def _check_speed(parameters: TrainTrackBridgeParameters) -> None:
    critical = critical_speed(parameters)
    _require(
        parameters.speed < critical,
        "speed",
        f"the speed must stay below the critical speed of the track, {critical:.1f} m/s ({3.6 * critical:.0f} km/h)",
        f"{parameters.speed:g} m/s",
        "lower the speed or stiffen the track",
    )


def _check_discretisation(parameters: TrainTrackBridgeParameters) -> None:
    spacing, (start, end) = parameters.sleeper_spacing, run_of_first_axle(parameters)
    advance = parameters.speed * parameters.time_step
    _require(
        advance <= spacing,
        "time_step",
        f"the train may advance by no more than the sleeper spacing of {spacing:g} m in a step",
        f"{parameters.time_step:g} s ({advance:g} m)",
        f"use {spacing / parameters.speed:.2g} s or less",
    )
    steps = (end - start) / advance
    _require(
        steps <= MOST_STEPS,
        "time_step",
        f"the run would take {steps:g} steps and {MOST_STEPS:g} are the most",
        f"{parameters.time_step:g} s",
        "lengthen the time step",
    )
    train = float(axle_offsets(parameters.vehicle, parameters.vehicles)[-1])
    elements = (end - start + train + 2.0 * parameters.margin_sleepers * spacing) / element_length(parameters)
    _require(
        elements <= MOST_ELEMENTS,
        "elements_per_spacing",
        f"the rail would have {elements:g} elements and {MOST_ELEMENTS:g} are the most",
        parameters.elements_per_spacing,
        "use fewer or shorten the run",
    )


def _check_irregularity(parameters: TrainTrackBridgeParameters) -> None:
    if parameters.irregularity_file:
        _check_file(parameters)
        return
    if parameters.irregularity_spectrum != LEVEL:
        _check_spectrum(parameters.irregularity_spectrum)
    shortest, longest, period = (
        parameters.irregularity_shortest,
        parameters.irregularity_longest,
        parameters.irregularity_period,
    )
    _require(
        shortest <= longest <= period,
        "irregularity_longest",
        f"it must lie between the shortest wavelength, {shortest:g} m, and the period, {period:g} m",
        f"{longest:g} m",
        "order the wavelengths or lengthen irregularity_period",
    )
    start, end = run_of_first_axle(parameters)
    run = end - start + float(axle_offsets(parameters.vehicle, parameters.vehicles)[-1])
    _require(
        run <= period,
        "irregularity_period",
        f"a generated profile must not repeat under the train: its axles run over {run:g} m",
        f"{period:g} m",
        "lengthen the period",
    )
    nyquist = 2.0 * parameters.speed * parameters.time_step
    _require(
        shortest >= nyquist,
        "irregularity_shortest",
        f"waves shorter than two steps of the train, {nyquist:g} m, cannot be followed",
        f"{shortest:g} m",
        "shorten the time step or leave short waves out",
    )


def _check_spectrum(name: str) -> None:
    try:
        spectrum_named(name)
    except InputError as error:
        raise InputError(f"train-track-bridge.irregularity_spectrum: {error}; '{LEVEL}' is a level track") from None


def _check_file(parameters: TrainTrackBridgeParameters) -> None:
    spline = measured_profile(parameters.irregularity_file).spline
    positions, highest = spline.x, float(abs(spline(spline.x)).max())
    _require(
        highest <= HIGHEST,
        "irregularity_file",
        f"heights must be in m and not above {HIGHEST:g} m",
        f"{highest:g} m",
        "divide them by 1000 if they are in mm, or take their mean off",
    )
    start, end = run_of_first_axle(parameters)
    first = start - float(axle_offsets(parameters.vehicle, parameters.vehicles)[-1])
    rounding = ROUNDING * element_length(parameters)
    _require(
        positions[0] <= first + rounding and positions[-1] >= end - rounding,
        "irregularity_file",
        f"the profile must cover the run of all axles from {first:g} to {end:g} m",
        f"{positions[0]:g} to {positions[-1]:g} m",
        "extend the profile or shorten the run",
    )
