"""From samples to importances: surrogates on random inputs, samples that can be used, the command and its report."""

import json

import numpy as np
import pytest

from railsearch.distributions import random_vector
from railsearch.errors import CapabilityError, InputError
from railsearch.interfaces import Quantity
from railsearch.plugin_manager import load_plugins
from railsearch.sampling import latin_hypercube
from railsearch.sensitivity.fitting import fitted_surrogate, surrogate_fit
from railsearch.sensitivity_study import check_independent, sampled_output

INPUTS = random_vector(
    {
        "a": {"distribution": "lognormal", "mean": 2.0, "cov": 0.2},
        "b": {"distribution": "uniform", "lower": -1.0, "upper": 1.0},
        "c": {"distribution": "normal", "mean": 0.0, "std": 3.0},
    }
)
UNIT = {"distribution": "uniform", "lower": 0.0, "upper": 1.0}
OUTPUT = Quantity("y", "m")
PUBLISHED = {"E1": 0.3952, "A1": 0.3703, "P3": 0.0652, "P4": 0.0652, "P5": 0.0314, "P2": 0.0314, "A2": 0.0180, "E2": 0.0154}


def function(x):
    return x[:, 0] ** 2 + x[:, 0] * x[:, 1] + 0.5 * x[:, 2]


def samples(count, seed=1):
    points = latin_hypercube(INPUTS, count, np.random.default_rng(seed))
    return points, function(points)


@pytest.mark.parametrize("name", ["pce", "kriging", "rbf"])
def test_surrogates_are_of_the_inputs_in_their_units(name):
    """Whether a surrogate knows distributions or sees a unit cube: values and slopes are those over the inputs."""
    fitted = fitted_surrogate(surrogate_fit(load_plugins(), name, {}, INPUTS), *samples(150), np.random.default_rng(2))
    inside = samples(20, seed=9)[0]
    inside = np.clip(inside, *INPUTS.percentiles([0.05, 0.95]))
    exact = np.column_stack([2.0 * inside[:, 0] + inside[:, 1], inside[:, 0], np.full(20, 0.5)])
    scale = np.ptp(function(inside))
    np.testing.assert_allclose(fitted.model.predict(inside), function(inside), atol=0.03 * scale)
    np.testing.assert_allclose(fitted.model.gradient(inside) * INPUTS.std, exact * INPUTS.std, atol=0.15 * scale)


def test_error_is_that_of_samples_the_fit_has_not_seen():
    """With a surrogate that says the mean, the error is the variance of the held-out values about it: one and a little."""

    class Mean:
        def __init__(self, values):
            self.mean = values.mean()

        def predict(self, points):
            return np.full(len(points), self.mean)

        def gradient(self, points):
            return np.zeros_like(points)

    seen = []

    def fit(points, values):
        seen.append(values)
        return Mean(values)

    points, values = samples(200)
    fitted = fitted_surrogate(fit, points, values, np.random.default_rng(3))
    assert [len(rows) for rows in seen] == [160, 200]
    assert not set(fitted.true) & set(seen[0])
    expected = np.mean((fitted.true - seen[0].mean()) ** 2) / np.var(values)
    assert fitted.quality.generalisation == pytest.approx(expected)
    assert (fitted.quality.samples, fitted.quality.held_out) == (200, 40)


def test_a_surrogate_without_a_gradient_is_refused():
    with pytest.raises(CapabilityError, match="has no gradient, which the search for extremes needs: choose pce"):
        surrogate_fit(load_plugins(), "sklearn.ensemble.RandomForestRegressor", {}, INPUTS)


def test_failed_and_repeated_samples_are_left_out_and_counted():
    points, values = samples(30)
    values[[3, 7]] = np.nan
    doubled = np.concatenate([points, points[:5]]), np.concatenate([values, values[:5]])
    found = sampled_output(OUTPUT, *doubled)
    assert (len(found.values), found.failed, found.repeated) == (28, 3, 4)
    np.testing.assert_array_equal(found.points, np.delete(points, [3, 7], axis=0))
    with pytest.raises(InputError, match="y: none of 30 samples has a value"):
        sampled_output(OUTPUT, points, np.full(30, np.nan))
    doubled[1][-1] += 1.0
    with pytest.raises(InputError, match=r"y: the same inputs have the values .* needs a model without randomness"):
        sampled_output(OUTPUT, *doubled)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        (np.ones(50), "the output is 1 in all 50 samples"),
        (np.arange(5.0), "10 or more are needed with 3 inputs, .* received 5"),
    ],
)
def test_samples_that_cannot_be_explained_are_refused(values, message):
    points = samples(len(values))[0]
    with pytest.raises(InputError, match=message):
        fitted_surrogate(surrogate_fit(load_plugins(), "pce", {}, INPUTS), points, values, np.random.default_rng(0))


def test_more_samples_than_inputs_are_needed():
    """A linear function of d inputs has d + 1 terms, and an error needs one sample more."""
    fit = surrogate_fit(load_plugins(), "pce", {}, random_vector({f"x{k}": UNIT for k in range(16)}))
    points = np.random.default_rng(0).random((18, 16))
    with pytest.raises(InputError, match=r"18 or more are needed with 16 inputs, .* received 17"):
        fitted_surrogate(fit, points[:17], points[:17, 0], np.random.default_rng(1))
    assert fitted_surrogate(fit, points, points[:, 0], np.random.default_rng(1)).quality.samples == 18


def test_correlated_inputs_are_refused_and_a_small_hypercube_is_not():
    points = samples(200)[0]
    check_independent(INPUTS, points)
    check_independent(INPUTS, samples(12)[0])
    points[:, 2] = np.sort(points[:, 2])[np.argsort(np.argsort(points[:, 0] + 0.3 * points[:, 2]))]
    with pytest.raises(InputError, match=r"a and c have a rank correlation of 0.*correlated inputs are refused"):
        check_independent(INPUTS, points)


def test_command_on_the_truss(railsearch, tmp_path):
    """Importances of the exact model to a hundredth, from 150 samples; the second time nothing is evaluated."""
    words = ("sensitivity", "truss", "--samples", 150, "--seed", 3, "--points", 30, "--out", tmp_path / "study")
    answer = railsearch(*words, "--thresholds", "0.09,0.5", "--json")
    assert answer.code == 0, answer.err
    (criterion,) = json.loads(answer.out)["criteria"]
    for name, share in PUBLISHED.items():
        assert criterion["importances"][name] == pytest.approx(share, abs=0.01), name
    assert criterion["surrogate"]["generalisation"] < 1e-4
    assert criterion["extremes"]["effort"]["check"]["held"]
    statuses = {threshold["value"]: threshold["status"] for threshold in criterion["thresholds"]["thresholds"]}
    assert statuses[0.09] == "reached"
    assert statuses[0.5] == "never reached"
    assert len(statuses) == 5
    page = (tmp_path / "study" / "report.html").read_text(encoding="utf-8")
    assert "Sensitivity of truss" in page
    assert "In the worst case w by" in page
    assert page.count("<svg") == 4
    again = railsearch(*words)
    assert again.code == 0, again.err
    assert "nothing is evaluated" in again.err
    assert "worst case" in again.out


INPUTS_FILE = """
[distributions.a]
distribution = "lognormal"
mean = 2.0
cov = 0.2
unit = "mm"

[distributions.b]
distribution = "uniform"
lower = -1.0
upper = 1.0

[distributions.c]
distribution = "normal"
mean = 0.0
std = 3.0
"""


@pytest.fixture
def own(tmp_path):
    """A table and a file of distributions of one's own."""
    points, values = samples(120)
    rows = [",".join(map(repr, map(float, [*row, value]))) for row, value in zip(points, values, strict=True)]
    (tmp_path / "own.csv").write_text("\n".join(["a [mm],b,c,y [m]", *rows]), encoding="utf-8")
    (tmp_path / "inputs.toml").write_text(INPUTS_FILE, encoding="utf-8")
    return tmp_path


def test_command_on_data_of_ones_own(railsearch, own):
    """A quadratic is found exactly: with b and c at their worst, y over a is x² + |x| + const."""
    words = ("sensitivity", "--data", own / "own.csv", "--distributions", own / "inputs.toml", "--seed", 1)
    answer = railsearch(*words, "--out", own / "study", "--json")
    assert answer.code == 0, answer.err
    document = json.loads(answer.out)
    (criterion,) = document["criteria"]
    assert "inputs: a, b, c; outputs, because they have no distribution: y" in answer.err
    assert (criterion["name"], criterion["unit"]) == ("y", "m")
    assert document["inputs"][0]["unit"] == "mm"
    curve = next(factor for factor in criterion["extremes"]["factors"] if factor["name"] == "a")
    a = np.array(curve["grid"])
    largest_c = INPUTS.ranges(0.01)[2, 1]
    np.testing.assert_allclose(curve["maximum"]["values"], a**2 + a + 0.5 * largest_c, rtol=1e-6)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ((), "a problem is needed, or --data with --distributions"),
        (("truss", "--distributions", "inputs.toml"), "they belong to data of your own"),
        (("--data", "own.csv", "--distributions", "inputs.toml", "--criterion", "z"), "unknown 'z'; there are y"),
        (("--data", "own.csv", "--distributions", "inputs.toml", "--thresholds", "1,x"), "numbers with commas"),
        (("--data", "own.csv", "--distributions", "other.toml"), "column 'd' is missing"),
        (("--data", "own.csv", "--distributions", "correlated.toml"), "correlated inputs are refused"),
        (("--data", "own.csv", "--distributions", "empty.toml"), "tables [distributions.INPUT]"),
        (("--data", "own.csv", "--distributions", "metres.toml"), "a: the unit is 'm' in metres.toml and 'mm' in own.csv"),
        (("--data", "own.csv", "--distributions", "large.toml"), "c: samples from -"),
        (("--data", "constant.csv", "--distributions", "inputs.toml"), "b: it is 0.5 in all 120 samples"),
        (("truss", "--criterion", "z"), "criterion: unknown 'z'; there are w"),
        (("truss", "--surrogate", "zz"), "unknown surrogate 'zz'"),
        (("truss", "--surrogate-set", "degree=abc"), "degree"),
        (("truss", "--surrogate-set", "degree"), "--surrogate-set: NAME=VALUE is needed"),
        (("truss", "--level", "0.6"), "level: a fraction between 0 and 0.5"),
        (("truss", "--thresholds", "nan"), "thresholds of w: finite numbers are needed"),
        (("truss", "--limit", "middle"), "limit: upper or lower is needed"),
        (("truss", "--on-model", "10"), "a power of two"),
        (("truss", "--samples", "11"), "12 or more are needed with 10 inputs"),
    ],
)
def test_faults_are_named(railsearch, own, monkeypatch, words, message):
    monkeypatch.chdir(own)
    (own / "other.toml").write_text(INPUTS_FILE.replace("distributions.c", "distributions.d"), encoding="utf-8")
    (own / "correlated.toml").write_text("correlation = [[1.0, 0.5], [0.5, 1.0]]\n" + INPUTS_FILE, encoding="utf-8")
    (own / "empty.toml").write_text("[ranges]\n", encoding="utf-8")
    (own / "metres.toml").write_text(INPUTS_FILE.replace('"mm"', '"m"'), encoding="utf-8")
    (own / "large.toml").write_text(INPUTS_FILE.replace("mean = 0.0", "mean = 3000.0"), encoding="utf-8")
    lines = (own / "own.csv").read_text(encoding="utf-8").splitlines()
    rows = [line.split(",") for line in lines[1:]]
    constant = [lines[0], *(",".join([a, "0.5", c, y]) for a, _, c, y in rows)]
    (own / "constant.csv").write_text("\n".join(constant), encoding="utf-8")
    answer = railsearch("sensitivity", *words)
    assert answer.code == 2
    assert message in answer.err
    assert not list(own.glob("**/*.parquet*")), "refused before anything was evaluated"


def test_rows_without_an_input_are_left_out_and_an_index_is_no_output(railsearch, own):
    """Rows that lack an input count as failed; columns without a name, or with the name that pandas gives an index, go."""
    lines = (own / "own.csv").read_text(encoding="utf-8").splitlines()
    rows = [line.split(",") for line in lines[1:]]
    rows[4][1], rows[7][0] = "", ""
    text = ["," + lines[0] + ",__index_level_0__", *(f"{k}," + ",".join(row) + f",{k}" for k, row in enumerate(rows))]
    (own / "index.csv").write_text("\n".join(text), encoding="utf-8")
    words = ("--data", own / "index.csv", "--distributions", own / "inputs.toml", "--seed", 1, "--points", 5)
    answer = railsearch("sensitivity", *words, "--out", own / "study", "--criterion", "y,y", "--json")
    assert answer.code == 0, answer.err
    (criterion,) = json.loads(answer.out)["criteria"]
    assert "no distribution: y\n" in answer.err
    assert (criterion["samples"]["used"], criterion["samples"]["failed"]) == (118, 2)
