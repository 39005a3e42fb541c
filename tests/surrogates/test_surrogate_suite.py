"""The conformance suite finds what it is there to find in surrogates with a deviation."""

import itertools

import numpy as np
import pytest

from railsearch.testing import check_surrogate
from railsearch.testing.surrogates import check_made_surrogate
from railsearch_plugins.surrogates.kriging import Kriging, KrigingParameters

PARAMETERS = KrigingParameters(length_scales=(0.5,))


class Negative(Kriging):
    def deviation(self, points):
        return -super().deviation(points)


class Certain(Kriging):
    def deviation(self, points):
        return np.zeros(len(points))

    def deviation_gradient(self, points):
        return np.zeros_like(points)


class Everywhere(Kriging):
    def deviation(self, points):
        return super().deviation(points) + 1.0


class WrongSlope(Kriging):
    def deviation_gradient(self, points):
        return super().deviation_gradient(points) + 0.1


class Column(Kriging):
    def deviation(self, points):
        return super().deviation(points)[:, None]


class Undecided(Kriging):
    count = itertools.count()

    def predict(self, points):
        return super().predict(points) + self.offset

    def __init__(self, dimension, parameters):
        super().__init__(dimension, parameters)
        self.offset = 1e-8 * next(Undecided.count)


class Boastful(Kriging):
    lacks = ("deviation", "deviation_gradient")


@pytest.mark.parametrize(
    ("plugin", "explanation"),
    [
        (Negative, "finite and not negative"),
        (Certain, "no larger than at them"),
        (Everywhere, "at the points themselves"),
        (WrongSlope, "deviation_gradient differs from central differences"),
        (Column, r"deviation must give \(k,\)"),
        (Undecided, "two fits to the same points differ"),
        (Boastful, "among what the surrogate lacks"),
    ],
)
def test_a_surrogate_at_fault_is_found(plugin, explanation):
    with pytest.raises(AssertionError, match=explanation):
        check_made_surrogate(lambda dimension: plugin(dimension, PARAMETERS))


def test_additions_are_held_to_the_tolerance_that_is_stated(monkeypatch):
    check_surrogate(Kriging, {"starts": 1})
    monkeypatch.setattr(Kriging, "add_tolerance", 1e-12)
    with pytest.raises(AssertionError, match="added one after another"):
        check_surrogate(Kriging, {"starts": 1})
