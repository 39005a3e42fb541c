"""The truss of 23 bars and the six-hump camel, with the factors, ranges and results of the publication.

Shang, Nogal, Teixeira & Wolfert, Reliability Engineering & System Safety 243 (2024) 109818.
"""

from dataclasses import dataclass

from railsearch.sensitivity import MAXIMUM, SENSES, factors_on, input_space
from railsearch_problems.six_hump_camel import SixHumpCamel, camel_values
from railsearch_problems.truss import Truss, deflections

SURROGATES = ("pce", "pck", "kriging")
POINTS = 50
MODULUS = (1.535e11, 2.844e11)
"""The publication prints 1.54e11 Pa; with this bound its importances come out to all four digits."""

PUBLISHED = {"E1": 0.3952, "E2": 0.0154, "A1": 0.3703, "A2": 0.0180}
PUBLISHED |= {"P1": 0.0040, "P2": 0.0314, "P3": 0.0652, "P4": 0.0652, "P5": 0.0314, "P6": 0.0040}
"""Importances of the truss's largest deflection from direct calls of the finite element model."""


@dataclass(frozen=True)
class Case:
    """A problem whose true values cost little, the extremes that are looked for, and the sizes of designs."""

    problem: object
    function: object
    senses: tuple[str, ...]
    sizes: tuple[int, ...]
    ranges: dict[str, tuple[float, float]]

    @property
    def inputs(self):
        """The random inputs."""
        return self.problem.distributions

    @property
    def output(self):
        """Name and unit of what is computed."""
        return self.problem.objectives[0]

    def factors(self, points=POINTS, spacings=None):
        """All inputs on grids within their bounds."""
        units = {variable.name: variable.unit for variable in self.problem.space.variables}
        return factors_on(input_space(self.inputs, ranges=self.ranges, units=units), points, spacings)


def published_cases():
    """Both cases by name."""
    truss, camel = Truss(), SixHumpCamel()
    bounds = {variable.name: (variable.lower, variable.upper) for variable in truss.space.variables}
    bounds |= {"E1": MODULUS, "E2": MODULUS}
    return {
        "truss": Case(truss, deflections, (MAXIMUM,), (100, 400, 700, 1000), bounds),
        "camel": Case(camel, camel_values, SENSES, (100,), {}),
    }
