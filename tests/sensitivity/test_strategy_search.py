"""Extreme surfaces of the true model by a strategy: values, counts, failures, signs."""

import numpy as np
import pytest

from railsearch.design_problem import DesignProblem
from railsearch.errors import InputError, PluginError
from railsearch.interfaces import Outcome, Quantity
from railsearch.plugin_manager import load_plugins
from railsearch.sensitivity import (
    ExactModel,
    ProblemFunction,
    StrategySettings,
    extreme_surfaces,
    factors_on,
    strategy_surfaces,
    threshold_surfaces,
)
from railsearch.space import Space, Variable
from railsearch_problems.six_hump_camel import SixHumpCamel, camel_values

REGISTRY = load_plugins()


class Slope(DesignProblem):
    """h = x + 2 y + 10 n with a whole number n, to be maximised; and twice as much as a metric. Fails where y > `limit`."""

    def __init__(self, limit=9.0):
        variables = (Variable("x", 0.0, 1.0), Variable("y", 0.0, 1.0), Variable("n", 0.0, 2.0, integer=True))
        metrics = [Quantity("twice", "m")]
        super().__init__("slope", Space(variables), [Quantity("h", "m", maximised=True)], metrics, np.array([0.5, 0.5, 1.0]))
        self.limit = limit

    def simulate(self, design):
        if design[1] > self.limit:
            raise RuntimeError("derailed")
        height = float(design @ [1.0, 2.0, 10.0])
        return Outcome(np.array([-height]), {"twice": 2.0 * height})


def found(problem, name, points=3, strategy="random", budget=30, **more):
    return strategy_surfaces(
        REGISTRY, problem, name, factors_on(problem.space, points), StrategySettings(strategy, budget, 1, **more)
    )


def test_a_strategy_comes_near_the_extremes_and_counts_its_evaluations():
    """128 Sobol' points of one variable lie within 1/64 of its range of the extreme; slopes are at most 57."""
    camel = SixHumpCamel()
    surfaces = found(camel, "f", points=4, strategy="sobol", budget=128)
    factors = surfaces.factors
    exact = extreme_surfaces(ExactModel(camel_values, camel.space), factors, np.random.default_rng(0))
    assert surfaces.effort.asked == 2 * 8 * 128
    assert surfaces.effort.exact
    assert surfaces.effort.solver == "strategy sobol"
    for name in factors.names:
        for sense, sign in (("maximum", -1.0), ("minimum", 1.0)):
            behind = sign * (surfaces.surface(name, sense).values - exact.surface(name, sense).values)
            assert np.all((behind > -1e-8) & (behind < 1.0))
            points = surfaces.surface(name, sense).points
            np.testing.assert_allclose(camel_values(points), surfaces.surface(name, sense).values)
            np.testing.assert_array_equal(points[:, factors.index(name)], factors.grids[factors.index(name)])


def test_natural_signs_whole_numbers_and_metrics():
    """Ȳmax of n is 3 + 10 n at x = y = 1, which random points come near; a metric is twice as large everywhere."""
    objective, metric = (found(Slope(), name, budget=60) for name in ("h", "twice"))
    assert objective.factors.grids[2].tolist() == [0.0, 1.0, 2.0]
    np.testing.assert_allclose(objective.surface("n").values, [3.0, 13.0, 23.0], atol=0.6)
    np.testing.assert_allclose(objective.surface("n", "minimum").values, [0.0, 10.0, 20.0], atol=0.6)
    np.testing.assert_allclose(metric.surface("n").values, 2.0 * objective.surface("n").values)
    assert objective.surface("x").points[:, 2].tolist() == [2.0, 2.0, 2.0]
    assert threshold_surfaces(objective, 24.0).thresholds[0].status == "never reached"


def test_a_good_start_from_the_grid_value_before_is_kept():
    """With warm starts no value is worse than that of the solution before, moved along: here by ten per step."""
    warm = found(Slope(), "h", budget=3)
    assert np.all(np.diff(warm.surface("n").values) >= 10.0 - 1e-9)
    cold = found(Slope(), "h", budget=3, warm_starts=False)
    assert np.any(np.diff(cold.surface("n").values) < 10.0)


def test_failures_are_counted_and_problems_without_a_value_are_missing():
    surfaces = found(Slope(limit=0.5), "h", points=3, budget=20, senses=("maximum",))
    assert surfaces.senses == ("maximum",)
    assert 0 < surfaces.effort.failures < surfaces.effort.asked
    held = surfaces.surface("y").values
    assert np.isfinite(held[:2]).all()
    assert np.isnan(held[2])
    assert surfaces.unsolved == 1
    function = ProblemFunction(Slope(limit=0.5), "h")
    assert np.isnan(function(np.array([[0.0, 0.4, 1.0], [0.0, 0.6, 1.0]]))).tolist() == [False, True]
    assert function.reasons == {"RuntimeError: derailed": 1}


def test_the_same_seed_gives_the_same_bits_and_progress_is_told():
    told = []
    settings = StrategySettings("random", 8, 3)
    factors = factors_on(Slope().space, 2)
    first = strategy_surfaces(REGISTRY, Slope(), "h", factors, settings, lambda done, total: told.append((done, total)))
    second = strategy_surfaces(REGISTRY, Slope(), "h", factors, settings)
    assert first.surface("x").points.tobytes() == second.surface("x").points.tobytes()
    assert told == [(k, 12) for k in range(1, 13)]


@pytest.mark.parametrize(
    ("make", "error", "message"),
    [
        (lambda: found(Slope(), "H"), InputError, "unknown quantity 'H' of slope; there are h, twice"),
        (lambda: found(Slope(), "h", budget=0), InputError, "budget"),
        (lambda: found(Slope(), "h", senses=()), InputError, "none"),
        (lambda: found(Slope(), "h", senses=("largest",)), InputError, "maximum or minimum"),
        (lambda: found(Slope(), "h", strategy="randm"), PluginError, "did you mean 'random'"),
        (
            lambda: strategy_surfaces(
                REGISTRY, Slope(), "h", factors_on(SixHumpCamel().space, 3), StrategySettings("random", 5, 1)
            ),
            InputError,
            "all variables of slope",
        ),
    ],
)
def test_bad_input_is_named(make, error, message):
    with pytest.raises(error, match=message):
        make()
