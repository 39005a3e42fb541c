"""The worked example of docs/preferences.md is run as it stands there; preference figures show what they are to show."""

import json
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from command_line import Answer
from railsearch.interfaces import Quantity
from railsearch.preferences import Desirability, Linear, PhysicalProgramming, StatedPreference
from railsearch.preferences.physical_programming import RANGES
from railsearch.report.preferences import preference_figure

PAGE = (Path(__file__).parents[1] / "docs" / "preferences.md").read_text(encoding="utf-8")
COST, ENERGY = Quantity("C_cap", "€"), Quantity("E_max", "N·m")


def test_the_worked_example_runs(railsearch: Callable[..., Answer], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    wishes, group = re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)
    Path("preferences.toml").write_text(wishes)
    Path("group.toml").write_text(group)
    commands = re.findall(r"^    railsearch (.*)$", PAGE, re.MULTILINE)
    assert len(commands) == 3
    for command in commands:
        answer = railsearch(*command.replace("--budget 200", "--budget 21").split())
        assert answer.code == 0, answer.err
    assert json.loads(answer.out)["scalariser"] == "imap"
    result = json.loads(Path("my-preferred/result.json").read_text())
    assert [row["function"] for row in result["preferences"]] == ["linear", "physical-programming"]
    assert result["preferences"][0]["scores"]["best"] > result["preferences"][0]["scores"]["reference"]


def test_the_python_example_states_the_same() -> None:
    names: dict[str, object] = {}
    exec(re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)[0], names)
    (wishes, _) = re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)
    import tomllib

    import railsearch

    again = railsearch.problem("level-crossing", scalariser="preference-minmax", scalariser_settings=tomllib.loads(wishes))
    assert names["problem"].scalariser.preferences == again.scalariser.preferences  # type: ignore[attr-defined]


def test_every_function_and_scalariser_is_on_the_page() -> None:
    from railsearch.plugin_manager import load_plugins
    from railsearch.preferences import FUNCTIONS

    for name in (*FUNCTIONS, *(entry.name for entry in load_plugins().entries("scalariser"))):
        assert f"| `{name}` |" in PAGE


def test_designs_are_marked_on_every_curve_with_their_scores() -> None:
    stated = [
        StatedPreference(COST, Linear(8500.0, 12500.0), 2.0, "manager"),
        StatedPreference(COST, Desirability(9000.0, upper=10000.0), 1.0, "resident"),
        StatedPreference(ENERGY, PhysicalProgramming((0.1, 0.2, 0.3, 0.4, 0.5)), 1.0, "manager"),
    ]
    values = {"reference": {"C_cap": 10500.0, "E_max": 0.3}, "best": {"C_cap": 9207.0, "E_max": 0.1}}
    figure = preference_figure(stated, values, {"C_cap": np.array([9000.0, 1e9]), "E_max": np.array([0.2])})
    cost, energy = figure.axes
    marks = [tuple(np.round(c.get_offsets()[0], 2)) for c in cost.collections if c.get_label() in values]
    assert marks == [(10500.0, 50.0), (9207.0, 82.32), (10500.0, 0.0), (9207.0, 79.3)]
    assert {text.get_text() for text in cost.texts} == {"50", "82.3", "0", "79.3"}
    (others, _) = [c.get_offsets().tolist() for c in cost.collections if c.get_label() == "other designs"]
    assert others == [[9000.0, 87.5]], "what lies outside is left out"
    assert cost.get_xlabel() == "C_cap [€]"
    assert cost.get_title("left") == "manager: linear, weight 2\nresident: desirability, weight 1"
    assert set(RANGES) <= {text.get_text() for text in energy.texts}
    knots = {line.get_xdata()[0] for line in cost.lines if len(line.get_xdata()) == 2}
    assert knots == {8500.0, 12500.0, 9000.0, 10000.0}
    assert [text.get_text() for text in figure.legends[0].texts] == [
        "manager",
        "other designs",
        "reference",
        "best",
        "resident",
    ]


def test_stakeholders_with_the_same_function_share_a_curve() -> None:
    same = Linear(8500.0, 12500.0)
    stated = [StatedPreference(COST, same, weight, who) for who, weight in (("manager", 2.0), ("resident", 1.0))]
    (axes,) = preference_figure([*stated, StatedPreference(COST, Linear(9000.0, 12000.0), 1.0, "state")], {}).axes
    curves = {line.get_label() for line in axes.lines if len(line.get_xdata()) > 2}
    assert curves == {"manager, resident", "state"}
    assert axes.get_title("left").splitlines()[:2] == ["manager: linear, weight 2", "resident: linear, weight 1"]
