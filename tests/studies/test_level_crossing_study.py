"""The recorded study of design problem A: it is what its command makes, and the README says what is in it."""

import json
import sqlite3
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import railsearch
from examples.level_crossing_study.__main__ import main
from examples.level_crossing_study.tables import study_tables

FOLDER = Path(__file__).parents[2] / "examples" / "level_crossing_study"
RECORD: dict[str, Any] = json.loads((FOLDER / "study.json").read_text(encoding="utf-8"))
OPTIMA = {optimum["label"]: optimum for optimum in RECORD["optima"]}
MEASURES = ("F_rms", "F_max", "E_rms", "E_max")
SHORT_SITE = 'problem = "level-crossing"\n[track.geometry]\ntotal_length = 60.0\napproach_length = 30.0\n'


def metrics_of(design: dict[str, float]) -> dict[str, float]:
    problem = railsearch.problem("level-crossing")
    return dict(problem.simulate(np.array([design[name] for name in problem.space.names], dtype=float)).metrics)


def test_the_searches_are_those_of_the_study() -> None:
    budgets = {name: (optimum["strategy"], optimum["budget"], optimum["failed"]) for name, optimum in OPTIMA.items()}
    assert budgets == dict.fromkeys(MEASURES, ("dycors", 200, 0)) | {"asf": ("dycors", 400, 0)}
    reference, achievement = RECORD["reference"]["metrics"], RECORD["achievement"]
    assert achievement["worst"] == {"F_max": 6000.0, "E_max": 1.5}
    assert achievement["aspiration"] == pytest.approx({name: 0.8 * reference[name] for name in ("F_max", "E_max")})


@pytest.mark.parametrize("name", ["reference", "published", *OPTIMA])
def test_recorded_designs_have_the_recorded_values(name: str) -> None:
    entry = {"reference": RECORD["reference"], "published": RECORD["published"]["here"], **OPTIMA}[name]
    assert metrics_of(entry["design"]) == pytest.approx(entry["metrics"], rel=1e-6)


def test_one_design_improves_force_by_20_and_energy_by_45_per_cent() -> None:
    found, start = metrics_of(OPTIMA["asf"]["design"]), metrics_of(RECORD["reference"]["design"])
    assert found["F_max"] <= 0.80 * start["F_max"]
    assert found["E_max"] <= 0.55 * start["E_max"]


@pytest.mark.parametrize("name", MEASURES)
def test_no_other_single_objective_optimum_is_better_in_a_measure(name: str) -> None:
    own = OPTIMA[name]["metrics"][name]
    assert own == OPTIMA[name]["value"]
    assert own < RECORD["reference"]["metrics"][name]
    assert own == min(OPTIMA[other]["metrics"][name] for other in MEASURES)


def test_histories_fall_to_the_optimum() -> None:
    for optimum in OPTIMA.values():
        values = [entry["value"] for entry in optimum["history"]]
        assert np.all(np.diff(values) < 0.0)
        assert values[-1] == optimum["value"]
        assert optimum["history"][-1]["evaluation"] == optimum["found_at"] <= optimum["budget"]


def test_mean_levels_vary_ten_times_less_than_ranges() -> None:
    sampled = {name: np.array(values) for name, values in RECORD["random"]["values"].items()}
    variation = {name: values.std() / values.mean() for name, values in sampled.items()}
    assert all(values.size == RECORD["random"]["number"] for values in sampled.values())
    assert 10.0 * max(variation["F_rms"], variation["E_rms"]) <= min(variation["F_max"], variation["E_max"])


def test_the_readme_has_every_table_and_every_figure() -> None:
    text = (FOLDER / "README.md").read_text(encoding="utf-8")
    rows = [line for line in study_tables(RECORD).splitlines() if line.startswith("|")]
    assert len(rows) > 20
    assert set(rows) <= set(text.splitlines())
    for figure in ("histories", "measures", "force", "energy"):
        assert f"({figure}.png)" in text
        assert (FOLDER / f"{figure}.png").stat().st_size < 300_000


def test_the_command_makes_the_record_and_goes_on_after_a_stop(study: Callable[..., dict[str, Any]], tmp_path: Path) -> None:
    site, out = tmp_path / "short.toml", tmp_path / "study"
    site.write_text(SHORT_SITE, encoding="utf-8")
    words = ("--parameters", site, "--budget", 20, "--asf-budget", 21, "--random", 3, "--seed", 2)
    first = study(main, out, *words)
    assert {path.name for path in out.glob("*.*")} >= {"study.db", "tables.md", "energy.png", "force.png", "measures.png"}
    assert [optimum["label"] for optimum in first["optima"]] == [*MEASURES, "asf"]
    assert (out / "tables.md").read_text(encoding="utf-8") == study_tables(first)
    stop(out / "study.db", "asf", 12)
    assert study(main, out, *words) == first


def stop(database: Path, search: str, evaluations: int) -> None:
    """Leave a search as a stop after so many evaluations would have left it, and the searches after it not begun."""
    with sqlite3.connect(database) as connection:
        (begun,) = connection.execute("SELECT study_id FROM studies WHERE study_name LIKE ?", (f"{search} /%",)).fetchone()
        connection.execute("DELETE FROM trials WHERE study_id > ?", (begun,))
        connection.execute("DELETE FROM trials WHERE study_id = ? AND number >= ?", (begun, evaluations))
        tables = [name for (name,) in connection.execute("SELECT name FROM sqlite_master WHERE type = 'table'")]
        for table in tables:
            columns = {row[1] for row in connection.execute(f"PRAGMA table_info({table})")}
            if table != "trials" and "trial_id" in columns:
                connection.execute(f"DELETE FROM {table} WHERE trial_id NOT IN (SELECT trial_id FROM trials)")
