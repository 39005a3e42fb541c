"""The fast model against TTB-2D and against the coupled twin."""

from dataclasses import replace

import coupled_twin
import numpy as np
import pytest
from bridges import CASES, case, file_profile, short_bridge

from railsearch_plugins.track_models.train_track_bridge import TrainTrackBridge
from railsearch_plugins.track_models.train_track_bridge import measures as m
from railsearch_plugins.track_models.train_track_bridge.ballast import ballast_values
from railsearch_plugins.track_models.train_track_bridge.layout import axle_offsets, first_axle
from railsearch_plugins.track_models.train_track_bridge.passage import irregularity_under, simulate_passage

SPERLING = {"c01_smooth": 0.660, "c02_irr": 1.666, "c05_irr_1veh_200": 1.939}


@pytest.fixture(scope="module", params=CASES)
def run(request):
    known = case(request.param)
    return known, TrainTrackBridge().simulate(known.parameters, histories=True)


def test_same_mesh_and_steps(run):
    known, response = run
    histories = response.histories
    assert histories["time"].size == known.steps
    assert histories["rail_position"].size == known.mesh["n_rail_nodes"]
    assert histories["bridge_position"].size == known.mesh["n_beam_nodes"]
    assert histories["sleeper_position"].size == known.mesh["n_sleepers"]
    assert histories["rail_position"][0] == pytest.approx(known.mesh["model_left_end_X"], abs=1e-9)
    assert histories["rail_position"][-1] == pytest.approx(known.mesh["model_right_end_X"], abs=1e-9)
    assert response.metrics["bridge_span"] == pytest.approx(50.1, rel=1e-12)


def test_extremes_within_what_another_code_can_differ(run):
    known, response = run
    metrics, scalars = response.metrics, known.scalars
    carbody = max(scalars["carbody_acc_max_centre_per_vehicle"])
    assert metrics["carbody_acceleration_max"] == pytest.approx(carbody, rel=1.5e-3)
    assert metrics["U_r"] == pytest.approx(scalars["rail_disp_max_down_all_m"], rel=1.5e-3)
    assert metrics["U_d"] == pytest.approx(scalars["bridge_defl_X25_max_down_m"], rel=1.5e-3)
    assert metrics["contact_force_max"] == pytest.approx(scalars["contact_force_onbridge_max_N"], rel=7e-3)
    assert metrics["contact_force_min"] == pytest.approx(scalars["contact_force_onbridge_min_N"], rel=7e-3)
    assert metrics["A_s"] == pytest.approx(scalars["sleeper_acc_max_window_-20_to_L+20"], rel=5e-3)
    assert metrics["W_z"] == pytest.approx(max(scalars["Wz_sperling_rms_cm_s2_per_vehicle"]), rel=1e-3)
    assert metrics["W_z"] == pytest.approx(SPERLING[known.name], rel=1e-3)
    assert metrics["bridge_frequency_1"] == pytest.approx(known.frequencies[0], rel=1e-6)
    assert metrics["bridge_frequency_2"] == pytest.approx(known.frequencies[1], rel=1e-6)


def test_sleepers_under_the_parked_train_dominate_when_they_count():
    known = case("c05_irr_1veh_200")
    response = TrainTrackBridge().simulate(replace(known.parameters, sleeper_range="all"))
    assert response.metrics["A_s"] == pytest.approx(known.scalars["sleeper_acc_max_all"], rel=5e-3)


@pytest.mark.parametrize("name", CASES[1:])
def test_forces_agree_closer_with_the_same_differences_in_time(name):
    known = case(name)
    front, step = first_axle(known.parameters)
    axles = front[:, None] - axle_offsets(known.parameters.vehicle, known.parameters.vehicles)
    irregularity = irregularity_under(known.parameters, axles)
    for order in (1, 2):
        irregularity[1:, :, order] = np.diff(irregularity[:, :, order - 1], axis=0) / step
        irregularity[0, :, order] = 0.0
    simulated = simulate_passage(known.parameters, irregularity)
    on_bridge = m.wheels_on_bridge(known.parameters, simulated.axles, simulated.elements.layout.span)
    force = simulated.passage.force[on_bridge]
    assert force.max() == pytest.approx(known.scalars["contact_force_onbridge_max_N"], rel=1e-3)
    assert force.min() == pytest.approx(known.scalars["contact_force_onbridge_min_N"], rel=1e-3)


TWINS = {
    "three vehicles": (case("c02_irr").parameters, 120),
    "onto a bridge": (short_bridge(), None),
    "three elements, shear": (
        short_bridge(elements_per_spacing=3, ballast_shear_stiffness=7.84e7, ballast_shear_damping=8e4, end_position=10.5),
        None,
    ),
    "one element": (short_bridge(elements_per_spacing=1, end_position=10.5, speed=60.1), None),
}


@pytest.mark.parametrize("name", TWINS)
def test_one_factorisation_equals_the_coupled_system_at_every_step(name):
    parameters, steps = TWINS[name]
    twin = coupled_twin.run(parameters, *ballast_values(parameters), file_profile, steps, 0.5 * parameters.bridge_length)
    simulated = simulate_passage(parameters)
    fast = m.make_histories(simulated)
    count = twin.position.size
    np.testing.assert_allclose(simulated.axles[:count, 0], twin.position, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(fast["contact_force"][:count], twin.force, rtol=1e-8)
    np.testing.assert_allclose(
        fast["carbody_acceleration"][:count], -twin.carbody_acceleration, atol=1e-8 * np.abs(twin.carbody_acceleration).max()
    )
    np.testing.assert_allclose(fast["deck_deflection"][:count], -twin.deck, atol=1e-8 * np.abs(twin.deck).max())
    if steps is None:
        np.testing.assert_allclose(fast["rail_lowest"], -twin.rail_lowest, atol=1e-8 * np.abs(twin.rail_lowest).max())
        np.testing.assert_allclose(
            fast["sleeper_acceleration_max"], twin.sleeper_acceleration, atol=1e-8 * twin.sleeper_acceleration.max()
        )
        np.testing.assert_allclose(
            fast["bridge_deflection_max"][1:-1], -twin.bridge_lowest, atol=1e-8 * np.abs(twin.bridge_lowest).max()
        )
