"""The one-shot path: what is modelled, how far off it is, what is chosen, and what is confirmed."""

from collections import Counter
from functools import partial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymoo.optimize import minimize

from railsearch.design_problem import DesignProblem, ScalarisedProblem
from railsearch.errors import InputError
from railsearch.interfaces import Outcome, Quantity
from railsearch.parameters import make_parameters
from railsearch.plugin_manager import load_plugins
from railsearch.pymoo_algorithm import StrategyAlgorithm
from railsearch.run import RunSettings, best, run_search
from railsearch.space import Space, Variable
from railsearch_plugins.strategies.fixed_surrogate import FixedSurrogateParameters, FixedSurrogateSearch
from railsearch_plugins.surrogate_search.validation import chosen_surrogate, predictivity, relative_error, split_rows

REGISTRY = load_plugins()
QUICK = {"surrogates": ["rbf"], "population_size": 20, "generations": 30, "further_generations": 10}


class DampingAndPrice(DesignProblem):
    """A wavy response that is simulated, and a price that jumps with an integer and is known without a simulation."""

    def __init__(self):
        variables = (Variable("x", -1.0, 3.0), Variable("y", 0.0, 10.0), Variable("k", 0.0, 6.0, integer=True))
        super().__init__("damping-and-price", Space(variables), [Quantity("price", "€"), Quantity("damping", "N·s/m")])

    @property
    def exact_objectives(self):
        return {"price": lambda designs: 10.0 * (designs[:, 2] % 3.0) + designs[:, 1]}

    def simulate(self, design):
        x, y, k = design
        damping = 3.0 + (x - 1.2) ** 2 + 0.1 * (y - 4.0) ** 2 + 0.05 * (k - 2.0) ** 2
        return Outcome(np.array([self.exact_objectives["price"](design[None, :])[0], damping]))


class Sum:
    """A scalariser: the sum of all objectives."""

    ready = True
    values = {}  # noqa: RUF012 - part of the contract

    def __call__(self, objectives):
        return objectives.sum(axis=1)


def search(problem, budget, settings=None, batch_size=1):
    return run_search(
        REGISTRY, problem, RunSettings("fixed-surrogate", budget, 4, {**QUICK, **(settings or {})}, batch_size)
    )


def test_only_what_must_be_simulated_is_a_response_and_the_objectives_follow_from_it():
    for problem in (DampingAndPrice(), ScalarisedProblem(DampingAndPrice(), "sum", Sum())):
        evaluations = run_search(REGISTRY, problem, RunSettings("random", 12, 1)).evaluations
        responses = problem.responses
        assert [quantity.name for quantity in responses.quantities] == ["damping"]
        values = np.array([responses.values(evaluation) for evaluation in evaluations])
        assert values.shape == (12, 1)
        designs, objectives = (np.array([getattr(e, name) for e in evaluations]) for name in ("design", "objectives"))
        np.testing.assert_array_equal(responses.objectives(designs, values), objectives)


def test_the_cost_of_a_crossing_is_exact():
    from railsearch.problem_factory import ProblemSettings, make_problem

    problem = make_problem(REGISTRY, ProblemSettings("level-crossing-preference"))
    assert [quantity.name for quantity in problem.responses.quantities] == ["E_max", "A_max"]
    designs = np.array([[13.0, 6.0, 78.0, 78.0, 78.0, 0.0], [10.0, 15.0, 78.0, 78.0, 78.0, 0.0]])
    predicted = np.array([[0.5, 0.1], [0.6, 0.2]])
    expected = np.column_stack([predicted, [9967.7, 12413.0]])
    np.testing.assert_allclose(problem.responses.objectives(designs, predicted), expected, rtol=1e-12)


def test_the_optimum_of_the_scalar_is_found_and_confirmed_although_the_price_jumps():
    problem = ScalarisedProblem(DampingAndPrice(), "sum", Sum())
    result = search(problem, 60)
    assert Counter(evaluation.origin for evaluation in result.evaluations) == {"initial": 54, "confirmation": 6}
    found = best(result.evaluations)
    assert found.origin == "confirmation"
    # At k = 3 and k = 0 the price has no jump; d/dy: 1 + 0.2 (y − 4) = 0 at y = −1, below the bound; x = 1.2.
    lowest = problem.base.simulate(np.array([1.2, 0.0, 3.0])).objectives.sum()
    assert found.objectives[0] < lowest + 0.01
    assert len({problem.space.key(evaluation.design) for evaluation in result.evaluations}) == 60


def test_without_the_exact_price_its_jumps_mislead_the_surrogate():
    class AllSimulated(DampingAndPrice):
        exact_objectives = {}  # noqa: RUF012 - nothing is exact

        def simulate(self, design):
            return DampingAndPrice().simulate(design)

    def lowest(problem):
        return best(search(ScalarisedProblem(problem, "sum", Sum()), 40).evaluations).objectives[0]

    assert lowest(DampingAndPrice()) < lowest(AllSimulated())


def test_several_starts_find_the_basin_of_another_integer(monkeypatch):
    """Each of 40 whole numbers has a bowl of its own; the surrogate is the truth."""
    depth, x, y = np.random.default_rng(3).random((3, 40))

    def bowls(search, designs):
        k = designs[:, 2].astype(int)
        return (100.0 * ((designs[:, 0] - x[k]) ** 2 + (designs[:, 1] - y[k]) ** 2) + depth[k])[:, None]

    class Bowls(DesignProblem):
        def __init__(self):
            variables = (Variable("x", 0.0, 1.0), Variable("y", 0.0, 1.0), Variable("k", 0.0, 39.0, integer=True))
            super().__init__("bowls", Space(variables), [Quantity("f")])

        def simulate(self, design):
            return Outcome(bowls(None, design[None, :])[0])

    monkeypatch.setattr(FixedSurrogateSearch, "_predicted", bowls)

    def shortfall(starts, seed):
        settings = {**QUICK, "starts": starts, "population_size": 10}
        found = run_search(REGISTRY, Bowls(), RunSettings("fixed-surrogate", 63, seed, settings)).evaluations
        return min(evaluation.objectives[0] for evaluation in found[60:]) - depth.min()

    shortfalls = [np.mean([shortfall(starts, seed) for seed in range(8)]) for starts in (1, 6)]
    assert shortfalls[1] < 0.6 * shortfalls[0]


def test_several_objectives_are_confirmed_along_the_front_in_batches():
    result = search(DampingAndPrice(), 60, {"design_size": 45}, batch_size=5)
    confirmed = np.array([e.objectives for e in result.evaluations if e.origin == "confirmation"])
    initial = np.array([e.objectives for e in result.evaluations if e.origin == "initial"])
    assert len(confirmed) == 15
    beaten = (confirmed[None] <= initial[:, None]).all(axis=2).any(axis=1)
    assert beaten.mean() > 0.9


def test_surrogates_that_learn_no_confirmations_stay_as_they_are():
    result = search(DampingAndPrice(), 40, {"learn_confirmations": False})
    assert Counter(evaluation.origin for evaluation in result.evaluations)["confirmation"] == 4


def test_findings_are_the_errors_of_the_responses_and_reach_the_result():
    from railsearch.commands.tables import result_tables
    from railsearch.report.page import report_page
    from railsearch.result import RunCommand, result_document

    problem = ScalarisedProblem(DampingAndPrice(), "sum", Sum())
    result = search(problem, 60)
    assert [finding.name for finding in result.findings] == [
        "damping: error in validation",
        "damping: generalisation error",
        "damping: predictivity Q²",
    ]
    assert 0.0 < result.findings[1].value < 5.0
    assert 0.9 < result.findings[2].value < 1.0
    identity = {
        "problem": "p",
        "sections": {},
        "strategy": {"name": "fixed-surrogate", "settings": {}},
        "scalariser": None,
        "budget": 60,
        "seed": 4,
    }
    document = result_document(REGISTRY, problem, RunCommand("railsearch run", identity), result)
    assert document["findings"][1]["unit"] == "%"
    assert result_tables(document)[-1].row_count == 3
    assert "generalisation error [%]" in report_page(document, {})


def wavy(points):
    return 2.0 + np.sin(5.0 * points[:, 0]) * points[:, 1] + points[:, 2] ** 2


def test_the_error_on_the_test_set_is_that_of_a_large_fresh_sample():
    generator = np.random.default_rng(7)
    points, fresh = generator.random((250, 3)), generator.random((20000, 3))
    split = split_rows(250, 0.16, 0.2, generator)
    chosen = chosen_surrogate({"rbf": partial(REGISTRY.surrogate, "rbf", 3, {})}, points, wavy(points), split)
    errors = np.abs(chosen.surrogate.predict(fresh) - wavy(fresh)) / np.abs(wavy(fresh)).mean() * 100.0
    assert abs(chosen.test_error - errors.mean()) < 4.0 * errors.std() / np.sqrt(len(split.test))
    assert chosen.predictivity > 0.99


class Mean:
    """Predicts the mean of what it was fitted to."""

    def fit(self, points, values):
        self.mean = values.mean()

    def predict(self, points):
        return np.full(len(points), self.mean)


@pytest.mark.parametrize("order", [("mean", "rbf"), ("rbf", "mean")])
def test_the_surrogate_of_least_error_in_validation_is_chosen(order):
    points = np.random.default_rng(8).random((100, 3))
    makes = {"mean": Mean, "rbf": partial(REGISTRY.surrogate, "rbf", 3, {})}
    split = split_rows(100, 0.16, 0.2, np.random.default_rng(1))
    chosen = chosen_surrogate({name: makes[name] for name in order}, points, wavy(points), split)
    assert chosen.name == "rbf"
    assert chosen.validation_error == relative_error(
        chosen.surrogate.predict(points[split.validation]), wavy(points[split.validation])
    )


def test_surrogates_that_cannot_be_fitted_are_left_out():
    points = np.random.default_rng(8).random((5, 3))
    split = split_rows(5, 0.2, 0.2, np.random.default_rng(1))
    rbf = partial(REGISTRY.surrogate, "rbf", 3, {})
    assert chosen_surrogate({"rbf": rbf}, points, wavy(points), split) is None
    assert chosen_surrogate({"rbf": rbf, "mean": Mean}, points, wavy(points), split).name == "mean"


def test_under_plain_pymoo_the_responses_behind_the_scalar_are_known_too():
    problem = ScalarisedProblem(DampingAndPrice(), "sum", Sum())
    found = minimize(problem, StrategyAlgorithm(REGISTRY, "fixed-surrogate", 30, QUICK), seed=4)
    evaluations = search(problem, 30).evaluations
    np.testing.assert_array_equal(found.pop.get("X"), np.array([e.design for e in evaluations]))


@given(st.integers(0, 300), st.integers(0, 2**20))
def test_a_split_divides_all_rows(n, seed):
    split = split_rows(n, 0.16, 0.2, np.random.default_rng(seed))
    assert sorted([*split.training, *split.validation, *split.test]) == list(range(n))
    assert abs(len(split.training) - 0.64 * n) <= 1.0
    assert abs(len(split.validation) - 0.16 * n) <= 0.5


def test_predictivity_of_the_mean_is_nought_and_of_the_truth_one():
    values = np.array([1.0, 4.0, 2.0])
    assert predictivity(np.full(3, values.mean()), values) == 0.0
    assert predictivity(values, values) == 1.0
    assert np.isnan(predictivity(np.ones(3), np.ones(3)))
    assert np.isnan(relative_error(np.ones(0), np.ones(0)))


def test_relative_error_is_in_per_cent_of_the_mean_size():
    assert relative_error(np.array([1.0, -3.0]), np.array([2.0, -2.0])) == pytest.approx(50.0)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"surrogates": []}, "surrogates: one or more names are needed"),
        ({"surrogate_settings": {"pce": {}}}, r"surrogate_settings: pce not among the surrogates \(kriging, rbf\)"),
    ],
)
def test_bad_settings_are_refused(settings, message):
    with pytest.raises(InputError, match=message):
        make_parameters(FixedSurrogateParameters, settings, "strategy fixed-surrogate")


def test_a_design_without_a_confirmation_is_refused():
    with pytest.raises(InputError, match="fixed-surrogate needs at least 41 evaluations"):
        search(DampingAndPrice(), 40, {"design_size": 40})
