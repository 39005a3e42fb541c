"""The analytic problems: what they state of their optimum holds, and their formulas agree with pymoo's."""

import itertools
import pickle
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from pymoo.problems import get_problem

import railsearch
from conftest import Answer
from railsearch.errors import InputError
from railsearch.sampling import random_designs
from railsearch_problems.analytic import AnalyticProblem, FunctionParameters, TwoSpheres

FUNCTIONS = ("sphere", "ackley", "rastrigin", "rosenbrock")
EVERY = (*FUNCTIONS, "two-spheres")
CHOICES = [
    {"dimension": dimension, "integers": integers, "shift": shift}
    for (dimension, integers), shift in itertools.product([(2, 1), (13, 0), (10, 5)], [0.0, 0.3, 0.8])
]


def made(name: str, **choices: Any) -> AnalyticProblem:
    problem = railsearch.problem(name, sections={"function": choices})
    assert isinstance(problem, AnalyticProblem)
    return problem


def value(problem: AnalyticProblem, design: np.ndarray) -> np.ndarray:
    return problem.simulate(problem.space.checked(design)).objectives


@pytest.mark.parametrize("choices", CHOICES)
@pytest.mark.parametrize("name", EVERY)
def test_the_stated_optimum_is_attained_and_inside_the_bounds(name: str, choices: dict[str, Any]) -> None:
    problem = made(name, **choices)
    designs, front = problem.pareto_set(), problem.pareto_front()
    assert np.all((problem.space.lower < designs) & (designs < problem.space.upper))
    assert np.array_equal(problem.space.rounded(designs), designs), "integers whole"
    attained = [value(problem, design) for design in designs]
    assert np.allclose(attained, front, rtol=0.0, atol=1e-14)


@pytest.mark.parametrize("choices", CHOICES)
@pytest.mark.parametrize("name", FUNCTIONS)
def test_the_gradient_vanishes_at_the_optimum(name: str, choices: dict[str, Any]) -> None:
    """Central differences; Ackley's funnel has a tip there, to both sides of which the function is equal."""
    problem, step = made(name, **choices), 1e-5
    for k in np.flatnonzero(~problem.space.integer):
        shift = np.where(np.arange(problem.n_var) == k, step, 0.0)
        ahead, behind = (value(problem, problem.optimum + sign * shift)[0] for sign in (1.0, -1.0))
        assert ahead > 0.0
        assert abs(ahead - behind) / (2.0 * step) < 1e-6


@pytest.mark.parametrize("choices", CHOICES)
@pytest.mark.parametrize("name", FUNCTIONS)
def test_nothing_is_lower_nearby_or_anywhere(name: str, choices: dict[str, Any]) -> None:
    problem, generator = made(name, **choices), np.random.default_rng(5)
    anywhere = random_designs(problem.space, 300, generator)
    near = problem.optimum + generator.normal(0.0, 1.0, (300, problem.n_var)) * 10.0 ** generator.uniform(-6, 0.5, (300, 1))
    steps = np.where(problem.space.integer, 1.0, 1e-3) * np.eye(problem.n_var)
    neighbours = problem.space.rounded([*near, *(problem.optimum + steps), *(problem.optimum - steps)])
    for design in (*anywhere, *neighbours):
        at_optimum = np.array_equal(design, problem.optimum)
        assert (value(problem, design)[0] > 0.0) != at_optimum


@pytest.mark.parametrize("choices", CHOICES)
def test_nothing_dominates_the_front_of_two_spheres(choices: dict[str, Any]) -> None:
    """√f_1 + √f_2 = 1 on the front and more elsewhere: distances to two points sum to their distance between them only."""
    problem, generator = made("two-spheres", **choices), np.random.default_rng(6)
    assert np.allclose(np.sqrt(problem.pareto_front()).sum(axis=1), 1.0, rtol=0.0, atol=1e-14)
    assert problem.pareto_front().min(axis=0).tolist() == [0.0, 0.0]
    near = problem.pareto_set() + generator.normal(0.0, 0.1, problem.pareto_set().shape)
    for design in (*random_designs(problem.space, 300, generator), *problem.space.rounded(near)):
        assert np.sqrt(value(problem, design)).sum() > 1.0 - 1e-14


@pytest.mark.parametrize("choices", CHOICES)
def test_the_worst_values_of_two_spheres_are_those_of_the_corners(choices: dict[str, Any]) -> None:
    problem = made("two-spheres", **choices)
    corners = np.array(list(itertools.product([-5.0, 5.0], repeat=problem.n_var)))
    values = np.array([value(problem, corner) for corner in corners])
    assert np.allclose(values.max(axis=0), [problem.worst["left"], problem.worst["right"]], rtol=1e-12)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_without_a_shift_the_formula_is_the_textbook_s(name: str) -> None:
    problem = made(name, dimension=6, shift=0.0)
    designs = random_designs(problem.space, 50, np.random.default_rng(7))
    offset = 0.5 if name == "sphere" else 0.0  # pymoo's sphere has its optimum at 0.5
    expected = get_problem(name, n_var=6).evaluate(designs + offset)
    assert np.allclose([value(problem, design) for design in designs], expected, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("name", EVERY)
def test_a_shift_moves_the_function_as_it_is(name: str) -> None:
    there, here = made(name, dimension=5, shift=0.7), made(name, dimension=5, shift=0.0)
    moved = there.optimum - here.optimum
    assert np.all(np.abs(moved) > 1e-2)
    assert len(np.unique(moved)) == 5
    for design in random_designs(here.space, 20, np.random.default_rng(8)):
        step = 0.1 * design
        assert np.allclose(value(there, there.optimum + step), value(here, here.optimum + step), rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("name", EVERY)
def test_the_last_variables_are_integer(name: str) -> None:
    assert made(name, dimension=5, integers=2).space.integer.tolist() == [False, False, False, True, True]


@pytest.mark.parametrize("choices", CHOICES)
@pytest.mark.parametrize("name", EVERY)
def test_the_reference_design_leaves_much_to_be_found(name: str, choices: dict[str, Any]) -> None:
    problem = made(name, **choices)
    assert problem.reference is not None
    assert np.all(value(problem, problem.reference) > 0.0)
    assert np.linalg.norm(problem.reference - problem.pareto_set(), axis=1).min() > 0.05 * (problem.upper - problem.lower)


@pytest.mark.parametrize("name", EVERY)
@pytest.mark.parametrize(("place", "wrong", "message"), [(0, 40.0, "x1: allowed is"), (-1, 0.5, "x4: a whole number")])
def test_designs_that_are_not_allowed_are_refused(name: str, place: int, wrong: float, message: str) -> None:
    problem = made(name, dimension=4, integers=2)
    design = problem.optimum.copy()
    design[place] = wrong
    with pytest.raises(InputError, match=message):
        value(problem, design)


@pytest.mark.parametrize(
    ("name", "choices", "message"),
    [
        ("ackley", {"dimension": 3, "integers": 4}, "parameters.function: integers: .* received 4 of dimension 3"),
        ("sphere", {"dimension": 1}, "function.dimension: allowed is ≥ 2, received 1"),
        ("sphere", {"shift": 0.9}, "function.shift: allowed is ≥ 0 and ≤ 0.8, received 0.9"),
        ("sphere", {"computing": 1}, "function.computing: true or false is needed"),
        ("two-spheres", {"dimension": 3, "integers": 3}, "function.integers: two-spheres needs a real variable"),
    ],
)
def test_choices_that_are_not_allowed_are_refused(name: str, choices: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        made(name, **choices)


def test_the_objectives_are_the_problem_s_own() -> None:
    assert railsearch.problem("two-spheres", objectives=("left", "right")).n_obj == 2
    with pytest.raises(InputError, match="ackley always has f, received F_max"):
        railsearch.problem("ackley", objectives=("F_max",))


@pytest.mark.parametrize("computing", [True, False])
def test_an_evaluation_lasts_as_long_as_asked(computing: bool) -> None:
    problem = made("sphere", seconds=0.05, computing=computing)
    wall, work = time.perf_counter(), time.thread_time()
    problem.simulate(problem.optimum)
    wall, work = time.perf_counter() - wall, time.thread_time() - work
    assert wall >= 0.05
    assert (work >= 0.05) == computing


def test_a_problem_travels_to_another_process() -> None:
    problem = TwoSpheres(FunctionParameters(dimension=4, integers=2))
    there = pickle.loads(pickle.dumps(problem))
    assert np.array_equal(value(there, problem.optimum), value(problem, problem.optimum))


def test_an_analytic_problem_is_searched_like_any_other(railsearch: Callable[..., Answer], tmp_path: Any) -> None:
    site = tmp_path / "site.toml"
    site.write_text("[function]\ndimension = 4\nintegers = 2\n")
    words = ("--strategy", "random", "--budget", 3, "--seed", 1, "-p", site, "--out", tmp_path / "run")
    answer = railsearch("run", "rastrigin", *words)
    assert (answer.code, "3 of 3 evaluations" in answer.out) == (0, True), answer.err
