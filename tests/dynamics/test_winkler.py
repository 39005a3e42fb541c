"""A long beam on a continuous foundation against closed forms.

Static: w = P β/(2k), β = (k/(4 EI))^(1/4) (Hetényi 1946, eq. 1.3). A load moving at the share α of the critical speed
(4 k EI/m²)^(1/4): w = w_static/√(1 − α²) (Frýba 1999, ch. 13, no damping).
"""

import numpy as np
import pytest

from railsearch_plugins.dynamics import banded
from railsearch_plugins.dynamics.beam import bending_matrices, gram_matrices, locate
from railsearch_plugins.dynamics.moving_contact import Track, make_contact, pass_over, static_displacement
from railsearch_plugins.dynamics.vehicles import Vehicle

EI, FOUNDATION, MASS = 4.9e6, 27e6, 54.0
LOAD = 50e3
WAVE_NUMBER = (FOUNDATION / (4.0 * EI)) ** 0.25
STATIC = LOAD * WAVE_NUMBER / (2.0 * FOUNDATION)
CRITICAL_SPEED = (4.0 * FOUNDATION * EI / MASS**2) ** 0.25


def pinned_beam(length, count):
    """Nodes, their unknowns (count + 1, 2), those of the elements (count, 4), ∫ N″ᵀN″ EI and ∫ NᵀN of a pinned beam."""
    nodes = np.linspace(0.0, length, count + 1)
    unknowns = np.arange(-1, 2 * count + 1).reshape(count + 1, 2)
    unknowns[-1] = [-1, 2 * count - 1]
    elements = np.concatenate([unknowns[:-1], unknowns[1:]], axis=1)
    spans = np.diff(nodes)
    size = 2 * count
    bending = banded.assemble([(elements, bending_matrices(spans, EI))], size, 3)
    gram = banded.assemble([(elements, gram_matrices(spans, 0.0, spans))], size, 3)
    return nodes, unknowns, elements, bending, gram


def deflection_under_static_load(count, position):
    nodes, _, elements, bending, gram = pinned_beam(40.0, count)
    element, row = locate(nodes, position)
    load = np.zeros(gram.shape[1])
    load[elements[element[0]]] = LOAD * row[0]
    return static_displacement(bending + FOUNDATION * gram, load)[elements[element[0]]] @ row[0]


@pytest.mark.parametrize("position", [20.0, 20.003, 20.031])
def test_static_deflection_under_a_point_load(position):
    assert deflection_under_static_load(1600, position) == pytest.approx(STATIC, rel=6e-7)


@pytest.mark.parametrize(("place", "order"), [(0.0, 4.0), (0.5, 3.0)], ids=["on a node", "inside an element"])
def test_static_deflection_converges_at_the_order_of_cubics(place, order):
    # Inside an element the cubics cannot follow the jump of the third derivative under the load: one order less.
    errors = [
        abs(deflection_under_static_load(count, 20.0 + place * 40.0 / count) / STATIC - 1.0) for count in (80, 160, 320)
    ]
    np.testing.assert_allclose(np.log2(np.divide(errors[:-1], errors[1:])), order, atol=0.2)


@pytest.mark.parametrize("share", [0.2, 0.5, 0.7])
def test_moving_load_below_the_critical_speed(share):
    # A wheel too heavy to move on a spring of next to no stiffness is a prescribed force; the irregularity fades it in.
    nodes, unknowns, _, bending, gram = pinned_beam(110.0, 1100)
    speed, step = share * CRITICAL_SPEED, 0.025 / CRITICAL_SPEED
    track = Track(MASS * gram, 0.0 * gram, bending + FOUNDATION * gram)
    wheel = Vehicle(1e15 * np.eye(1), np.zeros((1, 1)), np.zeros((1, 1)), np.array([LOAD]), 1e-3)
    positions = speed * step * np.arange(int(76.0 / (speed * step)))
    s = np.clip(positions / 60.0, 0.0, 1.0)
    fade = 1.0 - s**4 * (35.0 - 84.0 * s + 70.0 * s**2 - 20.0 * s**3)
    fade[0] = 0.0
    irregularity = (fade * LOAD / wheel.contact_stiffness)[:, None, None]
    passage = pass_over(track, wheel, make_contact(nodes, unknowns, positions[:, None], irregularity), step)
    rail = (passage.motion - irregularity)[:, 0, 0]
    settled = rail[(positions > 65.0) & (positions < 75.0)]
    np.testing.assert_allclose(passage.force[positions > 60.0, 0], LOAD, rtol=1e-9)
    np.testing.assert_allclose(settled, STATIC / np.sqrt(1.0 - share**2), rtol=3e-4)
