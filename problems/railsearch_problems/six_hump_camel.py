"""Problem `six-hump-camel`: a polynomial of degree six in two variables with six local minima, two of them lowest.

f = (4 − 2.1 x₁² + x₁⁴/3) x₁² + x₁ x₂ + (−4 + 4 x₂²) x₂²

| symbol | meaning | shape | unit |
|---|---|---|---|
| x₁, x₂ | variables, in [−2, 2] and [−1, 1] | (n,) | - |
| f | value; f(−x) = f(x) | (n,) | - |

Source: Dixon & Szegő 1978, Towards Global Optimisation 2, 1-15; as a case of sensitivity near extremes: Shang, Nogal,
Teixeira & Wolfert, Reliability Engineering & System Safety 243 (2024) 109818.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from railsearch.design_problem import DesignProblem
from railsearch.distributions import random_vector
from railsearch.errors import InputError
from railsearch.hookspecs import Register, hookimpl
from railsearch.interfaces import Outcome, Quantity
from railsearch.space import FloatArray, Space, Variable

VARIABLES = (Variable("x1", -2.0, 2.0), Variable("x2", -1.0, 1.0))
DISTRIBUTIONS: Mapping[str, Mapping[str, object]] = {
    variable.name: {"distribution": "uniform", "lower": variable.lower, "upper": variable.upper} for variable in VARIABLES
}
LOWEST = np.array([0.08984201368301331, -0.7126564032704135])
"""One of the two points of the least value; the other one is its mirror image."""


class SixHumpCamel(DesignProblem):
    """Six-hump camel: a polynomial of degree six in two variables, lowest (−1.0316) at ±(0.0898, −0.7127)."""

    def __init__(self) -> None:
        super().__init__(
            name="six-hump-camel",
            space=Space(VARIABLES),
            objectives=[Quantity("f", meaning="value of the function")],
            reference=np.array([1.0, 0.5]),
            distributions=random_vector(DISTRIBUTIONS),
        )
        self.optimum = LOWEST

    def simulate(self, design: FloatArray) -> Outcome:
        """The function at a design (2,)."""
        return Outcome(camel_values(design[None, :]))

    def _calc_pareto_set(self) -> FloatArray:
        return np.array([LOWEST, -LOWEST])

    def _calc_pareto_front(self) -> FloatArray:
        return camel_values(LOWEST[None, :])[None, :]


def camel_values(designs: ArrayLike) -> FloatArray:
    """F (n,) of designs (n, 2). Raises InputError for another shape."""
    values = np.asarray(designs, dtype=float)
    if values.ndim != 2 or values.shape[1] != len(VARIABLES):
        raise InputError(f"six-hump-camel: designs (n, {len(VARIABLES)}) are needed, received shape {values.shape}")
    first, second = values.T
    return np.asarray(
        (4.0 - 2.1 * first**2 + first**4 / 3.0) * first**2 + first * second + (4.0 * second**2 - 4.0) * second**2
    )


@hookimpl
def railsearch_problems(register: Register) -> None:
    """Register `six-hump-camel`."""
    register("six-hump-camel", SixHumpCamel)
