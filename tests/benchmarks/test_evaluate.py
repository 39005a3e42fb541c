import json
import sys
from pathlib import Path

import evaluate
import numpy as np
import pytest
from railsearch_peers.cells import CellResult


def cell(problem: str, strategy: str, repetition: int, *best: float, ended: str = "") -> CellResult:
    return CellResult(problem, strategy, repetition, 7, "s", 0.002, ended, best)


CELLS = [
    cell("known", "random", 1, 6.0, 5.0, 4.0),
    cell("known", "pysot-dycors", 1, 3.0, 2.0, 1.0),
    cell("known", "slow", 1, 3.0, 2.0, 1.5, ended="it was silent for 600 s"),
    cell("open", "random", 1, 9.0, 8.0, 7.0),
    cell("open", "pysot-dycors", 1, 5.0, 4.0, 3.0),
]
CAMPAIGNS = [
    {
        "campaign": "fast",
        "problems": ["known", "open"],
        "strategies": ["random", "pysot-dycors"],
        "planned": 4,
        "complete": 4,
    },
    {"campaign": "slow", "problems": ["known"], "strategies": ["slow"], "planned": 5, "complete": 1},
]
RECORD = evaluate.Gathered(CELLS, CAMPAIGNS, {"known": 1.0})


@pytest.fixture
def kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(evaluate, "BEST_KNOWN", tmp_path / "best_known.json")
    return tmp_path / "best_known.json"


def test_the_best_ever_found_stands_for_an_unknown_optimum_and_is_kept(kept: Path) -> None:
    assert evaluate.best_known(CELLS, {"known": 1.0}) == {"known": 1.0, "open": 3.0}
    assert json.loads(kept.read_text()) == {"open": 3.0}
    assert evaluate.best_known(CELLS[:4], {"known": 1.0})["open"] == 3.0
    better = [*CELLS, cell("open", "other", 1, 3.0, 3.0, 2.5)]
    assert evaluate.best_known(better, {"known": 1.0})["open"] == 2.5
    assert json.loads(kept.read_text()) == {"open": 2.5}


def test_those_on_all_problems_are_ranked_on_all_and_everybody_where_everybody_is() -> None:
    whole, everybody = evaluate.rankings(RECORD)
    assert (whole.strategies, whole.problems) == (("pysot-dycors", "random"), ("known", "open"))
    assert (everybody.strategies, everybody.problems) == (("pysot-dycors", "random", "slow"), ("known",))


def test_results_are_written_with_what_is_missing_and_who_ended(
    kept: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(evaluate, "gathered", lambda folders: RECORD)
    monkeypatch.setattr(sys, "argv", ["evaluate.py", "record", "--out", str(tmp_path / "results")])
    assert evaluate.main() == 0
    written = {path.name for path in (tmp_path / "results").iterdir()}
    assert {"cells.csv", "scores.json", "tables.md", "ratios.png", "scores.png"} <= written
    tables = (tmp_path / "results" / "tables.md").read_text()
    assert "Record incomplete, provisional: fast 4 of 4 runs, slow 1 of 5 runs" in tables
    assert "- slow on known, repetition 1: it was silent for 600 s" in tables
    numbers = json.loads((tmp_path / "results" / "scores.json").read_text())
    slow = next(row for row in numbers["standings"] if row["strategy"] == "slow")
    # The reference is at the optimum after 200 evaluations: its score is 0, a ratio to it is not a number.
    assert np.allclose(slow["ratio"][:2], 1.0, rtol=1e-15)
    assert slow["ratio"][2] is None
