"""What is asked of the model itself: its values at a surrogate's extremes, Sobol' indices and elementary effects."""

import json

import numpy as np
import pytest

from railsearch.design_problem import DesignProblem
from railsearch.distributions import random_vector
from railsearch.errors import InputError
from railsearch.interfaces import Outcome, Quantity
from railsearch.plugin_manager import load_plugins
from railsearch.run import MemoryRecord
from railsearch.samples import Experiment, MeasureDesign, Samples, designs_of, evaluate_samples
from railsearch.sensitivity.screening import elementary_effects
from railsearch.sensitivity.variance_based import closed_form_indices, sobol_indices
from railsearch.sensitivity_study import (
    ModelSamples,
    StudyData,
    StudySettings,
    StudyWatcher,
    confirm,
    study_document,
    study_samples,
)
from railsearch.simulation import simulators
from railsearch.space import Space, Variable
from railsearch_plugins.polynomial_chaos.estimator import PolynomialChaosRegressor

SPACE = Space((Variable("a", -1.0, 3.0, "m"), Variable("b", 0.0, 2.0, "N")))
INPUTS = random_vector({v.name: {"distribution": "uniform", "lower": v.lower, "upper": v.upper} for v in SPACE.variables})
MAXIMISED = Quantity("y", "kN", maximised=True)


class Product(DesignProblem):
    """y = a b + a, maximised; fails where a and b are both above a limit."""

    def __init__(self, limit=np.inf, offset=0.0):
        super().__init__("product", SPACE, [MAXIMISED])
        self.limit, self.offset = limit, offset

    def simulate(self, design):
        if min(design) > self.limit:
            raise RuntimeError("too much of both")
        # The objective is stored negated: it is maximised.
        return Outcome(-np.array([design[0] * design[1] + design[0] + self.offset * (min(design) > 1.9)]))


def values_at(points):
    return points[:, 0] * points[:, 1] + points[:, 0]


def measured(problem, design, count):
    """Samples of a problem at the points of a design of measures."""
    experiment = Experiment(design, design.number(count, SPACE.dimension), 5)
    evaluations = evaluate_samples(problem, experiment, MemoryRecord(), lambda evaluation: None, simulators(problem))
    points = np.array([evaluation.design for evaluation in evaluations])
    values = -np.array([evaluation.objectives[0] for evaluation in evaluations])
    columns = dict(zip(SPACE.names, points.T, strict=True))
    return Samples("memory", columns, {"y": values}, {}, {"y": "kN"}, tuple(e.reason or "" for e in evaluations))


def studied(problem, model=None, **settings):
    points = INPUTS.from_uniform(np.random.default_rng(1).random((60, 2)))
    columns = dict(zip(SPACE.names, points.T, strict=True))
    samples = Samples("memory", columns, {"y": values_at(points)}, {}, {"y": "kN"}, ("",) * 60)
    bounds = {variable.name: (variable.lower, variable.upper) for variable in SPACE.variables}
    data = StudyData("product", INPUTS, {}, bounds, samples, {"y": MAXIMISED}, ("y",))
    asked = StudySettings(points=11, **settings)
    studies = study_samples(load_plugins(), data, asked, StudyWatcher(), model)
    return data, asked, confirm(studies, problem, simulators(problem))


def test_extremes_are_confirmed_with_their_natural_sign():
    """On a ∈ [−1, 3], b ∈ [0, 2]: the largest a b + a is 9 at (3, 2), the smallest −3 at (−1, 2)."""
    data, asked, (study,) = studied(Product())
    for sense, value, point in (("maximum", 9.0, [3.0, 2.0]), ("minimum", -3.0, [-1.0, 2.0])):
        confirmed = study.confirmed[sense]
        assert (confirmed.found, confirmed.simulated) == (pytest.approx(value), pytest.approx(value))
        np.testing.assert_allclose(confirmed.point, point)
    assert study.warnings == []
    (criterion,) = study_document(data, asked, [study], "test")["criteria"]
    assert criterion["confirmed"]["maximum"]["point"] == {"a": 3.0, "b": 2.0}
    assert criterion["samples"]["maximum"] < 9.0
    json.dumps(criterion, allow_nan=False)


def test_a_model_that_differs_or_fails_at_the_extreme_is_a_warning():
    """The samples do not show the corner; the model has another value there, or none."""
    study = studied(Product(offset=4.0))[2][0]
    (warning,) = study.warnings
    assert "has its maximum, 9, the model has 13 kN" in warning
    study = studied(Product(limit=1.9))[2][0]
    (warning,) = study.warnings
    assert "has its maximum the model fails: RuntimeError: too much of both" in warning
    assert study.confirmed["maximum"].document(SPACE.names)["model"] is None
    assert study.confirmed["minimum"].simulated == pytest.approx(-3.0)


def test_extrapolation_that_nothing_confirms_is_a_warning():
    points = 0.5 + 0.1 * np.random.default_rng(2).random((40, 2))
    columns = dict(zip(SPACE.names, points.T, strict=True))
    samples = Samples("memory", columns, {"y": values_at(points)}, {}, {"y": "kN"}, ("",) * 40)
    data = StudyData("product", INPUTS, {}, {}, samples, {"y": MAXIMISED}, ("y",))
    (study,) = study_samples(load_plugins(), data, StudySettings(points=5), StudyWatcher())
    assert any("it extrapolates, and nothing confirms it" in warning for warning in study.warnings)
    (study,) = confirm([study], Product(), simulators(Product()))
    assert study.warnings == []


def test_samples_outside_the_ranges_that_exceed_the_extremes_are_said():
    """Searched is a ∈ [−1, 1] only; samples with a up to 3 have larger values than any in there."""
    points = INPUTS.from_uniform(np.random.default_rng(1).random((60, 2)))
    columns = dict(zip(SPACE.names, points.T, strict=True))
    samples = Samples("memory", columns, {"y": values_at(points)}, {}, {"y": "kN"}, ("",) * 60)
    data = StudyData("product", INPUTS, {}, {"a": (-1.0, 1.0)}, samples, {"y": MAXIMISED}, ("y",), whole=("b",))
    (study,) = study_samples(load_plugins(), data, StudySettings(points=5), StudyWatcher())
    outside = int((points[:, 0] > 1.0).sum())
    assert study.document()["samples"]["outside"] == outside > 0
    first, second = study.warnings
    assert f"{outside} samples lie outside the ranges that are searched" in first
    assert second.startswith("b: whole numbers, searched as real ones")


def test_measures_from_samples_are_those_of_the_function():
    """The same points and generators: a problem sampled beforehand gives what the function itself gives."""
    problem = Product()
    model = ModelSamples(measured(problem, MeasureDesign.SALTELLI, 64), measured(problem, MeasureDesign.MORRIS, 8))
    assert (model.blocks.number, model.trajectories.number) == (64 * 4, 8 * 3)
    measures = studied(problem, model)[2][0].on_model
    direct = sobol_indices(values_at, INPUTS, 4096, np.random.default_rng(0))
    for kind in ("first", "total"):
        error = np.abs(getattr(measures.sobol, kind) - getattr(direct, kind))
        assert np.all(error < 2.0 * getattr(measures.sobol, f"{kind}_half_width") + 0.01), kind
    # Over its range of 4 m an effect of a is 4 (b + 1), between 4 and 12; b's over 2 N is 2 a, between −2 and 6.
    effects = elementary_effects(values_at, SPACE, 400, np.random.default_rng(0)).mean_absolute
    np.testing.assert_allclose(measures.morris.mean_absolute, effects, rtol=0.35)
    assert measures.sobol.evaluations == 256
    assert not measures.document()["sobol"]["closed_form"]


def test_blocks_and_trajectories_that_lack_a_value_are_dropped():
    problem = Product(limit=1.5)
    model = ModelSamples(measured(problem, MeasureDesign.SALTELLI, 64), measured(problem, MeasureDesign.MORRIS, 16))
    failed = sum(bool(reason) for reason in model.blocks.reasons)
    assert failed > 0
    measures = studied(Product(), model)[2][0].on_model
    assert 0 < measures.sobol.dropped <= failed
    assert measures.morris.dropped > 0


def test_designs_of_measures_are_the_same_for_the_same_seed_and_refuse_other_numbers():
    for design in MeasureDesign:
        experiment = Experiment(design, design.number(16, 2), 3)
        designs = designs_of(Product(), experiment)
        assert designs.shape == (design.number(16, 2), 2)
        np.testing.assert_array_equal(designs, designs_of(Product(), experiment))
    with pytest.raises(InputError, match="a power of two from 2 is needed"):
        designs_of(Product(), Experiment(MeasureDesign.SALTELLI, MeasureDesign.SALTELLI.number(12, 2), 3))


def test_indices_of_an_expansion_need_no_estimate():
    """A b + a is a polynomial: its indices in closed form are those of Saltelli's estimate, to the width of that."""
    points = INPUTS.from_uniform(np.random.default_rng(4).random((50, 2)))
    expansion = PolynomialChaosRegressor(inputs=INPUTS).fit(points, values_at(points)).expansion_
    exact, estimated = (
        closed_form_indices(SPACE.names, expansion),
        sobol_indices(values_at, INPUTS, 8192, np.random.default_rng(5)),
    )
    # Var(a) = 4/3, Var(b) = 1/3, means 1 and 1: V_a = 4 · 4/3, V_b = 1/3, V_ab = 4/3 · 1/3.
    parts = np.array([16.0 / 3.0, 1.0 / 3.0, 4.0 / 9.0])
    np.testing.assert_allclose(exact.first, parts[:2] / parts.sum(), rtol=1e-10)
    np.testing.assert_allclose(exact.total, (parts[:2] + parts[2]) / parts.sum(), rtol=1e-10)
    assert np.all(np.abs(exact.total - estimated.total) < 2.0 * estimated.total_half_width)
    assert exact.document()["closed_form"]


def test_command_confirms_refits_and_measures_on_the_model(railsearch, tmp_path):
    words = ("sensitivity", "truss", "--samples", 100, "--seed", 3, "--points", 5, "--out", tmp_path / "study")
    answer = railsearch(*words, "--refits", 4, "--on-model", 8, "--json")
    assert answer.code == 0, answer.err
    (criterion,) = json.loads(answer.out)["criteria"]
    assert criterion["sobol"]["closed_form"]
    for confirmed in criterion["confirmed"].values():
        assert confirmed["model"] == pytest.approx(confirmed["surrogate"], rel=0.05)
    assert criterion["spread"]["refits"] == 4
    assert "4/4 refits" in answer.err
    assert answer.err.count(" refits") == 1
    for row in criterion["spread"]["factors"]:
        assert row["lower"] <= row["median"] <= row["upper"]
    measures = criterion["on_model"]
    assert (measures["sobol"]["evaluations"], measures["morris"]["evaluations"]) == (8 * 12, 8 * 11)
    page = (tmp_path / "study" / "report.html").read_text(encoding="utf-8")
    for words_of_page in ("95% of 4 refits", "Sobol&#x27; total, model", "variance, on the model itself"):
        assert words_of_page in page
    again = railsearch(*words, "--on-model", 8, "--no-confirm")
    assert again.code == 0, again.err
    assert again.err.count("nothing is evaluated") == 3
    assert "of the problem there" not in again.out


def test_data_of_ones_own_have_no_model_to_ask(railsearch, tmp_path):
    (tmp_path / "own.csv").write_text("a,y\n" + "".join(f"{k},{k * k}\n" for k in range(20)), encoding="utf-8")
    (tmp_path / "inputs.toml").write_text(
        '[distributions.a]\ndistribution = "uniform"\nlower = 0.0\nupper = 20.0\n', encoding="utf-8"
    )
    words = ("--data", tmp_path / "own.csv", "--distributions", tmp_path / "inputs.toml", "--on-model", 4)
    answer = railsearch("sensitivity", *words)
    assert answer.code == 2
    assert "--on-model: data of your own have no model" in answer.err
