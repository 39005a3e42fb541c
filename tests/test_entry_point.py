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
    code = (
        "import json, sys, railsearch.__main__; print(json.dumps(sorted({name.partition('.')[0] for name in sys.modules})))"
    )
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert not {"numpy", "typer", "pymoo", "optuna", "rich"} & set(json.loads(loaded))
