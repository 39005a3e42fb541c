"""What mechanics demands of the model: energy, symmetry, linearity, convergence, the role of each design variable."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import scipy.sparse
from crossings import BUMPS, REFERENCE, design_a, short_crossing, symmetric_crossing

from railsearch_plugins.track_models.level_crossing import LevelCrossing
from railsearch_plugins.track_models.level_crossing.assembly import assemble_track, pad_values
from railsearch_plugins.track_models.level_crossing.parameters import Irregularity, Railpad, Vehicle
from railsearch_plugins.track_models.level_crossing.passage import simulate_passage, wheel_positions


def sparse(band):
    lower = scipy.sparse.diags_array([band[k, k:] for k in range(band.shape[0])], offsets=range(0, -band.shape[0], -1))
    return scipy.sparse.csr_array(lower + lower.T - scipy.sparse.diags_array([band[0]], offsets=[0]))


def quadratic(matrix, states):
    return np.einsum("ti,ti->t", states @ matrix, states)


def contact_matrix(contact, size):
    """The Hermite rows of all steps as a sparse matrix (t, n)."""
    count = contact.rows.shape[0]
    places = np.repeat(np.arange(count), 4), contact.unknowns.ravel()
    return scipy.sparse.csr_array((contact.rows.ravel(), places), shape=(count, size))


def energy_ledger(parameters):
    """Work of gravity, work of the drive, energy dissipated and change of stored energy over a passage, in J.

    All of the midpoint rule, which Newmark's method with β = 1/4 and γ = 1/2 is. The drive pushes the force over the
    slope of the rail and of the irregularity: −½ (F_n u_{n+1} + F_{n+1} u_n)·(N_{n+1} − N_n) − ½ (F_n + F_{n+1}) Δr.
    """
    s = simulate_passage(parameters, kept=np.arange(wheel_positions(parameters).size))
    track, vehicle, run, dt = s.track, s.vehicle, s.passage, parameters.passage.time_step
    u, v, z, zv, force = (
        run.track_displacement,
        run.track_velocity,
        run.vehicle_displacement,
        run.vehicle_velocity,
        run.force[:, 0],
    )
    mass, damping, stiffness = (sparse(band) for band in track[:3])
    rows = contact_matrix(s.contact, u.shape[1])
    slope = rows[1:] - rows[:-1]
    moved = force[:-1, None] * u[1:] + force[1:, None] * u[:-1]
    drive = (
        -0.5 * slope.multiply(moved).sum()
        - 0.5 * ((force[1:] + force[:-1]) * np.diff(s.contact.irregularity[:, 0, 0])).sum()
    )
    weight = parameters.vehicle.gravity * np.diag(vehicle.mass)
    gravity = float(weight @ (z[-1] - z[0]))
    middle, vehicle_middle = 0.5 * (v[1:] + v[:-1]), 0.5 * (zv[1:] + zv[:-1])
    dissipated = dt * (quadratic(damping, middle).sum() + quadratic(vehicle.damping, vehicle_middle).sum())
    p = parameters.vehicle
    stretched = z[:, :2] - z[:, 1:] + np.array([weight[0] / p.secondary_stiffness, weight[:2].sum() / p.primary_stiffness])
    stored = 0.5 * (
        quadratic(mass, v)
        + quadratic(stiffness, u)
        + quadratic(vehicle.mass, zv)
        + p.secondary_stiffness * stretched[:, 0] ** 2
        + p.primary_stiffness * stretched[:, 1] ** 2
        + force**2 / p.contact_stiffness
    )
    return gravity, drive, dissipated, stored[-1] - stored[0]


@pytest.mark.parametrize("irregularity", [Irregularity(), BUMPS], ids=["level", "irregular"])
def test_work_of_gravity_and_drive_is_dissipated_or_stored(irregularity):
    gravity, drive, dissipated, stored = energy_ledger(
        replace(short_crossing(element_length=0.1), irregularity=irregularity)
    )
    assert dissipated > 1.0
    assert gravity + drive == pytest.approx(dissipated + stored, abs=1e-9 * dissipated)


def test_energy_in_the_ballast_is_part_of_what_is_dissipated():
    parameters = short_crossing()
    response = LevelCrossing().simulate(parameters, histories=True)
    _, _, dissipated, _ = energy_ledger(parameters)
    assert 0.5 * dissipated < response.histories["sleeper_energy"].sum() < dissipated


def test_mirror_image_run_from_the_other_end_has_the_same_force():
    parameters = symmetric_crossing()
    there = wheel_positions(parameters)
    back = parameters.geometry.total_length - there
    forward, backward = (simulate_passage(parameters, x).passage for x in (there, back))
    np.testing.assert_allclose(forward.force, backward.force, rtol=1e-11)
    np.testing.assert_allclose(forward.support_integrals, backward.support_integrals[::-1], rtol=1e-10)


def test_strip_is_not_mirrored():
    parameters = symmetric_crossing()
    parameters = replace(parameters, zone=replace(parameters.zone, type_2_strip_length=2.0))
    there = wheel_positions(parameters)
    forward, backward = (
        simulate_passage(parameters, x).passage.force for x in (there, parameters.geometry.total_length - there)
    )
    assert np.abs(forward - backward).max() > 10.0


def test_matrices_are_symmetric_about_the_middle_of_a_symmetric_crossing():
    sleepers = assemble_track(symmetric_crossing()).sleepers
    np.testing.assert_allclose(sleepers.position + sleepers.position[::-1], 40.0, rtol=1e-14)
    np.testing.assert_array_equal(sleepers.mass, sleepers.mass[::-1])
    np.testing.assert_array_equal(sleepers.pad_stiffness, sleepers.pad_stiffness[::-1])


def test_rails_lifted_as_a_whole_change_nothing_but_the_level():
    parameters = short_crossing()
    lifted = replace(parameters, irregularity=Irregularity((0.0, 40.0), (2e-3, 2e-3)))
    level, raised = (LevelCrossing().simulate(p, histories=True).histories for p in (parameters, lifted))
    np.testing.assert_allclose(raised["wheel_rail_force"], level["wheel_rail_force"], rtol=1e-10)
    np.testing.assert_allclose(raised["wheel_displacement"], level["wheel_displacement"] - 2e-3, rtol=0.0, atol=1e-12)


def test_a_rise_of_the_rail_pushes_the_wheel_up():
    parameters = short_crossing()
    x = np.arange(0.0, 40.0, 0.25)
    s = np.clip((x - 9.0) / 2.0, 0.0, 1.0)
    rising = replace(parameters, irregularity=Irregularity(tuple(x), tuple(1e-3 * s**2 * (3.0 - 2.0 * s))))
    level, rise = (LevelCrossing().simulate(p, histories=True).histories for p in (parameters, rising))
    at = np.searchsorted(level["wheel_position"], [9.4, 13.0])
    assert rise["wheel_rail_force"][at[0]] > level["wheel_rail_force"][at[0]] + 1e3
    assert rise["wheel_displacement"][at[1]] < level["wheel_displacement"][at[1]] - 5e-4


def test_response_is_linear_in_the_irregularity():
    parameters = short_crossing()
    doubled = Irregularity(BUMPS.position, tuple(2.0 * height for height in BUMPS.height))
    forces = [
        LevelCrossing().simulate(replace(parameters, irregularity=i), histories=True).histories["wheel_rail_force"]
        for i in (Irregularity(), BUMPS, doubled)
    ]
    np.testing.assert_allclose(forces[2] - forces[0], 2.0 * (forces[1] - forces[0]), atol=1e-6)


def test_energies_converge_with_the_square_of_the_time_step():
    energies = [
        LevelCrossing().simulate(design_a(REFERENCE, time_step=step), histories=True).histories["sleeper_energy"][146:166]
        for step in (2e-3, 1e-3, 5e-4, 2.5e-4)
    ]
    differences = [np.linalg.norm(b - a) for a, b in pairwise(energies)]
    np.testing.assert_allclose(np.log2(np.divide(differences[:-1], differences[1:])), 2.0, atol=0.05)


def test_displacement_under_the_wheel_converges_with_the_third_power_of_the_element_length():
    # Inside an element the kink of the third derivative under the wheel is out of the cubics' reach: order 3, not 4.
    passages = [replace(short_crossing().passage, element_length=h, time_step=5e-4) for h in (0.2, 0.1, 0.05, 0.025)]
    rails = [
        LevelCrossing().simulate(replace(short_crossing(), passage=passage), histories=True).histories["rail_displacement"]
        for passage in passages
    ]
    differences = [np.linalg.norm(b - a) for a, b in pairwise(rails)]
    np.testing.assert_allclose(np.log2(np.divide(differences[:-1], differences[1:])), 3.0, atol=0.5)


def test_pad_damping_goes_with_its_stiffness_and_the_full_track_reading_halves_both():
    sleepers = assemble_track(design_a((200, 300, 400, 8, 6, 6, 4, 0))).sleepers
    stiffness, damping = pad_values(design_a(REFERENCE), sleepers)
    np.testing.assert_allclose(damping / stiffness, 120e3 / 1120e6)
    np.testing.assert_array_equal(stiffness[163:169], [200e6, 300e6, 400e6, 400e6, 300e6, 200e6])
    halved = pad_values(design_a(REFERENCE, reading="full-track"), sleepers)
    np.testing.assert_array_equal(halved, [0.5 * stiffness, 0.5 * damping])


def test_pads_of_another_stiffness_have_damping_in_proportion():
    parameters = replace(design_a(REFERENCE), railpad=Railpad(stiffness=560e6, damping=30e3))
    _, damping = pad_values(parameters, assemble_track(parameters).sleepers)
    assert damping[0] == pytest.approx(30e3)
    assert damping[165] == pytest.approx(60e3)


def test_layout_of_the_reference_design():
    track = assemble_track(design_a(REFERENCE))
    sleepers = track.sleepers
    assert sleepers.position.size == 166 + 36
    np.testing.assert_allclose(sleepers.position[[0, 164, 165, 166, 167, -1]], [0.6, 99.0, 99.6, 112.4, 113.0, 133.4])
    np.testing.assert_array_equal(sleepers.mass[157:175], [125.5] + 16 * [150.0] + [125.5])
    assert track.numbering.size + 2 == 3128


def test_wheel_load_from_masses():
    assert Vehicle(wheel_load="from masses").static_load == pytest.approx(87217, abs=1)
    assert Vehicle().effective_carbody_mass == pytest.approx(3249.5, abs=0.1)
    assert Vehicle().contact_stiffness == pytest.approx(1.077e9, rel=1e-3)


def test_passage_starts_in_equilibrium():
    histories = LevelCrossing().simulate(short_crossing(), histories=True).histories
    assert histories["wheel_rail_force"][0] == 50e3
    assert abs(histories["carbody_acceleration"][0]) < 1e-15
    assert histories["rail_displacement"][0] == 0.0


def test_track_states_are_kept_at_the_steps_asked_for_and_change_nothing():
    parameters = short_crossing()
    steps = np.arange(wheel_positions(parameters).size)
    some = np.array([0, 7, steps[-1]])
    none, few, every = (simulate_passage(parameters, kept=kept).passage for kept in (steps[:0], some, steps))
    np.testing.assert_array_equal(few.track_displacement, every.track_displacement[some])
    np.testing.assert_array_equal(few.track_velocity, every.track_velocity[some])
    assert none.track_displacement.shape == (0, every.track_displacement.shape[1])
    assert np.ptp(few.track_displacement[1]) > 0.0
    for passage in (none, few):
        np.testing.assert_array_equal(passage.force, every.force)
