"""Distributions against closed forms and scipy, isoprobabilistic maps against their inverses, and what is refused."""

import math
import pickle
import re
import tomllib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats
from scipy.integrate import quad
from scipy.special import ndtr

from railsearch.distributions import (
    FAMILIES,
    Marginal,
    TruncationWarning,
    keep_inside,
    marginal_from_scipy,
    marginal_from_table,
    random_vector,
)
from railsearch.errors import InputError

STATED = {
    "uniform": {"lower": 1e8, "upper": 1.5e9},
    "normal": {"mean": 35e9, "cov": 0.08},
    "lognormal": {"mean": 1.0, "cov": 0.15},
    "gumbel-max": {"mean": 5e4, "std": 7.5e3},
    "gumbel-min": {"mean": 5e4, "std": 7.5e3},
    "beta": {"alpha": 2.0, "beta": 3.5, "lower": -1.0, "upper": 3.0},
    "triangular": {"lower": 0.0, "mode": 0.2, "upper": 1.0},
    "scipy.stats.weibull_min": {"c": 1.8, "loc": 2.0, "scale": 3.0},
}
TRUNCATED = {
    "middle": {"distribution": "normal", "mean": 0.0, "std": 1.0, "truncate_below": -1.0, "truncate_above": 2.0},
    "one side": {"distribution": "lognormal", "mean": 1.0, "cov": 0.5, "truncate_above": 2.0},
    "upper tail": {"distribution": "normal", "mean": 0.0, "std": 1.0, "truncate_below": 9.0, "truncate_above": 11.0},
    "lower tail": {"distribution": "normal", "mean": 0.0, "std": 1.0, "truncate_below": -11.0, "truncate_above": -9.0},
    "beyond 9": {"distribution": "normal", "mean": 0.0, "std": 1.0, "truncate_below": 9.0},
    "gumbel": {"distribution": "gumbel-max", "mean": 5e4, "std": 7.5e3, "truncate_below": 3e4, "truncate_above": 9e4},
}


def stated(name, **changes):
    return marginal_from_table({"distribution": name, **STATED[name], **changes}, "x")


ALL = {name: stated(name) for name in STATED} | {name: marginal_from_table(t, "x") for name, t in TRUNCATED.items()}


@pytest.fixture(params=ALL)
def marginal(request):
    return ALL[request.param]


def test_every_family_is_tried():
    assert set(FAMILIES) < set(STATED)


@pytest.mark.parametrize("name", ["normal", "lognormal", "gumbel-max", "gumbel-min"])
@pytest.mark.parametrize("spread", [{"std": 3.0}, {"cov": 0.25}])
def test_mean_and_deviation_are_those_of_the_variable_itself(name, spread):
    made = marginal_from_table({"distribution": name, "mean": 12.0, **spread}, "x")
    assert made.mean == pytest.approx(12.0, rel=1e-12)
    assert made.std == pytest.approx(3.0, rel=1e-12)
    low, high = made.percentile(1e-13), made.percentile(1.0 - 1e-13)
    mean = quad(lambda x: x * made.pdf(x), low, high, epsabs=0.0, limit=200)[0]
    variance = quad(lambda x: (x - 12.0) ** 2 * made.pdf(x), low, high, epsabs=0.0, limit=200)[0]
    assert mean == pytest.approx(12.0, rel=1e-7)
    assert variance == pytest.approx(9.0, rel=1e-7)


def test_coefficient_of_variation_of_a_negative_mean_is_taken_by_size():
    assert marginal_from_table({"distribution": "normal", "mean": -4.0, "cov": 0.25}, "x").std == pytest.approx(1.0)


def test_families_are_those_of_their_closed_forms():
    x = np.array([3.9e4, 5e4, 6.4677e4])
    scale = 7.5e3 * math.sqrt(6.0) / math.pi
    location = 5e4 - 0.5772156649015329 * scale
    np.testing.assert_allclose(stated("gumbel-max").cdf(x), np.exp(-np.exp(-(x - location) / scale)), rtol=1e-12)
    # A Gumbel for minima is the mirror image of that for maxima.
    np.testing.assert_allclose(stated("gumbel-min").sf(1e5 - x), stated("gumbel-max").cdf(x), rtol=1e-12)
    np.testing.assert_allclose(
        stated("lognormal").cdf([0.8, 1.0, 1.3]),
        ndtr((np.log([0.8, 1.0, 1.3]) + 0.5 * math.log(1.0225)) / math.sqrt(math.log(1.0225))),
        rtol=1e-12,
    )
    np.testing.assert_allclose(stated("triangular").cdf([0.1, 0.2, 0.6]), [0.05, 0.2, 0.8], rtol=1e-12)
    wide = marginal_from_table({"distribution": "triangular", "lower": 10.0, "mode": 12.0, "upper": 18.0}, "x")
    np.testing.assert_allclose(wide.cdf([11.0, 12.0, 15.0]), [1.0 / 16.0, 0.25, 1.0 - 9.0 / 48.0], rtol=1e-12)
    np.testing.assert_allclose(stated("uniform").percentile([0.0, 0.5, 1.0]), [1e8, 8e8, 1.5e9], rtol=1e-15)
    beta = stated("beta")
    assert beta.mean == pytest.approx(-1.0 + 4.0 * 2.0 / 5.5, rel=1e-12)
    assert beta.std == pytest.approx(4.0 * math.sqrt(2.0 * 3.5 / (5.5**2 * 6.5)), rel=1e-12)


def test_published_ranges_of_the_truss_are_percentiles_of_these_distributions():
    """Ranges printed to three or five digits: Shang et al. 2024, table of the truss."""
    modulus = marginal_from_table({"distribution": "lognormal", "mean": 2.10e11, "std": 2.10e10}, "E")
    np.testing.assert_allclose(modulus.percentile([0.001, 0.999]), [1.535e11, 2.844e11], rtol=5e-4)
    load = stated("gumbel-min")
    assert load.percentile([0.01, 0.999]) == pytest.approx([26475.0, 64677.0], abs=0.6)


@pytest.mark.parametrize("name", ["uniform", "normal", "weibull_min", "t"])
def test_scipy_distributions_by_name_are_those_of_scipy(name):
    shapes = {"weibull_min": {"c": 1.8}, "t": {"df": 4.0}}.get(name, {})
    mine = marginal_from_table(
        {"distribution": f"scipy.stats.{name.replace('normal', 'norm')}", **shapes, "scale": 2.0}, "x"
    )
    theirs = getattr(stats, name.replace("normal", "norm"))(**shapes, scale=2.0)
    x = np.linspace(-1.0, 4.0, 11)
    np.testing.assert_allclose(mine.cdf(x), theirs.cdf(x), rtol=1e-14)
    np.testing.assert_allclose(marginal_from_scipy(theirs, "x").cdf(x), theirs.cdf(x), rtol=1e-14)


@given(st.floats(1e-12, 1.0 - 1e-12))
@settings(max_examples=30, deadline=None)
def test_percentile_inverts_the_distribution_function(p):
    for made in ALL.values():
        assert made.cdf(made.percentile(p)) == pytest.approx(p, abs=1e-8)
        assert made.sf(made.upper_percentile(p)) == pytest.approx(p, abs=1e-8)


@pytest.mark.parametrize("name", ALL)
def test_standard_normal_map_is_inverted_into_both_tails(name):
    made = ALL[name]
    # A mode or a density that begins with zero slope hides the tail in the last digit of x; within ±5 all keep theirs.
    xi = np.linspace(-5.0, 5.0, 41)
    x = made.from_standard_normal(xi)
    assert (np.diff(x) > 0.0).all()
    back = made.to_standard_normal(x)
    # One rounding of x moves ξ by ε|x| f(x)/φ(ξ).
    rounding = 2.0**-50 * np.abs(x) * made.pdf(x) / stats.norm.pdf(xi)
    assert (np.abs(back - xi) <= 1e-9 + rounding).all()


@pytest.mark.parametrize("xi", [-20.0, 20.0])
def test_far_tails_of_a_normal_keep_all_digits(xi):
    made = marginal_from_table({"distribution": "normal", "mean": 3.0, "std": 2.0}, "x")
    assert made.from_standard_normal(xi) == pytest.approx(3.0 + 2.0 * xi, rel=1e-12)
    assert made.to_standard_normal(3.0 + 2.0 * xi) == pytest.approx(xi, rel=1e-12)


def test_standard_normal_map_of_a_lognormal_is_its_logarithm():
    variance = math.log1p(0.15**2)
    x = np.array([0.3, 0.9, 2.5])
    np.testing.assert_allclose(
        stated("lognormal").to_standard_normal(x), (np.log(x) + 0.5 * variance) / math.sqrt(variance), rtol=1e-9
    )


def test_density_is_the_derivative_and_integrates_to_one(marginal):
    x = marginal.percentile(np.linspace(0.05, 0.95, 19))
    step = 1e-5 * marginal.std
    np.testing.assert_allclose((marginal.cdf(x + step) - marginal.cdf(x - step)) / (2.0 * step), marginal.pdf(x), rtol=2e-4)
    low, high = marginal.percentile(1e-12), marginal.upper_percentile(1e-12)
    assert quad(marginal.pdf, low, high, epsabs=0.0, limit=300)[0] == pytest.approx(1.0, rel=1e-6)
    for beyond in (marginal.support[0] - 1.0, marginal.support[1] + 1.0):
        assert not math.isfinite(beyond) or marginal.pdf(beyond) == 0.0


def test_distribution_function_is_zero_below_and_one_above(marginal):
    low, high = marginal.support
    np.testing.assert_allclose(marginal.cdf([low, high]), [0.0, 1.0], atol=1e-15)
    np.testing.assert_allclose(marginal.sf([low, high]), [1.0, 0.0], atol=1e-15)
    x = marginal.percentile(np.linspace(0.01, 0.99, 9))
    np.testing.assert_allclose(marginal.cdf(x) + marginal.sf(x), 1.0, atol=1e-12)


@pytest.mark.parametrize("name", ["middle", "upper tail", "lower tail", "beyond 9"])
def test_truncated_normals_are_those_of_scipy(name):
    made, table = ALL[name], TRUNCATED[name]
    low, high = table.get("truncate_below", -math.inf), table.get("truncate_above", math.inf)
    theirs = stats.truncnorm(low, high)
    assert made.mean == pytest.approx(theirs.mean(), rel=1e-9)
    assert made.std == pytest.approx(theirs.std(), rel=1e-7)
    p = np.linspace(0.02, 0.98, 13)
    np.testing.assert_allclose(made.percentile(p), theirs.ppf(p), rtol=1e-10)
    np.testing.assert_allclose(made.cdf(theirs.ppf(p)), p, rtol=1e-9)
    np.testing.assert_allclose(made.sf(theirs.ppf(p)), 1.0 - p, rtol=1e-9)


def test_moments_of_a_truncated_exponential_are_known():
    made = marginal_from_table({"distribution": "scipy.stats.expon", "scale": 1.0, "truncate_above": 2.0}, "x")
    kept = 1.0 - math.exp(-2.0)
    mean = (1.0 - 3.0 * math.exp(-2.0)) / kept
    assert made.mean == pytest.approx(mean, rel=1e-9)
    assert made.std**2 == pytest.approx((2.0 - 10.0 * math.exp(-2.0)) / kept - mean**2, rel=1e-8)


def test_truncating_twice_is_truncating_at_the_inner_bounds():
    once = stated("normal", truncate_below=30e9, truncate_above=36e9)
    twice = stated("normal", truncate_below=28e9, truncate_above=36e9).truncated(30e9, 50e9)
    assert stated("normal", truncate_below=30e9, truncate_above=40e9).truncated(20e9, 36e9).support == once.support
    assert (once.support, once.mean) == (twice.support, twice.mean)
    assert str(twice) == "normal(mean=3.5e+10, cov=0.08) between 3e+10 and 3.6e+10"


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ({}, "x: distribution: must be given; there are uniform, normal"),
        ({"distribution": "gaussian"}, "unknown 'gaussian'; there are uniform, .*scipy.stats.NAME"),
        ({"distribution": 3}, "unknown '3'"),
        ({"distribution": "scipy.stats.nothing"}, "no continuous distribution 'nothing'"),
        ({"distribution": "scipy.stats.poisson", "mu": 3}, "no continuous distribution 'poisson'"),
        ({"distribution": "scipy.stats.weibull_min", "k": 3}, "it takes c, loc, scale"),
        ({"distribution": "scipy.stats.weibull_min", "c": -3.0}, "is not the distribution of one"),
        ({"distribution": "scipy.stats.norm", "scale": "wide"}, "x.scale: a finite number is needed, received 'wide'"),
        ({"distribution": "scipy.stats.norm", "scale": [1.0, 2.0]}, "x.scale: a finite number is needed"),
        ({"distribution": "scipy.stats.norm", "loc": math.inf}, "x.loc: a finite number is needed"),
        ({"distribution": "uniform", "lower": 1.0}, "upper must be given"),
        ({"distribution": "uniform", "lower": 2.0, "upper": 2.0}, "below the upper one, received 2 and 2"),
        ({"distribution": "uniform", "lower": 2.0, "upper": math.inf}, "finite number is needed"),
        ({"distribution": "uniform", "lower": 1.0, "upper": 2.0, "mean": 3}, "unknown parameter 'mean'"),
        ({"distribution": "normal", "mean": 1.0}, "std or cov: one of them is needed, received neither"),
        ({"distribution": "normal", "mean": 1.0, "std": 1.0, "cov": 1.0}, "received both"),
        ({"distribution": "normal", "mean": 0.0, "cov": 0.1}, "mean of zero has no coefficient"),
        ({"distribution": "normal", "mean": 0.0, "std": 0.0}, "x.std: allowed is > 0"),
        ({"distribution": "lognormal", "mean": -1.0, "cov": 0.1}, "x.mean: allowed is > 0"),
        ({"distribution": "triangular", "lower": 0.0, "mode": 2.0, "upper": 1.0}, "mode: must lie between"),
        ({"distribution": "beta", "alpha": 2.0, "beta": 0.0}, "x.beta: allowed is > 0"),
        ({"distribution": "beta", "alpha": 2.0, "beta": 1.0, "lower": 2.0}, "below the upper one, received 2 and 1"),
        ({**TRUNCATED["middle"], "truncate_above": -2.0}, "nothing of normal.*lies between -1 and -2"),
        ({**TRUNCATED["middle"], "truncate_below": 50.0, "truncate_above": 51.0}, "nothing of normal"),
        ({**TRUNCATED["middle"], "truncate_below": "low"}, "x.truncate_below: a number is needed"),
    ],
)
def test_tables_that_state_no_distribution_are_refused(table, words):
    with pytest.raises(InputError, match=rf"(?=^x).*{words}"):
        marginal_from_table(table, "x")


@pytest.mark.parametrize("thing", [stats.norm, stats.poisson(3.0), 1.0, "normal"])
def test_what_is_no_frozen_continuous_distribution_is_refused(thing):
    with pytest.raises(InputError, match=r"^distributions\.x: a table, or a frozen continuous distribution"):
        random_vector({"x": thing})


@pytest.mark.parametrize("frozen", [stats.norm(0.0, -1.0), stats.norm([0.0, 1.0], 1.0)])
def test_a_frozen_distribution_of_no_or_several_variables_is_refused(frozen):
    with pytest.raises(InputError, match=r"x: scipy\.stats\.norm\(.*\) is not the distribution of one variable"):
        random_vector({"x": frozen})


@pytest.fixture
def vector():
    return random_vector(
        {
            "stiffness": {"distribution": "uniform", "lower": 1e8, "upper": 1.5e9},
            "mass": {"distribution": "lognormal", "mean": 1.0, "cov": 0.15},
            "load": stats.gumbel_r(5e4, 6e3),
            "angle": ALL["triangular"],
        }
    )


def test_vector_maps_every_column_by_its_own_distribution(vector):
    xi = np.random.default_rng(1).normal(size=(5, 7, 4))
    points = vector.from_standard_normal(xi)
    assert points.shape == (5, 7, 4)
    np.testing.assert_allclose(vector.to_standard_normal(points), xi, atol=1e-9)
    np.testing.assert_allclose(vector.from_uniform(vector.cdf(points)), points, rtol=1e-9)
    np.testing.assert_allclose(vector.cdf(points), ndtr(xi), atol=1e-12)
    for k, made in enumerate(vector.marginals.values()):
        np.testing.assert_array_equal(points[..., k], made.from_standard_normal(xi[..., k]))
    assert vector.names == ("stiffness", "mass", "load", "angle")
    np.testing.assert_allclose(vector.mean[:2], [8e8, 1.0])
    np.testing.assert_allclose(vector.std[:2], [1.4e9 / math.sqrt(12.0), 0.15])


def test_a_vector_is_stated_in_toml():
    document = tomllib.loads(
        """
        load = { distribution = "gumbel-max", mean = 5e4, cov = 0.15 }
        damping = { distribution = "normal", mean = 0.02, std = 0.01, truncate_below = 0 }

        [wind]
        distribution = "scipy.stats.weibull_min"
        c = 2
        scale = 8.0
        """
    )
    vector = random_vector(document)
    assert vector.names == ("load", "damping", "wind")
    np.testing.assert_allclose(vector.std[[0, 2]], [7.5e3, stats.weibull_min(2, scale=8.0).std()])
    assert vector.marginals["damping"].support == (0.0, math.inf)


def test_percentiles_and_ranges(vector):
    table = vector.percentiles([0.01, 0.5, 0.99])
    assert table.shape == (3, 4)
    ranges = vector.ranges()
    np.testing.assert_array_equal(ranges[0], [1e8, 1.5e9])
    np.testing.assert_array_equal(ranges[1], table[[0, 2], 1])
    np.testing.assert_array_equal(ranges[3], [0.0, 1.0])
    np.testing.assert_allclose(vector.ranges(0.001)[2], stats.gumbel_r(5e4, 6e3).ppf([0.001, 0.999]))
    assert vector.percentiles(0.5).shape == (1, 4)


def test_a_vector_survives_its_way_to_another_process(vector):
    points = vector.percentiles([0.1, 0.7])
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(vector)).cdf(points), vector.cdf(points))


def test_points_that_cannot_be_are_refused_by_name(vector):
    point = vector.percentiles(0.5)
    with pytest.raises(
        InputError, match=r"4 values each are needed \(stiffness, mass, load, angle\), received shape \(1, 3\)"
    ):
        vector.cdf(point[:, :3])
    for column, value in ((0, 9e7), (0, 1.6e9), (1, -0.1), (3, math.nan)):
        wrong = point.copy()
        wrong[0, column] = value
        with pytest.raises(
            InputError, match=rf"^{vector.names[column]}: .* has values from .*received {re.escape(f'{value:g}')}"
        ):
            vector.to_standard_normal(wrong)
    for level in (-0.1, 1.1, math.nan):
        with pytest.raises(InputError, match="from 0 to 1"):
            vector.percentiles(level)
    for level in (0.0, 0.5):
        with pytest.raises(InputError, match=r"a level between 0 and 0\.5"):
            vector.ranges(level)


def test_no_inputs_are_refused():
    with pytest.raises(InputError, match="one or more are needed"):
        random_vector({})


def test_correlated_inputs_are_refused_with_the_reason():
    tables = {"a": ALL["normal"], "b": ALL["uniform"]}
    assert random_vector(tables, correlation=np.eye(2)).dimension == 2
    with pytest.raises(InputError, match=r"correlated inputs are refused: .* stand on independent inputs"):
        random_vector(tables, correlation=[[1.0, 0.3], [0.3, 1.0]])
    with pytest.raises(InputError, match="correlated inputs are refused"):
        random_vector({"a": stats.multivariate_normal([0.0, 0.0], np.eye(2))})


def test_a_distribution_outside_its_physical_range_is_refused_with_the_probability():
    damping = random_vector({"damping": {"distribution": "normal", "mean": 0.02, "std": 0.01}})
    with pytest.raises(InputError, match=r"damping: normal.* its physical range, 0 to 1, with a probability of 0\.0228"):
        keep_inside(damping, {"damping": (0.0, 1.0)})
    with pytest.raises(InputError, match="depth are not among the inputs damping"):
        keep_inside(damping, {"depth": (0.0, 1.0)})


@pytest.mark.parametrize(("low", "high", "share"), [(-1.0, 9.0, 0.158655), (-9.0, 2.0, 0.022750), (-1.0, 2.0, 0.181405)])
def test_probability_outside_counts_both_sides(low, high, share):
    standard = marginal_from_table({"distribution": "normal", "mean": 0.0, "std": 1.0}, "x")
    assert standard.probability_outside(low, high) == pytest.approx(share, abs=1e-6)


def test_truncation_warns_of_what_is_cut_off_and_keeps_the_rest():
    damping = random_vector({"damping": {"distribution": "normal", "mean": 0.02, "std": 0.01}, "angle": ALL["triangular"]})
    with pytest.warns(TruncationWarning, match=r"damping: .* probability of 0\.0228; it was cut off there"):
        kept = keep_inside(damping, {"damping": (0.0, math.inf)}, truncate=True)
    assert kept.marginals["damping"].support == (0.0, math.inf)
    assert kept.marginals["damping"].mean == pytest.approx(stats.truncnorm(-2.0, math.inf, 0.02, 0.01).mean(), rel=1e-9)
    assert kept.marginals["angle"] is damping.marginals["angle"]


def test_what_happens_once_in_a_thousand_million_times_is_no_fault(recwarn):
    vector = random_vector({"modulus": {"distribution": "normal", "mean": 35e9, "cov": 0.16}})
    assert Marginal.probability_outside(vector.marginals["modulus"], 0.0, math.inf) < 1e-9
    assert keep_inside(vector, {"modulus": (0.0, math.inf)}).marginals["modulus"].support[0] == -math.inf
    assert not recwarn
    with pytest.raises(InputError, match="modulus"):
        keep_inside(vector, {"modulus": (0.0, math.inf)}, negligible=0.0)
