"""COCO's suites: known optima and ends of fronts by COCO's own account, refusals, other processes, no files."""

import multiprocessing
import pickle
import sys
from collections.abc import Callable
from pathlib import Path

import cocoex
import numpy as np
import pytest

import railsearch
from command_line import Answer
from railsearch.errors import InputError, PluginError
from railsearch.sampling import random_designs
from railsearch_problems.coco import Bbob, BbobBiobj, CocoProblem

# By which bbob-mixint multiplies bbob's functions (Tušar, Brockhoff and Hansen 2019, table 1).
SCALES = np.array(
    [1, 1e-3, 0.1, 0.1, 1, 0.01, 1, 0.01, 0.01, 1e-3, 0.01, 1e-4, 0.1, 1, 0.1, 1, 10, 1, 10, 0.1, 1, 1, 10, 0.1]
)
SUITES = ("bbob", "bbob-mixint", "bbob-biobj")


def made(suite: str, function: int, instance: int = 1, dimension: int = 10) -> CocoProblem:
    problem = railsearch.problem(
        suite, sections={"coco": {"function": function, "instance": instance, "dimension": dimension}}
    )
    assert isinstance(problem, CocoProblem)
    return problem


def value(problem: CocoProblem, design: np.ndarray) -> np.ndarray:
    return problem.simulate(problem.space.checked(design)).objectives


@pytest.mark.parametrize(("suite", "scales"), [("bbob", np.ones(24)), ("bbob-mixint", SCALES)])
@pytest.mark.parametrize(("instance", "dimension"), [(1, 5), (2, 10), (77, 10), (15, 40)])
def test_the_value_at_the_optimum_is_the_one_that_coco_tells(
    suite: str, scales: np.ndarray, instance: int, dimension: int
) -> None:
    for function, scale in enumerate(scales, start=1):
        problem = made(suite, function, instance, dimension)
        told = scale * cocoex.BareProblem("bbob", function, dimension, instance).best_value()
        assert problem.pareto_front().shape == (1, 1)
        assert problem.pareto_front()[0, 0] == pytest.approx(told, rel=1e-12, abs=1e-12)
        assert np.array_equal(value(problem, problem.pareto_set()[0]), problem.pareto_front()[0])


@pytest.mark.parametrize("suite", ["bbob", "bbob-mixint"])
def test_nothing_is_lower_nearby_or_anywhere(suite: str) -> None:
    generator = np.random.default_rng(3)
    for function in range(1, 25):
        problem = made(suite, function, instance=4)
        assert isinstance(problem, Bbob)
        steps = generator.normal(0.0, 1.0, (60, 10)) * 10.0 ** generator.uniform(-5, 0.5, (60, 1))
        for design in (*random_designs(problem.space, 60, generator), *problem.space.rounded(problem.optimum + steps)):
            assert value(problem, design)[0] >= problem.pareto_front()[0, 0] - 1e-9


@pytest.mark.parametrize("dimension", [5, 20])
def test_bbob_mixint_has_variables_of_2_4_8_16_values_and_real_ones(dimension: int) -> None:
    space, fifth = made("bbob-mixint", 1, dimension=dimension).space, dimension // 5
    assert space.integer.tolist() == [True] * 4 * fifth + [False] * fifth
    assert space.lower.tolist() == [0.0] * 4 * fifth + [-5.0] * fifth
    assert space.upper.tolist() == [top for top in (1.0, 3.0, 7.0, 15.0, 5.0) for _ in range(fifth)]


@pytest.mark.parametrize(("instance", "dimension"), [(1, 2), (15, 10)])
def test_the_ends_of_the_front_are_those_that_coco_measures_hypervolume_by(instance: int, dimension: int) -> None:
    for function in range(1, 56):
        problem = made("bbob-biobj", function, instance, dimension)
        assert isinstance(problem, BbobBiobj)
        told = cocoex.Suite("bbob-biobj", f"instances: {instance}", f"dimensions: {dimension}")
        coco = told.get_problem_by_function_dimension_instance(function, dimension, instance)
        assert np.allclose(problem.nadir_point(), coco.largest_fvalues_of_interest, rtol=1e-12, atol=0.0)
        assert list(problem.worst.values()) == problem.nadir_point().tolist()
        for design in random_designs(problem.space, 20, np.random.default_rng(4)):
            assert np.all(value(problem, design) >= problem.ideal_point())


def test_the_ideal_point_has_the_best_values_of_the_two_functions() -> None:
    """Function 5 of bbob-biobj stacks bbob's functions 1 and 13, at its instance 1 with their instances 2 and 4."""
    first, second = (cocoex.BareProblem("bbob", function, 10, instance) for function, instance in ((1, 2), (13, 4)))
    expected = [first.best_value(), second.best_value()]
    assert made("bbob-biobj", 5).ideal_point() == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("suite", SUITES)
def test_the_values_are_coco_s_and_the_search_begins_where_coco_proposes(suite: str) -> None:
    problem = made(suite, 17, instance=3)
    coco = cocoex.Suite(suite, "instances: 3", "dimensions: 10 function_indices: 17")[0]
    assert np.array_equal(problem.reference, coco.initial_solution)
    for design in random_designs(problem.space, 20, np.random.default_rng(5)):
        assert np.array_equal(value(problem, design), np.atleast_1d(coco(design)))


@pytest.mark.parametrize(
    ("suite", "choices", "message"),
    [
        ("bbob", {"function": 25}, "coco.function: allowed is ≥ 1 and ≤ 24, received 25"),
        ("bbob", {"dimension": 7}, "parameters.coco: dimension: the suite has 2, 3, 5, 10, 20, 40, received 7"),
        ("bbob-mixint", {"dimension": 80}, "the suite has 5, 10, 20, 40, received 80"),
        ("bbob-biobj", {"function": 56}, "allowed is ≥ 1 and ≤ 55, received 56"),
        ("bbob-biobj", {"instance": 16}, "allowed is ≥ 1 and ≤ 15, received 16"),
        ("bbob", {"instance": 0}, "coco.instance: allowed is ≥ 1"),
        ("bbob", {"number": 3}, "unknown parameter 'number'"),
    ],
)
def test_choices_that_are_not_allowed_are_refused(suite: str, choices: dict[str, int], message: str) -> None:
    with pytest.raises(InputError, match=message):
        railsearch.problem(suite, sections={"coco": choices})


def test_designs_outside_the_bounds_and_fractions_are_refused() -> None:
    problem = made("bbob-mixint", 3)
    with pytest.raises(InputError, match="x1: a whole number is needed"):
        value(problem, problem.space.lower + 0.5)
    with pytest.raises(InputError, match="x1: allowed is 0 to 1"):
        value(problem, problem.space.lower - 1.0)


def test_the_objectives_are_the_problem_s_own() -> None:
    with pytest.raises(InputError, match="bbob always has f, received g"):
        railsearch.problem("bbob", objectives=("g",))


@pytest.mark.parametrize("suite", SUITES)
def test_a_problem_is_the_same_in_another_process(suite: str) -> None:
    problem = made(suite, 21, instance=2)
    design = random_designs(problem.space, 1, np.random.default_rng(6))[0]
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        there = pool.apply(problem.simulate, (design,))
    assert np.array_equal(there.objectives, value(problem, design))
    assert len(pickle.dumps(problem)) < 20_000


def test_without_the_extra_the_remedy_is_told(monkeypatch: pytest.MonkeyPatch, railsearch: Callable[..., Answer]) -> None:
    monkeypatch.setitem(sys.modules, "cocoex", None)
    with pytest.raises(PluginError, match=r"need the package coco-experiment, .*`\.venv/bin/pip install '\.\[coco\]'`"):
        Bbob()
    answer = railsearch("describe", "bbob")
    assert answer.code == 0, answer.err
    assert "cannot be made here: the problems of COCO need the package coco-experiment" in answer.out
    assert all(f"coco.{name}" in answer.out for name in ("function", "instance", "dimension"))
    assert railsearch("evaluate", "bbob").code == 2
    assert "bbob-mixint" in railsearch("list", "problem").out


def test_a_search_writes_nothing_but_its_own_folder(
    railsearch: Callable[..., Answer], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "site.toml").write_text("[coco]\nfunction = 15\ninstance = 2\n")
    words = ("--strategy", "random", "--budget", 3, "--seed", 1, "-p", "site.toml", "--out", "run")
    answer = railsearch("run", "bbob-mixint", *words)
    assert (answer.code, "3 of 3 evaluations" in answer.out) == (0, True), answer.err
    assert "bbob-mixint f15, instance 2, 10 variables" in answer.err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["run", "site.toml"]
