"""What mechanics demands of the train-track-bridge model: equilibrium, energy, frequencies, limits, convergence."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse
from bridges import case, short_bridge

from railsearch_plugins.dynamics.moving_contact import static_displacement
from railsearch_plugins.track_models.train_track_bridge import TrainTrackBridge, TrainTrackBridgeParameters
from railsearch_plugins.track_models.train_track_bridge.assembly import (
    assemble_track,
    bridge_frequencies,
    make_train,
    rayleigh_factors,
    track_matrices,
)
from railsearch_plugins.track_models.train_track_bridge.ballast import ballast_values
from railsearch_plugins.track_models.train_track_bridge.layout import first_axle
from railsearch_plugins.track_models.train_track_bridge.parameters import Rail
from railsearch_plugins.track_models.train_track_bridge.passage import simulate_passage

LEVEL = {"irregularity_file": "", "irregularity_spectrum": "none"}


def sparse(band):
    lower = scipy.sparse.diags_array([band[k, k:] for k in range(band.shape[0])], offsets=range(0, -band.shape[0], -1))
    return scipy.sparse.csr_array(lower + lower.T - scipy.sparse.diags_array([band[0]], offsets=[0]))


def test_ground_and_supports_carry_the_parked_train():
    parameters = short_bridge(**LEVEL, start_position=-1.0, end_position=0.5)
    simulated = simulate_passage(parameters, kept=np.array([0]))
    layout, numbering = simulated.elements.layout, simulated.elements.numbering
    start = simulated.passage.track_displacement[0]
    ground = parameters.subballast_stiffness * start[numbering.ballast[~layout.on_bridge]].sum()
    # What the bridge carries goes through its vertical unknowns; the sleepers on the supports press on those directly.
    lift = np.zeros(start.size)
    lift[numbering.rail[:, 0]] = lift[numbering.sleepers] = 1.0
    lift[numbering.ballast[numbering.ballast >= 0]] = 1.0
    lift[numbering.bridge[1:-1, 0]] = 1.0
    supports = lift @ sparse(simulated.track.stiffness) @ start - ground
    weight = simulated.train.static_load.sum()
    assert ground < weight
    assert ground + supports == pytest.approx(weight, rel=1e-9)
    np.testing.assert_allclose(simulated.passage.force[0], weight / 4, rtol=1e-12)


def test_static_load_is_the_weight_of_the_vehicle():
    assert make_train(TrainTrackBridgeParameters()).static_load == pytest.approx(np.full(12, 109092.105), rel=1e-9)
    heavy = make_train(TrainTrackBridgeParameters(carbody_mass_factor=1.5)).static_load[0]
    assert heavy == pytest.approx(109092.105 + 0.25 * 9.81 * 16000.0, rel=1e-9)


def test_work_of_the_contact_forces_is_stored_in_the_track_or_dissipated():
    parameters = short_bridge(end_position=4.0)
    simulated = simulate_passage(parameters, kept=np.arange(first_axle(parameters)[0].size))
    run, contact = simulated.passage, simulated.contact
    mass, damping, stiffness = (sparse(band) for band in simulated.track[:3])
    u, v = run.track_displacement, run.track_velocity
    load = np.zeros_like(u)
    for n, force in enumerate(run.force):
        np.add.at(load[n], contact.unknowns[n], force[:, None] * contact.rows[n, :, 0])
    work = 0.5 * np.einsum("ti,ti->t", load[1:] + load[:-1], u[1:] - u[:-1])
    middle = 0.5 * (v[1:] + v[:-1])
    lost = simulated.time_step * np.einsum("ti,ti->t", middle @ damping, middle)
    stored = 0.5 * (np.einsum("ti,ti->t", v @ mass, v) + np.einsum("ti,ti->t", u @ stiffness, u))
    assert lost.sum() > 1.0
    np.testing.assert_allclose(work, lost + np.diff(stored), rtol=0.0, atol=1e-8 * np.abs(work).max())


@pytest.mark.parametrize("parts", [1, 2])
def test_frequencies_of_the_meshed_bridge(parts):
    parameters = short_bridge(bridge_length=50.0, elements_per_spacing=parts, end_position=0.5)
    elements = assemble_track(parameters)
    own = np.sort(elements.numbering.bridge[elements.numbering.bridge >= 0])
    place = np.full(elements.numbering.size, -1)
    place[own] = np.arange(own.size)
    mass, stiffness = np.zeros((own.size, own.size)), np.zeros((own.size, own.size))
    for matrix, kind in ((mass, elements.mass[1]), (stiffness, elements.stiffness[1])):
        for unknowns, element in zip(*kind, strict=True):
            free = unknowns >= 0
            matrix[np.ix_(place[unknowns[free]], place[unknowns[free]])] += element[np.ix_(free, free)]
    found = np.sqrt(scipy.linalg.eigh(stiffness, mass, eigvals_only=True, subset_by_index=[0, 1])) / (2.0 * np.pi)
    np.testing.assert_allclose(found, bridge_frequencies(parameters), rtol=2e-6)
    assert elements.layout.span == pytest.approx({1: 49.8, 2: 50.1}[parts])


def test_rayleigh_damping_has_the_ratio_at_both_frequencies():
    first, second = rayleigh_factors(0.02, np.array([3.192365629827294, 12.769461214501558]))
    assert first == pytest.approx(0.6418631811378729, rel=1e-9)
    assert second == pytest.approx(0.0003988389164826511, rel=1e-9)


def test_stiff_bridge_does_not_move_and_its_deflection_goes_with_its_flexibility():
    deflections, forces = [], []
    for factor in (1e3, 1e4):
        stiff = short_bridge(**LEVEL, bridge_modulus=factor * 35e9, bridge_damping=0.0, rail=Rail(damping=0.0))
        response = TrainTrackBridge().simulate(stiff, histories=True)
        deflections.append(response.metrics["U_d"])
        forces.append(response.histories["contact_force"])
    assert deflections[0] < 1e-7
    assert deflections[0] / deflections[1] == pytest.approx(10.0, rel=1e-2)
    np.testing.assert_allclose(forces[0], forces[1], rtol=1e-4)


def test_hertz_contact_approaches_the_rigid_one_with_its_flexibility():
    parameters = short_bridge(**LEVEL, time_step=2.5e-4, end_position=4.0)
    rigid = simulate_passage(parameters).passage.motion[:, :, 0]
    soft = [simulate_passage(replace(parameters, contact_stiffness=k)).passage.motion[:, :, 0] for k in (1e8, 1e9)]
    errors = [np.abs(rail - rigid)[200:].max() for rail in soft]
    assert errors[1] < 0.25 * errors[0]
    assert errors[1] < 2e-2 * rigid.max()


def test_half_the_step_changes_little():
    # As in TTB-2D: 0.02 % of the carbody acceleration, 0.15 % of the force, 0.04 % of the rail, 0.02 % of the deck.
    known = case("c05_irr_1veh_200").parameters
    coarse, fine = (TrainTrackBridge().simulate(replace(known, time_step=step)).metrics for step in (1e-3, 5e-4))
    for name, change in (("carbody_acceleration_max", 1e-3), ("contact_force_max", 5e-3), ("U_r", 1e-3), ("U_d", 1e-3)):
        assert coarse[name] == pytest.approx(fine[name], rel=change), name


def test_response_is_linear_in_the_irregularity_and_the_seed_keeps_its_shape():
    base = short_bridge(irregularity_file="", start_position=-20.0137, irregularity_fade=5.0)
    forces = [
        TrainTrackBridge().simulate(replace(base, irregularity_amplitude=a), histories=True).histories["contact_force"]
        for a in (0.0, 4e-7, 1.6e-6)
    ]
    np.testing.assert_allclose(forces[2] - forces[0], 2.0 * (forces[1] - forces[0]), rtol=0.0, atol=1e-4)
    assert np.abs(forces[1] - forces[0]).max() > 100.0


def static_rail(parameters, position):
    """Where a load of 1 N stands on the rail, with the layout, the numbering and the displacement of the whole track."""
    elements = assemble_track(parameters)
    node = int(np.argmin(np.abs(elements.layout.nodes - position)))
    load = np.zeros(elements.numbering.size)
    load[elements.numbering.rail[node, 0]] = 1.0
    return elements.layout.nodes[node], elements, static_displacement(track_matrices(elements).stiffness, load)


@pytest.mark.parametrize("share", [0.5, 0.3])
def test_deck_bends_as_a_simply_supported_beam_under_a_standing_load(share):
    """w(x) = P b x (L² − b² − x²)/(6 EI L) for x up to the load at a = L − b; the track spreads it over a metre or two."""
    parameters = TrainTrackBridgeParameters(**LEVEL, vehicles=1)
    span = assemble_track(parameters).layout.span
    place, elements, found = static_rail(parameters, share * span)
    x = elements.layout.bridge_nodes[1:-1]
    a = np.where(x <= place, place, span - place)
    x = np.where(x <= place, x, span - x)
    b = span - a
    stiffness = parameters.bridge_modulus * parameters.bridge_inertia
    expected = b * x * (span**2 - b**2 - x**2) / (6.0 * stiffness * span)
    np.testing.assert_allclose(found[elements.numbering.bridge[1:-1, 0]], expected, rtol=0.0, atol=2e-3 * expected.max())


def test_rail_off_the_bridge_stands_on_a_winkler_foundation():
    """u = P λ/(2 k), λ = (k/4EI)^(1/4), with pad, ballast and sub-ballast in series; sleepers are no continuum: 2 %."""
    parameters = TrainTrackBridgeParameters(**LEVEL, vehicles=1, pad_stiffness=1e8)
    series = 1.0 / sum(1.0 / k for k in (1e8, ballast_values(parameters)[1], parameters.subballast_stiffness))
    foundation = series / parameters.sleeper_spacing
    decay = (foundation / (4.0 * parameters.rail.bending_stiffness)) ** 0.25
    over, between = (static_rail(parameters, position) for position in (-30.0, -30.3))
    for place, elements, found in (over, between):
        node = int(np.flatnonzero(elements.layout.nodes == place)[0])
        assert found[elements.numbering.rail[node, 0]] == pytest.approx(0.5 * decay / foundation, rel=2e-2)
