"""docs/problems.md: its code runs, its campaign is sound, and it names every problem with a known optimum."""

import re
import tomllib
from collections.abc import Callable
from pathlib import Path

from command_line import Answer
from railsearch.plugin_manager import load_plugins
from railsearch_problems.coco import CocoProblem

PAGE = (Path(__file__).parents[2] / "docs" / "problems.md").read_text(encoding="utf-8")


def block(language: str) -> str:
    found = re.search(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)
    assert found is not None
    return found[1]


def test_the_python_code_runs() -> None:
    exec(compile(block("python"), "problems.md", "exec"), {})


def test_the_campaign_passes_every_check(railsearch: Callable[..., Answer], tmp_path: Path) -> None:
    file = tmp_path / "known.toml"
    file.write_text(block("toml").replace('["random"]', '["nsga2"]'), encoding="utf-8")
    answer = railsearch("campaign", file, "--dry-run", "--skip-incapable", "--out", tmp_path / "out")
    assert answer.code == 0, answer.err
    document = tomllib.loads(block("toml"))
    labels = [*document["campaign"]["problems"], *(table["label"] for table in document["problem"])]
    assert len(labels) == 9
    assert all(re.search(rf"\b{re.escape(label)}\b", answer.out) for label in labels), answer.out


def test_the_commands_are_there_and_lead_to_a_run(railsearch: Callable[..., Answer], tmp_path: Path) -> None:
    site = tmp_path / "f15.toml"
    assert railsearch("init", "bbob-mixint", "--out", site).code == 0
    site.write_text(site.read_text().replace("function = 1\n", "function = 15\n"))
    words = ("--parameters", site, "--strategy", "random", "--budget", 3, "--seed", 1, "--out", tmp_path / "run")
    answer = railsearch("run", "bbob-mixint", *words)
    assert (answer.code, "bbob-mixint f15" in answer.err) == (0, True), answer.err


def test_every_problem_with_a_known_optimum_is_named() -> None:
    entries = load_plugins().entries("problem")
    ours = [e.name for e in entries if e.provenance.module in ("railsearch_problems.analytic", CocoProblem.__module__)]
    assert len(ours) == 17
    assert all(f"`{name}`" in PAGE for name in ours)
