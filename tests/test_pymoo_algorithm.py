import numpy as np
import pytest
from pymoo.algorithms.soo.nonconvex.ga import GA
from pymoo.core.problem import Problem
from pymoo.core.variable import Integer, Real
from pymoo.optimize import minimize
from pymoo.problems import get_problem

import railsearch
from railsearch.errors import CapabilityError, InputError, PluginError
from railsearch.interfaces import Outcome, Quantity
from railsearch.plugin_manager import load_plugins
from railsearch.run import RunSettings, run_search
from railsearch_plugins.strategies.dycors import DynamicCoordinateSearch
from registered_strategies import SMALL_SETTINGS, every_strategy, small_budget
from sample_problems import Sphere, Troubled, TwoObjectives


def evaluated(result):
    """All designs of a run under pymoo, in order."""
    return np.vstack([entry.off.get("X") for entry in result.history])


@every_strategy
def test_under_pymoo_a_strategy_proposes_what_it_proposes_in_a_run(entry):
    strategy, budget, settings = entry.name, small_budget(entry.name), SMALL_SETTINGS.get(entry.name, {})
    for problem in (Sphere(), TwoObjectives()) if entry.plugin.capabilities.multi_objective else (Sphere(),):
        given = [np.array([1.5, 1.0, 0.0, 0.0])]
        run = run_search(load_plugins(), problem, RunSettings(strategy, budget, 3, settings), given)
        algorithm = railsearch.algorithm(strategy, budget, settings, given)
        result = minimize(problem, algorithm, seed=3, save_history=True)
        assert np.array_equal(evaluated(result), np.array([evaluation.design for evaluation in run.evaluations]))
        best = np.min([evaluation.objectives for evaluation in run.evaluations], axis=0)
        assert np.array_equal(np.min(np.atleast_2d(result.F), axis=0), best)


@pytest.mark.parametrize("strategy", ["dycors", "nsga2"])
def test_the_budget_is_exact_on_any_pymoo_problem(strategy):
    problem = get_problem("zdt1", n_var=6) if strategy == "nsga2" else get_problem("ackley", n_var=5)
    result = minimize(problem, railsearch.algorithm(strategy, 53), seed=1)
    assert result.algorithm.evaluator.n_eval == 53


@pytest.mark.parametrize(("termination", "spent"), [(("n_eval", 500), 25), (("n_gen", 900), 25), (("n_eval", 22), 22)])
def test_a_termination_of_ones_own_may_be_longer_or_shorter_than_the_budget(termination, spent):
    result = minimize(get_problem("sphere", n_var=3), railsearch.algorithm("dycors", 25), termination, seed=1)
    assert result.algorithm.evaluator.n_eval == spent
    assert np.isfinite(result.F).all()


def test_a_strategy_class_is_as_good_as_a_name():
    found = [
        minimize(Sphere(), railsearch.algorithm(dycors, 30), seed=1).F for dycors in ("dycors", DynamicCoordinateSearch)
    ]
    assert np.array_equal(*found)
    with pytest.raises(PluginError, match="Quantity"):
        railsearch.algorithm(Quantity, 30)


def test_dycors_under_pymoo_solves_a_sphere():
    result = minimize(get_problem("sphere", n_var=5), railsearch.algorithm("dycors", 60), seed=1)
    assert result.F[0] < 1e-3


def test_a_pymoo_problem_of_integers_is_searched_in_whole_numbers():
    class Steps(Problem):
        def __init__(self):
            super().__init__(n_var=3, n_obj=1, xl=-4, xu=5, vtype=int)

        def _evaluate(self, x, out, *args, **kwargs):
            assert x.dtype.kind == "i"
            out["F"] = ((x - np.array([1, -2, 3])) ** 2).sum(axis=1)

    told = []

    class Watched(DynamicCoordinateSearch):
        def tell(self, evaluations):
            told.extend(evaluation.design for evaluation in evaluations)
            super().tell(evaluations)

    result = minimize(Steps(), railsearch.algorithm(Watched, 40), seed=1)
    assert np.array_equal(told, np.round(told))
    assert result.F[0] == 0.0
    assert result.X.tolist() == [1, -2, 3]


def test_constraints_are_kept_under_pymoo():
    result = minimize(TwoObjectives(constrained=True), railsearch.algorithm("nsga2", 120), seed=1)
    assert len(result.X) > 3
    assert np.all(result.X[:, 0] >= 0.5)


def test_values_that_are_not_finite_are_told_as_failures():
    class Holed(Troubled):
        def simulate(self, design):
            return Outcome(np.array([np.nan])) if design[2] < 0 else Sphere.simulate(self, design)

    result = minimize(Holed(), railsearch.algorithm("dycors", 30), seed=1)
    assert result.algorithm.evaluator.n_eval == 30
    assert np.isfinite(result.F).all()


def test_what_cannot_be_done_is_refused():
    with pytest.raises(PluginError, match="unknown strategy 'dycor'"):
        railsearch.algorithm("dycor", 30)
    for strange in (GA(), None, ["ga"]):
        with pytest.raises(PluginError, match="the name of one, or a class, is needed, received"):
            railsearch.algorithm(strange, 30)
    with pytest.raises(InputError, match="strategy ga: a table of names and values is needed, received 'a'"):
        minimize(Sphere(), railsearch.algorithm("ga", 30, settings="a"), seed=1)
    with pytest.raises(InputError, match=r"parameters: a table of names and values is needed, received \[1\]"):
        railsearch.problem("ackley", sections=[1])
    with pytest.raises(InputError, match="at least 20"):
        minimize(Sphere(), railsearch.algorithm("dycors", 19), seed=1)
    with pytest.raises(CapabilityError, match=r"2 \(left, right\)"):
        minimize(TwoObjectives(), railsearch.algorithm("dycors", 30), seed=1)
    with pytest.raises(CapabilityError, match="equality constraints"):
        minimize(Problem(2, 1, n_eq_constr=1, xl=0.0, xu=1.0), railsearch.algorithm("ga", 30), seed=1)
    with pytest.raises(CapabilityError, match="one by one"):
        minimize(Problem(vars={"x": Real(bounds=(0.0, 1.0)), "n": Integer(bounds=(1, 5))}), railsearch.algorithm("ga", 30))
    with pytest.raises(CapabilityError, match="bounds"):
        minimize(Problem(2, 1), railsearch.algorithm("ga", 30), seed=1)
