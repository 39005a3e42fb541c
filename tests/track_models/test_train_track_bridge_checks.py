"""Parameters of a train on a bridge that are not allowed are refused with the field, the value and the remedy."""

from dataclasses import replace

import numpy as np
import pytest
from bridges import PROFILE, short_bridge

from railsearch.errors import InputError, SimulationError
from railsearch.parameters import describe_parameters
from railsearch_plugins.track_models.train_track_bridge import TrainTrackBridge, TrainTrackBridgeParameters
from railsearch_plugins.track_models.train_track_bridge.checks import checked, critical_speed
from railsearch_plugins.track_models.train_track_bridge.parameters import Vehicle

NOT_ALLOWED = [
    ({"bridge_length": 0.2}, "bridge_length: the span must hold at least one element of 0.3 m, received 0.2 m; lengthen"),
    ({"bridge_length": -1.0}, "bridge_length: allowed is > 0, received -1.0 m"),
    (
        {"speed": 400.0},
        "speed: the speed must stay below the critical speed of the track, 220.0 m/s (792 km/h), received 400 m/s",
    ),
    ({"speed": 0.0}, "speed: allowed is > 0"),
    ({"speed": float("nan")}, "speed: a finite number"),
    ({"pad_damping": -1.0}, "pad_damping: allowed is ≥ 0, received -1.0 N s/m"),
    ({"ballast_damping": -1.0}, "ballast_damping: allowed is ≥ 0"),
    ({"bridge_damping": -0.01}, "bridge_damping: allowed is ≥ 0 and < 1"),
    ({"bridge_damping": 2.0}, "bridge_damping: allowed is ≥ 0 and < 1, received 2.0"),
    ({"ballast_angle": 0.0}, "ballast_angle: allowed is > 0 and ≤ 60"),
    ({"ballast_angle": 89.0}, "ballast_angle: allowed is > 0 and ≤ 60"),
    ({"vehicles": 0}, "vehicles: allowed is ≥ 1"),
    (
        {"irregularity_spectrum": "chinese"},
        "irregularity_spectrum: unknown spectrum 'chinese'; there are german, german-low, german-high, fra-1",
    ),
    (
        {"irregularity_longest": 2.0},
        "irregularity_longest: it must lie between the shortest wavelength, 3 m, and the period",
    ),
    ({"irregularity_shortest": 0.05}, "irregularity_shortest: waves shorter than two steps of the train"),
    ({"irregularity_file": "no-such-file.csv"}, "irregularity_file: no-such-file.csv: cannot be read"),
    ({"irregularity_file": str(PROFILE), "start_position": -60.0}, "must cover the run of all axles from -131.56 to"),
    ({"start_position": 1.0}, "start_position: allowed is ≤ 0, received 1.0 m"),
    ({"vehicles": 16}, "irregularity_period: a generated profile must not repeat under the train: its axles run over"),
    ({"end_position": -5.0}, "end_position: the first axle must reach the bridge"),
    (
        {"snapshot_time": 6.0},
        "snapshot_time: the snapshot must lie within the run, which takes 5.057 s, received 6.0 s; give an earlier time",
    ),
    ({"snapshot_time": -1.0}, "snapshot_time: allowed is ≥ 0, received -1.0 s"),
    ({"time_step": 0.1}, "time_step: the train may advance by no more than the sleeper spacing of 0.6 m in a step"),
    ({"time_step": 1e-9}, "time_step: the run would take"),
    ({"bridge_length": 1e6}, "the most"),
    ({"contact_stiffness": "soft"}, "contact_stiffness: allowed is 'rigid'"),
    ({"vehicle": Vehicle(pitch=20.0)}, "vehicle.pitch: the vehicles, 21.56 m from first to last axle, must not overlap"),
    ({"vehicle": Vehicle(axle_distance=10.0)}, "vehicle.axle_distance: the bogies"),
]


@pytest.mark.parametrize(("changes", "message"), NOT_ALLOWED, ids=[message[:40] for _, message in NOT_ALLOWED])
def test_parameters_that_are_not_allowed(changes, message):
    with pytest.raises(InputError) as caught:
        TrainTrackBridge().check(replace(TrainTrackBridgeParameters(), **changes))
    assert message in str(caught.value)
    assert "train-track-bridge." in str(caught.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1 2 3\n4 5 6\n7 8 9\n1 2 3\n", "two columns"),
        ("0,0\n1,0\n", "four or more"),
        ("0 0\n2 0\n1 0\n3 0\n", "positions must ascend, received 1 m after 2 m"),
        ("position,height\n0,0\n", "four or more"),
        ("0 0\n1 x\n2 0\n3 0\n", "two columns of numbers"),
        ("-200 0\n0 0.9\n50 -0.4\n300 0\n", "heights must be in m and not above 0.2 m, received 0.9 m; divide them by 1000"),
        ("0 0\n1 nan\n2 0\n3 0\n", "finite positions and heights"),
    ],
)
def test_files_that_are_no_profile(tmp_path, text, message):
    file = tmp_path / "profile.csv"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=message):
        checked(TrainTrackBridgeParameters(irregularity_file=str(file)))


def test_parameters_at_the_limit_are_allowed():
    checked(TrainTrackBridgeParameters(bridge_length=0.3, end_position=40.0))
    checked(TrainTrackBridgeParameters(speed=0.999 * critical_speed(TrainTrackBridgeParameters())))
    checked(TrainTrackBridgeParameters(irregularity_file=str(PROFILE), start_position=-24.0, end_position=158.4))


def test_default_run_is_measured_on_approach_bridge_and_departure():
    model = TrainTrackBridge()
    sound = checked(TrainTrackBridgeParameters())
    response = model.simulate(sound, histories=True)
    axles = response.histories["axle_position"]
    assert axles[0, 0] == pytest.approx(-45.0)
    assert axles[-1, -1] == pytest.approx(50.1 + 30.0)
    assert np.abs(response.histories["irregularity"][axles <= -45.0]).max() == 0.0
    assert np.abs(response.histories["irregularity"][axles > -30.0]).max() > 1e-4


def test_given_ballast_replaces_the_cone():
    cone = TrainTrackBridge().simulate(short_bridge()).metrics
    given = short_bridge(ballast_mass=443.43503123934096, ballast_stiffness=130384041.60657689, ballast_depth=0.3)
    assert TrainTrackBridge().simulate(given).metrics == pytest.approx(cone, rel=1e-7)


def test_a_diverging_simulation_is_an_error_of_the_simulation():
    absurd = short_bridge(pad_stiffness=1e300, ballast_stiffness=1e300, subballast_stiffness=1e300)
    with pytest.raises(SimulationError, match="diverged"):
        TrainTrackBridge().simulate(absurd)


def test_every_parameter_has_meaning_and_source():
    for description in describe_parameters(TrainTrackBridgeParameters()):
        assert description.meaning, description.name
        assert description.source, description.name
