"""Envelope storage against dense algebra, and the passage with a handed-in solver for several wheels."""

import numpy as np
import pytest
import scipy.sparse

from railsearch_plugins.dynamics import banded, envelope
from railsearch_plugins.dynamics.beam import bending_matrices, gram_matrices
from railsearch_plugins.dynamics.handed_solver import EnvelopeSolver, PairObservation, pass_over
from railsearch_plugins.dynamics.moving_contact import Observation, Track, make_contact, static_displacement
from railsearch_plugins.dynamics.moving_contact import pass_over as compiled_pass
from railsearch_plugins.dynamics.vehicles import RIGID, Vehicle


def random_matrix(size, density, seed):
    """A sparse positive definite matrix, dense, and its lower triangle."""
    generator = np.random.default_rng(seed)
    half = scipy.sparse.random_array((size, size), density=density, rng=generator)
    matrix = (half @ half.T).toarray() + 0.1 * np.eye(size)
    rows, columns = np.nonzero(np.tril(matrix))
    return matrix, rows, columns


@pytest.mark.parametrize(("size", "density"), [(1, 1.0), (30, 0.05), (200, 0.01)])
def test_factor_and_solution_are_those_of_dense_algebra(size, density):
    matrix, rows, columns = random_matrix(size, density, 1)
    pattern = envelope.envelope_of(rows, columns, size)
    lower, row = envelope.factorise(*pattern, envelope.in_envelope(pattern, rows, columns, matrix[rows, columns]))
    assert row == -1
    load = np.random.default_rng(2).normal(size=size)
    x = load.copy()
    envelope.solve(*pattern, lower, x)
    np.testing.assert_allclose(matrix @ x, load, atol=1e-11)


def test_the_first_row_that_is_not_positive_is_told():
    matrix, rows, columns = random_matrix(40, 0.1, 3)
    matrix[17, 17] = -1.0
    pattern = envelope.envelope_of(rows, columns, 40)
    _, row = envelope.factorise(*pattern, envelope.in_envelope(pattern, rows, columns, matrix[rows, columns]))
    minors = [np.linalg.det(matrix[:k, :k]) for k in range(1, 41)]
    assert row == int(np.argmax(np.array(minors) <= 0.0))


def beam(count, foundation=2e7, damping=2e4):
    """A pinned beam on a soft layer: nodes, unknowns of the nodes, and M, C, K by diagonals."""
    nodes = np.linspace(0.0, 0.25 * count, count + 1)
    unknowns = np.arange(-1, 2 * count + 1).reshape(count + 1, 2)
    unknowns[-1] = [-1, 2 * count - 1]
    elements = np.concatenate([unknowns[:-1], unknowns[1:]], axis=1)
    spans = np.diff(nodes)
    gram = banded.assemble([(elements, gram_matrices(spans, 0.0, spans))], 2 * count, 3)
    bending = banded.assemble([(elements, bending_matrices(spans, 5e6))], 2 * count, 3)
    return nodes, unknowns, Track(54.0 * gram, damping * gram, bending + foundation * gram)


def envelope_solver(track, unknowns, step):
    """The same track in envelope storage."""
    newmark = (2.0 / step) * ((2.0 / step) * track.mass + track.damping) + track.stiffness
    size = newmark.shape[1]
    rows, columns = (place for place in np.nonzero(np.tril(np.ones((size, size))) * band_mask(size, newmark.shape[0])))
    values = [band[rows - columns, rows] for band in (newmark, track.mass, track.stiffness)]
    pattern = envelope.envelope_of(rows, columns, size)
    lower, _ = envelope.factorise(*pattern, envelope.in_envelope(pattern, rows, columns, values[0]))
    columns_of = envelope.Columns(*envelope.inverse_columns(*pattern, lower, np.unique(unknowns)))
    return EnvelopeSolver(rows, columns, (2.0 / step) * values[1], -values[2], pattern, lower, columns_of), newmark


def band_mask(size, width):
    distance = np.abs(np.subtract.outer(np.arange(size), np.arange(size)))
    return distance < width


def dense(band):
    size = band.shape[1]
    matrix = np.zeros((size, size))
    for k in range(min(band.shape)):
        matrix[np.arange(k, size), np.arange(size - k)] = matrix[np.arange(size - k), np.arange(k, size)] = band[k, k:]
    return matrix


def test_cut_columns_are_those_of_the_inverse():
    # A long step on a soft layer: the columns decay over many blocks of rows.
    nodes, unknowns, track = beam(400, 2e4, 0.0)
    wanted = np.array([0, 5, 399, 400, 798])
    solver, newmark = envelope_solver(track, wanted, 0.02)
    inverse = np.linalg.inv(dense(newmark))
    for k in wanted:
        first, values = solver.response(np.array([k, k, k, k]), np.array([1.0, 0.0, 0.0, 0.0]))
        column = np.zeros(inverse.shape[0])
        column[first : first + values.size] = values
        np.testing.assert_allclose(column, inverse[:, k], atol=1e-8 * np.abs(inverse[:, k]).max())
    assert 300 < values.size < 600
    assert nodes.size == unknowns.shape[0]


def test_two_wheels_on_a_bogie_pass_as_with_the_compiled_steps():
    nodes, unknowns, track = beam(120)
    step = 1e-3
    mass = np.diag([3000.0, 400.0, 900.0, 900.0])
    rows = np.array([[1.0, 1.2, -1.0, 0.0], [1.0, -1.2, 0.0, -1.0]])
    stiffness, damping = (value * rows.T @ rows for value in (1.2e6, 5e3))
    bogie = Vehicle(mass, damping, stiffness, np.array([5e4, 4e4]), 1e9)
    bogie = bogie._replace(static_load=np.array([5e4, 5e4]))
    front = 6.0 + 0.04 * np.arange(400)
    positions = np.stack([front, front - 2.4], axis=1)
    contact = make_contact(nodes, unknowns, positions, 1e-4 * np.sin(positions)[:, :, None])
    solver, _ = envelope_solver(track, contact.unknowns, step)
    load = np.zeros(track.mass.shape[1])
    np.add.at(load, contact.unknowns[0], bogie.static_load[:, None] * contact.rows[0, :, 0])
    start = static_displacement(track.stiffness, load)
    pairs = np.array([[30, -1], [90, -1]])
    made = pass_over(solver, bogie, contact, step, start, PairObservation(pairs, np.array([0, 399])))
    expected = compiled_pass(track, bogie, contact, step, Observation(supports=pairs[:, 0], kept=np.array([0, 399])))
    np.testing.assert_allclose(made.force, expected.force, rtol=1e-9)
    np.testing.assert_allclose(made.support_integrals, expected.support_integrals, rtol=1e-8)
    np.testing.assert_allclose(made.track_displacement, expected.track_displacement, atol=1e-12)
    assert np.ptp(made.force) > 1e3


def test_a_rigid_contact_is_refused():
    nodes, unknowns, track = beam(20)
    contact = make_contact(nodes, unknowns, np.full((3, 1), 2.0), np.zeros((3, 1, 1)))
    solver, _ = envelope_solver(track, contact.unknowns, 1e-3)
    wheel = Vehicle(np.eye(1), np.zeros((1, 1)), np.zeros((1, 1)), np.ones(1), RIGID)
    with pytest.raises(ValueError, match="a Hertz contact is needed"):
        pass_over(solver, wheel, contact, 1e-3, np.zeros(40), PairObservation(np.empty((0, 2), dtype=np.int64)))
