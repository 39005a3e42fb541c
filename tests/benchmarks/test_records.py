import sys
from pathlib import Path
from typing import Any

import evaluate
import pytest
from railsearch_peers.cells import CellResult
from railsearch_peers.records import Gathered, continued, read_results


def cell(strategy: str, repetition: int, last: float) -> CellResult:
    return CellResult("sphere", strategy, repetition, 7, "s", 0.002, "", (last + 2.0, last + 1.0, last))


def campaign(name: str, *strategies: str, repetitions: int = 2, complete: int = 0) -> dict[str, Any]:
    identity = {"campaign": name, "seed": 1, "repetitions": repetitions, "strategies": {word: {} for word in strategies}}
    return {**identity, "problems": ["sphere"], "planned": repetitions * len(strategies), "complete": complete}


FAST = [cell(strategy, repetition, 3.0) for strategy in ("random", "pysot-dycors") for repetition in (1, 2)]
EARLIER = Gathered(
    [*FAST, cell("slow", 1, 4.0)],
    [campaign("fast", "random", "pysot-dycors", complete=4), campaign("slow", "slow", complete=1)],
    {"sphere": 0.0},
)


def test_what_a_record_lacks_is_kept_and_what_both_have_is_the_records() -> None:
    again = Gathered([cell("slow", 1, 2.5), cell("slow", 2, 2.0)], [campaign("slow", "slow", complete=2)], {"other": 1.0})
    both = continued(EARLIER, again)
    assert sorted(both.cells, key=lambda run: run.key) == sorted([*FAST, *again.cells], key=lambda run: run.key)
    assert [(entry["campaign"], entry["complete"]) for entry in both.campaigns] == [("fast", 4), ("slow", 2)]
    assert both.optima == {"sphere": 0.0, "other": 1.0}


def test_a_campaign_that_goes_on_elsewhere_counts_the_runs_of_both_places() -> None:
    rest = Gathered([cell("slow", 3, 2.0)], [campaign("slow", "slow", repetitions=3, complete=1)], {})
    slow = continued(EARLIER, rest).campaigns[-1]
    assert (slow["planned"], slow["complete"]) == (3, 2)


def test_campaigns_of_one_name_with_other_strategies_are_two() -> None:
    other = Gathered([cell("dycors", 1, 2.0)], [campaign("fast", "dycors", repetitions=1, complete=1)], {})
    assert [entry["complete"] for entry in continued(EARLIER, other).campaigns] == [4, 1, 1]


def test_results_go_on_from_results(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(evaluate, "BEST_KNOWN", tmp_path / "best_known.json")
    rest = Gathered([cell("slow", 2, 2.0)], [campaign("slow", "slow", complete=1)], {"sphere": 0.0})
    results = str(tmp_path / "results")
    for record, more in ((EARLIER, []), (rest, ["--earlier", results])):
        monkeypatch.setattr(evaluate, "gathered", lambda folders, record=record: record)
        monkeypatch.setattr(sys, "argv", ["evaluate.py", "record", *more, "--out", results])
        assert evaluate.main() == 0
    assert "Record complete: fast 4 of 4 runs, slow 2 of 2 runs" in (tmp_path / "results" / "tables.md").read_text()
    assert read_results(tmp_path / "results") == Gathered(
        sorted([*EARLIER.cells, *rest.cells], key=lambda run: run.key),
        [campaign("fast", "random", "pysot-dycors", complete=4), campaign("slow", "slow", complete=2)],
        {"sphere": 0.0},
    )


def test_a_folder_without_results_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(evaluate, "gathered", lambda folders: EARLIER)
    monkeypatch.setattr(sys, "argv", ["evaluate.py", "record", "--earlier", str(tmp_path), "--out", str(tmp_path)])
    with pytest.raises(SystemExit):
        evaluate.main()
    assert f"earlier: {tmp_path} has no cells.csv" in capsys.readouterr().err
    assert not list(tmp_path.iterdir()), "a refusal leaves nothing behind"
