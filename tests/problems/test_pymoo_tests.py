"""pymoo's test problems by name: the same values, true optima and fronts, refusals with reasons, the command line."""

import pickle
import urllib.request
from collections.abc import Callable
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pymoo.problems import get_problem

import railsearch
from command_line import Answer
from railsearch.errors import InputError, PluginError
from railsearch.plugin_manager import load_plugins
from railsearch.problem_factory import ProblemSettings, make_problem
from railsearch.sampling import random_designs
from railsearch_problems.pymoo_tests import PymooProblem, PymooTests

REGISTRY = load_plugins()
# Which pymoo itself cannot evaluate or make.
BROKEN = {"clutch", "multiobjectiveknapsack"}
EQUALITIES = {f"g{number}" for number in (3, 5, 13, 14, 15, 17, 20, 21, 22, 23)}
# What was asked of the internet meanwhile.
DOWNLOADS: list[object] = []


@cache
def every() -> dict[str, PymooProblem]:
    """All problems as they are without settings, by name, their fronts known."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(urllib.request, "urlretrieve", lambda *arguments: DOWNLOADS.append(arguments))
        problems = {name: made(name) for name in PymooTests.members()}
        for problem in problems.values():
            problem.pareto_front()
    return problems


def violating(holds: Callable[[PymooProblem], bool], names: Callable[[str], bool] = bool) -> str:
    """The names of the problems that do not have a property."""
    found = []
    for name, problem in every().items():
        try:
            if names(name) and not holds(problem):
                found.append(name)
        except Exception as error:
            error.add_note(f"in the case of {name}")
            raise
    return ", ".join(found)


def made(name: str, **choices: Any) -> PymooProblem:
    problem = make_problem(REGISTRY, ProblemSettings(f"pymoo:{name}", sections={"pymoo": choices}))
    assert isinstance(problem, PymooProblem)
    return problem


def test_nearly_all_of_pymoo_is_there() -> None:
    assert len(every()) > 120
    assert {"zdt1", "dtlz2", "wfg9", "mw14", "g6", "pressurevessel", "zcat20", "dascmop9"} <= set(every())


@pytest.mark.parametrize(
    ("name", "theirs", "choices"),
    [
        ("zdt1", "zdt1", {"n_var": 7}),
        ("DTLZ2", "dtlz2", {"n_var": 6, "n_obj": 4}),
        ("convex_dtlz2", "convex_dtlz2", {}),
        ("dtlz1^-1", "dtlz1^-1", {}),
        ("sdtlz1", "sdtlz1", {"scale_factor": 3.0}),
        ("welded_beam", "welded_beam", {}),
        ("mw4", "mw4", {"n_obj": 4}),
        ("dascmop3", "dascmop3", {"difficulty": 5}),
        ("wfg4", "wfg4", {"n_var": 12, "n_obj": 3, "k": 4}),
        ("zcat3", "zcat3", {"n_var": 10, "bias": True}),
        ("ctp8", "ctp8", {}),
        ("rastrigin", "rastrigin", {"n_var": 5, "A": 3.0}),
    ],
)
def test_values_bounds_and_constraints_are_pymoo_s(name: str, theirs: str, choices: dict[str, Any]) -> None:
    problem, expected = made(name, **choices), get_problem(theirs, **choices)
    assert np.array_equal(problem.space.lower, expected.xl)
    assert np.array_equal(problem.space.upper, expected.xu)
    for design in random_designs(problem.space, 5, np.random.default_rng(1)):
        found, told = problem.simulate(design), expected.evaluate(design, return_as_dictionary=True)
        assert np.array_equal(found.objectives, told["F"])
        assert problem.n_ieq_constr == 0 or np.array_equal(found.constraints, told["G"])


def test_nothing_feasible_dominates_the_stated_front() -> None:
    assert violating(_front_holds, lambda name: not name.startswith("wfg")) == ""


def _front_holds(problem: PymooProblem) -> bool:
    generator = np.random.default_rng(2)
    front, optima = problem.pareto_front(), problem.pareto_set()
    if front is None:
        return optima is None
    designs = random_designs(problem.space, 300, generator)
    if optima is not None:
        if not np.array_equal(problem.space.rounded(optima), optima):
            return False  # Outside the bounds or not whole.
        steps = generator.normal(0.0, 1.0, (300, problem.n_var)) * 10.0 ** generator.uniform(-5.0, -1.0, (300, 1))
        near = optima[generator.integers(len(optima), size=300)] + steps * (problem.space.upper - problem.space.lower)
        designs = np.vstack([designs, problem.space.rounded(near)])
    whole = problem.space.integer.all()
    objectives, constraints = problem.inner.evaluate(designs.astype(int) if whole else designs, return_values_of=["F", "G"])
    feasible = objectives[np.all(constraints <= 0.0, axis=1)]
    margin = 1e-9 * np.maximum(1.0, np.abs(front).max(axis=0))
    return not any(np.any(np.all(values < front - margin, axis=1)) for values in feasible)


def test_the_stated_optimum_is_feasible_and_attained() -> None:
    assert sum(problem.pareto_set() is not None for problem in every().values()) > 25
    assert violating(_optimum_holds) == ""


def _optimum_holds(problem: PymooProblem) -> bool:
    optima = problem.pareto_set()
    outcomes = [problem.simulate(problem.space.checked(design)) for design in ([] if optima is None else optima)]
    # Published optima with active constraints are rounded: SRN's constraint is violated by 1.6e-5, others by less.
    feasible = all(np.all(outcome.constraints <= 2e-5) for outcome in outcomes)
    misses = (np.abs(problem.pareto_front() - outcome.objectives).max(axis=1).min() for outcome in outcomes)
    return feasible and all(miss <= 1e-8 for miss in misses)


def test_the_optimum_of_the_pressure_vessel_is_that_of_whole_plates() -> None:
    """6059.714 with plates in whole sixteenths of an inch (Coello Coello 2002); 5885.33 needs any thickness."""
    problem = made("pressure_vessel")
    assert problem.space.integer.tolist() == [True, True, False, False]
    assert problem.pareto_front()[0, 0] == pytest.approx(6059.714, abs=0.01)


def test_zdt5_has_bits_for_variables() -> None:
    problem = made("zdt5", m=3, n=4)
    assert (problem.n_var, problem.space.integer.all()) == (38, True)
    assert problem.simulate(np.ones(38)).objectives == pytest.approx([1.0, 0.0])


def test_what_differs_from_call_to_call_or_has_to_be_downloaded_is_not_stated() -> None:
    unknown = {name for name, problem in every().items() if problem.pareto_front() is None}
    assert DOWNLOADS == []
    assert {"wfg2", "dtlz7", "tnk", "ctp1", "dascmop1", "zcat1", "mw5"} <= unknown
    assert not {"zdt1", "dtlz1", "mw1", "srn", "c2dtlz2", "truss2d"} & unknown


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("zdt9", "unknown problem 'pymoo:zdt9', did you mean pymoo:zdt"),
        ("qqqq", "unknown problem 'pymoo:qqqq'; `railsearch describe pymoo:NAME` lists"),
        ("NAME", "unknown problem 'pymoo:NAME'"),
        ("", "unknown problem 'pymoo:'"),
        ("df1", "'pymoo:df1' changes with time"),
        ("knapsack", "'pymoo:knapsack' needs n_items and W and P and C, which a file of settings cannot give"),
        ("modact", "'pymoo:modact' needs function"),
    ],
)
def test_names_that_are_unknown_or_need_more_are_refused(name: str, message: str) -> None:
    with pytest.raises(PluginError, match=message):
        made(name)


@pytest.mark.parametrize(
    ("name", "choices", "message"),
    [
        ("g3", {}, "'pymoo:g3': strategies here know inequality .* received 1 equalities"),
        ("zdt1", {"n_vars": 3}, "unknown parameter 'n_vars'; did you mean 'n_var'"),
        ("zdt1", {"n_var": 2.5}, "parameters.pymoo.n_var: an integer is needed"),
        ("zdt1", {"n_var": 0}, "pymoo: ZDT1 of pymoo cannot take {'n_var': 0}"),
        ("wfg1", {"n_obj": 20}, "pymoo: WFG1 of pymoo cannot take"),
        ("wfg4", {"n_var": 3, "n_obj": 3, "k": 4}, "pymoo: WFG4 of pymoo has no finite values"),
        ("dascmop1", {"difficulty": 99}, "DASCMOP1 of pymoo cannot take {'difficulty': 99}"),
        ("multiobjectiveknapsack", {}, "cannot evaluate it: TypeError: .*missing"),
    ],
)
def test_what_pymoo_cannot_take_is_refused(name: str, choices: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        made(name, **choices)


def test_a_problem_that_pymoo_cannot_evaluate_is_named_with_the_reason() -> None:
    with pytest.raises(InputError) as refused:
        made("clutch")
    told = str(refused.value)
    assert told.startswith(f"problem 'pymoo:clutch': pymoo {version('pymoo')} cannot evaluate it: Problem Error: G can not")
    assert "('" not in told


def test_every_listed_name_can_be_made() -> None:
    assert set(PymooTests.members()) == set(every())
    assert not (BROKEN | EQUALITIES) & set(PymooTests.members())


def test_the_objectives_are_the_problem_s_own() -> None:
    assert [objective.name for objective in railsearch.problem("pymoo:zdt1").objectives] == ["f1", "f2"]
    assert [objective.name for objective in railsearch.problem("pymoo:ackley").objectives] == ["f"]
    with pytest.raises(InputError, match="pymoo:ackley always has f, received f1"):
        railsearch.problem("pymoo:ackley", objectives=("f1",))


def test_the_worst_values_of_several_objectives_lie_behind_the_front() -> None:
    """So that hypervolume can be measured from there; rounding to three digits takes less than 1 % of the range."""
    assert sum(problem.n_obj > 1 for problem in every().values()) > 90
    assert violating(_worst_holds) == ""


def _worst_holds(problem: PymooProblem) -> bool:
    front, worst = problem.pareto_front(), np.array(list(problem.worst.values()))
    if problem.n_obj == 1:
        return not worst.size
    if list(problem.worst) != [objective.name for objective in problem.objectives] or not np.isfinite(worst).all():
        return False
    return front is None or bool(
        np.all(worst - front.max(axis=0) >= -0.01 * np.ptp(front, axis=0)) and np.all(worst > front.min(axis=0))
    )


def test_a_problem_travels_to_another_process() -> None:
    for name in ("zdt1", "c1dtlz1", "zcat1", "wfg1"):
        problem = made(name)
        design = random_designs(problem.space, 1, np.random.default_rng(3))[0]
        there = pickle.loads(pickle.dumps(problem)).simulate(design)
        assert np.array_equal(there.objectives, problem.simulate(design).objectives)


def test_a_test_problem_is_searched_and_described_like_any_other(railsearch: Callable[..., Answer], tmp_path: Path) -> None:
    site = tmp_path / "site.toml"
    site.write_text('problem = "pymoo:zdt5"\n[pymoo]\nm = 3\n')
    words = ("--strategy", "nsga2", "--budget", 12, "--seed", 1, "-p", site, "--out", tmp_path / "run")
    answer = railsearch("run", "pymoo:zdt5", *words)
    assert (answer.code, "12 of 12 evaluations" in answer.out) == (0, True), answer.err
    described = railsearch("describe", "pymoo:zdt5").out
    assert all(word in described for word in ("ZDT5", "pymoo.m", "pymoo.normalize", "x80", "f2")), described
    family = railsearch("describe", "pymoo:NAME").out
    assert all(word in family for word in ("in place of NAME", "zdt1", "c2dtlz2"))
    assert "pymoo:NAME" in railsearch("list", "problem").out
    assert railsearch("init", "pymoo:zdt5").out.startswith("# A site for the problem pymoo:zdt5.")


def test_a_campaign_takes_test_problems_by_name(railsearch: Callable[..., Answer], tmp_path: Path) -> None:
    """The front that pymoo states is the one beside which fronts are measured."""
    text = (
        '[campaign]\nbudget = 6\nrepetitions = 1\nseed = 1\nproblems = ["pymoo:zdt1", "pymoo:g6"]\nstrategies = ["random"]\n'
    )
    (tmp_path / "tests.toml").write_text(text)
    answer = railsearch("campaign", tmp_path / "tests.toml", "--out", tmp_path / "out")
    assert answer.code == 0, answer.err
    report = (tmp_path / "out" / "report.html").read_text()
    assert "Distance from the known front" in report
    (tmp_path / "tests.toml").write_text(text.replace("zdt1", "zdt11"))
    refused = railsearch("campaign", tmp_path / "tests.toml", "--out", tmp_path / "other")
    assert (refused.code, "unknown problem 'pymoo:zdt11', did you mean" in refused.err) == (2, True)
