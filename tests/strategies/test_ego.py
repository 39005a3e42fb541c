"""Efficient global optimisation: where the improvement is really largest, and what it finds."""

import itertools

import numpy as np
import pytest
from scipy.stats import norm

from railsearch.design_problem import DesignProblem
from railsearch.errors import CapabilityError
from railsearch.interfaces import Evaluation, Outcome, Quantity
from railsearch.plugin_manager import load_plugins
from railsearch.run import RunSettings, run_search
from railsearch.space import Space, Variable
from railsearch.testing import Trial, run_trial
from railsearch_plugins.metric_search.expected_improvement import expected_improvement
from railsearch_plugins.strategies.ego import EfficientGlobalOptimisation
from railsearch_plugins.surrogate_search.log_improvement import NegativeLogImprovement

LINE = Space((Variable("x", 0.0, 4.0),))
PLANE = Space((Variable("x", 0.0, 4.0), Variable("y", -2.0, 2.0)))
HALF = Space((*PLANE.variables, Variable("k", -3.0, 9.0, integer=True)))


class Given:
    """A surrogate with stated prediction and deviation, both smooth."""

    def predict(self, points):
        return np.sin(3.0 * points).sum(axis=1)

    def gradient(self, points):
        return 3.0 * np.cos(3.0 * points)

    def deviation(self, points):
        return 0.1 + (points**2).sum(axis=1)

    def deviation_gradient(self, points):
        return 2.0 * points


def test_logarithm_of_the_expected_improvement_where_that_is_a_number():
    points = np.random.default_rng(1).random((50, 2))
    function = NegativeLogImprovement(Given(), 0.5, 1.0)
    expected = expected_improvement(Given().predict(points), Given().deviation(points), 0.5)
    np.testing.assert_allclose(np.exp(-function.predict(points)), expected, rtol=1e-9)


@pytest.mark.parametrize("z", [-30.0, -1e3, -9.9e3, -1.1e4, -1e6])
def test_far_below_it_follows_the_asymptotic_series(z):
    class Flat(Given):
        def predict(self, points):
            return np.full(len(points), -2.0 * z)

        def deviation(self, points):
            return np.full(len(points), 2.0)

    value = NegativeLogImprovement(Flat(), 0.0, 1.0).predict(np.zeros((1, 2)))[0]
    series = norm.logpdf(z) - 2.0 * np.log(-z) + np.log1p(-3.0 / z**2 + 15.0 / z**4 - 105.0 / z**6)
    assert -value == pytest.approx(np.log(2.0) + series, abs=1e-6)


@pytest.mark.parametrize("best", [3.0, 0.5, -1.0, -40.0])
def test_its_gradient_is_that_of_central_differences(best):
    points, step = np.random.default_rng(2).uniform(0.1, 0.9, (20, 2)), 1e-5
    function = NegativeLogImprovement(Given(), best, 1.0)
    for j, unit in enumerate(np.eye(2)):
        difference = (function.predict(points + step * unit) - function.predict(points - step * unit)) / (2.0 * step)
        np.testing.assert_allclose(function.gradient(points)[:, j], difference, rtol=1e-5, atol=1e-5)


def wave(design):
    return np.array([np.sin(3.0 * design[0]) + 0.3 * (design - 1.0) @ (design - 1.0)])


def told(space, designs):
    return [Evaluation(k, x, wave(x), np.empty(0), {}, "given") for k, x in enumerate(np.atleast_2d(designs))]


class Spy:
    """Makes registered surrogates and keeps the last one."""

    def __call__(self, name, dimension, settings):
        self.made = load_plugins().surrogate(name, dimension, settings)
        return self.made


def proposal_and_improvement(space, designs, batch_size=1):
    """What is proposed after some designs, and the improvement as a function of designs (n, d)."""
    spy, first = Spy(), []

    class Told(EfficientGlobalOptimisation):
        def ask(self):
            self.tell(told(space, designs))
            first.extend(super().ask())
            return first

    run_trial(Told, Trial(space, budget=batch_size, batch_size=batch_size), {"initial_size": len(designs)}, surrogate=spy)
    best = min(wave(x)[0] for x in designs)
    return first, lambda x: expected_improvement(
        spy.made.predict(space.to_unit(x)), spy.made.deviation(space.to_unit(x)), best
    )


@pytest.mark.parametrize("designs", [[0.3, 1.1, 2.9, 3.7], [0.0, 2.2, 4.0], [0.1, 1.5, 1.6, 2.4, 3.1]])
def test_on_a_line_the_proposal_has_the_largest_improvement_of_all(designs):
    (proposal,), improvement = proposal_and_improvement(LINE, np.array(designs)[:, None])
    everywhere = improvement(np.linspace(0.0, 4.0, 4001)[:, None])
    assert improvement(proposal.design[None, :])[0] >= everywhere.max() * (1.0 - 1e-6)


def test_with_an_integer_too():
    designs = np.column_stack([np.random.default_rng(4).random((12, 2)) * 4.0 - [0.0, 2.0], np.arange(-2, 10, 1.0)])
    (proposal,), improvement = proposal_and_improvement(HALF, designs)
    axes = [np.linspace(0.0, 4.0, 61), np.linspace(-2.0, 2.0, 61), np.arange(-3.0, 10.0)]
    everywhere = improvement(np.array(list(itertools.product(*axes))))
    assert improvement(proposal.design[None, :])[0] >= everywhere.max() * (1.0 - 1e-6)


def test_a_batch_is_spread_because_what_is_proposed_is_believed():
    designs = np.random.default_rng(5).random((8, 2)) * 4.0 - [0.0, 2.0]
    proposals, _ = proposal_and_improvement(PLANE, designs, batch_size=4)
    points = PLANE.to_unit(np.array([proposal.design for proposal in proposals]))
    apart = np.linalg.norm(points[:, None] - points, axis=2)[~np.eye(4, dtype=bool)]
    assert apart.min() > 0.02


@pytest.mark.parametrize("space", [PLANE, HALF])
def test_a_wave_of_several_valleys_is_solved_after_50_evaluations(space):
    run = run_trial(EfficientGlobalOptimisation, Trial(space, budget=50), objective=wave)
    x = np.linspace(0.0, 4.0, 4001)
    lowest = (np.sin(3.0 * x) + 0.3 * (x - 1.0) ** 2).min()
    assert min(e.objectives[0] for e in run) < lowest + 1e-3


def test_kriging_is_regularised_unless_it_is_told_otherwise():
    seen = []

    def make(name, dimension, settings):
        seen.append((name, settings["length_scale_prior"]))
        return load_plugins().surrogate(name, dimension, settings)

    for settings in ({}, {"surrogate_settings": {"length_scale_prior": 2.0}}):
        run_trial(EfficientGlobalOptimisation, Trial(PLANE, budget=22), settings, surrogate=make)
    assert dict.fromkeys(seen) == dict.fromkeys([("kriging", 0.5), ("kriging", 2.0)])


class LeftFails(DesignProblem):
    """Improvement is promised where every evaluation fails."""

    def __init__(self):
        super().__init__("left fails", PLANE, [Quantity("f")])

    def simulate(self, design):
        if design[0] < 2.0:
            raise ValueError("no result on the left")
        return Outcome(np.array([np.sum((PLANE.to_unit(design) - np.array([0.4, 0.3])) ** 2)]))


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_search_finds_its_way_out_of_failures(seed):
    """Without a probability of success all of the last 25 evaluations fail, and the best is 0.03 to 0.08."""
    evaluations = run_search(load_plugins(), LeftFails(), RunSettings("ego", 45, seed)).evaluations
    assert sum(evaluation.failed for evaluation in evaluations[20:]) < 25
    assert min(evaluation.objectives[0] for evaluation in evaluations if not evaluation.failed) < 0.02


def test_a_surrogate_without_deviation_is_refused_with_the_remedy():
    class Certain:
        """Says nothing about its deviation."""

    with pytest.raises(
        CapabilityError,
        match="has no gradient and no deviation and no deviation_gradient, which expected improvement needs: choose",
    ):
        run_trial(EfficientGlobalOptimisation, Trial(LINE), surrogate=lambda name, dimension, settings: Certain())
