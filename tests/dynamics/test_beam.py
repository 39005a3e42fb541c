"""Element matrices against polynomial identities and rigid-body motion."""

import numpy as np
import pytest

from railsearch_plugins.dynamics.beam import bending_matrices, coupled, gram_matrices, hermite, layer_matrices, locate, outer

LENGTH = 0.37
CUBIC = np.polynomial.Polynomial([0.3, -1.1, 0.7, 2.3])
NODAL = np.array([CUBIC(0.0), CUBIC.deriv()(0.0), CUBIC(LENGTH), CUBIC.deriv()(LENGTH)])


def test_hermite_functions_reproduce_cubics():
    offsets = np.linspace(0.0, LENGTH, 11)
    np.testing.assert_allclose(hermite(offsets, LENGTH) @ NODAL, CUBIC(offsets), rtol=1e-14)


def test_hermite_functions_are_a_partition_of_unity():
    rows = hermite(np.linspace(0.0, LENGTH, 11), LENGTH)
    np.testing.assert_allclose(rows[:, 0] + rows[:, 2], 1.0, rtol=1e-15)


def test_bending_energy_of_a_cubic_is_exact():
    stiffness = bending_matrices(LENGTH, 5.0)[0]
    curvature = (CUBIC.deriv(2) ** 2).integ()
    assert NODAL @ stiffness @ NODAL == pytest.approx(5.0 * (curvature(LENGTH) - curvature(0.0)), rel=1e-13)


def test_rigid_body_motion_meets_no_bending_stiffness():
    stiffness = bending_matrices(LENGTH, 5.0)[0]
    for motion in ([1.0, 0.0, 1.0, 0.0], [0.0, 1.0, LENGTH, 1.0]):
        np.testing.assert_allclose(stiffness @ motion, 0.0, atol=1e-12 * np.abs(stiffness).max())


def test_consistent_mass_has_the_energy_of_a_moving_cubic():
    square = (CUBIC**2).integ()
    assert NODAL @ gram_matrices(LENGTH, 0.0, LENGTH)[0] @ NODAL == pytest.approx(square(LENGTH) - square(0.0), rel=1e-13)


@pytest.mark.parametrize("boundary", [-1.0, 0.0, 0.1, 0.37, 0.5, 0.6, 0.74, 2.0])
def test_layer_is_split_exactly_where_its_stiffness_changes(boundary):
    edges = np.array([0.0, LENGTH, 2 * LENGTH])
    matrices = layer_matrices(edges, boundary, before=3.0, after=7.0)
    for start, matrix in zip(edges[:-1], matrices, strict=True):
        square, change = (CUBIC**2).integ(), np.clip(boundary - start, 0.0, LENGTH)
        energy = 3.0 * (square(change) - square(0.0)) + 7.0 * (square(LENGTH) - square(change))
        assert NODAL @ matrix @ NODAL == pytest.approx(energy, rel=1e-13)


def test_layer_between_two_bodies_feels_only_their_difference():
    matrix = coupled(gram_matrices(LENGTH, 0.0, LENGTH))[0]
    np.testing.assert_allclose(matrix @ np.concatenate([NODAL, NODAL]), 0.0, atol=1e-14)
    assert np.concatenate([NODAL, 0 * NODAL]) @ matrix @ np.concatenate([NODAL, 0 * NODAL]) > 0.0


def test_spring_stores_the_energy_of_its_elongation():
    matrices = outer(np.array([[0.5, 0.5, -1.0]]), 4.0)
    assert 0.5 * np.array([1.0, 3.0, 0.5]) @ matrices[0] @ np.array([1.0, 3.0, 0.5]) == pytest.approx(0.5 * 4.0 * 1.5**2)


def test_positions_next_to_a_node_are_taken_on_it():
    nodes = np.array([0.0, 0.5, 1.5])
    elements, rows = locate(nodes, [0.0, 0.5 - 1e-11, 0.5 + 1e-11, 1.0, 1.5])
    np.testing.assert_array_equal(elements, [0, 0, 1, 1, 1])
    np.testing.assert_array_equal(rows[[0, 1, 2, 4]], [[1, 0, 0, 0], [0, 0, 1, 0], [1, 0, 0, 0], [0, 0, 1, 0]])


@pytest.mark.parametrize("outside", [-0.01, 1.51])
def test_positions_beyond_the_beam_are_refused(outside):
    with pytest.raises(ValueError, match=r"between 0 and 1\.5 m"):
        locate(np.array([0.0, 0.5, 1.5]), [outside])
