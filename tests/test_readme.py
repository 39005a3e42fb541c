"""What the README says is run as it stands there."""

import re
import types
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from command_line import Answer
from railsearch.testing import check_strategy

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def fenced(language: str, heading: str) -> str:
    section = README[README.index(f"## {heading}\n") :]
    block = re.search(rf"```{language}\n(.*?)```", section, re.DOTALL)
    assert block is not None
    return block[1]


def module(name: str, heading: str) -> types.ModuleType:
    made = types.ModuleType(name)
    exec(compile(fenced("python", heading), f"{name}.py", "exec"), vars(made))
    return made


@pytest.fixture
def jumps() -> types.ModuleType:
    return module("jumps", "Write a strategy")


@pytest.mark.parametrize("words", [("--strategy", "nsga2"), ("--scalarise", "asf", "--strategy", "dycors")])
def test_the_smallest_problem_runs(
    railsearch: Callable[..., Answer], install: Callable[..., None], tmp_path: Path, words: tuple[str, ...]
) -> None:
    cantilever = module("cantilever", "Write a problem")
    install(railsearch_cantilever=lambda: cantilever)
    answer = railsearch("run", "cantilever", *words, "--budget", 40, "--seed", 1, "--out", tmp_path)
    assert answer.code == 0, answer.err
    assert "40 of 40 evaluations, 0 failed" in answer.out
    assert "deflection [mm]" in answer.out


def test_the_smallest_plugin_runs(
    railsearch: Callable[..., Answer], install: Callable[..., None], jumps: types.ModuleType, tmp_path: Path
) -> None:
    install(railsearch_jumps=lambda: jumps)
    words = ["run", "level-crossing", "--scalarise", "asf", "--strategy", "jumps", "--budget", "5", "--seed", "1"]
    assert " ".join(words[:-4]) in README
    answer = railsearch(*words, "--out", tmp_path)
    assert answer.code == 0, answer.err
    assert "5 of 5 evaluations" in answer.out


def test_the_smallest_plugin_passes_the_conformance_suite(jumps: types.ModuleType) -> None:
    check_strategy(jumps.Jumps)


def test_the_package_of_the_smallest_plugin_names_its_entry_point() -> None:
    import tomllib

    document = tomllib.loads(fenced("toml", "Write a strategy"))
    assert document["project"]["entry-points"]["railsearch"] == {"jumps": "jumps"}
    assert document["tool"]["setuptools"]["py-modules"] == ["jumps"]


def test_the_python_example_runs() -> None:
    (block,) = re.findall(r"### From Python\n\n((?:    .*\n|\n)+)", README)
    code = "\n".join(line[4:] for line in block.splitlines()).replace("200)", "24)").replace("pop_size=20", "pop_size=8")
    names: dict[str, object] = {}
    exec(compile(code, "README.md", "exec"), names)
    assert np.atleast_2d(names["result"].F).shape[1] == 2  # type: ignore[attr-defined]
    assert names["sphere"].F[0] < 1e-3  # type: ignore[attr-defined]


def test_every_command_and_file_that_the_readme_names_exists(railsearch: Callable[..., Answer]) -> None:
    commands = set(re.findall(r"^    railsearch ([a-z-]+)", README, re.MULTILINE))
    for command in commands:
        assert railsearch(command, "--help").code == 0
    for path in re.findall(r"\]\(([^)#]+)\)", README):
        assert (ROOT / path).exists(), path
