"""Loads and masses that move over a simply supported beam, against modal solutions (Frýba 1999, ch. 1 and 2)."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from railsearch_plugins.dynamics import banded
from railsearch_plugins.dynamics.beam import bending_matrices, gram_matrices, locate
from railsearch_plugins.dynamics.moving_contact import Observation, Track, make_contact, pass_over
from railsearch_plugins.dynamics.vehicles import RIGID, Vehicle

SPAN, MASS, EI, LOAD = 20.0, 10e3, 2e10, 1e5
FIRST = (np.pi / SPAN) ** 2 * np.sqrt(EI / MASS)
CRITICAL = FIRST * SPAN / np.pi


def midspan(share, wheel_mass, steps, count=40):
    """Time and deflection at midspan while a wheel crosses at a share of the critical speed, its spring infinitely stiff."""
    nodes = np.linspace(0.0, SPAN, count + 1)
    unknowns = np.arange(-1, 2 * count + 1).reshape(count + 1, 2)
    unknowns[-1] = [-1, 2 * count - 1]
    elements = np.concatenate([unknowns[:-1], unknowns[1:]], axis=1)
    length = np.diff(nodes)
    mass = banded.assemble([(elements, MASS * gram_matrices(length, 0.0, length))], 2 * count, 3)
    stiffness = banded.assemble([(elements, bending_matrices(length, EI))], 2 * count, 3)
    wheel = Vehicle(np.array([[wheel_mass]]), np.zeros((1, 1)), np.zeros((1, 1)), np.array([LOAD]), RIGID)
    speed = share * CRITICAL
    time = np.linspace(0.0, SPAN / speed, steps + 1)
    contact = make_contact(nodes, unknowns, speed * time[:, None], np.zeros((steps + 1, 1, 3)), speed)
    element, row = locate(nodes, 0.5 * SPAN)
    assert row[0, 0] == 1.0
    observation = Observation(points=unknowns[element[0], :1])
    passage = pass_over(Track(mass, 0.0 * mass, stiffness), wheel, contact, time[1], observation)
    return time, passage.point_displacement[:, 0], passage.force[:, 0]


def series(share, time, terms=60):
    """Midspan deflection under a constant moving force, undamped, all harmonics (Frýba 1999, eq. 1.31)."""
    total = np.zeros_like(time)
    for n in range(1, 2 * terms, 2):
        own, forced = n**2 * FIRST, n * share * FIRST
        shape = np.sin(0.5 * n * np.pi)
        response = (np.sin(forced * time) - forced / own * np.sin(own * time)) / (own**2 - forced**2)
        total += 2.0 * LOAD / (MASS * SPAN) * shape * response
    return total


def moving_mass(share, mass, time, terms=12):
    """Midspan deflection under a moving mass, all convective terms kept, by modes and an adaptive Runge-Kutta method."""
    n = np.arange(1, terms + 1)
    speed = share * CRITICAL

    def rate(t, state):
        q, dq = np.split(state, 2)
        angle = n * np.pi * speed * t / SPAN
        shape, slope = np.sin(angle), n * np.pi * speed / SPAN * np.cos(angle)
        convective = 2.0 * slope @ dq - (n * np.pi * speed / SPAN) ** 2 * shape @ q
        inertia = np.eye(terms) + 2.0 * mass / (MASS * SPAN) * np.outer(shape, shape)
        load = 2.0 / (MASS * SPAN) * (LOAD - mass * convective) * shape - (n**2 * FIRST) ** 2 * q
        return np.concatenate([dq, np.linalg.solve(inertia, load)])

    solution = solve_ivp(rate, (0.0, time[-1]), np.zeros(2 * terms), "DOP853", time, rtol=1e-9, atol=1e-14)
    return np.sin(0.5 * n * np.pi) @ solution.y[:terms]


@pytest.mark.parametrize("share", [0.1, 0.5, 0.98], ids=["slow", "sub-critical", "near-resonant"])
def test_constant_force_on_a_simply_supported_beam(share):
    time, deflection, force = midspan(share, 0.0, 4000)
    np.testing.assert_allclose(force, LOAD, rtol=1e-12)
    known = series(share, time)
    np.testing.assert_allclose(deflection, known, rtol=0.0, atol=2e-4 * known.max())


def test_moving_mass_on_a_simply_supported_beam():
    mass = 0.3 * MASS * SPAN
    time, deflection, force = midspan(0.4, mass, 2000)
    known = moving_mass(0.4, mass, time)
    assert np.abs(known - series(0.4, time)).max() > 0.1 * known.max()
    np.testing.assert_allclose(deflection, known, rtol=0.0, atol=3e-3 * known.max())
    assert np.ptp(force[1:-1]) > 0.1 * LOAD


def test_a_light_mass_is_a_constant_force():
    _, deflection, force = midspan(0.3, 1e-6 * MASS * SPAN, 1000)
    np.testing.assert_allclose(deflection, midspan(0.3, 0.0, 1000)[1], rtol=0.0, atol=1e-5 * deflection.max())
    np.testing.assert_allclose(force, LOAD, rtol=1e-3)


def test_deflection_under_a_constant_force_converges_with_the_step():
    # Less than the order 2 of Newmark's method: the load goes to the next element between two steps.
    runs = [midspan(0.2, 0.0, steps, 4)[1][:: steps // 2000] for steps in (2000, 4000, 8000, 16000)]
    differences = [np.abs(b - a).max() for a, b in pairwise(runs)]
    assert np.log2(differences[0] / differences[-1]) / 2.0 > 1.5


def test_deflection_under_a_constant_force_converges_with_the_mesh():
    # Inside an element the kink of the third derivative under the load is out of the cubics' reach: order 3, not 4.
    deflections = [midspan(0.5, 0.0, 4000, count)[1] for count in (8, 16, 32, 64)]
    differences = [np.abs(b - a).max() for a, b in pairwise(deflections)]
    np.testing.assert_allclose(np.log2(np.divide(differences[:-1], differences[1:])), 3.0, atol=0.6)
