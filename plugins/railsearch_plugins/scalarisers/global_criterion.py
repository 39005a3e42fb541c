"""Scalarisers `weighted-sum`, `chebyshev` and `lp`: the weighted distance of the objectives from their ideal values."""

import math
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from railsearch.errors import InputError
from railsearch.hookspecs import Register, hookimpl
from railsearch.interfaces import Quantity, parameter
from railsearch.objective_values import minimised, natural, weights_by_name
from railsearch.scalarise import chebyshev, deviations, lp_distance, weighted_sum
from railsearch.space import FloatArray

INFINITY = "infinity"


@dataclass(frozen=True)
class CriterionParameters:
    """Weights, ideal and nadir point, by objective name, in the units and with the natural sign of the objectives."""

    weights: dict[str, float] | None = parameter(  # noqa: RUF009 - a field, not a value
        None, meaning="weights by objective, 1 where none is given"
    )
    ideal: dict[str, float] | None = parameter(  # noqa: RUF009 - a field, not a value
        None, meaning="ideal values by objective: the best of each alone"
    )
    nadir: dict[str, float] | None = parameter(  # noqa: RUF009 - a field, not a value
        None, meaning="nadir values by objective: the worst of good compromises; default: the worst values of the problem"
    )
    normalise: bool = parameter(True, meaning="divide each difference from the ideal value by nadir minus ideal")


@dataclass(frozen=True)
class LpParameters(CriterionParameters):
    """The order of the distance besides."""

    p: float | str = parameter(
        2.0,
        meaning="order of the distance: 1 sums the differences, 2 is Euclid's, 'infinity' takes the largest",
        source="Yu 1973",
        minimum=1.0,
        choices=(INFINITY,),
    )


class GlobalCriterion:
    """What the three have in common: weights, the ideal and the nadir point."""

    Parameters: ClassVar[type] = CriterionParameters
    name: ClassVar[str]
    from_ideal: ClassVar[bool] = True
    ready = True

    def __init__(self, parameters: CriterionParameters, objectives: Sequence[Quantity], worst: Mapping[str, float]) -> None:
        names = [objective.name for objective in objectives]
        self._parameters = parameters
        self._objectives = tuple(objectives)
        self._weights = weights_by_name(parameters.weights, names, f"{self.name}.weights")
        self._ideal = minimised(parameters.ideal or {}, objectives, f"{self.name}.ideal")
        self._nadir = {**worst, **minimised(parameters.nadir or {}, objectives, f"{self.name}.nadir")}
        if self.from_ideal or parameters.normalise:
            self._require("ideal", self._ideal, "best")
        if parameters.normalise:
            self._require("nadir", self._nadir, "worst")
            self._check_order()

    @property
    def values(self) -> Mapping[str, object]:
        """Weights, ideal and nadir values in use."""
        used: dict[str, object] = {"weights": self._weights, "normalise": self._parameters.normalise}
        if self.from_ideal or self._parameters.normalise:
            used["ideal"] = self._natural(self._ideal)
        if self._parameters.normalise:
            used["nadir"] = self._natural(self._nadir)
        return used

    def prepare(self, reference: FloatArray) -> None:
        """Nothing depends on the reference design."""

    def __call__(self, objectives: FloatArray) -> FloatArray:
        """The scalars g (n,) of objectives f (n, m)."""
        return self._scalars(self._deviations(objectives), self._row(self._weights))

    @abstractmethod
    def _scalars(self, values: FloatArray, weights: FloatArray) -> FloatArray:
        """The scalars (n,) of deviations (n, m) and weights (m,)."""

    def _deviations(self, objectives: FloatArray) -> FloatArray:
        if self._parameters.normalise:
            return deviations(objectives, self._row(self._ideal), self._row(self._nadir))
        return objectives - self._row(self._ideal) if self.from_ideal else objectives

    def _row(self, values: Mapping[str, float]) -> FloatArray:
        return np.array([values[objective.name] for objective in self._objectives])

    def _natural(self, values: Mapping[str, float]) -> dict[str, float]:
        return natural({objective.name: values[objective.name] for objective in self._objectives}, self._objectives)

    def _require(self, field: str, values: Mapping[str, float], column: str) -> None:
        missing = [objective.name for objective in self._objectives if objective.name not in values]
        if missing:
            raise InputError(
                f"{self.name}.{field}: the value of {', '.join(missing)} is not known: take the {column} one that "
                f"`railsearch sample PROBLEM` prints, or of a search of that objective alone, and set it under {field}"
            )

    def _check_order(self) -> None:
        ideal, nadir = self._natural(self._ideal), self._natural(self._nadir)
        for objective in self._objectives:
            if not self._ideal[objective.name] < self._nadir[objective.name]:
                side = "above" if objective.maximised else "below"
                raise InputError(
                    f"{self.name}.ideal.{objective.name}: the ideal value must lie {side} the nadir value, received "
                    f"{ideal[objective.name]:g} and {nadir[objective.name]:g} {objective.unit}".rstrip()
                    + f"; set ideal or nadir of {objective.name}"
                )


class WeightedSum(GlobalCriterion):
    """Weighted sum of the objectives, each by default divided by nadir minus ideal."""

    name = "weighted-sum"
    from_ideal = False

    def _scalars(self, values: FloatArray, weights: FloatArray) -> FloatArray:
        return weighted_sum(values, weights)


class Chebyshev(GlobalCriterion):
    """Largest weighted distance of an objective from its ideal value, by default divided by nadir minus ideal."""

    name = "chebyshev"

    def _scalars(self, values: FloatArray, weights: FloatArray) -> FloatArray:
        return chebyshev(values, weights)


class LpDistance(GlobalCriterion):
    """Global criterion: L_p distance of the objectives from the ideal point, by default divided by nadir minus ideal."""

    Parameters = LpParameters
    name = "lp"

    def __init__(self, parameters: LpParameters, objectives: Sequence[Quantity], worst: Mapping[str, float]) -> None:
        super().__init__(parameters, objectives, worst)
        self._p = parameters.p

    @property
    def values(self) -> Mapping[str, object]:
        """Weights, ideal and nadir values, and the order in use."""
        return {**super().values, "p": self._p}

    def _scalars(self, values: FloatArray, weights: FloatArray) -> FloatArray:
        return lp_distance(values, weights, math.inf if self._p == INFINITY else float(self._p))


@hookimpl
def railsearch_scalarisers(register: Register) -> None:
    """Register `weighted-sum`, `chebyshev` and `lp`."""
    for scalariser in (WeightedSum, Chebyshev, LpDistance):
        register(scalariser.name, scalariser)
