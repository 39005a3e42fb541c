"""What mechanics demands of an imported track: round trips, closed forms, energy, symmetry, convergence, slow twins."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse
from crossings import BUMPS, short_crossing
from imported_tracks import DAMPING, EI, FOUNDATION, MASS, beam_export, written

from railsearch_plugins.single_wheel import Vehicle
from railsearch_plugins.track_models.imported_track import ImportedTrack
from railsearch_plugins.track_models.imported_track.parameters import Passage, Windows
from railsearch_plugins.track_models.imported_track.passage import ROUTES, fastest_route, simulate_passage
from railsearch_plugins.track_models.imported_track.pattern import whole_matrix
from railsearch_plugins.track_models.imported_track.rail import cubic_rows, linear_rows
from railsearch_plugins.track_models.level_crossing import LevelCrossing

WAVE_NUMBER = (FOUNDATION / (4.0 * EI)) ** 0.25


@pytest.mark.parametrize("kind", ["npz", "mtx"])
@pytest.mark.parametrize("parts", [False, True])
def test_a_level_crossing_goes_out_and_comes_back(tmp_path, kind, parts):
    crossing = replace(short_crossing(), irregularity=BUMPS)
    expected = LevelCrossing().simulate(crossing, histories=True)
    came_back = written(tmp_path / "track", LevelCrossing().export(crossing, parts), kind)
    response = ImportedTrack().simulate(came_back, histories=True)
    assert response.metrics == pytest.approx(expected.metrics, rel=1e-9)
    for name in ("wheel_rail_force", "rail_displacement", "carbody_acceleration"):
        scale = np.abs(expected.histories[name]).max()
        np.testing.assert_allclose(response.histories[name], expected.histories[name], atol=1e-9 * scale)
    np.testing.assert_allclose(response.histories["support_energy"], expected.histories["sleeper_energy"], rtol=1e-9)


def test_parts_are_the_pads_of_the_crossing(tmp_path):
    crossing = short_crossing()
    softer = replace(crossing, zone=replace(crossing.zone, pad_stiffness=(70e6, 500e6, 210e6)))
    came_back = written(tmp_path / "track", LevelCrossing().export(crossing, parts=True))
    changed = replace(came_back, factors={"pad_1": 70.0, "pad_2": 500.0, "pad_3": 210.0})
    metrics = ImportedTrack().simulate(changed).metrics
    assert metrics == pytest.approx(LevelCrossing().simulate(softer).metrics, rel=1e-9)
    assert metrics["F_max"] != pytest.approx(LevelCrossing().simulate(crossing).metrics["F_max"], rel=1e-3)


@pytest.mark.parametrize("route", ROUTES[1:])
def test_every_way_of_a_step_gives_the_same_passage(tmp_path, route):
    came_back = written(tmp_path / "track", LevelCrossing().export(short_crossing()))
    compiled, other = (simulate_passage(came_back, route=name).passage for name in ("banded", route))
    np.testing.assert_allclose(other.force, compiled.force, rtol=1e-9)
    np.testing.assert_allclose(other.support_integrals, compiled.support_integrals, rtol=1e-8)
    np.testing.assert_allclose(other.vehicle_velocity, compiled.vehicle_velocity, atol=1e-9)


def test_the_numbering_of_the_unknowns_does_not_matter(tmp_path):
    export = LevelCrossing().export(short_crossing())
    order = np.random.default_rng(3).permutation(export.matrices["mass"].shape[0])
    place = np.argsort(order)
    shuffled = replace(
        export,
        matrices={kind: matrix[order][:, order] for kind, matrix in export.matrices.items()},
        rail=moved(export.rail, place, (1, 2)),
        supports=moved(export.supports, place, (1,)),
    )
    straight, mixed = (written(tmp_path / name, made) for name, made in (("a", export), ("b", shuffled)))
    assert simulate_passage(mixed).track.pattern.half_bandwidth < 40
    expected = ImportedTrack().simulate(straight).metrics
    assert ImportedTrack().simulate(mixed).metrics == pytest.approx(expected, rel=1e-9)


def moved(table, place, columns):
    made = table.copy()
    for column in columns:
        unknowns = table[:, column].astype(int)
        made[:, column] = np.where(unknowns >= 0, place[unknowns], -1)
    return made


@pytest.mark.parametrize("axis", ["upward", "slope reversed"])
def test_a_vertical_axis_that_points_up_gives_the_same_force(tmp_path, axis):
    export = beam_export()
    signs = np.ones(export.matrices["mass"].shape[0])
    signs[:: 1 if axis == "upward" else 2] = -1.0
    flip = scipy.sparse.diags_array(signs)
    flipped = replace(export, matrices={k: (flip @ m @ flip).tocsr() for k, m in export.matrices.items()})
    rotation = "slope" if axis == "upward" else "minus slope"
    one, two = written(tmp_path / "a", export), written(tmp_path / "b", flipped)
    two = replace(two, rail=replace(two.rail, rotation=rotation))
    np.testing.assert_allclose(simulate_passage(two).passage.force, simulate_passage(one).passage.force, rtol=1e-10)


@pytest.mark.parametrize("share", [0.2, 0.5])
def test_a_wheel_on_an_even_track_settles_at_the_closed_form(tmp_path, share):
    # Static deflection P β/(2k) (Hetényi 1946, eq. 1.3), over √(1 − α²) under a moving load (Frýba 1999, ch. 13).
    critical = (4.0 * FOUNDATION * EI / MASS**2) ** 0.25
    speed = share * critical
    parameters = replace(
        written(tmp_path / "track", beam_export(200.0, 1600, damping=0.0)),
        vehicle=Vehicle(secondary_damping=2e5, primary_damping=2e4),
        passage=Passage(speed, 0.0625 / speed, 40.0, 180.0),
    )
    histories = ImportedTrack().simulate(parameters, histories=True).histories
    static = histories["rail_displacement"][0]
    amid = (histories["wheel_position"] > 110.0) & (histories["wheel_position"] < 160.0)
    moving = histories["rail_displacement"][amid].mean() / histories["wheel_rail_force"][amid].mean() * 50e3
    assert static == pytest.approx(50e3 * WAVE_NUMBER / (2.0 * FOUNDATION), rel=3e-6)
    assert moving == pytest.approx(static / np.sqrt(1.0 - share**2), rel=2e-3)


@pytest.mark.parametrize(("interpolation", "order"), [("hermite", 3.0), ("cubic", 2.0), ("linear", 2.0)])
def test_the_static_deflection_converges(tmp_path, interpolation, order):
    # Between nodes; without rotations the force is carried to nodes next to it, which spreads the load.
    exact, errors = 50e3 * WAVE_NUMBER / (2.0 * FOUNDATION), []
    for count in (80, 160, 320):
        track = written(tmp_path / str(count), beam_export(40.0, count))
        start = 20.0 + 0.5 * 40.0 / count
        asked = replace(track, rail=replace(track.rail, interpolation=interpolation), passage=Passage(start=start))
        histories = ImportedTrack().simulate(asked, histories=True).histories
        errors.append(abs(histories["rail_displacement"][0] / exact - 1.0))
    assert min(np.log2(np.divide(errors[:-1], errors[1:]))) > order - 0.3


def test_work_of_gravity_and_drive_is_dissipated_or_stored(tmp_path):
    ledgers = [
        energy_ledger(written(tmp_path / route, beam_export(damping=DAMPING)), route) for route in ("banded", "envelope")
    ]
    for gravity, drive, dissipated, stored in ledgers:
        assert dissipated > 1.0
        assert gravity + drive == pytest.approx(dissipated + stored, abs=1e-9 * dissipated)


def energy_ledger(parameters, route):
    """Work of gravity and of the drive, energy dissipated, and change of the energy stored, all by the midpoint rule."""
    steps = np.arange(simulate_passage(parameters).position.size)
    made = simulate_passage(parameters, steps, route)
    run, vehicle, dt = made.passage, made.vehicle, parameters.passage.time_step
    mass, damping, stiffness = (
        whole_matrix(made.values[kind], made.track.pattern) for kind in ("mass", "damping", "stiffness")
    )
    u, v, z, zv, force = (
        run.track_displacement,
        run.track_velocity,
        run.vehicle_displacement,
        run.vehicle_velocity,
        run.force[:, 0],
    )
    places = np.repeat(steps, 4), made.contact.unknowns.ravel()
    rows = scipy.sparse.csr_array((made.contact.rows.ravel(), places), shape=(steps.size, u.shape[1]))
    drive = -0.5 * (rows[1:] - rows[:-1]).multiply(force[:-1, None] * u[1:] + force[1:, None] * u[:-1]).sum()
    p = parameters.vehicle
    weight = p.gravity * np.diag(vehicle.mass)
    middle, in_vehicle = 0.5 * (v[1:] + v[:-1]), 0.5 * (zv[1:] + zv[:-1])
    dissipated = dt * (quadratic(damping, middle).sum() + quadratic(vehicle.damping, in_vehicle).sum())
    stretched = z[:, :2] - z[:, 1:] + np.array([weight[0] / p.secondary_stiffness, weight[:2].sum() / p.primary_stiffness])
    springs = stretched**2 @ [p.secondary_stiffness, p.primary_stiffness] + force**2 / p.contact_stiffness
    stored = 0.5 * (quadratic(mass, v) + quadratic(stiffness, u) + quadratic(vehicle.mass, zv) + springs)
    return float(weight @ (z[-1] - z[0])), drive, dissipated, stored[-1] - stored[0]


def quadratic(matrix, states):
    return np.einsum("ti,ti->t", states @ matrix, states)


def test_a_mirrored_track_gives_the_same_energies_as_a_run_from_the_other_side_would(tmp_path):
    # Even track, even passage: supports far from both ends cannot tell where they are.
    parameters = replace(
        written(tmp_path / "track", beam_export(120.0, 480)), windows=Windows(energy_from=60.0, energy_to=90.0)
    )
    response = ImportedTrack().simulate(parameters, histories=True)
    assert response.metrics["E_max"] < 0.05 * response.metrics["E_rms"]


def test_receptances_are_symmetric(tmp_path):
    from railsearch_plugins.track_models.imported_track.pattern import static_displacement

    made = simulate_passage(written(tmp_path / "track", LevelCrossing().export(short_crossing())))
    pattern, stiffness = made.track.pattern, made.values["stiffness"]
    pair = []
    for loaded, seen in ((30, 90), (90, 30)):
        load = np.zeros(pattern.size)
        load[loaded] = 1.0
        pair.append(static_displacement(stiffness, pattern, load)[seen])
    assert pair[0] == pytest.approx(pair[1], rel=1e-12)


def test_a_damper_between_two_unknowns_sees_their_difference(tmp_path):
    export = LevelCrossing().export(short_crossing())
    table = export.supports
    both = np.column_stack([table, np.roll(table[:, 1], 1)])
    one, two = written(tmp_path / "a", export), written(tmp_path / "b", replace(export, supports=both))
    steps = np.arange(simulate_passage(one).position.size)
    made = simulate_passage(two, steps)
    assert (fastest_route(simulate_passage(one).track), fastest_route(made.track)) == ("banded", "envelope")
    supports, v = made.track.supports, made.passage.track_velocity
    difference = (v[:, supports.unknown] - v[:, supports.other]) ** 2
    expected = one.passage.time_step * (difference.sum(axis=0) - 0.5 * (difference[0] + difference[-1]))
    np.testing.assert_allclose(made.passage.support_integrals, expected, rtol=1e-10)


NODES = np.array([0.0, 0.3, 0.5, 1.0, 1.2, 1.9, 2.0])


@pytest.mark.parametrize(("rows_of", "degree"), [(cubic_rows, 2), (linear_rows, 1)])
@pytest.mark.parametrize("count", [2, 3, 4, 7])
def test_rails_without_rotations_have_polynomials_exactly(rows_of, degree, count):
    nodes = NODES[:count]
    degree = min(degree, count - 1)
    x = np.linspace(nodes[0], nodes[-1], 41)
    around, rows = rows_of(nodes, x)
    np.testing.assert_allclose(rows.sum(axis=1), 1.0, rtol=1e-13)
    for power in range(degree + 1):
        np.testing.assert_allclose((rows * nodes[around] ** power).sum(axis=1), x**power, atol=1e-13)


def test_a_cubic_rail_has_a_continuous_slope():
    x = np.concatenate([NODES[1:-1] - 1e-7, NODES[1:-1], NODES[1:-1] + 1e-7])
    values = np.random.default_rng(1).normal(size=NODES.size)
    around, rows = cubic_rows(NODES, x)
    before, at, after = (rows * values[around]).sum(axis=1).reshape(3, -1)
    np.testing.assert_allclose(after - at, at - before, atol=1e-5 * 1e-7 * 1e3)
