"""The study of the published sensitivities: what is recorded is what its command makes, and agrees with the references."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "examples" / "published_sensitivity"
RECORD: dict[str, Any] = json.loads((FOLDER / "study.json").read_text(encoding="utf-8"))


def reference(name: str) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((ROOT / "tests" / "reference" / f"{name}.json").read_text(encoding="utf-8"))
    return found


def entries(case: str, surrogate: str) -> dict[int, dict[str, Any]]:
    return {e["samples"]: e for e in RECORD["surrogates"] if (e["case"], e["surrogate"]) == (case, surrogate)}


def test_the_readme_has_every_table_and_every_figure() -> None:
    from examples.published_sensitivity.record import study_tables

    text = (FOLDER / "README.md").read_text(encoding="utf-8")
    rows = [line for line in study_tables(RECORD).splitlines() if line.startswith("|")]
    assert len(rows) > 40
    assert set(rows) <= set(text.splitlines())
    for figure in ("importances", "convergence", "grids", "camel"):
        assert f"({figure}.png)" in text
        assert (FOLDER / f"{figure}.png").stat().st_size < 300_000


def test_recorded_importances_are_those_of_the_publication_and_of_the_references() -> None:
    exact = RECORD["exact"]["truss"]["importances"]["maximum"]
    assert {name: round(share, 4) for name, share in exact.items()} == RECORD["published"]
    assert exact == pytest.approx(reference("truss")["importance_max_weighted"]["I"], abs=1e-8)
    camel, known = RECORD["exact"]["camel"], reference("camel")
    for name in ("x1", "x2"):
        np.testing.assert_allclose(camel["curves"]["minimum"][name], known[f"min_fix_{name}"], atol=1e-8)
    for name in ("pce", "pck"):
        assert max(entries("camel", name)[100]["largest_curve_error"]) < 1e-9


def test_twenty_designs_of_every_size_and_errors_that_fall() -> None:
    for name in ("pce", "pck", "kriging"):
        found = entries("truss", name)
        assert list(found) == [100, 400, 700, 1000]
        assert all(len(entry["generalisation"]) == 20 for entry in found.values())
        medians = [np.median(entry["generalisation"]) for entry in found.values()]
        assert medians == sorted(medians, reverse=True)
    limits = {100: 2e-4, 400: 1e-6, 1000: 1e-8}
    for size, limit in limits.items():
        assert np.median(entries("truss", "pce")[size]["generalisation"]) < limit
    assert max(entries("truss", "pce")[400]["largest_error"]) < 5e-4


def test_finer_grids_converge_with_the_second_order() -> None:
    finest = RECORD["grids"][-1]
    assert (finest["spacing"], finest["points"]) == ("equal", 200)
    coarse, fine = (
        max(abs(row["importances"][name] - share) for name, share in finest["importances"].items())
        for row in RECORD["grids"]
        if row["spacing"] == "equal" and row["points"] in (10, 50)
    )
    assert coarse / fine > 0.8 * (49 / 9) ** 2


def test_the_command_makes_a_record_and_goes_on(study: Callable[..., dict[str, Any]], tmp_path: Path, capsys: Any) -> None:
    from examples.published_sensitivity.__main__ import main

    words = ("--designs", 1, "--sizes", 1, "--grids", 5, 10, "--seed", 1)
    record = study(main, tmp_path, *words)
    assert "truss kriging 100 1" in capsys.readouterr().out
    first = {(e["case"], e["surrogate"]): e for e in record["surrogates"]}
    for (case, surrogate), entry in first.items():
        recorded = entries(case, surrogate)[100]
        # The likelihood is flat: other numbers of threads change the length scales of a process in the fourth digit.
        assert entry["generalisation"][0] == pytest.approx(recorded["generalisation"][0], rel=1e-2, abs=1e-25)
        for sense, shares in entry["importances"].items():
            for name, share in shares.items():
                assert share[0] == pytest.approx(recorded["importances"][sense][name][0], abs=1e-4)
    again = study(main, tmp_path, *words)
    assert "truss kriging 100 1" not in capsys.readouterr().out
    assert again == record
