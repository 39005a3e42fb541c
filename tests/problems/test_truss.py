"""The truss of 23 bars: finite elements, closed form, published numbers."""

import json
from pathlib import Path

import numpy as np
import pytest

import railsearch
from railsearch.errors import InputError
from railsearch_problems.truss import Truss, closed_form, deflections

REFERENCE = json.loads((Path(__file__).parents[1] / "reference" / "truss.json").read_text(encoding="utf-8"))


def test_finite_elements_and_closed_form_agree():
    """More trusses than are solved at a time; rounding of a matrix of 23 rows."""
    designs = Truss().distributions.from_uniform(np.random.default_rng(0).random((1100, 10)))
    np.testing.assert_allclose(deflections(designs), closed_form(designs), rtol=1e-12)
    assert deflections(designs[:0]).shape == (0,)


def test_deflections_of_an_independent_model():
    """Of a two-dimensional bar model in another program."""
    assert tuple(REFERENCE["order"]) == Truss().space.names
    np.testing.assert_allclose(deflections(REFERENCE["X"]), REFERENCE["deflection_m"], rtol=1e-12)


def test_deflection_at_the_means():
    problem = railsearch.problem("truss")
    outcome = problem.simulate(problem.reference)
    assert outcome.objectives == pytest.approx([REFERENCE["deflection_at_means_m"]], rel=1e-12)
    assert problem.evaluate(problem.reference[None, :])[0] == pytest.approx(outcome.objectives, rel=1e-15)


def test_published_moments():
    """7.940 cm and 1.108 cm with loads of Gumbel's distribution for maxima; the sample's error is 0.002 cm."""
    inputs = Truss().distributions
    values = closed_form(inputs.from_uniform(np.random.default_rng(1).random((400_000, 10))))
    assert values.mean() == pytest.approx(7.940e-2, abs=1e-4)
    assert values.std() == pytest.approx(1.108e-2, abs=1e-4)
    np.testing.assert_allclose(inputs.mean, Truss().reference, rtol=1e-12)


def test_loads_have_gumbels_distribution_for_maxima():
    """Its mode, at which F = 1/e, lies γ s below the mean."""
    modes = Truss().distributions.percentiles([np.exp(-1.0)])[0, 4:]
    np.testing.assert_allclose(modes, 5.0e4 - np.euler_gamma * 7.5e3 * np.sqrt(6.0) / np.pi, rtol=1e-12)


def test_published_ranges_are_the_percentiles_that_the_publication_means():
    """0.1 and 99.9 % of moduli and cross-sections, as printed; loads 1 and 99.9 % of Gumbel's distribution for minima."""
    problem = Truss()
    assert problem.distributions is not None
    low, high = problem.distributions.percentiles([0.001, 0.999])
    np.testing.assert_allclose(problem.space.lower[:2], low[:2], rtol=5e-3)
    np.testing.assert_allclose(problem.space.upper[:2], high[:2], rtol=5e-3)
    assert np.round(low[2:4], 4).tolist() == [0.0015, 0.0007]
    assert np.round(high[2:4], 4).tolist() == [0.0027, 0.0014]
    minima = railsearch.distributions.random_vector({"P": {"distribution": "gumbel-min", "mean": 5.0e4, "std": 7.5e3}})
    np.testing.assert_allclose(minima.percentiles([0.01, 0.999])[:, 0], [26475.0, 64677.0], atol=1.0)


def test_published_importances_of_the_largest_deflection():
    """Extreme surfaces from the closed form: moduli and cross-sections at their lower bounds, loads at their upper ones."""
    low, high = np.array(REFERENCE["importance_max_weighted"]["lo"]), np.array(REFERENCE["importance_max_weighted"]["hi"])
    worst = np.concatenate([low[:4], high[4:]])
    variances = {}
    for i, name in enumerate(REFERENCE["order"]):
        logarithmic = name.startswith(("E", "P"))
        grid = np.geomspace(low[i], high[i], 50) if logarithmic else np.linspace(low[i], high[i], 50)
        designs = np.tile(worst, (50, 1))
        designs[:, i] = grid
        widths = np.concatenate([[grid[1] - grid[0]], grid[2:] - grid[:-2], [grid[-1] - grid[-2]]])
        curve = deflections(designs)
        variances[name] = np.average((curve - np.average(curve, weights=widths)) ** 2, weights=widths)
    total = sum(variances.values())
    published = {"E1": 0.3952, "A1": 0.3703, "P3": 0.0652, "P5": 0.0314, "A2": 0.0180, "E2": 0.0154, "P6": 0.0040}
    for name, importance in published.items():
        assert round(variances[name] / total, 4) == importance


@pytest.mark.parametrize(
    ("designs", "message"),
    [
        (np.ones((2, 9)), r"designs \(n, 10\) .* \(2, 9\)"),
        (np.zeros((1, 10)), "above 0"),
        (np.full((1, 10), np.nan), "finite"),
    ],
)
def test_bad_designs_are_refused(designs, message):
    for function in (deflections, closed_form):
        with pytest.raises(InputError, match=message):
            function(designs)
