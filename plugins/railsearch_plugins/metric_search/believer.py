"""Kriging believer: designs of a batch are chosen as if those before had the values that are predicted for them."""

import copy

from railsearch.errors import SurrogateError
from railsearch.interfaces import UncertainSurrogate
from railsearch.space import FloatArray


def believing(surrogate: UncertainSurrogate, points: FloatArray, values: FloatArray) -> UncertainSurrogate:
    """A copy of the surrogate that believes its predictions (k,) at points (k, d); itself if they cannot be added.

    Source: Ginsbourger, Le Riche and Carraro 2010.
    """
    believer = copy.deepcopy(surrogate)
    try:
        believer.add(points, values)
    except SurrogateError:
        return surrogate
    return believer
