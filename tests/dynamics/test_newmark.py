"""What Newmark's step knows of the track, carried from step to step, against its definition in dense algebra."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from railsearch_plugins.dynamics import kernels
from railsearch_plugins.dynamics.newmark import recursion

STEP = 0.3


def spring_mass_chain(generator, size, reach):
    """Dense M, C, K: beams alike in mass and stiffness with Rayleigh damping by halves, and single dampers."""
    coupling = np.tril(np.triu(generator.uniform(-1.0, 1.0, (size, size)), -reach), reach)
    mass = coupling @ coupling.T * (np.abs(np.subtract.outer(np.arange(size), np.arange(size))) <= reach) + np.eye(size)
    stiffness = 3.0 * mass + np.diag(generator.uniform(1.0, 2.0, size))
    half = np.arange(size) < size // 2
    across = half[:, None] != half
    mass[across] = stiffness[across] = 0.0
    mass += np.diag(np.abs(mass).sum(axis=1))
    alpha, beta = np.where(half, 0.4, 0.1), np.where(half, 0.05, 0.2)
    damping = alpha[:, None] * mass + beta[:, None] * stiffness
    for _ in range(3):
        i, j = generator.integers(0, size, 2)
        if i != j and abs(i - j) <= reach:
            damping[np.ix_([i, j], [i, j])] += generator.uniform(0.1, 1.0) * np.array([[1.0, -1.0], [-1.0, 1.0]])
    return mass, damping, stiffness, np.stack([alpha, beta])


def bands(matrix, reach):
    band = np.zeros((reach + 1, matrix.shape[0]))
    for k in range(min(band.shape)):
        band[k, k:] = np.diag(matrix, -k)
    return band


@pytest.mark.parametrize("rayleigh", ["given", "none", "wrong"])
@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), size=st.integers(1, 150), reach=st.integers(1, 9))
def test_known_part_of_the_next_step(rayleigh, seed, size, reach):
    generator = np.random.default_rng(seed)
    mass, damping, stiffness, factors = spring_mass_chain(generator, size, reach)
    newmark = (2.0 / STEP) * ((2.0 / STEP) * mass + damping) + stiffness
    u, v, load = generator.standard_normal((3, size))
    known = (2.0 / STEP) * mass @ v - stiffness @ u
    h = np.linalg.solve(newmark, known + load)
    new_u, new_v = u + 2.0 * h, 4.0 / STEP * h - v
    given_factors = {"given": factors, "none": None, "wrong": generator.uniform(0.0, 1.0, (2, size))}[rayleigh]
    carried = recursion(bands(mass, 9), bands(damping, 9), bands(newmark, 9), given_factors, STEP)
    most = (carried.blocks.shape[1] // kernels.BLOCK - 3) // 2
    x = np.zeros(size + 2 * most)
    x[most : most + size] = new_v + carried.proportional * h
    following = known.copy()
    kernels.next_known(carried, x, h, following)
    following += (carried.retained - 1.0) * load
    expected = (2.0 / STEP) * mass @ new_v - stiffness @ new_u
    np.testing.assert_allclose(following, expected, rtol=0.0, atol=1e-10 * np.abs(newmark).max() * np.abs(h).max())


def test_rayleigh_damping_leaves_single_dampers_alone():
    generator = np.random.default_rng(2)
    mass, damping, stiffness, factors = spring_mass_chain(generator, 90, 4)
    damping = factors[0][:, None] * mass + factors[1][:, None] * stiffness
    damping[np.ix_([30, 33], [30, 33])] += np.array([[2.0, -2.0], [-2.0, 2.0]])
    newmark = (2.0 / STEP) * ((2.0 / STEP) * mass + damping) + stiffness
    carried = recursion(bands(mass, 9), bands(damping, 9), bands(newmark, 9), factors, STEP)
    assert carried.pairs.tolist() == [[33, 30]]
