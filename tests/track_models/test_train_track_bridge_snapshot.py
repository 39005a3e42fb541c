"""The snapshot is the state of train, track and bridge at its time."""

import numpy as np
import pytest
from bridges import short_bridge

from railsearch_plugins.dynamics.vehicles import at_rest
from railsearch_plugins.track_models.train_track_bridge import TrainTrackBridge
from railsearch_plugins.track_models.train_track_bridge.assembly import make_train
from railsearch_plugins.track_models.train_track_bridge.layout import first_axle
from railsearch_plugins.track_models.train_track_bridge.passage import simulate_passage

HERTZ = 1.4e9


@pytest.mark.parametrize("contact", ["rigid", HERTZ])
@pytest.mark.parametrize("time", [None, 0.0, 0.123])
def test_it_is_the_state_at_its_step(contact, time):
    parameters = short_bridge(snapshot_time=time, contact_stiffness=contact)
    simulated = simulate_passage(parameters, kept=np.arange(first_axle(parameters)[0].size))
    histories = TrainTrackBridge().simulate(parameters, histories=True).histories
    step = simulated.snapshot
    assert histories["snapshot_time"] == histories["time"][step]
    if time is not None:
        assert histories["snapshot_time"][0] == pytest.approx(time, abs=0.5 * simulated.time_step)
    u, numbering = simulated.passage.track_displacement[step], simulated.elements.numbering
    np.testing.assert_array_equal(histories["snapshot_rail_displacement"], u[numbering.rail[:, 0]])
    np.testing.assert_array_equal(histories["snapshot_sleeper_displacement"], u[numbering.sleepers])
    np.testing.assert_array_equal(histories["snapshot_bridge_deflection"][[0, -1]], 0.0)
    np.testing.assert_array_equal(histories["snapshot_bridge_deflection"][1:-1], u[numbering.bridge[1:-1, 0]])
    middle = np.interp(4.5, histories["bridge_position"], histories["snapshot_bridge_deflection"])
    assert middle == pytest.approx(histories["deck_deflection"][step], rel=1e-3)
    under_wheels = np.interp(
        histories["axle_position"][step], histories["rail_position"], histories["snapshot_rail_displacement"]
    )
    np.testing.assert_allclose(under_wheels, histories["rail_displacement"][step], rtol=0.05, atol=1e-6)
    pressed = 0.0 if contact == "rigid" else histories["contact_force"][step] / HERTZ
    np.testing.assert_allclose(
        histories["snapshot_wheel_displacement"],
        histories["rail_displacement"][step] - histories["irregularity"][step] + pressed,
        rtol=1e-9,
    )


def test_on_the_bridge_the_ballast_moves_with_the_deck():
    histories = TrainTrackBridge().simulate(short_bridge(), histories=True).histories
    sleepers, span = histories["sleeper_position"], histories["bridge_position"][-1]
    on = (sleepers > -0.1) & (sleepers < span + 0.1)
    deck = np.interp(sleepers[on], histories["bridge_position"], histories["snapshot_bridge_deflection"])
    np.testing.assert_allclose(histories["snapshot_ballast_displacement"][on], deck, atol=1e-15)
    near = on | (np.abs(sleepers - 0.5 * span) < 8.0)
    assert (histories["snapshot_ballast_displacement"][near & ~on] != 0.0).all()


def test_at_the_start_the_vehicle_stands_on_its_wheels():
    parameters = short_bridge(snapshot_time=0.0)
    histories = TrainTrackBridge().simulate(parameters, histories=True).histories
    standing = at_rest(make_train(parameters), histories["snapshot_wheel_displacement"])
    names = ("carbody_displacement", "carbody_pitch", "bogie_displacement", "bogie_pitch")
    carbody, pitch, bogie, bogie_pitch = (histories[f"snapshot_{name}"] for name in names)
    np.testing.assert_allclose([carbody[0], pitch[0]], standing[:2], rtol=1e-12)
    np.testing.assert_allclose(np.stack([bogie, bogie_pitch], axis=1).ravel(), standing[2:6], rtol=1e-12)


def test_without_a_time_the_middle_of_the_train_is_at_midspan():
    parameters = short_bridge(end_position=20.0)
    simulated = simulate_passage(parameters)
    axles = simulated.axles[simulated.snapshot]
    advance = parameters.speed * simulated.time_step
    assert axles[[0, -1]].mean() == pytest.approx(4.5, abs=0.51 * advance)


def test_a_run_that_ends_before_that_shows_its_last_step():
    simulated = simulate_passage(short_bridge(end_position=5.0))
    assert simulated.snapshot == simulated.axles.shape[0] - 1
    last = short_bridge(end_position=5.0, snapshot_time=8.0137 / short_bridge().speed)
    assert simulate_passage(last).snapshot == simulated.axles.shape[0] - 1
