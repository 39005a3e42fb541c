"""The page of strategies says what is registered and what it can do, and its examples run."""

import re
from pathlib import Path

import pytest

from railsearch.plugin_manager import load_plugins

PAGE = (Path(__file__).parents[1] / "docs" / "strategies.md").read_text(encoding="utf-8")
YES = {True: "yes", False: "no"}


def rows():
    """(name, objectives, integers, constraints) of every strategy on the page."""
    for line in PAGE.split("## Surrogates")[0].splitlines():
        if line.startswith("| `"):
            names, *cells = (cell.strip() for cell in line.strip("|").split("|"))
            yield from ((name, *cells[:3]) for name in re.findall(r"`([^`]+)`", names))


def test_every_strategy_is_on_the_page_with_its_capabilities():
    registered = {}
    for entry in load_plugins().entries("strategy"):
        able = entry.plugin.capabilities
        objectives = "any" if able.multi_objective else "one"
        registered[entry.name] = (objectives, YES[able.integers], YES[able.constraints])
    assert {name: tuple(cells) for name, *cells in rows()} == registered


@pytest.mark.parametrize("name", ["rbf", "kriging", "pce", "pck"])
def test_surrogates_on_the_page_have_what_it_says(name):
    plugin = load_plugins().get("surrogate", name)
    line = next(line for line in PAGE.split("## Surrogates")[1].splitlines() if line.startswith(f"| `{name}` |"))
    gradient, deviation = (cell.strip() for cell in line.strip("|").split("|")[1:3])
    assert gradient == YES[hasattr(plugin, "gradient")]
    assert deviation == YES[hasattr(plugin, "deviation")]


def test_the_settings_on_the_page_search(railsearch, tmp_path):
    site = tmp_path / "site.toml"
    site.write_text(re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)[0], encoding="utf-8")
    answer = railsearch(
        "run", "sphere", "--parameters", str(site), "--strategy", "dycors", "--budget", "25", "--seed", "1", "--out",
        str(tmp_path / "run"),
    )  # fmt: skip
    assert answer.code == 0, answer.err


def test_the_program_on_the_page_runs():
    exec(re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)[0], {})
