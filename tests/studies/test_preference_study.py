"""The recorded study of design problem B: it is what its command makes, holds what it claims, and the README says so."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import railsearch
from examples.preference_study.__main__ import ORIGIN, main
from examples.preference_study.points import read_points
from examples.preference_study.ranges import linear_preferences, outward, preference_file
from examples.preference_study.record import worst_score
from examples.preference_study.tables import compromises, study_tables
from railsearch.preferences import scores
from railsearch.result import stated_preferences
from railsearch.site import read_toml

FOLDER = Path(__file__).parents[2] / "examples" / "preference_study"
RECORD: dict[str, Any] = json.loads((FOLDER / "study.json").read_text(encoding="utf-8"))
NAME = "level-crossing-preference"
SHORT_SITE = f'problem = "{NAME}"\n[track.geometry]\ntotal_length = 60.0\napproach_length = 30.0\n'
SCORED = [*RECORD["designs"], *(entry for found in RECORD["found"].values() for entry in found.values())]


@pytest.mark.parametrize(
    ("low", "high", "expected"),
    [(0.13, 1.33, (0.1, 1.4)), (8562.2, 12413.0, (8500.0, 12500.0)), (0.1, 1.4, (0.1, 1.4)), (0.0894, 0.2051, (0.08, 0.21))],
)
def test_ranges_are_rounded_outward(low: float, high: float, expected: tuple[float, float]) -> None:
    assert outward(low, high) == expected


def test_the_own_ranges_are_the_rounded_extremes() -> None:
    text = (FOLDER / "own-ranges.toml").read_text(encoding="utf-8")
    assert text == preference_file(linear_preferences(RECORD["extremes"]), RECORD["objectives"], ORIGIN)
    for objective, ends in RECORD["extremes"].items():
        stated = read_toml(FOLDER / "own-ranges.toml")["preferences"][objective]
        assert stated["best"] <= ends["smallest"]["value"] < ends["largest"]["value"] <= stated["worst"]


def test_the_published_ranges() -> None:
    stated = read_toml(FOLDER / "published-ranges.toml")["preferences"]
    ranges = {name: (table["best"], table["worst"]) for name, table in stated.items()}
    assert ranges == {"E_max": (0.1, 1.4), "A_max": (0.21, 0.26), "C_cap": (8500.0, 12500.0)}


def test_with_the_published_ranges_accelerations_have_no_influence() -> None:
    assert {entry["scores"]["published"]["A_max"] for entry in SCORED} == {100.0}


@pytest.mark.parametrize("entry", SCORED, ids=lambda entry: entry["label"])
def test_recorded_designs_have_the_recorded_values_and_scores(entry: dict[str, Any]) -> None:
    problem = railsearch.problem(NAME)
    metrics = problem.simulate(np.array([entry["design"][name] for name in problem.space.names], dtype=float)).metrics
    assert metrics == pytest.approx(entry["metrics"], rel=1e-6)
    for name, ranges in RECORD["preferences"].items():
        for objective, ends in ranges.items():
            score = 100.0 * (ends["worst"] - metrics[objective]) / (ends["worst"] - ends["best"])
            assert entry["scores"][name][objective] == pytest.approx(np.clip(score, 0.0, 100.0), abs=1e-3)


@pytest.mark.parametrize("route", list(RECORD["found"]))
def test_the_two_lowest_scores_are_level(route: str) -> None:
    first, second, _ = sorted(RECORD["found"][route]["own"]["scores"]["own"].values())
    assert second - first <= 3.0


@pytest.mark.parametrize("route", list(RECORD["found"]))
def test_no_optimum_of_a_single_objective_has_a_higher_worst_score(route: str) -> None:
    compromise = worst_score(RECORD["found"][route]["own"], "own")
    assert all(worst_score(entry, "own") < compromise for entry in RECORD["designs"])


def test_no_point_of_the_surrogates_has_a_higher_worst_score() -> None:
    points = read_points(FOLDER / "points.csv")
    stated = railsearch.problem(
        NAME, scalariser="preference-minmax", scalariser_settings=read_toml(FOLDER / "own-ranges.toml")
    )
    worst = scores(stated_preferences(stated), points).min(axis=1)
    assert worst.size == RECORD["points"]["number"] == 2000
    assert worst.max() == pytest.approx(RECORD["points"]["own"]["worst_score"], abs=1e-6)
    for found in RECORD["found"].values():
        assert worst.max() < worst_score(found["own"], "own")


def test_some_points_have_the_recorded_values() -> None:
    points, problem = read_points(FOLDER / "points.csv"), railsearch.problem(NAME)
    rows = np.random.default_rng(1).integers(0, 2000, 3)
    designs = np.column_stack([points[name] for name in problem.space.names])
    assert points["C_cap"] == pytest.approx(problem.exact_objectives["C_cap"](designs), rel=1e-9)
    for row in rows:
        expected = [points[quantity.name][row] for quantity in problem.objectives]
        assert problem.simulate(designs[row]).objectives == pytest.approx(expected, rel=1e-6)


def test_errors_of_the_surrogates_are_reported_for_every_simulated_objective() -> None:
    errors = {finding["name"]: finding["value"] for finding in RECORD["surrogates"]}
    for objective in ("E_max", "A_max"):
        assert 0.0 < errors[f"{objective}: generalisation error"] < 10.0
    assert not any(name.startswith("C_cap") for name in errors)


def test_the_readme_has_every_table_and_every_figure() -> None:
    text = (FOLDER / "README.md").read_text(encoding="utf-8")
    rows = [line for line in study_tables(RECORD).splitlines() if line.startswith("|")]
    assert len(rows) > 20
    assert set(rows) <= set(text.splitlines())
    for figure in ("preferences", "scores", "points", "histories", "energy", "acceleration", "zone"):
        assert f"({figure}.png)" in text
        assert (FOLDER / f"{figure}.png").stat().st_size < 300_000


def test_the_command_makes_the_record(study: Callable[..., dict[str, Any]], tmp_path: Path) -> None:
    site, out = tmp_path / "short.toml", tmp_path / "study"
    site.write_text(SHORT_SITE, encoding="utf-8")
    words = ("--parameters", site, "--extreme-budget", 20, "--direct-budget", 20, "--points", 30, "--confirmations", 1)
    first = study(main, out, *words)
    assert set(compromises(first, "own")) == {"direct search", "fixed surrogates"}
    assert set(compromises(first, "published")) == {"direct search"}
    assert read_points(out / "points.csv")["E_max"].size == first["points"]["number"] == 30
    assert (out / "tables.md").read_text(encoding="utf-8") == study_tables(first)
