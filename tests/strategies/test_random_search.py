"""Random search draws uniformly and learns nothing."""

import numpy as np

from railsearch.testing import MIXED, Trial, run_trial
from railsearch_plugins.strategies.random import RandomSearch


def test_designs_are_uniform_and_labelled_random():
    evaluations = run_trial(RandomSearch, Trial(MIXED, budget=4000, batch_size=50))
    designs = np.array([evaluation.design for evaluation in evaluations])
    assert {evaluation.origin for evaluation in evaluations} == {"random"}
    tenths = np.histogram(designs[:, 0], bins=10, range=(-5.0, 5.0))[0]
    values = np.bincount((designs[:, 1] + 3).astype(int), minlength=16)
    for counts, limit in ((tenths, 27.9), (values, 37.7)):  # chi-squared with 9 and 15 degrees of freedom at 0.1 %
        expected = 4000 / len(counts)
        assert np.sum((counts - expected) ** 2 / expected) < limit


def test_what_it_is_told_does_not_matter():
    calm, stormy = (
        run_trial(RandomSearch, Trial(MIXED, fails=fails)) for fails in (lambda number: False, lambda number: True)
    )
    assert [e.design.tobytes() for e in calm] == [e.design.tobytes() for e in stormy]
