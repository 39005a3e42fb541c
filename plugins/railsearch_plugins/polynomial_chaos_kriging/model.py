"""PC-Kriging: an expansion is searched, and its terms become the trend of a Gaussian process.

| symbol | meaning | shape | source |
|---|---|---|---|
| x | inputs | (n, d) | |
| z | coordinates of their polynomials over the range of the data | (n, d) | |
| f_j | terms of the expansion, in the order in which they were selected, the constant first | p of them | |
| ŷ | Σ_j β_j f_j(x) + σ Z(z), Z a stationary process of variance 1 | (n,) | Schöbi et al. 2015, Eq. 10 |

The polynomials are functions of z, so that trend and process see the same points.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from railsearch.space import FloatArray

from ..gaussian_process.estimation import Hyperparameters
from ..gaussian_process.placement import PlacedProcess
from ..gaussian_process.process import GaussianProcess
from ..polynomial_chaos.coordinates import Coordinates, coordinates_over
from ..polynomial_chaos.families import Family
from ..polynomial_chaos.multi_indices import IndexArray
from ..polynomial_chaos.search import FittedExpansion, fit_expansion
from .optimal import best_trend
from .parameters import PolynomialChaosKrigingParameters
from .trend import ExpansionTrend


@dataclass(frozen=True)
class FittedPolynomialChaosKriging:
    """The expansion that was found, the terms (p, d) that are the trend, and the process on them."""

    expansion: FittedExpansion
    indices: IndexArray
    model: PlacedProcess

    @property
    def errors(self) -> Mapping[str, float]:
        """Mean squared errors as fractions of the variance of the values.

        `training` at the points; `leave-one-out`, which is too small where many terms were chosen by the same points; and
        for this reason `corrected-expansion`, the corrected leave-one-out error of the expansion that was found.
        """
        return {**self.model.process.errors, "corrected-expansion": self.expansion.corrected_error}


def fit_polynomial_chaos_kriging(
    families: tuple[Family, ...],
    points: FloatArray,
    values: FloatArray,
    settings: PolynomialChaosKrigingParameters,
    generator: np.random.Generator,
) -> FittedPolynomialChaosKriging:
    """Search the terms for points x (n, d) with values (n,), choose those of the trend, and fit the process.

    Raises SurrogateError for fewer than three points. Source: Schöbi, Sudret & Wiart 2015.
    """
    expansion = fit_expansion(families, points, values, settings)
    indices, coordinates, start = expansion.expansion.indices, coordinates_over(families, points), None
    if settings.variant == "optimal":
        placed = coordinates.placed(points)
        count, start = best_trend(ExpansionTrend(coordinates.polynomials, indices), placed, values, settings, generator)
        indices = indices[:count]
    model = process_on_terms(coordinates, indices, points, values, settings, generator, start)
    return FittedPolynomialChaosKriging(expansion, indices, model)


def process_on_terms(
    coordinates: Coordinates,
    indices: IndexArray,
    points: FloatArray,
    values: FloatArray,
    settings: PolynomialChaosKrigingParameters,
    generator: np.random.Generator,
    start: Hyperparameters | None = None,
) -> PlacedProcess:
    """The process with the terms of multi-indices (p, d) as its trend; its scales are searched from `start` if given.

    Raises SurrogateError for fewer points than terms and one more.
    """
    trend = ExpansionTrend(coordinates.polynomials, indices)
    model = PlacedProcess(GaussianProcess(trend, settings), coordinates)
    model.fit(points, values, generator, start)
    return model
