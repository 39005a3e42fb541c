"""The published cases: extreme surfaces of the six-hump camel, importances of the truss, from the true models and from PCE.

References: independent computations for Shang, Nogal, Teixeira & Wolfert 2024, Reliability Engineering & System Safety 243.
"""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from railsearch.sampling import latin_hypercube
from railsearch.sensitivity import FRUGAL, ExactModel, ProblemFunction, extreme_surfaces, factors_on, input_space
from railsearch_plugins.polynomial_chaos.parameters import PolynomialChaosParameters
from railsearch_plugins.surrogates.pce import PolynomialChaos
from railsearch_problems.six_hump_camel import SixHumpCamel, camel_values
from railsearch_problems.truss import Truss, deflections

REFERENCES = Path(__file__).parents[1] / "reference"
CAMEL = json.loads((REFERENCES / "camel.json").read_text(encoding="utf-8"))
TRUSS = json.loads((REFERENCES / "truss.json").read_text(encoding="utf-8"))
PUBLISHED = {"E1": 0.3952, "A1": 0.3703, "P3": 0.0652, "P4": 0.0652, "P2": 0.0314, "P5": 0.0314}
PUBLISHED |= {"A2": 0.0180, "E2": 0.0154, "P1": 0.0040, "P6": 0.0040}


def camel_factors():
    return factors_on(input_space(SixHumpCamel().distributions), 50)


def camel_maxima(grid, held):
    """The largest value with one variable held: the best local maximum from a fine grid, and both ends."""
    other = np.linspace(*((-1.0, 1.0) if held == 0 else (-2.0, 2.0)), 4001)
    found = []
    for x in grid:
        at = lambda y, x=x: -camel_values([[x, y] if held == 0 else [y, x]])[0]  # noqa: E731 - handed to scipy
        best = other[np.argmin([at(y) for y in other[::20]]) * 20]
        inside = minimize_scalar(at, bounds=(max(other[0], best - 0.1), min(other[-1], best + 0.1)), method="bounded")
        found.append(-min(inside.fun, at(other[0]), at(other[-1])))
    return np.array(found)


def camel_surrogate():
    inputs = SixHumpCamel().distributions
    points = latin_hypercube(inputs, 100, np.random.default_rng(8))
    surrogate = PolynomialChaos.for_inputs(inputs, PolynomialChaosParameters())
    surrogate.fit(points, camel_values(points))
    return surrogate


def truss_factors():
    truss, reference = Truss(), TRUSS["importance_max_weighted"]
    ranges = dict(zip(TRUSS["order"], zip(reference["lo"], reference["hi"], strict=True), strict=True))
    units = {variable.name: variable.unit for variable in truss.space.variables}
    return factors_on(input_space(truss.distributions, ranges=ranges, units=units), 50)


@pytest.mark.parametrize("model", ["exact", "pce"])
def test_extreme_surfaces_of_the_camel(model):
    """Reference minima; maxima by one-dimensional searches, those of x2 with both branches: x1 = 2 and x1 = −2."""
    factors = camel_factors()
    np.testing.assert_allclose(factors.grids[0], CAMEL["x1"], atol=1e-15)
    asked = ExactModel(camel_values, factors.space) if model == "exact" else camel_surrogate()
    surfaces = extreme_surfaces(asked, factors, np.random.default_rng(0))
    np.testing.assert_allclose(surfaces.surface("x1", "minimum").values, CAMEL["min_fix_x1"], atol=1e-8)
    np.testing.assert_allclose(surfaces.surface("x2", "minimum").values, CAMEL["min_fix_x2"], atol=1e-8)
    for held, name in enumerate(factors.names):
        np.testing.assert_allclose(surfaces.surface(name).values, camel_maxima(factors.grids[held], held), atol=1e-7)
    branches = surfaces.surface("x2").points[:, 0]
    np.testing.assert_array_equal(branches, np.sign(factors.grids[1]) * 2.0)
    weighted, plain = CAMEL["importance_min_weighted"], CAMEL["importance_min_plain"]
    assert surfaces.importances("minimum")["x1"] == pytest.approx(weighted["X1"], abs=1e-7)
    assert surfaces.importances("minimum", weighted=False)["x1"] == pytest.approx(plain["X1"], abs=1e-7)
    assert list(surfaces.variances("minimum").values()) == pytest.approx(weighted["var"], rel=1e-7)
    assert surfaces.effort.check.held


def test_published_importances_of_the_truss_by_finite_elements():
    """Four digits of the publication, eight of the reference; fewer evaluations than the 82 242 that were published."""
    factors = truss_factors()
    assert factors.spacings == tuple("equal" if name[0] == "A" else "logarithmic" for name in factors.names)
    model = ExactModel(deflections, factors.space)
    surfaces = extreme_surfaces(model, factors, np.random.default_rng(0), FRUGAL)
    importances = surfaces.importances()
    assert {name: round(value, 4) for name, value in importances.items()} == PUBLISHED
    assert importances == pytest.approx(TRUSS["importance_max_weighted"]["I"], abs=1e-8)
    assert surfaces.variances() == pytest.approx(TRUSS["importance_max_weighted"]["var"], rel=1e-8)
    assert surfaces.effort.asked == model.evaluations < 82_242, "for the maximum and the minimum together"


def test_published_importances_of_the_truss_by_pce():
    inputs, factors = Truss().distributions, truss_factors()
    points = latin_hypercube(inputs, 200, np.random.default_rng(3))
    surrogate = PolynomialChaos.for_inputs(inputs, PolynomialChaosParameters(degree=6))
    surrogate.fit(points, deflections(points))
    surfaces = extreme_surfaces(surrogate, factors, np.random.default_rng(0))
    assert surfaces.importances() == pytest.approx(PUBLISHED, abs=5e-3)
    worst = surfaces.surface("E1").points
    assert set(worst[:, 9]) == {64677.0}, "loads at their upper bounds"


def test_a_problem_of_the_registry_is_the_same_as_its_function():
    camel = SixHumpCamel()
    function = ProblemFunction(camel, "f")
    points = camel.space.from_unit(np.random.default_rng(1).random((20, 2)))
    assert np.array_equal(function(points), camel_values(points))
