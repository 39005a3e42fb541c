"""Bounds, grids and weights of factors."""

import numpy as np
import pytest

from railsearch.distributions import random_vector
from railsearch.errors import InputError
from railsearch.sensitivity import factors_on, input_space
from railsearch.sensitivity.factors import trapezoidal_weights
from railsearch.space import Space, Variable

INPUTS = random_vector(
    {
        "modulus": {"distribution": "lognormal", "mean": 2.1e11, "std": 2.1e10},
        "depth": {"distribution": "uniform", "lower": 0.3, "upper": 0.6},
        "load": {"distribution": "normal", "mean": 5e4, "std": 7.5e3},
    }
)
SPACE = Space((Variable("E", 1.0e11, 3.0e11, "Pa"), Variable("h", 0.3, 0.6, "m"), Variable("n", 1.0, 6.0, integer=True)))


def test_bounds_are_stated_ones_or_supports_or_percentiles():
    space = input_space(INPUTS, 0.001, {"load": (2e4, 8e4)}, {"load": "N"})
    assert space.names == INPUTS.names
    assert [space.lower[0], space.upper[0]] == pytest.approx(INPUTS.percentiles([0.001, 0.999])[:, 0])
    assert [space.lower[1], space.upper[1]] == [0.3, 0.6], "a bounded input keeps its own bounds"
    assert [space.lower[2], space.upper[2]] == [2e4, 8e4]
    assert [variable.unit for variable in space.variables] == ["", "", "N"]


def test_wide_positive_ranges_have_logarithmic_grids_by_default():
    factors = factors_on(SPACE, 11)
    assert factors.spacings == ("logarithmic", "equal", "equal")
    ratios = factors.grids[0][1:] / factors.grids[0][:-1]
    np.testing.assert_allclose(ratios, 3.0**0.1)
    np.testing.assert_allclose(np.diff(factors.grids[1]), 0.03)
    assert factors.grids[2].tolist() == [1.0, 2.0, 3.0, 4.0, 5.0, 6.0], "each whole number once"


def test_the_rule_asks_for_more_than_a_thousand_above_zero():
    bounds = {"narrow": (1.0, 1001.0), "wide": (1.0, 1001.5), "from zero": (0.0, 1e6), "negative": (-5.0, 1e6)}
    space = Space(tuple(Variable(name, *pair) for name, pair in bounds.items()))
    assert factors_on(space).spacings == ("equal", "logarithmic", "equal", "equal")


def test_points_and_spacings_by_name_leave_the_others_as_they_are():
    factors = factors_on(SPACE, {"h": 7}, {"E": "equal", "h": "random"}, np.random.default_rng(3))
    assert [len(grid) for grid in factors.grids] == [50, 7, 6]
    assert factors.spacings == ("equal", "random", "equal")
    again = factors_on(SPACE, {"h": 7}, {"h": "random"}, np.random.default_rng(3))
    assert np.array_equal(factors.grids[1], again.grids[1])
    assert (np.diff(factors.grids[1]) > 0.0).all()
    assert factors.grids[1][0] >= 0.3
    assert factors.grids[1][-1] <= 0.6


def test_weights_are_those_of_the_trapezoidal_rule():
    grid = np.array([0.0, 1.0, 4.0, 4.5])
    assert trapezoidal_weights(grid).tolist() == [0.5, 2.0, 1.75, 0.25]
    assert trapezoidal_weights(grid) @ (2.0 + 3.0 * grid) == pytest.approx(np.trapezoid(2.0 + 3.0 * grid, grid))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: factors_on(SPACE, 1), "points of E: an integer ≥ 2"),
        (lambda: factors_on(SPACE, {"hh": 5}), "points: unknown factor 'hh', did you mean 'h'"),
        (lambda: factors_on(SPACE, 5, "cubic"), "equal, logarithmic, random are known, received 'cubic'"),
        (lambda: factors_on(SPACE, 5, "random"), "needs a generator"),
        (lambda: factors_on(Space((Variable("z", 0.0, 1.0),)), 5, "logarithmic"), "lower bound above 0, received 0"),
        (lambda: input_space(INPUTS, ranges={"depht": (0.3, 0.5)}), "did you mean 'depth'"),
        (
            lambda: input_space(INPUTS, ranges={"depth": (0.3, 0.7)}),
            "range of depth: .* 0.6, received 0.3 to 0.7",
        ),
        (lambda: input_space(INPUTS, ranges={"load": (8e4, 2e4)}), "lower bound must lie below"),
        (lambda: input_space(INPUTS, ranges={"load": (2e4, 2e4)}), "lower bound must lie below"),
        (lambda: input_space(INPUTS, ranges={"load": (2e4,)}), "a lower and an upper bound"),
        (lambda: input_space(INPUTS, 0.5), "level"),
        (lambda: factors_on(SPACE).index("e"), "unknown factor 'e'"),
    ],
)
def test_bad_input_is_named(make, message):
    with pytest.raises(InputError, match=message):
        make()
