"""The ballast cone against its check values, integrals over the cone, and its limits."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from railsearch.errors import InputError
from railsearch_plugins.track_models.train_track_bridge.ballast import ballast_cone

HALF_LENGTH, WIDTH, SPACING = 0.95, 0.273, 0.545
USUAL = {"depth": 0.45, "angle": 35.0, "density": 1800.0, "modulus": 1.1e8}


def border_angle(depth):
    """The angle in degrees at which neighbouring cones just touch at the foot of the ballast."""
    return math.degrees(math.atan((SPACING - WIDTH) / (2.0 * depth)))


def test_check_values_of_the_overlapping_cone():
    steep = ballast_cone(0.45, 35.0, 1800.0, 1.1e8)
    assert steep.mass == pytest.approx(531.4, abs=0.05)
    assert steep.stiffness == pytest.approx(137.75e6, abs=0.005e6)
    flat = ballast_cone(0.45, 25.0, 1800.0, 1.2e8)
    # Source: inputs of the reference runs, given there to 16 digits.
    assert flat.mass == pytest.approx(443.43503123934096, rel=1e-13)
    assert flat.stiffness == pytest.approx(130384041.60657689, rel=1e-13)


@pytest.mark.parametrize("angle", [2.0, 10.0, 16.0])
def test_a_cone_alone_is_the_integral_over_its_sections(angle):
    depth, density, modulus, t = 0.45, 1800.0, 1.1e8, math.tan(math.radians(angle))
    cone = ballast_cone(depth, angle, density, modulus)

    def section(z):
        return (HALF_LENGTH + 2.0 * z * t) * (WIDTH + 2.0 * z * t)

    assert cone.overlap == 0.0
    assert cone.mass == pytest.approx(density * quad(section, 0.0, depth)[0], rel=1e-12)
    assert 1.0 / cone.stiffness == pytest.approx(quad(lambda z: 1.0 / (modulus * section(z)), 0.0, depth)[0], rel=1e-12)


@pytest.mark.parametrize("angle", [20.0, 35.0, 60.0])
def test_overlapping_cones_are_in_series_with_the_part_of_constant_width(angle):
    depth, modulus, t = 0.6, 1.1e8, math.tan(math.radians(angle))
    cone = ballast_cone(depth, angle, 1800.0, modulus)
    meeting = (SPACING - WIDTH) / (2.0 * t)
    free = quad(lambda z: 1.0 / ((HALF_LENGTH + 2.0 * z * t) * (WIDTH + 2.0 * z * t)), 0.0, meeting)[0]
    mean_section = quad(lambda z: SPACING * (HALF_LENGTH + 2.0 * z * t), meeting, depth)[0] / (depth - meeting)
    assert cone.overlap == pytest.approx(depth - meeting, rel=1e-13)
    assert modulus / cone.stiffness == pytest.approx(free + (depth - meeting) / mean_section, rel=1e-12)


@pytest.mark.parametrize("angle", [20.0, 35.0, 60.0])
def test_printed_mass_of_overlapping_cones_exceeds_their_solid_by_the_known_amount(angle):
    depth, density, t = 0.6, 1800.0, math.tan(math.radians(angle))
    cone = ballast_cone(depth, angle, density, 1.1e8)
    meeting = depth - cone.overlap
    above = quad(lambda z: (HALF_LENGTH + 2.0 * z * t) * (WIDTH + 2.0 * z * t), 0.0, meeting)[0]
    below = quad(lambda z: SPACING * (HALF_LENGTH + 2.0 * z * t), meeting, depth)[0]
    excess = 2.0 * t**2 * (depth - cone.overlap) * cone.overlap**2
    assert cone.mass == pytest.approx(density * (above + below + excess), rel=1e-12)


@pytest.mark.parametrize("depth", [0.3, 0.45, 0.6])
def test_branches_meet_with_value_and_stiffness_on_both_sides(depth):
    border, step = border_angle(depth), 1e-7
    below, at, above = (ballast_cone(depth, border + shift, 1800.0, 1.1e8) for shift in (-step, 0.0, step))
    assert below.overlap == 0.0 < above.overlap
    for side in (below, above):
        assert side.mass == pytest.approx(at.mass, rel=1e-7)
        assert side.stiffness == pytest.approx(at.stiffness, rel=1e-7)


def test_a_vertical_cone_is_a_column():
    cone = ballast_cone(0.45, 1e-12, 1800.0, 1.1e8)
    assert cone.mass == pytest.approx(1800.0 * HALF_LENGTH * WIDTH * 0.45, rel=1e-10)
    assert cone.stiffness == pytest.approx(1.1e8 * HALF_LENGTH * WIDTH / 0.45, rel=1e-10)


@given(st.floats(0.3, 0.6), st.floats(15.0, 35.0), st.floats(1500.0, 2100.0), st.floats(8e7, 1.6e8), st.floats(1.001, 1.2))
def test_scale_with_density_and_modulus_and_grow_with_the_angle(depth, angle, density, modulus, factor):
    cone = ballast_cone(depth, angle, density, modulus)
    scaled = ballast_cone(depth, angle, factor * density, factor * modulus)
    wider = ballast_cone(depth, factor * angle, density, modulus)
    assert scaled.mass == pytest.approx(factor * cone.mass, rel=1e-12)
    assert scaled.stiffness == pytest.approx(factor * cone.stiffness, rel=1e-12)
    assert wider.mass > cone.mass
    assert wider.stiffness > cone.stiffness
    assert ballast_cone(depth * factor, angle, density, modulus).stiffness < cone.stiffness


def test_the_switch_doubles_mass_and_stiffness():
    one, two = (ballast_cone(0.45, 25.0, 1800.0, 1.2e8, doubled=doubled) for doubled in (False, True))
    assert (two.mass, two.stiffness, two.overlap) == (2.0 * one.mass, 2.0 * one.stiffness, one.overlap)


@pytest.mark.parametrize(
    ("field", "change"),
    [
        ("ballast_angle", {"angle": 0.0}),
        ("ballast_angle", {"angle": 90.0}),
        ("ballast_angle", {"angle": -5.0}),
        ("ballast_angle", {"angle": math.nan}),
        ("ballast_depth", {"depth": 0.0}),
        ("ballast_depth", {"depth": math.inf}),
        ("ballast_density", {"density": -1.0}),
        ("ballast_modulus", {"modulus": 0.0}),
        ("sleeper_width", {"width": 0.0}),
        ("sleeper_half_length", {"half_length": 0.273}),
        ("cone_spacing", {"spacing": 0.273}),
    ],
)
def test_degenerate_cones_are_refused_by_name(field, change):
    received = next(iter(change.values()))
    with pytest.raises(InputError, match=rf"^{field}: .*received {np.float64(received):g}; .+"):
        ballast_cone(**{**USUAL, **change})
