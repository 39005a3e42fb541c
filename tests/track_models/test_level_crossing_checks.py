"""Parameters that are not allowed are refused with the field, the value and the remedy; those at the limit are not."""

from dataclasses import replace

import numpy as np
import pytest
from crossings import short_crossing

from railsearch.errors import InputError, SimulationError
from railsearch.parameters import amend_parameters, describe_parameters
from railsearch_plugins.track_models.level_crossing import LevelCrossing, LevelCrossingParameters
from railsearch_plugins.track_models.level_crossing.checks import checked, critical_speed

NOT_ALLOWED = [
    ("rail", "young_modulus", -1.0, "rail.young_modulus: allowed is > 0, received -1.0 Pa"),
    ("sleeper", "mass", 0.0, "sleeper.mass"),
    ("ballast", "stiffness", float("nan"), "ballast.stiffness: a finite number is needed, received nan"),
    ("slab", "density", float("inf"), "slab.density: a finite number"),
    ("railpad", "reading", "halved", "'per rail seat' or 'full-track', received 'halved'"),
    ("zone", "pad_stiffness", (50e6, -1.0), "zone.pad_stiffness"),
    ("zone", "pad_stiffness", (), "zone.pad_stiffness: one or more"),
    ("zone", "sleeper_distances", (), "zone.sleeper_distances: one or more"),
    (
        "zone",
        "sleeper_distances",
        (0.6,) * 40,
        "less than the shorter ballast track of 22 m, the zone being mirrored, received 24 m",
    ),
    ("zone", "strengthened_sleepers", 37, "there are 36 sleepers on the shorter ballast track of 22 m, received 37"),
    ("zone", "pad_stiffness", (1e8,) * 37, "zone.pad_stiffness: there are 36 sleepers"),
    ("zone", "type_2_strip_length", 12.1, "must fit in the crossing of 12 m, received 12.1 m; shorten it"),
    ("geometry", "total_length", 112.0, "geometry.total_length: approach and crossing need 112 m"),
    ("geometry", "slab_count", 20, "geometry.total_length: approach and crossing need 220 m"),
    ("windows", "force_before", 101.0, "windows.force_before"),
    ("windows", "force_after", 34.5, "the track ends 34 m after the first interface, received 34.5 m"),
    ("windows", "energy_sleepers", 167, "there are 166 sleepers before the crossing, received 167"),
    ("vehicle", "wheel_load", 18e3, "vehicle.wheel_load: bogie and wheelset alone weigh 18154"),
    ("vehicle", "wheel_load", "heavy", "vehicle.wheel_load: allowed is 'from masses'"),
    ("passage", "speed", 0.0, "passage.speed: allowed is > 0, received 0.0 m/s"),
    ("passage", "speed", 400.0, r"critical speed of the track, 297\.1 m/s"),
    ("passage", "time_step", 0.02, "no more than the smallest sleeper distance of 0.4 m in a step"),
    ("passage", "time_step", 1e-7, "the run would take 3.44571e\\+07 steps"),
    ("passage", "element_length", 1e-4, "the rail would have 1.34e\\+06 elements"),
    ("passage", "element_length", 0.41, "may not be longer than the smallest sleeper distance"),
    ("irregularity", "position", (0.0, 200.0), "2 positions and 0 heights"),
]


@pytest.mark.parametrize(("group", "field", "value", "message"), NOT_ALLOWED)
def test_what_is_not_allowed_is_refused(group, field, value, message):
    parameters = LevelCrossingParameters()
    wrong = replace(parameters, **{group: replace(getattr(parameters, group), **{field: value})})
    with pytest.raises(InputError, match=message):
        LevelCrossing().simulate(wrong)


@pytest.mark.parametrize(
    ("position", "message"),
    [((0.0, 50.0, 40.0, 200.0), "positions must ascend"), ((0.0, 1.0, 2.0, 3.0), "must cover the run from 0 to 134 m")],
)
def test_irregularity_must_ascend_and_cover_the_run(position, message):
    with pytest.raises(InputError, match=message):
        checked(
            amend_parameters(
                LevelCrossingParameters(), {"irregularity": {"position": position, "height": (0.0,) * 4}}, "site"
            )
        )


def test_force_window_must_hold_steps():
    with pytest.raises(InputError, match="must hold at least two time steps"):
        checked(amend_parameters(LevelCrossingParameters(), {"windows": {"force_before": 0.0, "force_after": 0.0}}, "site"))


@pytest.mark.parametrize(
    ("group", "field", "value"),
    [
        ("zone", "strengthened_sleepers", 36),
        ("zone", "strengthened_sleepers", 0),
        ("zone", "type_2_strip_length", 12.0),
        ("zone", "pad_stiffness", (1e8,)),
        ("zone", "sleeper_distances", (0.5,)),
        ("windows", "energy_sleepers", 166),
        ("windows", "force_after", 34.0),
        ("geometry", "slab_count", 1),
        ("vehicle", "wheel_load", "from masses"),
        ("passage", "speed", 30.0),
    ],
)
def test_values_at_the_limit_are_simulated(group, field, value):
    parameters = LevelCrossingParameters()
    response = LevelCrossing().simulate(
        replace(parameters, **{group: replace(getattr(parameters, group), **{field: value})})
    )
    assert all(np.isfinite(metric) for metric in response.metrics.values())


def test_critical_speed_of_the_winkler_beam():
    # Pads and ballast in series per sleeper distance under rail and strengthened sleepers, by hand.
    support = 1.0 / (1.0 / 1120e6 + 1.0 / 22.5e6) / 0.6
    mass = 6.977e-3 * 7800.0 + 150.0 / 0.6
    assert critical_speed(LevelCrossingParameters()) == pytest.approx((4.0 * support * 210e9 * 2.337e-5 / mass**2) ** 0.25)


def test_soft_strip_can_be_what_is_critical():
    parameters = LevelCrossingParameters()
    soft = replace(parameters, strip=replace(parameters.strip, type_2_stiffness=1e5))
    assert critical_speed(soft) == pytest.approx((4.0 * 1e5 * 210e9 * 2.337e-5 / (6.977e-3 * 7800.0) ** 2) ** 0.25)


@pytest.mark.filterwarnings("ignore:invalid value encountered:RuntimeWarning")
def test_diverged_simulation_is_reported():
    parameters = short_crossing()
    with pytest.raises(SimulationError, match="diverged"):
        LevelCrossing().simulate(replace(parameters, rail=replace(parameters.rail, young_modulus=1e300, second_moment=1e10)))


def test_response_holds_what_the_class_announces():
    response = LevelCrossing().simulate(short_crossing(), histories=True)
    assert list(response.metrics) == [quantity.name for quantity in LevelCrossing.metrics]
    assert list(response.histories) == [quantity.name for quantity in LevelCrossing.histories]
    assert not LevelCrossing().simulate(short_crossing()).histories


def test_same_parameters_give_the_same_bits():
    first, second = (LevelCrossing().simulate(short_crossing(), histories=True) for _ in range(2))
    assert first.metrics == second.metrics
    np.testing.assert_array_equal(first.histories["wheel_rail_force"], second.histories["wheel_rail_force"])


def test_every_parameter_has_meaning_and_source_and_every_dimensional_one_a_unit():
    without_unit = {"slab_count", "reading", "damping_ratio", "strengthened_sleepers", "energy_sleepers"}
    for description in describe_parameters(LevelCrossingParameters()):
        assert description.meaning, description.name
        assert description.source, description.name
        assert bool(description.unit) != (description.name.split(".")[-1] in without_unit), description.name
