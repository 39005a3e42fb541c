"""Analytic problems of one objective f(z), whose least value is 0; z, p and d as in function.py.

| problem | l … u | p | what it is like |
|---|---|---|---|
| sphere | −5 … 5 | 0 | a quadratic bowl |
| zakharov | −5 … 10 | 0 | a bent plate with one steep direction |
| rosenbrock | −5 … 10 | 1 | a curved narrow valley |
| ackley | −32 … 32 | 0 | a funnel with waves on it |
| griewank | −600 … 600 | 0 | a wide bowl with many shallow dents |
| levy | −10 … 10 | 1 | valleys and ridges |
| rastrigin | −5 … 5 | 0 | a bowl with a lattice of local minima |
| schwefel | −500 … 500 | 420.97 | deep minima far from one another, the best near a corner |
| rounding-trap | −5 … 5 | 0 and 1 | integers whose real optimum rounds to a bad design |
| constrained-sphere | −5 … 5 | 1 | a bowl cut by a plane, which the optimum lies on |
"""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from railsearch.errors import InputError
from railsearch.space import FloatArray
from railsearch_problems.analytic.function import HALF, SECTION, AnalyticProblem, FunctionParameters


class Sphere(AnalyticProblem):
    """Sphere: the simplest quadratic bowl, f = Σ z_i² on [−5, 5]^d."""

    function_name = "sphere"
    lower, upper = -5.0, 5.0

    def values(self, z: FloatArray) -> FloatArray:
        """F (1,) at z (d,)."""
        return np.array([np.sum(z**2)])


class Zakharov(AnalyticProblem):
    """Zakharov: a bent plate, f = Σ z_i² + a² + a⁴ with a = Σ i z_i/2, on [−5, 10]^d.

    Source: Rahnamayan, Tizhoosh & Salama 2007, Computers and Mathematics with Applications 53, 1605-1614.
    """

    function_name = "zakharov"
    lower, upper = -5.0, 10.0

    def values(self, z: FloatArray) -> FloatArray:
        """F (1,) at z (d,)."""
        along = 0.5 * np.sum(np.arange(1, len(z) + 1) * z)
        return np.array([np.sum(z**2) + along**2 + along**4])


class Rosenbrock(AnalyticProblem):
    """Rosenbrock: a curved narrow valley, f = Σ (100 (z_{i+1} − z_i²)² + (1 − z_i)²) on [−5, 10]^d.

    Source: Rosenbrock 1960, The Computer Journal 3, 175-184; in d dimensions Hansen et al. 2009, INRIA report 6829, f8.
    """

    function_name = "rosenbrock"
    lower, upper, place = -5.0, 10.0, 1.0

    def values(self, z: FloatArray) -> FloatArray:
        """F (1,) at z (d,)."""
        return np.array([np.sum(100.0 * (z[1:] - z[:-1] ** 2) ** 2 + (1.0 - z[:-1]) ** 2)])


class Ackley(AnalyticProblem):
    """Ackley: a funnel with waves on it, f = 20 (1 − exp(−0.2 √(Σ z_i²/d))) + e − exp(Σ cos(2π z_i)/d) on [−32, 32]^d.

    Source: Ackley 1987, A Connectionist Machine for Genetic Hillclimbing; in d dimensions Bäck 1996, Evolutionary
    Algorithms in Theory and Practice.
    """

    function_name = "ackley"
    lower, upper = -32.0, 32.0

    def values(self, z: FloatArray) -> FloatArray:
        """F (1,) at z (d,); expm1 keeps it exact near the optimum."""
        funnel = -20.0 * np.expm1(-0.2 * np.sqrt(np.mean(z**2)))
        waves = -np.e * np.expm1(np.mean(np.cos(2.0 * np.pi * z)) - 1.0)
        return np.array([funnel + waves])


class Griewank(AnalyticProblem):
    """Griewank: a wide bowl with many shallow dents, f = 1 + Σ z_i²/4000 − Π cos(z_i/√i) on [−600, 600]^d.

    Source: Griewank 1981, Journal of Optimization Theory and Applications 34, 11-39; in d dimensions Törn & Žilinskas
    1989, Global Optimization.
    """

    function_name = "griewank"
    lower, upper = -600.0, 600.0

    def values(self, z: FloatArray) -> FloatArray:
        """F (1,) at z (d,)."""
        waves = np.prod(np.cos(z / np.sqrt(np.arange(1, len(z) + 1))))
        return np.array([np.sum(z**2) / 4000.0 + (1.0 - waves)])


class Levy(AnalyticProblem):
    """Levy: valleys and ridges, f = sin²(π w_1) + Σ_{i<d} v_i² (1 + 10 sin²(π w_i + 1)) + v_d² (1 + sin²(2π w_d)).

    v_i = (z_i − 1)/4 and w_i = 1 + v_i, on [−10, 10]^d.
    Source: Levy & Montalvo 1985, SIAM Journal on Scientific and Statistical Computing 6, 15-29; this form Laguna & Martí
    2005, Journal of Global Optimization 33, 235-255.
    """

    function_name = "levy"
    lower, upper, place = -10.0, 10.0, 1.0

    def values(self, z: FloatArray) -> FloatArray:
        """F (1,) at z (d,); sin²(π w) is taken as sin²(π v), which is exact near the optimum."""
        v = (z - 1.0) / 4.0
        ridges = v[:-1] ** 2 * (1.0 + 10.0 * np.sin(np.pi * (1.0 + v[:-1]) + 1.0) ** 2)
        last = v[-1] ** 2 * (1.0 + np.sin(2.0 * np.pi * v[-1]) ** 2)
        return np.array([np.sin(np.pi * v[0]) ** 2 + np.sum(ridges) + last])


class Rastrigin(AnalyticProblem):
    """Rastrigin: a bowl with a lattice of local minima, f = Σ (z_i² + 10 − 10 cos(2π z_i)) on [−5, 5]^d.

    Source: Mühlenbein, Schomisch & Born 1991, Parallel Computing 17, 619-632, function 6.
    """

    function_name = "rastrigin"
    lower, upper = -5.0, 5.0

    def values(self, z: FloatArray) -> FloatArray:
        """F (1,) at z (d,)."""
        return np.array([np.sum(z**2 + 10.0 - 10.0 * np.cos(2.0 * np.pi * z))])


class Schwefel(AnalyticProblem):
    """Schwefel: deep minima far from one another, f = Σ (p sin √p − y_i sin √|y_i| + (z_i − y_i)²) on [−500, 500]^d.

    y is z held within [−500, 500], for beyond it the textbook function, which has no last term, falls without end; p is the
    place of its least value inside, the root of tan √p = −√p/2.
    Source: Schwefel 1981, Numerical Optimization of Computer Models; held within bounds as Hansen et al. 2009, INRIA
    report 6829, f20, do.
    """

    function_name = "schwefel"
    lower, upper, place = -500.0, 500.0, 420.9687463599821

    def values(self, z: FloatArray) -> FloatArray:
        """F (1,) at z (d,)."""
        y = np.clip(z, self.lower, self.upper)
        best = self.place * np.sin(np.sqrt(self.place))
        return np.array([np.sum(best - y * np.sin(np.sqrt(np.abs(y))) + (z - y) ** 2)])


class RoundingTrap(AnalyticProblem):
    """Rounding trap: f = Σ z_i² over real variables + Σ q(a, b) over pairs (a, b) of integer ones, on [−5, 5]^d.

    q = 10 (a + b − 1.2)² + (a − b + 0.1)² − 1.21. Over real numbers q is least at (0.55, 0.65), which rounds to (1, 1) with
    q = 5.2. Over whole numbers q is least at (0, 1), where it is 0: a + b = 1 leaves 0.4 + (a − b + 0.1)² with a − b odd,
    which is 1.21 or more, and any other sum 6.4 or more. An integer variable without a partner counts as a real one.
    """

    function_name = "rounding-trap"
    lower, upper = -5.0, 5.0
    defaults: ClassVar[FunctionParameters] = FunctionParameters(integers=HALF)

    def __init__(self, parameters: FunctionParameters | None = None) -> None:
        super().__init__(parameters)
        if self.parameters.whole < 2:
            raise InputError(
                f"{SECTION}.integers: {self.name} needs 2 integer variables or more, received {self.parameters.whole}"
            )

    def values(self, z: FloatArray) -> FloatArray:
        """F (1,) at z (d,); a hundred times q is taken, in whole numbers, which are exact."""
        pairs = self._paired
        a, b = z[pairs][0::2], z[pairs][1::2]
        trap = 40.0 * (5.0 * (a + b) - 6.0) ** 2 + (10.0 * (a - b) + 1.0) ** 2 - 121.0
        return np.array([np.sum(z[: pairs.start] ** 2) + np.sum(trap) / 100.0])

    @property
    def _paired(self) -> slice:
        whole = int(np.sum(self.space.integer))
        return slice(self.space.dimension - whole + whole % 2, self.space.dimension)

    def _textbook_optimum(self) -> FloatArray:
        best = np.zeros(self.space.dimension)
        best[self._paired][1::2] = 1.0
        return best


class ConstrainedSphere(AnalyticProblem):
    """Constrained sphere: f = Σ (z_i² − 1), feasible where the mean of z is 1 or more, on [−5, 5]^d.

    The optimum lies on the constraint, at z_i = 1: Σ z_i² ≥ (Σ z_i)²/d ≥ d for feasible z.
    """

    function_name = "constrained-sphere"
    lower, upper, place = -5.0, 5.0, 1.0
    constrained = 1

    def values(self, z: FloatArray) -> FloatArray:
        """F (1,) at z (d,)."""
        return np.array([np.sum(z**2 - 1.0)])

    def limits(self, z: FloatArray) -> FloatArray:
        """1 less the mean of z, (1,)."""
        return np.array([np.mean(1.0 - z)])


PROBLEMS = (
    Sphere,
    Zakharov,
    Rosenbrock,
    Ackley,
    Griewank,
    Levy,
    Rastrigin,
    Schwefel,
    RoundingTrap,
    ConstrainedSphere,
)
