"""The analytic problems: what they state of their optimum holds, and their formulas agree with pymoo's."""

import itertools
import math
import pickle
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from pymoo.problems import get_problem
from scipy.optimize import brentq, minimize

import railsearch
from command_line import Answer
from railsearch.errors import InputError
from railsearch.indicators import hypervolume, non_dominated
from railsearch.plugin_manager import load_plugins
from railsearch.problem_factory import ProblemSettings, make_problem
from railsearch.sampling import random_designs
from railsearch_problems.analytic.function import AnalyticProblem, FunctionParameters
from railsearch_problems.analytic.one_objective import PROBLEMS as ONE_OBJECTIVE
from railsearch_problems.analytic.several_objectives import PROBLEMS as SEVERAL_OBJECTIVES
from railsearch_problems.analytic.several_objectives import TwoSpheres

REGISTRY = load_plugins()
FUNCTIONS = tuple(problem.function_name for problem in ONE_OBJECTIVE)
SEVERAL = tuple(problem.function_name for problem in SEVERAL_OBJECTIVES)
LATTICES = ("convex-front", "broken-front", "spherical-front")
EVERY = (*FUNCTIONS, *SEVERAL)
# Schwefel's terms are of the order of 400, and so is their rounding.
ROUNDING = 1e-12


def cases(*names: str) -> Callable[[Callable[[str, dict[str, Any]], None]], Callable[[], None]]:
    """Fold a test over functions with two, many, and half integer variables, or as few as they can have, at three shifts."""
    fewest = {"rounding-trap": (4, 3), "spherical-front": (3, 1)}
    choices = [
        (name, {"dimension": dimension, "integers": integers, "shift": shift})
        for name in names
        for (dimension, integers), shift in itertools.product(
            [fewest.get(name, (2, 1)), (13, 2 if name == "rounding-trap" else 0), (10, 5)], [0.0, 0.3, 0.8]
        )
    ]

    def folded(test: Callable[[str, dict[str, Any]], None]) -> Callable[[], None]:
        def all_cases() -> None:
            for name, chosen in choices:
                try:
                    test(name, chosen)
                except Exception as error:
                    error.add_note(f"in the case of {name} with {chosen}")
                    raise

        all_cases.__doc__ = test.__doc__
        return all_cases

    return folded


def made(name: str, **choices: Any) -> AnalyticProblem:
    problem = make_problem(REGISTRY, ProblemSettings(name, sections={"function": choices}))
    assert isinstance(problem, AnalyticProblem)
    return problem


def value(problem: AnalyticProblem, design: np.ndarray) -> np.ndarray:
    return problem.simulate(problem.space.checked(design)).objectives


def feasible(problem: AnalyticProblem, design: np.ndarray) -> bool:
    return bool(np.all(problem.simulate(design).constraints <= 0.0))


@cases(*EVERY)
def test_the_stated_optimum_is_attained_feasible_and_inside_the_bounds(name: str, choices: dict[str, Any]) -> None:
    problem = made(name, **choices)
    designs, front = problem.pareto_set(), problem.pareto_front()
    assert np.array_equal(problem.space.rounded(designs), designs), "inside the bounds, integers whole"
    assert np.all((problem.space.lower < problem.optimum) & (problem.optimum < problem.space.upper))
    assert np.allclose([value(problem, design) for design in designs], front, rtol=0.0, atol=1e-14)
    assert all(feasible(problem, design) for design in designs)
    if problem.n_obj == 1:
        assert np.array_equal(front, [[0.0]])
        assert np.array_equal(designs, [problem.optimum])


@cases(*(name for name in FUNCTIONS if name != "constrained-sphere"))
def test_the_gradient_vanishes_at_the_optimum(name: str, choices: dict[str, Any]) -> None:
    """Central differences; Ackley's funnel has a tip there, to both sides of which the function is equal."""
    problem, step = made(name, **choices), 1e-5
    for k in np.flatnonzero(~problem.space.integer):
        shift = np.where(np.arange(problem.n_var) == k, step, 0.0)
        ahead, behind = (value(problem, problem.optimum + sign * shift)[0] for sign in (1.0, -1.0))
        assert ahead > 0.0
        assert abs(ahead - behind) / (2.0 * step) < 1e-6


@cases("constrained-sphere")
def test_the_gradients_balance_at_the_constrained_optimum(name: str, choices: dict[str, Any]) -> None:
    """Karush, Kuhn and Tucker: ∇f + λ ∇g = 0 with λ > 0, here λ = 2d, and g = 0."""
    problem, step = made(name, **choices), 1e-5
    assert problem.simulate(problem.optimum).constraints == pytest.approx([0.0], abs=1e-15)
    for k in range(problem.n_var):
        shift = np.where(np.arange(problem.n_var) == k, step, 0.0)
        ahead, behind = (problem.simulate(problem.optimum + sign * shift) for sign in (1.0, -1.0))
        rises = (ahead.objectives - behind.objectives) / (2.0 * step)
        falls = (ahead.constraints - behind.constraints) / (2.0 * step)
        assert rises + 2.0 * problem.n_var * falls == pytest.approx([0.0], abs=1e-8)


@cases(*FUNCTIONS)
def test_nothing_feasible_is_lower_nearby_or_anywhere(name: str, choices: dict[str, Any]) -> None:
    problem, generator = made(name, **choices), np.random.default_rng(5)
    anywhere = random_designs(problem.space, 300, generator)
    near = problem.optimum + generator.normal(0.0, 1.0, (300, problem.n_var)) * 10.0 ** generator.uniform(-6, 0.5, (300, 1))
    steps = np.where(problem.space.integer, 1.0, 1e-3) * np.eye(problem.n_var)
    neighbours = problem.space.rounded([*near, *(problem.optimum + steps), *(problem.optimum - steps)])
    for design in (*anywhere, *neighbours):
        if feasible(problem, design):
            away = np.linalg.norm(design - problem.optimum)
            assert value(problem, design)[0] > (0.0 if away > 1e-3 else -ROUNDING * problem.n_var)


@cases(*(name for name in FUNCTIONS if name != "constrained-sphere"))
def test_local_searches_of_the_real_variables_end_no_lower(name: str, choices: dict[str, Any]) -> None:
    problem, generator = made(name, **choices), np.random.default_rng(6)
    real = ~problem.space.integer
    bounds = list(zip(problem.space.lower[real], problem.space.upper[real], strict=True))

    def at(point: np.ndarray, start: np.ndarray) -> float:
        design = start.copy()
        design[real] = point
        return float(problem.simulate(design).objectives[0])

    for start in (*random_designs(problem.space, 2, generator), problem.optimum):
        found = minimize(at, start[real], args=(start,), method="L-BFGS-B", bounds=bounds)
        assert found.fun > -ROUNDING * problem.n_var


@pytest.mark.parametrize("shift", [0.0, 0.8])
def test_the_trap_s_real_optimum_rounds_to_a_worse_design_and_no_whole_one_is_better(shift: float) -> None:
    problem = made("rounding-trap", dimension=4, integers=4, shift=shift)
    for pair in itertools.product(range(-5, 6), repeat=2):
        design = problem.optimum.copy()
        design[:2] = pair
        assert (value(problem, design)[0] > 0.0) != np.array_equal(design, problem.optimum)
    relaxed = problem.optimum + np.array([0.55, -0.35, 0.55, -0.35])
    at_relaxed = problem.simulate(relaxed).objectives[0]
    for k, sign in itertools.product(range(4), (-1.0, 1.0)):
        assert problem.simulate(relaxed + 0.01 * sign * np.eye(4)[k]).objectives[0] > at_relaxed
    assert value(problem, np.round(relaxed))[0] == pytest.approx(2.0 * 5.2)


@cases("two-spheres")
def test_nothing_dominates_the_front_of_two_spheres(name: str, choices: dict[str, Any]) -> None:
    """√f_1 + √f_2 = 1 on the front and more elsewhere: distances to two points sum to their distance between them only."""
    problem, generator = made(name, **choices), np.random.default_rng(6)
    assert np.allclose(np.sqrt(problem.pareto_front()).sum(axis=1), 1.0, rtol=0.0, atol=1e-14)
    assert problem.pareto_front().min(axis=0).tolist() == [0.0, 0.0]
    near = problem.pareto_set() + generator.normal(0.0, 0.1, problem.pareto_set().shape)
    for design in (*random_designs(problem.space, 300, generator), *problem.space.rounded(near)):
        assert np.sqrt(value(problem, design)).sum() > 1.0 - 1e-14


@cases(*LATTICES)
def test_nothing_dominates_the_front(name: str, choices: dict[str, Any]) -> None:
    problem, generator = made(name, **choices), np.random.default_rng(7)
    front = problem.pareto_front()
    assert len(non_dominated(front)) == len(front)
    near = problem.pareto_set() + generator.normal(0.0, 0.1, problem.pareto_set().shape)
    for design in (*random_designs(problem.space, 300, generator), *problem.space.rounded(near)):
        found = value(problem, design)
        assert not np.any(np.all(found < front - 1e-12, axis=1))


def test_the_fronts_are_the_stated_curves_and_surfaces() -> None:
    convex, broken, spherical = (made(name).front(400) for name in LATTICES)
    assert np.allclose(convex[:, 1], 1.0 - np.sqrt(convex[:, 0]), rtol=0.0, atol=1e-15)
    assert (len(convex), len(broken), len(spherical)) == (400, 400, 400 - 19), "one edge of the sphere's lattice is a point"
    waves = broken[:, 0] * np.sin(10.0 * np.pi * broken[:, 0])
    assert np.allclose(broken[:, 1], 1.0 - np.sqrt(broken[:, 0]) - waves, rtol=0.0, atol=1e-15)
    # The parts of ZDT3's front as the literature has them, to ten digits.
    parts = [(0.0, 0.0830015349), (0.1822287280, 0.2577623634), (0.4093136748, 0.4538821041)]
    parts += [(0.6183967944, 0.6525117038), (0.8233317983, 0.8518328654)]
    place = np.sort(made("broken-front").front(100_000)[:, 0])
    edges = np.flatnonzero(np.diff(place) > 0.01)
    found = list(zip(place[[0, *(edges + 1)]], place[[*edges, -1]], strict=True))
    assert np.allclose(found, parts, rtol=0.0, atol=5e-6), "one step of 0.2673/100 000 beside the ends"
    assert np.allclose(np.sum(spherical**2, axis=1), 1.0, rtol=0.0, atol=1e-14)
    assert np.array_equal(spherical.min(axis=0), np.zeros(3))


def test_hypervolumes_of_the_fronts_approach_the_integrals() -> None:
    """Below (1, 1): ∫ √x = 2/3, and 1 less a ball's eighth, π/6; √f_1 + √f_2 = 1 leaves 1 − 1/6."""
    for name, exact in (("convex-front", 2.0 / 3.0), ("two-spheres", 5.0 / 6.0), ("spherical-front", 1.0 - math.pi / 6.0)):
        problem = made(name)
        coarse, fine = (exact - hypervolume(problem.front(n), np.ones(problem.n_obj)) for n in (100, 1600))
        assert 0.0 < fine < 0.3 * coarse


@pytest.mark.parametrize("integers", [0, 3])
@pytest.mark.parametrize("shift", [0.0, 0.8])
@pytest.mark.parametrize("name", SEVERAL)
def test_the_worst_values_are_those_of_the_corners(name: str, shift: float, integers: int) -> None:
    problem = made(name, dimension=7, integers=integers, shift=shift)
    values = np.array([value(problem, np.array(corner)) for corner in itertools.product([-5.0, 5.0], repeat=7)])
    assert values.max(axis=0) == pytest.approx(
        [problem.worst[objective.name] for objective in problem.objectives], rel=1e-12
    )


@pytest.mark.parametrize("name", ["ackley", "griewank", "rastrigin", "rosenbrock", "schwefel", "sphere", "zakharov"])
def test_without_a_shift_the_formula_is_the_textbook_s(name: str) -> None:
    problem = made(name, dimension=6, shift=0.0)
    designs = random_designs(problem.space, 50, np.random.default_rng(7))
    offset = 0.5 if name == "sphere" else 0.0  # pymoo's sphere has its optimum at 0.5
    expected = get_problem(name, n_var=6).evaluate(designs + offset)
    rounded = 1e-3 if name == "schwefel" else 1e-12  # pymoo has 418.9829 for its constant
    assert np.allclose([value(problem, design) for design in designs], expected, rtol=1e-12, atol=rounded)


def test_levy_at_w_equal_to_0_and_2() -> None:
    """Where w is 0 or 2 in all variables, v² is 1, the first and the last sine are 0, the others sin²(1)."""
    problem = made("levy", dimension=4, shift=0.0)
    for z in (-3.0, 5.0):
        assert value(problem, np.full(4, z)) == pytest.approx([3.0 * (1.0 + 10.0 * math.sin(1.0) ** 2) + 1.0], rel=1e-14)


def test_schwefel_s_best_place_is_the_root_and_beyond_the_bounds_it_rises() -> None:
    root = brentq(lambda r: math.sin(r) + 0.5 * r * math.cos(r), 20.0, 21.0, xtol=1e-14, rtol=1e-14)
    assert made("schwefel", shift=0.0).optimum == pytest.approx(np.full(10, root**2), rel=1e-13)
    moved = made("schwefel", dimension=2, optimum=[-490.0, -490.0])
    assert value(moved, np.array([500.0, -490.0]))[0] > 1e5, "z = 1411, where the textbook's terms fall below the optimum's"


@pytest.mark.parametrize(("theirs", "name"), [("zdt1", "convex-front"), ("zdt3", "broken-front")])
def test_fronts_are_those_of_the_problems_they_are_named_after(theirs: str, name: str) -> None:
    """pymoo's ZDT with all other variables at 0 has g = 1, at 1 it has g = 10, which is the farthest corner here."""
    problem, other = made(name, dimension=4, shift=0.0), get_problem(theirs, n_var=4)
    for t, rest in itertools.product((0.0, 0.3, 1.0), (0.0, 1.0)):
        expected = other.evaluate(np.array([t, rest, rest, rest]))
        assert value(problem, np.array([10.0 * t - 5.0, *[5.0 * rest] * 3])) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("name", EVERY)
def test_a_shift_moves_the_function_as_it_is(name: str) -> None:
    choices = {"dimension": 5, "integers": 2 if name == "rounding-trap" else 0}
    there, here = made(name, shift=0.7, **choices), made(name, shift=0.0, **choices)
    moved = (there.optimum - here.optimum)[~there.space.integer]
    assert np.all(np.abs(moved) > 1e-2)
    assert len(np.unique(moved)) == len(moved)
    if name in (*LATTICES, "schwefel"):
        return  # Their place and distance are measured by the bounds; Schwefel's function is held within them.
    for design in random_designs(here.space, 20, np.random.default_rng(8)):
        step = np.trunc(0.1 * design) if name == "rounding-trap" else 0.1 * design
        assert np.allclose(value(there, there.optimum + step), value(here, here.optimum + step), rtol=1e-9, atol=1e-12)


def test_the_shift_s_directions_come_from_its_seed() -> None:
    first, same, other, even = (made("sphere", shift_seed=seed).optimum for seed in (4, 4, 5, None))
    assert np.array_equal(first, same)
    assert not np.any((first == other) | (first == even))
    assert np.all(np.abs(first) <= 0.3 * 5.0)


@pytest.mark.parametrize("name", EVERY)
def test_the_optimum_can_be_given(name: str) -> None:
    wanted = [-2.5, 1.25, 3.0, -2.0]
    problem = made(name, dimension=4, integers=2, optimum=wanted)
    assert problem.optimum.tolist() == wanted
    assert (
        any(np.array_equal(value(problem, problem.optimum), row) for row in [*problem.pareto_front()]) or problem.n_obj > 1
    )


@pytest.mark.parametrize("name", EVERY)
def test_the_last_variables_are_integer(name: str) -> None:
    assert made(name, dimension=5, integers=2).space.integer.tolist() == [False, False, False, True, True]
    assert made(name, dimension=5, integers="half").space.integer.tolist() == [False, False, False, True, True]


@cases(*EVERY)
def test_the_reference_design_leaves_much_to_be_found(name: str, choices: dict[str, Any]) -> None:
    problem = made(name, **choices)
    assert problem.reference is not None
    assert np.all(value(problem, problem.reference) > 0.0)
    assert np.linalg.norm(problem.reference - problem.pareto_set(), axis=1).min() > 0.05 * (problem.upper - problem.lower)


@pytest.mark.parametrize("name", EVERY)
@pytest.mark.parametrize(("place", "wrong", "message"), [(0, 700.0, "x1: allowed is"), (-1, 0.5, "x4: a whole number")])
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
        (
            "ackley",
            {"integers": "all"},
            "integers: a number up to that of the variables or 'half' is needed, received 'all'",
        ),
        ("ackley", {"integers": -1}, "function.integers: allowed is ≥ 0, received -1"),
        ("sphere", {"dimension": 1}, "function.dimension: allowed is ≥ 2 and ≤ 10000, received 1"),
        ("sphere", {"shift": 0.9}, "function.shift: allowed is ≥ 0 and ≤ 0.8, received 0.9"),
        ("sphere", {"shift_seed": -1}, "function.shift_seed: allowed is ≥ 0, received -1"),
        ("sphere", {"computing": 1}, "function.computing: true or false is needed"),
        ("sphere", {"optimum": [1.0, 2.0]}, "function.optimum: design: 10 values are needed"),
        ("sphere", {"dimension": 2, "optimum": [1.0, 6.0]}, "function.optimum: variable x2: allowed is -5 to 5, received 6"),
        ("sphere", {"dimension": 2, "integers": 1, "optimum": [1.0, 0.5]}, "optimum: variable x2: a whole number is needed"),
        ("two-spheres", {"dimension": 3, "integers": 3}, "function.integers: two-spheres needs a real variable"),
        (
            "two-spheres",
            {"dimension": 2, "optimum": [4.5, 0.0]},
            "function.optimum: the centres of two-spheres lie 1 from it",
        ),
        ("rounding-trap", {"integers": 1}, "rounding-trap needs 2 integer variables or more, received 1"),
        ("spherical-front", {"dimension": 2}, "spherical-front needs 3 variables or more, 2 of them real, received 2 and 2"),
        ("spherical-front", {"dimension": 4, "integers": 3}, "2 of them real, received 4 and 1"),
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
