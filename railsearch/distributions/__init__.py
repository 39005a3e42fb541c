"""Random inputs: distributions by name and parameters, and vectors of independent ones."""

from railsearch.distributions.families import FAMILIES, INDEPENDENT, marginal_from_scipy, marginal_from_table
from railsearch.distributions.marginal import Marginal
from railsearch.distributions.random_vector import (
    NEGLIGIBLE,
    RandomVector,
    TruncationWarning,
    keep_inside,
    random_vector,
)

__all__ = [
    "FAMILIES",
    "INDEPENDENT",
    "NEGLIGIBLE",
    "Marginal",
    "RandomVector",
    "TruncationWarning",
    "keep_inside",
    "marginal_from_scipy",
    "marginal_from_table",
    "random_vector",
]
