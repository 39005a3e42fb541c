"""The entry point: Ctrl-C is answered while the command line is still being loaded."""

import json
import subprocess
import sys

import pytest

from railsearch import __main__ as entry_point


class Interrupted:
    """A module of which nothing can be imported before Ctrl-C is pressed."""

    def __getattr__(self, name: str) -> object:
        raise KeyboardInterrupt


def modules_after(code: str) -> set[str]:
    """The modules that a fresh interpreter has loaded after some code."""
    words = [sys.executable, "-c", f"{code}; import json, sys; print(json.dumps([*sys.modules]))"]
    return set(json.loads(subprocess.run(words, capture_output=True, text=True, check=True).stdout))


def test_an_interrupt_while_modules_load_is_a_word_and_code_130(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "railsearch.cli", Interrupted())
    with pytest.raises(SystemExit) as ended:
        entry_point.main()
    assert ended.value.code == 130
    assert capsys.readouterr().err == "railsearch: stopped before anything was done\n"


def test_the_package_runs_as_a_module_and_loads_nothing_heavy_before_it_can_be_interrupted() -> None:
    answer = subprocess.run(
        [sys.executable, "-m", "railsearch", "list", "--json"], capture_output=True, text=True, check=True
    )
    assert "level-crossing" in answer.stdout
    loaded = {name.partition(".")[0] for name in modules_after("import railsearch.__main__")}
    assert not {"numpy", "typer", "pymoo", "optuna", "rich"} & loaded


def test_what_only_some_commands_need_is_loaded_by_those_alone() -> None:
    """Every process of a campaign loads all plugins before it begins; these would take longer than all the others."""
    heavy = {"scipy.stats", "sklearn", "matplotlib", "pandas", "pyarrow", "cma", "torch", "optuna_dashboard"}
    assert not heavy & modules_after("from railsearch.plugin_manager import load_plugins; load_plugins()")
