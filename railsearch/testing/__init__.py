"""Conformance suite: what every registered strategy, surrogate, scalariser and track model has to fulfil.

Each check takes the registered class, runs it on small problems and raises an AssertionError that says in plain words
what is wrong. In the tests of a plugin package:

    from railsearch.testing import check_strategy

    def test_my_strategy():
        check_strategy(MyStrategy)
"""

from railsearch.testing.scalarisers import check_scalariser
from railsearch.testing.strategies import check_strategy
from railsearch.testing.surrogates import check_surrogate
from railsearch.testing.track_models import check_track_model
from railsearch.testing.trials import MIXED, REAL, Trial, run_trial

__all__ = [
    "MIXED",
    "REAL",
    "Trial",
    "check_scalariser",
    "check_strategy",
    "check_surrogate",
    "check_track_model",
    "run_trial",
]
