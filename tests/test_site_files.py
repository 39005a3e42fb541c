import json
import re
import tomllib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from command_line import Answer, refused

Cli = Callable[..., Answer]


@pytest.mark.parametrize(
    ("text", "messages"),
    [
        ("[variables.xr1]\nlower = 900\nupper = 100", ("xr1", "below", "900 and 100")),
        ("[variables.xr9]\nlower = 1", ("variables", "'xr9'")),
        ("[variables.xn]\nlower = 0.5", ("variables.xn.lower", "integer", "0.5")),
        ("[variables.xl]\nupper = 200", ("variables: at the upper bounds", "type_2_strip_length", "12 m", "20 m")),
        ("[variables.xn]\nupper = 500", ("variables: at the upper bounds", "strengthened_sleepers", "500")),
        ("[track.geometry]\nslab_count = 50", ("crossing", "400 m", "134 m")),
        ("[track.passage]\nspeed = 1500.0", ("speed", "critical", "1500")),
        ("[worst]\nF_min = 3.0", ("worst", "'F_min'", "F_rms, F_max, E_rms, E_max")),
        ("[worst]\nF_max = true", ("worst.F_max", "finite number")),
        ("worst = 3", ("worst", "3")),
        ("[variables.xs3]\nlower = 5", ("xs3", "5 to 7", "4")),
        ("[trak]\nx = 1", ("[trak]", "track, variables, worst, given, strategy.NAME, scalariser.NAME")),
        ("[track.rail]\narea = nan", ("track.rail.area", "finite")),
        ("[track.zone]\nsleeper_distances = [0.6, 0.6, 0.45]", ("0.1 m", "0.45")),
        ("[strategy.dycors]\nsigma_start = 'big'", ("strategy.dycors", "sigma_start", "'big'")),
        ("[strategy.magic]\na = 1", ("[strategy.magic]: unknown strategy 'magic'",)),
        ("problem = 'bridge'", ("'bridge'", "'level-crossing'")),
        ("given = 3", ("given", "3")),
        ("track = 3", ("track", "3")),
        ("[[", ("not a TOML file",)),
    ],
)
def test_a_bad_site_file_is_refused_by_field(railsearch: Cli, tmp_path: Path, text: str, messages: tuple[str, ...]) -> None:
    path = tmp_path / "site.toml"
    path.write_text(text)
    refused(railsearch("evaluate", "level-crossing", "--parameters", path), *messages)


def test_a_written_site_file_is_the_default_site(railsearch: Cli, tmp_path: Path) -> None:
    path = tmp_path / "site.toml"
    assert railsearch("init", "level-crossing", "--out", path).code == 0
    document = tomllib.loads(path.read_text())
    assert {"track", "variables", "worst", "strategy", "scalariser"} <= set(document)
    assert re.search(r"# young_modulus|# Young's modulus \[Pa\]", path.read_text())
    plain = json.loads(railsearch("evaluate", "level-crossing", "--json").out)
    assert json.loads(railsearch("evaluate", "level-crossing", "-p", path, "--json").out) == plain
    refused(railsearch("init", "level-crossing", "--out", path), "exists")


def test_lists_may_stand_in_a_file_beside_the_site(railsearch: Cli, tmp_path: Path) -> None:
    position = np.arange(0.0, 136.0, 0.25)
    table = np.column_stack([position, 1e-4 * np.sin(2.0 * np.pi * position / 1.3)])
    np.savetxt(tmp_path / "level.csv", table, delimiter=",", header="x [m], r [m], positive upward")
    path = tmp_path / "site.toml"
    columns = 'position = { file = "level.csv", column = 1 }\nheight = { file = "level.csv", column = 2 }'
    path.write_text(f"[track.irregularity]\n{columns}\n")
    document = json.loads(railsearch("simulate", "level-crossing", "-p", path, "--json").out)
    assert np.allclose(document["parameters"]["irregularity"]["height"], table[:, 1], rtol=1e-12)
    assert document["metrics"]["F_max"] > 2.0 * 1700.0, "a wavy rail shakes the wheel"
    path.write_text(f"[track.irregularity]\n{columns.replace('= 2', '= 3')}\n")
    refused(railsearch("evaluate", "level-crossing", "-p", path), "level.csv", "3 or more columns")
    path.write_text(f"[track.irregularity]\n{columns.replace('level', 'absent')}\n")
    refused(railsearch("evaluate", "level-crossing", "-p", path), "absent.csv", "No such file")


def test_given_designs_of_a_site_come_after_the_reference(railsearch: Cli, tmp_path: Path) -> None:
    path = tmp_path / "site.toml"
    path.write_text("[[given]]\nxr3 = 100\n[[given]]\nxr1 = 1120\n")
    words = ("run", "level-crossing", "--objectives", "F_max", "--strategy", "random", "--budget", 3, "-p", path)
    document = json.loads(railsearch(*words, "--seed", 1, "--out", tmp_path / "run", "--json").out)
    assert [row["origin"] for row in document["evaluations"]] == ["given", "given", "random"]
    assert document["evaluations"][1]["design"] == {**document["reference"]["design"], "xr3": 100.0}


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ("xr1 = 99999", "[[given]] 1: variable xr1: allowed is 50 to 1200 MN/m, received 99999"),
        ("xr1 = 300\n[[given]]\nxr9 = 300", "[[given]] 2: unknown variable 'xr9', did you mean 'xr"),
    ],
)
def test_a_bad_given_design_is_refused_by_its_number(railsearch: Cli, tmp_path: Path, given: str, message: str) -> None:
    path = tmp_path / "site.toml"
    path.write_text(f"[[given]]\n{given}\n")
    words = ("run", "level-crossing", "--objectives", "F_max", "--parameters", path, "--out", tmp_path / "run")
    refused(railsearch(*words), f"{path}: {message}")
    assert not (tmp_path / "run").exists()


def test_settings_of_a_scalariser_that_do_not_go_together_name_the_file(railsearch: Cli, tmp_path: Path) -> None:
    path = tmp_path / "site.toml"
    path.write_text("[scalariser.lp]\nweights = { F_max = 1.0, E_max = -1.0 }\n")
    words = ("run", "level-crossing", "--scalarise", "lp", "--parameters", path, "--out", tmp_path / "run")
    refused(railsearch(*words), f"{path}: scalariser.lp.weights.E_max: a weight ≥ 0 is needed, received -1.0")
