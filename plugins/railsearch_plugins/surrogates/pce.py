"""Surrogate `pce`: a sparse polynomial chaos expansion, on the unit cube or on random inputs in their own units."""

from railsearch.hookspecs import Register, hookimpl
from railsearch.space import FloatArray

from ..polynomial_chaos.expansion import Expansion
from ..polynomial_chaos.families import Family
from ..polynomial_chaos.parameters import PolynomialChaosParameters
from ..polynomial_chaos.search import FittedExpansion, fit_expansion
from ..polynomial_chaos.surrogate import ExpansionSurrogate


class PolynomialChaos(ExpansionSurrogate[PolynomialChaosParameters, FittedExpansion]):
    """Expansion in orthonormal polynomials: Legendre's on the unit cube of a search, others of given inputs (`for_inputs`).

    It regresses: values are not met exactly. Added points bring a search for the terms from the start.
    Source: Blatman & Sudret 2011.
    """

    Parameters = PolynomialChaosParameters
    name = "pce"
    interpolates = False

    @property
    def expansion(self) -> Expansion:
        """The expansion itself, with its moments and Sobol' indices. Raises SurrogateError before a fit."""
        return self.fitted.expansion

    def add(self, points: FloatArray, values: FloatArray) -> None:
        """Fit afresh with points (k, d) and values (k,) added. Raises SurrogateError as `fit`, and before the first fit."""
        self.fit(*self._with(points, values))

    @property
    def _predictor(self) -> Expansion:
        return self.expansion

    def _fit(self, polynomials: tuple[Family, ...], points: FloatArray, values: FloatArray) -> FittedExpansion:
        return fit_expansion(polynomials, points, values, self._parameters)


@hookimpl
def railsearch_surrogates(register: Register) -> None:
    """Register `pce`."""
    register("pce", PolynomialChaos)
