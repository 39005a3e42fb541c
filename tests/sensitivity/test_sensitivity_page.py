"""docs/sensitivity.md: its code runs."""

import re
from pathlib import Path

PAGE = (Path(__file__).parents[2] / "docs" / "sensitivity.md").read_text(encoding="utf-8")


def test_the_python_code_runs_and_finds_the_known_extremes(capsys):
    code = re.search(r"```python\n(.*?)```", PAGE, re.DOTALL)
    assert code is not None
    names: dict[str, object] = {}
    exec(compile(code[1], "sensitivity.md", "exec"), names)
    assert round(names["extremes"].importances()["E1"], 2) == float(re.search(r'"E1": ([\d.]+)', PAGE)[1])
    assert "0.16 m is reached: w lies between" in capsys.readouterr().out
