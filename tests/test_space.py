import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from railsearch.errors import InputError
from railsearch.space import Space, Variable
from sample_problems import MIXED

points = st.lists(st.floats(0.0, 1.0), min_size=4, max_size=4)


@given(points)
def test_designs_are_inside_the_bounds_with_whole_integers(point: list[float]) -> None:
    design = MIXED.from_unit(np.array(point))
    assert np.array_equal(MIXED.checked(design), design)
    assert np.array_equal(design[2:], np.round(design[2:]))
    again = MIXED.from_unit(MIXED.to_unit(design))
    assert np.allclose(again, design, rtol=0.0, atol=1e-14)


@given(points)
def test_rounding_is_to_the_nearest_whole_number(point: list[float]) -> None:
    exact = MIXED.lower + np.array(point) * (MIXED.upper - MIXED.lower)
    assert np.all(np.abs(MIXED.from_unit(np.array(point)) - exact)[2:] <= 0.5 + 1e-12)


def test_named_designs_have_native_types() -> None:
    named = MIXED.named(np.array([0.5, 1.0, -2.0, 3.0]))
    assert named == {"stiffness": 0.5, "length": 1.0, "count": -2, "rows": 3}
    assert [type(value) for value in named.values()] == [float, float, int, int]


def test_negative_zero_is_the_same_design() -> None:
    assert MIXED.key(np.array([-0.0, 0, 0, 0])) == MIXED.key(np.array([0.0, 0, 0, 0]))


def test_size_counts_the_designs() -> None:
    assert math.isinf(MIXED.size)
    assert Space((Variable("a", 0, 3, integer=True), Variable("b", -1, 1, integer=True))).size == 12


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"stiffness": 6.0}, ("stiffness", "-5 to 5 MN/m", "6 MN/m")),
        ({"stiffness": math.nan}, ("stiffness", "finite", "nan")),
        ({"count": 1.5}, ("count", "whole number", "1.5")),
        ({"stifness": 1.0}, ("'stifness'", "did you mean 'stiffness'")),
    ],
)
def test_bad_designs_are_refused_by_name(changes: dict[str, float], words: tuple[str, ...]) -> None:
    with pytest.raises(InputError) as caught:
        MIXED.amended(np.zeros(4), changes)
    assert all(word in str(caught.value) for word in words), str(caught.value)


@pytest.mark.parametrize("design", [["a"], "a", None, [1.0], [[0.0, 0.0, 0.0, 0.0]], {"stiffness": 1.0}])
def test_what_is_no_design_is_refused(design: Any) -> None:
    with pytest.raises(InputError, match=r"^design: 4 values are needed \(.*stiffness.*\), received "):
        MIXED.checked(design)


@pytest.mark.parametrize(
    ("lower", "upper", "integer", "word"),
    [(1.0, 0.0, False, "below"), (1.0, 1.0, False, "below"), (math.nan, 1.0, False, "finite"), (0.5, 2.0, True, "whole")],
)
def test_bad_bounds_are_refused(lower: float, upper: float, integer: bool, word: str) -> None:
    with pytest.raises(InputError, match=word):
        Variable("pad", lower, upper, integer=integer)


def test_names_must_differ() -> None:
    with pytest.raises(InputError, match="different names"):
        Space((Variable("a", 0, 1), Variable("a", 0, 2)))
