"""Sensitivities against OpenTURNS: Sobol' indices and moments, and target HSIC beside importances near extremes.

Target HSIC (Marrel & Chabridon 2021) asks how much the failure {g > t} depends on an input under the distributions; A-1AT
asks what an input held at a value leaves to the worst of all others in their ranges. What one implies about the other is
said where it is tested. The reference has means and standard errors of independent repetitions.
"""

import itertools
import json
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import skew, spearmanr

from railsearch.distributions import RandomVector
from railsearch.sampling import latin_hypercube
from railsearch.sensitivity import FRUGAL, ExactModel, extreme_surfaces, factors_on, input_space, threshold_surfaces
from railsearch.sensitivity.variance_based import sobol_indices
from railsearch_plugins.polynomial_chaos.estimator import PolynomialChaosRegressor
from railsearch_problems.six_hump_camel import SixHumpCamel, camel_values
from railsearch_problems.truss import Truss, closed_form

REFERENCES = Path(__file__).parents[1] / "reference"
OPENTURNS = json.loads((REFERENCES / "openturns.json").read_text(encoding="utf-8"))["cases"]
PUBLISHED = json.loads((REFERENCES / "truss.json").read_text(encoding="utf-8"))["importance_max_weighted"]
CASES = {"truss": (Truss().distributions, closed_form), "six-hump-camel": (SixHumpCamel().distributions, camel_values)}
GROUPS = (("E1", "A1"), ("P3", "P4"), ("P2", "P5"), ("E2", "A2"), ("P1", "P6"))
"""Inputs of the truss that are alike, in falling order of their effect."""

ERRORS = 4.0
"""Standard errors within which estimates agree."""

CONFIDENCE_ERRORS = 1.96
"""Standard errors in the half width of a confidence interval of 95 %."""


def agrees(found, reference, own_error=0.0):
    """Whether numbers are within the statistical error of the reference and of their own."""
    allowed = ERRORS * np.hypot(reference["standard_error"], own_error)
    return np.all(np.abs(np.subtract(found, reference["mean"])) <= allowed)


@pytest.fixture(scope="module")
def truss_extremes():
    """Extreme surfaces of the truss in its published ranges, from the closed form."""
    truss = Truss()
    ranges = dict(zip(truss.space.names, zip(PUBLISHED["lo"], PUBLISHED["hi"], strict=True), strict=True))
    units = {variable.name: variable.unit for variable in truss.space.variables}
    factors = factors_on(input_space(truss.distributions, ranges=ranges, units=units), 50)
    return extreme_surfaces(ExactModel(closed_form, factors.space), factors, np.random.default_rng(0), FRUGAL)


@pytest.fixture(scope="module")
def camel_extremes():
    """Extreme surfaces of the six-hump camel on its whole box, from the function itself."""
    factors = factors_on(input_space(SixHumpCamel().distributions), 201)
    return extreme_surfaces(ExactModel(camel_values, factors.space), factors, np.random.default_rng(0))


def hsic_of(case, threshold):
    """The reference at a threshold, and its means and standard errors by input."""
    found = next(entry for entry in OPENTURNS[case]["target_hsic"] if entry["threshold"] == threshold)
    pairs = zip(found["r2_hsic"]["mean"], found["r2_hsic"]["standard_error"], strict=True)
    return found, dict(zip(OPENTURNS[case]["inputs"], pairs, strict=True))


def thresholds_of(case):
    return [entry["threshold"] for entry in OPENTURNS[case]["target_hsic"]]


@pytest.mark.parametrize("case", CASES)
def test_moments_and_indices_of_an_expansion_are_those_by_saltelli_and_jansen(case):
    """In closed form from the coefficients here, by sampling there; the expansions' own errors are below 1e-6.

    The skewness is that of sampled predictions. It alone tells a load of Gumbel's distribution for maxima from one for
    minima, because the deflection is linear in the loads.
    """
    inputs, function = CASES[case]
    reference, moments = OPENTURNS[case]["sobol"], OPENTURNS[case]["moments"]
    assert isinstance(inputs, RandomVector)
    assert list(inputs.names) == OPENTURNS[case]["inputs"]
    generator = np.random.default_rng(1)
    points = latin_hypercube(inputs, 200, generator)
    expansion = PolynomialChaosRegressor(inputs=inputs, degree=6).fit(points, function(points)).expansion_
    assert agrees(expansion.mean, moments["mean"])
    assert agrees(np.sqrt(expansion.variance), moments["deviation"])
    assert agrees(expansion.first_order_indices, reference["first"])
    assert agrees(expansion.total_indices, reference["total"])
    skewnesses = [
        skew(expansion.predict(inputs.from_uniform(part))) for part in generator.random((20, 5000, inputs.dimension))
    ]
    assert agrees(np.mean(skewnesses), moments["skewness"], np.std(skewnesses, ddof=1) / np.sqrt(20))


@pytest.mark.parametrize("case", CASES)
def test_sampled_indices_are_those_by_saltelli_and_jansen(case):
    """Two programs, two designs (Sobol' points here, random ones there), within the errors of both."""
    inputs, function = CASES[case]
    found = sobol_indices(function, inputs, 4096, np.random.default_rng(2))
    reference = OPENTURNS[case]["sobol"]
    assert agrees(found.first, reference["first"], found.first_half_width / CONFIDENCE_ERRORS)
    assert agrees(found.total, reference["total"], found.total_half_width / CONFIDENCE_ERRORS)


def test_the_reference_is_sharp_enough_to_tell_the_inputs_apart():
    """Errors of the indices far below the differences that the tests above are to see."""
    for case in CASES:
        for measure in ("first", "total"):
            assert max(OPENTURNS[case]["sobol"][measure]["standard_error"]) < 2e-3


def test_importances_of_the_truss_rank_its_inputs_as_target_hsic_does(truss_extremes):
    """To the first order in the spreads both follow the effects e_i = σ_i |∂w/∂x_i|, at every threshold.

    A target HSIC with kernels in units of σ_i grows with the square of the correlation with w, which is e_i over the
    deviation of w. The worst-case curve of a factor spans e_i times its range in σ_i, and all curves are steepened alike by
    the others at their worst: I_i ∝ (e_i range_i)². Ranges are 5.1 to 7 σ, a ratio of 1.38, while the effects of successive
    groups differ by 1.43 and more: so the order of the groups is implied, unless the shapes of lognormal and Gumbel's
    distributions made up for a factor of two in HSIC. Within a group nothing is: E1 and A1 are exchangeable in w and have
    one HSIC, but their published ranges differ, so A-1AT must tell them apart.

    A ranking that has the groups right can still turn each of the five pairs: Spearman's ρ ≥ 1 − 6·5·2/(10·99) = 0.939.
    """
    importances = truss_extremes.importances()
    effects, ranges = effects_and_ranges(truss_extremes.factors)
    of_groups = [effects[first] for first, _ in GROUPS]
    assert max(ranges.values()) / min(ranges.values()) < min(a / b for a, b in itertools.pairwise(of_groups))
    for above, below in itertools.pairwise(GROUPS):
        assert min(importances[name] for name in above) > max(importances[name] for name in below)
    for threshold in thresholds_of("truss"):
        _, hsic = hsic_of("truss", threshold)
        for above, below in itertools.pairwise(GROUPS):
            (high, high_error), (low, low_error) = (mean_of_pair(hsic, pair) for pair in (above, below))
            assert high - low > 2.0 * np.hypot(high_error, low_error), (threshold, above, below)
        means = [hsic[name][0] for name in importances]
        assert spearmanr(list(importances.values()), means).statistic >= 1.0 - 60.0 / 990.0
        assert abs(hsic["E1"][0] - hsic["A1"][0]) <= ERRORS * np.hypot(hsic["E1"][1], hsic["A1"][1])
    assert importances["E1"] - importances["A1"] > 0.02


def mean_of_pair(hsic, pair):
    """Mean of two inputs that are alike, and its standard error."""
    values, errors = zip(*(hsic[name] for name in pair), strict=True)
    return np.mean(values), np.hypot(*errors) / 2.0


def effects_and_ranges(factors):
    """E_i = σ_i |∂w/∂x_i| in m at the means, and the ranges of the factors in σ_i, both by name."""
    inputs = Truss().distributions
    step = 1e-5 * np.diag(inputs.std)
    slopes = (closed_form(inputs.mean + step) - closed_form(inputs.mean - step)) / 2e-5
    widths = [variable.upper - variable.lower for variable in factors.space.variables]
    return dict(zip(factors.names, np.abs(slopes), strict=True)), dict(zip(factors.names, widths / inputs.std, strict=True))


def test_critical_factors_of_the_truss_are_the_first_of_target_hsic(truss_extremes):
    """As t rises, factors become critical in the order of their curves' spans, which is that of the groups (see above).

    At the thresholds of the reference the two measures must differ: the failure depends on E1 and A1 more than on anything
    else, and yet neither is critical, because with either at its best the others still bring w beyond 0.114 m.
    """
    for threshold in thresholds_of("truss"):
        _, hsic = hsic_of("truss", threshold)
        ranked = sorted(hsic, key=lambda name: hsic[name][0], reverse=True)
        near, middle, far = threshold_surfaces(truss_extremes, [threshold, 0.12, 0.16]).thresholds
        assert set(middle.critical) == set(ranked[:2]) == {"E1", "A1"}
        assert set(far.critical) == set(ranked[:4])
        assert near.critical == ()
        assert all(hsic[name][0] > ERRORS * hsic[name][1] for name in ("E1", "A1"))


def test_an_input_with_a_safe_range_has_a_target_hsic(camel_extremes):
    """In a safe range the failure has probability 0, elsewhere not: it depends on the input, so its HSIC is above 0.

    The kernels are characteristic, the box of A-1AT is that of the distributions, and the filter is the indicator, so this
    is exact. The other direction is not implied: x2 has no safe range at t = 2. Nor can failure be more frequent than x_i is
    outside its safe ranges: P[g > t] ≤ P[X_i unsafe].
    """
    for threshold in threshold_surfaces(camel_extremes, thresholds_of("six-hump-camel")).thresholds:
        reference, hsic = hsic_of("six-hump-camel", threshold.value)
        assert threshold.critical
        for factor, variable in zip(threshold.factors, camel_extremes.factors.space.variables, strict=True):
            assert factor.critical == bool(factor.safe)
            unsafe = 1.0 - sum(high - low for low, high in factor.safe) / (variable.upper - variable.lower)
            assert 0.0 < reference["share_beyond"] < unsafe
            if factor.critical:
                assert hsic[factor.name][0] > ERRORS * hsic[factor.name][1]
    assert [entry.critical for entry in threshold_surfaces(camel_extremes, [2.0, 4.0]).thresholds] == [("x1",), ("x1", "x2")]
