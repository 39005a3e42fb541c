"""The Sobol' search is scipy's scrambled sequence, balanced over the values of integers, without designs seen before."""

import numpy as np
from scipy.stats.qmc import Sobol

from railsearch.seeding import run_generators
from railsearch.space import Space, Variable
from railsearch.testing import MIXED, REAL, Trial, run_trial
from railsearch_plugins.strategies.sobol import SobolSearch


def designs(evaluations):
    return np.array([evaluation.design for evaluation in evaluations])


def test_the_points_are_scipys():
    sequence = Sobol(3, rng=run_generators(3).strategy)
    expected = REAL.from_unit(np.vstack([sequence.random(1) for _ in range(50)]))
    evaluations = run_trial(SobolSearch, Trial(REAL, budget=50, seed=3))
    np.testing.assert_array_equal(designs(evaluations), expected)
    assert {evaluation.origin for evaluation in evaluations} == {"sobol"}


def test_every_value_of_an_integer_comes_once_before_one_comes_twice():
    for seed in range(5):
        evaluations = designs(run_trial(SobolSearch, Trial(MIXED, budget=64, seed=seed)))
        for block in evaluations.reshape(4, 16, 3):
            assert sorted(block[:, 1]) == list(range(-3, 13))
            assert np.bincount(block[:, 2].astype(int)).tolist() == [8, 8]
            assert sorted(np.floor((block[:, 0] + 5.0) / 10.0 * 16)) == list(range(16))


def test_batches_make_no_difference():
    runs = [designs(run_trial(SobolSearch, Trial(MIXED, budget=40, batch_size=size))) for size in (1, 7, 40)]
    assert all(np.array_equal(runs[0], run) for run in runs[1:])


def test_designs_seen_before_are_skipped():
    sequence = designs(run_trial(SobolSearch, Trial(REAL, budget=12)))

    class Knowing(SobolSearch):
        def __init__(self, context, parameters):
            super().__init__(context, parameters)
            self._seen = {context.space.key(sequence[2]), context.space.key(sequence[5])}

    np.testing.assert_array_equal(designs(run_trial(Knowing, Trial(REAL, budget=10))), np.delete(sequence, [2, 5], axis=0))


def test_a_small_space_is_walked_through_without_a_repetition():
    asked = []

    class Listening(SobolSearch):
        def ask(self):
            asked.append(super().ask())
            return asked[-1]

    space = Space((Variable("a", 0, 4, integer=True), Variable("b", 0, 4, integer=True)))
    assert len({design.tobytes() for design in designs(run_trial(Listening, Trial(space, budget=60)))}) == 25
    assert len(asked) == 25
