"""The achievement scalarising function: values at marked points, order, Pareto optimality, and errors at the door."""

import copy
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from railsearch.errors import InputError
from railsearch.interfaces import Quantity
from railsearch.parameters import make_parameters
from railsearch.scalarise import augmented_chebyshev
from railsearch_plugins.scalarisers.asf import AchievementParameters, AchievementScalarisingFunction

ASPIRATION, WORST = np.array([1.0, -2.0, 100.0]), np.array([3.0, 2.0, 1100.0])
ROWS = arrays(float, (6, 3), elements=st.floats(-1e4, 1e4))
F_AND_E = [Quantity("F_max", "N"), Quantity("E_max", "N·m")]


def made(values=None, worst=None):
    parameters = make_parameters(AchievementParameters, values or {}, "asf")
    return AchievementScalarisingFunction(parameters, F_AND_E, {"F_max": 6000.0, "E_max": 1.5} if worst is None else worst)


def test_value_at_the_aspiration_point_and_at_the_worst_values():
    scalars = augmented_chebyshev(np.array([ASPIRATION, WORST]), ASPIRATION, WORST, 0.05)
    np.testing.assert_allclose(scalars, [0.0, 1.0 + 0.05 * 3], rtol=1e-14)


def test_by_hand():
    # κ = (1/2, 1/4, 1/1000); κ (f − f^r) = (0.25, −0.5, 0.1)
    scalar = augmented_chebyshev(np.array([[1.5, -4.0, 200.0]]), ASPIRATION, WORST, 0.1)
    np.testing.assert_allclose(scalar, [0.25 + 0.1 * (0.25 - 0.5 + 0.1)], rtol=1e-14)


@given(ROWS, arrays(float, (6, 3), elements=st.floats(1e-3, 10.0)), st.floats(0.0, 1.0))
def test_better_in_every_objective_is_better(rows, gains, rho):
    worse = augmented_chebyshev(rows, ASPIRATION, WORST, rho)
    assert np.all(augmented_chebyshev(rows - gains, ASPIRATION, WORST, rho) < worse)


@given(ROWS, st.floats(0.01, 100.0), st.floats(-50.0, 50.0))
def test_units_and_origins_of_the_objectives_do_not_matter(rows, scale, shift):
    original = augmented_chebyshev(rows, ASPIRATION, WORST, 0.05)
    changed = augmented_chebyshev(scale * rows + shift, scale * ASPIRATION + shift, scale * WORST + shift, 0.05)
    np.testing.assert_allclose(changed, original, rtol=1e-8, atol=1e-8)


@given(arrays(float, (30, 3), elements=st.floats(-5.0, 1500.0)))
def test_minimiser_is_not_dominated(rows):
    chosen = rows[np.argmin(augmented_chebyshev(rows, ASPIRATION, WORST, 0.05))]
    dominating = np.all(rows <= chosen, axis=1) & np.any(rows < chosen - 1e-9, axis=1)
    assert not dominating.any()


def test_without_augmentation_a_weakly_better_design_is_not_preferred_with_it_it_is():
    rows = np.array([[3.0, 0.0, 100.0], [3.0, -1.0, 100.0]])
    plain, augmented = (augmented_chebyshev(rows, ASPIRATION, WORST, rho) for rho in (0.0, 0.05))
    assert plain[0] == plain[1]
    assert augmented[1] < augmented[0]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"worst": np.array([3.0, -2.0, 1100.0])},
            "worst value must lie above the aspiration, received -2 and -2 for objective 2",
        ),
        ({"objectives": np.array([1.0, 2.0, 3.0])}, "objectives (n, m), aspiration (m,) and worst (m,) are needed"),
        ({"aspiration": np.array([1.0])}, "are needed, received shapes (1, 3), (1,) and (3,)"),
        ({"worst": np.array([np.nan, 2.0, 1100.0])}, "received nan and 1 for objective 1"),
        ({"rho": -0.1}, "rho ≥ 0 is needed, received -0.1"),
    ],
)
def test_bad_input_is_refused(change, message):
    arguments = {"objectives": ASPIRATION[None, :], "aspiration": ASPIRATION, "worst": WORST, "rho": 0.05} | change
    with pytest.raises(InputError, match=re.escape(message)):
        augmented_chebyshev(**arguments)


def test_aspiration_is_a_fraction_of_the_reference_designs_values():
    scalariser = made()
    assert not scalariser.ready
    scalariser.prepare(np.array([2000.0, 1.0]))
    assert scalariser.ready
    assert scalariser.aspiration == pytest.approx({"F_max": 1600.0, "E_max": 0.8})
    np.testing.assert_allclose(scalariser(np.array([[1600.0, 0.8]])), [0.0], atol=1e-14)
    np.testing.assert_allclose(scalariser(np.array([[6000.0, 1.5]])), [1.1], rtol=1e-14)


def test_a_negated_maximised_objective_is_asked_to_improve_too():
    scalariser = made(worst={"F_max": 0.0, "E_max": 1.5})
    scalariser.prepare(np.array([-10.0, 1.0]))
    assert scalariser.aspiration["F_max"] == pytest.approx(-12.0)


def test_explicit_values_take_the_place_of_reference_and_problem():
    scalariser = made({"aspiration": {"E_max": 0.5}, "worst": {"F_max": 9000.0}})
    assert not scalariser.ready
    scalariser.prepare(np.array([2000.0, 1.0]))
    assert scalariser.aspiration == pytest.approx({"F_max": 1600.0, "E_max": 0.5})
    assert scalariser.worst == {"F_max": 9000.0, "E_max": 1.5}
    assert made({"aspiration": {"E_max": 0.5, "F_max": 1000.0}}).ready


def test_preparing_a_copy_leaves_the_original_unprepared():
    original = made()
    copy.copy(original).prepare(np.array([2000.0, 1.0]))
    assert not original.ready


@pytest.mark.parametrize(
    ("values", "worst", "message"),
    [
        ({}, {"F_max": 6000.0}, "worst value of E_max is not known: sample it with `railsearch sample PROBLEM`"),
        (
            {"worst": {"A_max": 1.0}},
            None,
            "asf.worst: unknown objective 'A_max', did you mean 'F_max'?; the",
        ),
        ({"aspiration": {"F_max": 10**400}}, None, "asf.aspiration.F_max: a finite number is needed, received 1000"),
        ({"aspiration": {"F_max": "low"}}, None, "asf.aspiration.F_max: a finite number is needed, received 'low'"),
        (
            {"aspiration": {"F_max": 7000.0}},
            None,
            "aspiration of F_max must lie below its worst value, received 7000 and 6000",
        ),
        ({"aspiration_fraction": 1.2}, None, "asf.aspiration_fraction: allowed is > 0 and ≤ 1"),
        ({"rho": -1.0}, None, "asf.rho: allowed is ≥ 0"),
    ],
)
def test_bad_settings_are_refused(values, worst, message):
    with pytest.raises(InputError, match=re.escape(message)):
        made(values, worst)


def test_a_reference_design_worse_than_the_worst_values_is_refused():
    with pytest.raises(InputError, match="aspiration of F_max must lie below its worst value, received 8000 and 6000"):
        made().prepare(np.array([10000.0, 1.0]))
