"""docs/imported-track.md: its site file is sound, its commands are there, its script reads Abaqus' format."""

import re
import tomllib
from pathlib import Path

import numpy as np
import pytest
import scipy.io

from railsearch.parameters import make_parameters
from railsearch_plugins.track_models.imported_track import ImportedTrackParameters
from railsearch_problems.imported_track import Design

PAGE = (Path(__file__).parents[1] / "docs" / "imported-track.md").read_text(encoding="utf-8")


def block(language):
    return re.search(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)[1]


def test_the_site_file_has_parameters_that_there_are():
    document = tomllib.loads(re.sub(r"\{ file = (\".*?\") \}", r"\1", block("toml")))
    track = make_parameters(ImportedTrackParameters, document["track"], "track")
    assert track.files.mass == "track.mat#M"
    assert track.part_factors() == {"pads_near": 1120.0}
    assert set(make_parameters(Design, document["design"], "design").made()) == {"pads_near"}


def test_the_commands_are_there(railsearch):
    for name in re.findall(r"^    railsearch (\S+)", PAGE, re.MULTILINE):
        assert railsearch(name, "--help").code == 0


@pytest.mark.parametrize("stored", ["lower", "upper", "whole"])
def test_the_script_for_abaqus_reads_its_format(tmp_path, monkeypatch, stored):
    monkeypatch.chdir(tmp_path)
    matrix = np.array([[4.0, 1.0, 0.0], [1.0, 5.0, -2.0], [0.0, -2.0, 6.0]])
    places = [(-1, 1), (2, 2), (2, 6)]
    kept = {"lower": np.tril, "upper": np.triu, "whole": np.array}[stored](matrix)
    for code, scale in (("STIF", 1.0), ("MASS", 0.5)):
        lines = [
            f"{places[i][0]},{places[i][1]}, {places[j][0]},{places[j][1]}, {scale * kept[i, j]:.15e}"
            for i, j in zip(*np.nonzero(kept), strict=True)
        ]
        held = ["7,2, 7,2, 1.000000000000000e+36"]
        (tmp_path / f"JOB_{code}1.mtx").write_text("\n".join(["** a comment", *lines, *held]))
    names = {}
    exec(compile(block("python"), "imported-track.md", "exec"), names)
    assert names["convert"]("JOB", [(7, 2)]) == {(-1.0, 1.0): 0, (2.0, 2.0): 1, (2.0, 6.0): 2}
    np.testing.assert_array_equal(scipy.io.mmread("stiffness.mtx").toarray(), matrix)
    np.testing.assert_array_equal(scipy.io.mmread("mass.mtx").toarray(), 0.5 * matrix)
