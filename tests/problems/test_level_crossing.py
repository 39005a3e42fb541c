"""Design problem A, under railsearch and under plain pymoo."""

import dataclasses
import pickle

import numpy as np
import pytest
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.algorithms.soo.nonconvex.ga import GA
from pymoo.core.mixed import MixedVariableGA
from pymoo.operators.survival.rank_and_crowding import RankAndCrowding
from pymoo.optimize import minimize

import railsearch
from railsearch.design_problem import DesignProblem
from railsearch.errors import InputError
from railsearch.interfaces import Evaluation
from railsearch.plugin_manager import load_plugins
from railsearch.problem_factory import ProblemSettings, make_problem
from railsearch.result import improvement, reference_evaluation
from railsearch.run import RunSettings, best, run_search

SHORT = {"track": {"geometry": {"total_length": 60.0, "approach_length": 30.0}}}


@pytest.fixture(scope="module")
def problem() -> DesignProblem:
    return railsearch.problem("level-crossing")


@pytest.fixture(scope="module")
def short() -> DesignProblem:
    """The same on a short track, which is simulated sooner."""
    return railsearch.problem("level-crossing", sections=SHORT)


def test_the_design_becomes_the_zone_in_si_units(problem: DesignProblem) -> None:
    zone = problem.parameters(np.array([214.0, 155.0, 50.0, 5, 6, 7, 3, 53])).zone  # type: ignore[attr-defined]
    assert zone.pad_stiffness == (214e6, 155e6, 50e6)
    assert zone.sleeper_distances == (0.6, 0.7, 0.3)
    assert (zone.strengthened_sleepers, zone.type_2_strip_length) == (5, 5.3)


def test_the_reference_design_is_the_zone_of_the_site() -> None:
    site = {"track": {"zone": {"pad_stiffness": [3e8, 2e8, 1e8], "strengthened_sleepers": 2, "type_2_strip_length": 1.2}}}
    assert railsearch.problem("level-crossing", sections=site).reference.tolist() == [300, 200, 100, 2, 6, 6, 4, 12]


@pytest.mark.parametrize("names", [("F_rms",), ("E_max",), ("E_rms", "F_max"), ("F_rms", "F_max", "E_rms", "E_max")])
def test_any_choice_of_objectives(names: tuple[str, ...]) -> None:
    problem = railsearch.problem("level-crossing", objectives=names)
    outcome = problem.simulate(problem.reference)
    assert outcome.objectives.tolist() == [outcome.metrics[name] for name in names]
    assert set(outcome.metrics) == {"F_rms", "F_max", "E_rms", "E_max", "A_max"}


def test_objectives_are_named_once() -> None:
    with pytest.raises(InputError, match="each may be named once"):
        railsearch.problem("level-crossing", objectives=("F_max", "F_max"))


def test_the_problem_travels_to_another_process(problem: DesignProblem) -> None:
    there = pickle.loads(pickle.dumps(problem))
    assert np.array_equal(there.simulate(problem.reference).objectives, problem.simulate(problem.reference).objectives)


def test_plain_pymoo_nsga2(short: DesignProblem) -> None:
    result = minimize(short, NSGA2(pop_size=8), ("n_eval", 16), seed=1, save_history=True)
    population = result.history[0].pop
    for individual in population[:3]:
        outcome = short.simulate(short.space.rounded(individual.X))
        assert np.array_equal(individual.F, outcome.objectives)
        assert individual.get("A_max") == outcome.metrics["A_max"]


def test_plain_pymoo_ga_on_one_objective() -> None:
    problem = railsearch.problem("level-crossing", objectives=("F_max",), sections=SHORT)
    result = minimize(problem, GA(pop_size=6), ("n_eval", 12), seed=1)
    assert result.F[0] == problem.simulate(problem.space.rounded(result.X)).objectives[0]


def test_plain_pymoo_mixed_variables(short: DesignProblem) -> None:
    algorithm = MixedVariableGA(pop_size=6, survival=RankAndCrowding())
    result = minimize(short, algorithm, ("n_eval", 12), seed=1)
    for named, values in zip(np.atleast_1d(result.X), np.atleast_2d(result.F), strict=True):
        assert set(named) == set(short.space.names)
        assert all(named[name] == int(named[name]) for name in ("xn", "xs1", "xs2", "xs3", "xl"))
        design = np.array([named[name] for name in short.space.names], dtype=float)
        assert np.array_equal(values, short.simulate(design).objectives)


def test_plain_pymoo_on_the_scalarised_problem() -> None:
    problem = railsearch.problem("level-crossing", scalariser="asf", sections=SHORT)
    result = minimize(problem, GA(pop_size=6), ("n_eval", 12), seed=1, save_history=True)
    individual = result.history[0].pop[0]
    aspiration = 0.8 * problem.simulate(problem.reference).objectives
    weights = 1.0 / (np.array([6000.0, 1.5]) - aspiration)
    achieved = weights * (np.array([individual.get("F_max"), individual.get("E_max")]) - aspiration)
    assert individual.F[0] == pytest.approx(achieved.max() + 0.05 * achieved.sum(), rel=1e-12)


def test_a_search_improves_force_and_ballast_damage_in_one_design() -> None:
    """Published: 47 % and 48 % with 400 evaluations; asked for here at 90: 20 % and 45 % in one design."""
    registry = load_plugins()
    problem = make_problem(registry, ProblemSettings("level-crossing", scalariser="asf"))
    result = run_search(registry, problem, RunSettings("dycors", 90, 1), [problem.reference])
    found = best(result.evaluations)
    assert isinstance(found, Evaluation)
    gain = improvement(problem, reference_evaluation(problem, result.evaluations), found)
    assert gain["F_max"] >= 20.0
    assert gain["E_max"] >= 45.0
    again = problem.simulate(found.design)
    assert dataclasses.asdict(found)["metrics"]["F_max"] == again.metrics["F_max"]
