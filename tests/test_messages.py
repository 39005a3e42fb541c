import io
import re
import warnings

import numpy as np
import pytest
from rich.console import Console

from railsearch.commands import progress
from railsearch.interfaces import Evaluation, Quantity
from sample_problems import Sphere


def test_a_narrow_terminal_keeps_the_bar_and_the_time(monkeypatch: pytest.MonkeyPatch) -> None:
    console = Console(width=80, force_terminal=True, record=True, file=io.StringIO())
    monkeypatch.setattr(progress, "messages", console)
    problem = Sphere()
    problem.objectives = tuple(Quantity(f"a_long_name_of_an_objective_{k}", "N·m") for k in range(1))
    metrics = {f"another_long_name_of_a_metric_{k}": 1234.5 for k in range(3)}
    problem.metrics = tuple(Quantity(name, "N·m") for name in metrics)
    base = Sphere()
    base.objectives = problem.metrics
    monkeypatch.setattr(Sphere, "simulated", property(lambda self: base))
    with progress.run_progress(problem, 20) as watch:
        for number in range(5):
            watch(Evaluation(number, np.zeros(4), np.array([1.0]), np.empty(0), metrics, "initial"))
    last = console.export_text().rstrip()[-80:]
    assert re.match(r"━.* +5/20 [\d:-]+ left, best a_long_name_of_an_objective_0 1 N·m, .*…$", last)


def test_a_warning_of_a_library_is_told_once_as_a_plain_line(capsys: pytest.CaptureFixture[str]) -> None:
    with progress.plain_warnings():
        for number in range(10):
            warnings.warn_explicit(
                f"failed to converge after {number} iterations,\n  see there", UserWarning, "x.py", number
            )
        warnings.warn_explicit("something else", UserWarning, "x.py", 1)
    lines = capsys.readouterr().err.splitlines()
    assert lines == [
        "warning: failed to converge after 0 iterations, see there (told once)",
        "warning: something else (told once)",
    ]
