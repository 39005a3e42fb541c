"""What must hold between the parameters of a level crossing, and the critical speed of its track."""

import dataclasses

from railsearch.errors import InputError
from railsearch.parameters import make_parameters
from railsearch_plugins.dynamics import beam
from railsearch_plugins.single_wheel import check_irregularity, check_vehicle
from railsearch_plugins.track_models.level_crossing.layout import SAME_PLACE, sleeper_distances_from_crossing
from railsearch_plugins.track_models.level_crossing.parameters import LevelCrossingParameters

# What fits in a gigabyte or so; far beyond what converges.
MOST_STEPS = 1e6
MOST_ELEMENTS = 1e5


def checked(parameters: LevelCrossingParameters) -> LevelCrossingParameters:
    """The parameters themselves, if every field is in its range and they fit together.

    Raises InputError that names the field, the value received and what is allowed.
    """
    sound = make_parameters(LevelCrossingParameters, dataclasses.asdict(parameters), "level-crossing")
    _check_geometry(sound)
    _check_zone(sound)
    _check_windows(sound)
    check_vehicle(sound.vehicle, "level-crossing")
    _check_passage(sound)
    _check_mesh(sound)
    check_irregularity(sound.irregularity, (0.0, sound.geometry.total_length), "level-crossing")
    return sound


def critical_speed(parameters: LevelCrossingParameters) -> float:
    """The lowest critical speed in m/s over ballast track, embedded rail and slab.

    Of a beam on a Winkler foundation with k and m per metre: on ballast track the softest pad and the ballast in series
    and rail and sleeper; the rail on the softer strip; rail and slab together on the subgrade.
    """
    rail, slab, ballast = parameters.rail, parameters.slab, parameters.ballast
    share = 0.5 if parameters.railpad.reading == "full-track" else 1.0
    pad = share * min(parameters.railpad.stiffness, *parameters.zone.pad_stiffness)
    spacing = parameters.sleeper.spacing
    support = 1.0 / (1.0 / pad + 1.0 / ballast.stiffness) / spacing
    heaviest = max(parameters.sleeper.mass, parameters.sleeper.strengthened_mass)
    strip = min(parameters.strip.type_1_stiffness, parameters.strip.type_2_stiffness)
    both = rail.bending_stiffness + slab.bending_stiffness
    return min(
        beam.critical_speed(support, rail.bending_stiffness, rail.mass_per_length + heaviest / spacing),
        beam.critical_speed(strip, rail.bending_stiffness, rail.mass_per_length),
        beam.critical_speed(slab.subgrade_stiffness, both, rail.mass_per_length + slab.mass_per_length),
    )


def _require(holds: bool, field: str, rule: str, value: object, remedy: str) -> None:
    if not holds:
        raise InputError(f"level-crossing.{field}: {rule}, received {value}; {remedy}")


def _check_geometry(parameters: LevelCrossingParameters) -> None:
    geometry = parameters.geometry
    _require(
        geometry.departure_length > parameters.sleeper.spacing,
        "geometry.total_length",
        f"approach and crossing need {geometry.crossing_end:g} m and there must be ballast track beyond them",
        f"{geometry.total_length:g} m",
        "lengthen the track or shorten the crossing",
    )


def _check_zone(parameters: LevelCrossingParameters) -> None:
    geometry, zone = parameters.geometry, parameters.zone
    _require(len(zone.pad_stiffness) > 0, "zone.pad_stiffness", "one or more pads are needed", "none", "give the pads")
    _require(
        len(zone.sleeper_distances) > 0, "zone.sleeper_distances", "one or more are needed", "none", "give the distances"
    )
    _require(
        zone.type_2_strip_length <= geometry.crossing_length + SAME_PLACE,
        "zone.type_2_strip_length",
        f"the strip must fit in the crossing of {geometry.crossing_length:g} m",
        f"{zone.type_2_strip_length:g} m",
        "shorten it",
    )
    shorter = min(geometry.approach_length, geometry.departure_length)
    _require(
        sum(zone.sleeper_distances) < shorter,
        "zone.sleeper_distances",
        f"their sum must be less than the shorter ballast track of {shorter:g} m, the zone being mirrored",
        f"{sum(zone.sleeper_distances):g} m",
        "use fewer or shorter distances",
    )
    sleepers = sleeper_distances_from_crossing(zone, parameters.sleeper.spacing, shorter).size
    for field, count in (("strengthened_sleepers", zone.strengthened_sleepers), ("pad_stiffness", len(zone.pad_stiffness))):
        rule = f"there are {sleepers} sleepers on the shorter ballast track of {shorter:g} m"
        _require(count <= sleepers, f"zone.{field}", rule, count, f"use {sleepers} or fewer, or lengthen the track")


def _check_windows(parameters: LevelCrossingParameters) -> None:
    geometry, windows = parameters.geometry, parameters.windows
    _require(
        windows.force_before <= geometry.approach_length,
        "windows.force_before",
        f"the window must begin on the approach of {geometry.approach_length:g} m",
        f"{windows.force_before:g} m",
        "shorten the window or lengthen geometry.approach_length",
    )
    room = geometry.total_length - geometry.approach_length
    _require(
        windows.force_after is None or windows.force_after <= room,
        "windows.force_after",
        f"the track ends {room:g} m after the first interface",
        f"{windows.force_after} m",
        "shorten the window or lengthen geometry.total_length",
    )
    after = geometry.crossing_length if windows.force_after is None else windows.force_after
    least = 2.0 * parameters.passage.speed * parameters.passage.time_step
    _require(
        windows.force_before + after >= least,
        "windows.force_before",
        f"the force window must hold at least two time steps ({least:g} m)",
        f"a window of {windows.force_before + after:g} m",
        "lengthen the window",
    )
    approach = sleeper_distances_from_crossing(parameters.zone, parameters.sleeper.spacing, geometry.approach_length).size
    _require(
        windows.energy_sleepers <= approach,
        "windows.energy_sleepers",
        f"there are {approach} sleepers before the crossing",
        windows.energy_sleepers,
        "measure fewer or lengthen geometry.approach_length",
    )


def _check_passage(parameters: LevelCrossingParameters) -> None:
    passage, critical = parameters.passage, critical_speed(parameters)
    _require(
        passage.speed < critical,
        "passage.speed",
        f"the speed must stay below the critical speed of the track, {critical:.1f} m/s ({3.6 * critical:.0f} km/h)",
        f"{passage.speed:g} m/s",
        "lower the speed or stiffen the track",
    )
    closest = min(parameters.sleeper.spacing, *parameters.zone.sleeper_distances)
    _require(
        passage.speed * passage.time_step <= closest,
        "passage.time_step",
        f"the wheel may advance by no more than the smallest sleeper distance of {closest:g} m in a step",
        f"{passage.time_step:g} s ({passage.speed * passage.time_step:g} m)",
        f"use {closest / passage.speed:.2g} s or less",
    )
    steps = parameters.geometry.total_length / (passage.speed * passage.time_step)
    _require(
        steps <= MOST_STEPS,
        "passage.time_step",
        f"the run would take {steps:g} steps and {MOST_STEPS:g} are the most",
        f"{passage.time_step:g} s",
        "lengthen the time step",
    )


def _check_mesh(parameters: LevelCrossingParameters) -> None:
    passage, zone = parameters.passage, parameters.zone
    closest = min(parameters.sleeper.spacing, *zone.sleeper_distances)
    elements = parameters.geometry.total_length / passage.element_length
    _require(
        elements <= MOST_ELEMENTS,
        "passage.element_length",
        f"the rail would have {elements:g} elements and {MOST_ELEMENTS:g} are the most",
        f"{passage.element_length:g} m",
        "lengthen the elements",
    )
    _require(
        passage.element_length <= closest + SAME_PLACE,
        "passage.element_length",
        f"an element may not be longer than the smallest sleeper distance of {closest:g} m",
        f"{passage.element_length:g} m",
        "shorten the elements",
    )
