"""The design problem on an imported track, its commands, and its likeness to the level crossing that was exported."""

import json
import re
import tomllib
from dataclasses import replace

import numpy as np
import pytest

import railsearch as package
from railsearch.errors import InputError
from railsearch.site import read_toml
from railsearch_problems.imported_track import Design

LENGTHS = {"total_length": 35, "approach_length": 14, "slab_length": 5}
CHANGES = {f"geometry.{name}": value for name, value in LENGTHS.items()} | {
    "windows.energy_sleepers": 10,
    "passage.element_length": 0.2,
}
SHORT = [word for name, value in CHANGES.items() for word in ("--set", f"{name}={value}")]
VARIABLES = """
[design.variables.pad_3]
lower = 50.0
upper = 1200.0
unit = "MN/m"

[design.variables.others]
parts = ["pad_1", "pad_2"]
scale = 1120.0
lower = 0.05
upper = 1.1
meaning = "share of the usual stiffness"
"""


@pytest.fixture
def site(railsearch, tmp_path):
    """The site file of a short level crossing that was exported, with two design variables."""
    answer = railsearch("export-track", "level-crossing", *SHORT, "--parts", "--out", tmp_path / "track")
    assert answer.code == 0, answer.err
    file = tmp_path / "track" / "site.toml"
    own = re.sub(r"\n# What a search may change.*?\n\n", "\n", file.read_text(encoding="utf-8"), flags=re.DOTALL)
    assert "design.variables" not in own
    file.write_text(own + VARIABLES, encoding="utf-8")
    return file


def test_an_exported_track_can_be_searched_as_it_is(railsearch, tmp_path):
    answer = railsearch("export-track", "level-crossing", *SHORT, "--parts", "--out", tmp_path / "track")
    assert answer.code == 0, answer.err
    problem = package.problem("imported-track", sections=sections(tmp_path / "track" / "site.toml"))
    assert problem.space.named(problem.reference) == {"pad_1": 1120.0, "pad_2": 1120.0, "pad_3": 1120.0}
    np.testing.assert_allclose(problem.space.lower, 112.0)


def sections(site):
    document = read_toml(site)
    document.pop("problem")
    return document


def test_variables_scale_parts(site):
    problem = package.problem("imported-track", sections=sections(site))
    assert problem.space.named(problem.reference) == {"pad_3": 1120.0, "others": 1.0}
    crossing = package.problem("level-crossing", sections={"track": {}})
    short = replace(
        crossing.track,
        geometry=replace(crossing.track.geometry, total_length=35.0, approach_length=14.0, slab_length=5.0),
        windows=replace(crossing.track.windows, energy_sleepers=10),
        passage=replace(crossing.track.passage, element_length=0.2),
    )
    zone = replace(short.zone, pad_stiffness=(0.3 * 1120e6, 0.3 * 1120e6, 150e6))
    expected = crossing.model.simulate(replace(short, zone=zone)).metrics
    outcome = problem.simulate(np.array([150.0, 0.3]))
    assert outcome.metrics == pytest.approx(expected, rel=1e-9)
    assert list(outcome.objectives) == [outcome.metrics["F_max"], outcome.metrics["E_max"]]


def test_commands_of_a_site(railsearch, site, tmp_path):
    direct = railsearch("simulate", "level-crossing", *SHORT, "--json")
    imported = railsearch("simulate", "imported-track", "--parameters", site, "--histories", tmp_path / "h.npz", "--json")
    assert imported.code == 0, imported.err
    expected = json.loads(direct.out)["metrics"]
    assert json.loads(imported.out)["metrics"] == pytest.approx(expected, rel=1e-9)
    assert {"wheel_rail_force", "support_energy"} <= set(np.load(tmp_path / "h.npz"))
    softer = railsearch("simulate", "imported-track", "-p", site, "--set", "factors.pad_3=100", "--json")
    assert json.loads(softer.out)["metrics"]["F_max"] != pytest.approx(expected["F_max"], rel=1e-3)
    words = ("--strategy", "random", "--objectives", "F_max", "--budget", 4, "--seed", 1, "--out", tmp_path / "run")
    run = railsearch("run", "imported-track", "--parameters", site, *words, "--json")
    assert run.code == 0, run.err
    assert len(json.loads(run.out)["evaluations"]) == 4
    page = (tmp_path / "run" / "report.html").read_text(encoding="utf-8")
    assert "Wheel-rail force" in page or "Force between wheel and rail" in page
    again = railsearch("run", "imported-track", "--parameters", site, *words)
    assert "complete" in again.err


def test_a_site_may_be_used_from_anywhere(railsearch, site, monkeypatch, tmp_path):
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    answer = railsearch("evaluate", "imported-track", "--parameters", "../track/site.toml", "--set", "others=0.5", "--json")
    assert answer.code == 0, answer.err
    assert json.loads(answer.out)["design"] == {"pad_3": 1120.0, "others": 0.5}


def test_without_a_site_it_is_a_sample(railsearch):
    problem = package.problem("imported-track")
    assert problem.space.names == ("pad_1", "pad_2", "pad_3")
    assert railsearch("describe", "imported-track").code == 0
    template = tomllib.loads(railsearch("init", "imported-track").out)
    assert template["track"]["files"]["mass"] == "SAMPLE/mass.mtx"


FAULTS = {
    "lower = 50.0\nupper = 1200.0": ("lower = 50.0", "variables.pad_3: upper must be given"),
    "lower = 0.05\n": ("lower = 2.0\n", "the lower bound must lie below the upper one"),
    '["pad_1", "pad_2"]': ('["pad_1", "pad_4"]', "unknown part 'pad_4'; there are pad_1, pad_2, pad_3"),
    'parts = ["pad_1", "pad_2"]': ('parts = ["pad_1", "pad_3"]', "'pad_3' is scaled by pad_3 already"),
    "pad_2 = 1120.0": ("pad_2 = 900.0", "have the same factor in the reference design, received pad_1 = 1120, pad_2 = 900"),
    "scale = 1120.0": ("scale = 0.0", "variables.others.scale: allowed is > 0, received 0"),
    "lower = 0.05\nupper": ("lower = -0.05\nupper", "at the lower bounds"),
}


@pytest.mark.parametrize("old", FAULTS)
def test_unsound_variables_are_refused(railsearch, site, old):
    new, words = FAULTS[old]
    text = site.read_text(encoding="utf-8")
    assert old in text
    site.write_text(text.replace(old, new), encoding="utf-8")
    answer = railsearch("evaluate", "imported-track", "--parameters", site)
    assert answer.code == 2
    assert words in answer.err


def test_variables_are_needed_for_a_track_of_ones_own(railsearch, site):
    site.write_text(site.read_text(encoding="utf-8").replace(VARIABLES, ""), encoding="utf-8")
    answer = railsearch("evaluate", "imported-track", "--parameters", site)
    assert answer.code == 2
    assert "add [design.variables.NAME] with lower and upper for the parts pad_1, pad_2, pad_3" in answer.err


def test_a_variable_is_a_table():
    with pytest.raises(InputError, match=r"variables.x: a table with lower and upper is needed, received 3"):
        Design({"x": 3})


def test_what_cannot_be_exported_is_refused(railsearch, tmp_path):
    for words, fault in (
        (("imported-track", "--out", tmp_path / "a"), "no matrices to export, those of level-crossing can be"),
        (
            ("level-crossing", *SHORT, "--format", "xls", "--out", tmp_path / "b"),
            "--format: one of npz, mtx is needed, received 'xls'",
        ),
        (("level-crossing", "--set", "passage.speed=-1", "--out", tmp_path / "c"), "passage.speed"),
    ):
        answer = railsearch("export-track", *words)
        assert (answer.code, fault in answer.err) == (2, True), answer.err
    assert railsearch("export-track", "level-crossing", *SHORT, "--out", tmp_path / "d").code == 0
    assert "is not overwritten" in railsearch("export-track", "level-crossing", *SHORT, "--out", tmp_path / "d").err
