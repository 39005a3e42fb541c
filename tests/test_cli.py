import json
import math
import re
import subprocess
import sys
import tomllib
import types
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rich.table import Table

from command_line import Answer, refused
from railsearch.commands import tables
from railsearch.hookspecs import hookimpl
from sample_problems import Troubled, TwoObjectives

Cli = Callable[..., Answer]
REFERENCE = {"xr1": 1120.0, "xr2": 1120.0, "xr3": 1120.0, "xn": 8, "xs1": 6, "xs2": 6, "xs3": 4, "xl": 0}


def sample_problems() -> types.ModuleType:
    @hookimpl
    def railsearch_problems(register: Callable[[str, Any], None]) -> None:
        register("troubled", Troubled)
        register("two", TwoObjectives)

    made = types.ModuleType("samples")
    vars(made)["railsearch_problems"] = railsearch_problems
    return made


def test_help_teaches(railsearch: Cli) -> None:
    assert "railsearch run level-crossing" in railsearch("--help").out
    for command in ("list", "describe", "init", "simulate", "evaluate", "sample", "run", "show", "dashboard"):
        assert "Usage" in railsearch(command, "--help").out


def test_the_reference_design_is_evaluated_by_default(railsearch: Cli) -> None:
    document = json.loads(railsearch("evaluate", "level-crossing", "--json").out)
    assert document["design"] == REFERENCE
    assert set(document["metrics"]) == {"F_rms", "F_max", "E_rms", "E_max", "A_max"}
    assert document["objectives"] == {name: document["metrics"][name] for name in ("F_max", "E_max")}
    assert math.isclose(document["metrics"]["F_max"], 1700.14594, rel_tol=1e-6)
    table = railsearch("evaluate", "level-crossing", "--set", "xr1=300").out
    assert re.search(r"xr1 +MN/m +300", table)
    assert "A_max [m/s²]" in table


def test_simulate_takes_the_track_models_own_parameters(railsearch: Cli, tmp_path: Path) -> None:
    histories = tmp_path / "histories.npz"
    words = ("--set", "zone.pad_stiffness=[214e6, 155e6, 50e6]", "--set", "zone.strengthened_sleepers=5")
    words += ("--set", "zone.sleeper_distances=[0.6, 0.7, 0.3]")
    answer = railsearch("simulate", "level-crossing", *words, "--histories", histories, "--json")
    document = json.loads(answer.out)
    assert math.isclose(document["metrics"]["F_max"], 1078.7541, rel_tol=1e-6)
    assert document["units"]["F_max"] == "N"
    with np.load(histories) as stored:
        assert {"wheel_rail_force", "carbody_acceleration", "sleeper_energy"} <= set(stored)
        assert stored["wheel_rail_force"].shape == (3446,)


@pytest.mark.parametrize(
    ("words", "messages"),
    [
        (("evaluate", "level-crossing", "--set", "xr9=1"), ("'xr9'",)),
        (("evaluate", "level-crossing", "--set", "xn=1.5"), ("xn", "whole number", "1.5")),
        (("evaluate", "level-crossing", "--set", "xr1=nan"), ("xr1", "finite", "nan")),
        (("evaluate", "level-crossing", "--set", "xr1=soft"), ("xr1", "a number", "'soft'")),
        (("evaluate", "level-crossing", "--set", "xr1=49"), ("xr1", "50 to 1200 MN/m", "49 MN/m")),
        (("evaluate", "level-crossing", "--set", "xr1"), ("NAME=VALUE", "'xr1'")),
        (("evaluate", "level-crosing"), ("unknown problem 'level-crosing'", "did you mean 'level-crossing'")),
        (("evaluate", "level-crossing", "--objectives", "F_min"), ("'F_min'", "F_rms, F_max, E_rms, E_max")),
        (("evaluate", "level-crossing", "--parameters", "absent.toml"), ("absent.toml", "No such file")),
        (("simulate", "level-crossing", "--set", "passage.speed=0"), ("passage.speed", "> 0", "0.0 m/s")),
        (("simulate", "level-crossing", "--set", "passage.speed=800"), ("speed", "critical", "800")),
        (("simulate", "level-crossing", "--set", "ballast.stiffness=-1"), ("ballast.stiffness", "> 0", "-1.0 N/m")),
        (("simulate", "level-crossing", "--set", "geometry.slab_length=60"), ("crossing", "220 m", "134 m")),
        (("simulate", "level-crossing", "--set", "rail.aera=1"), ("'aera'", "did you mean 'area'")),
        (("simulate", "level-crossing", "--histories", "x.csv"), ("--histories", ".npz")),
        (("list", "problems"), ("KIND", "'problems', did you mean 'problem'?", "track-model")),
        (
            ("run", "level-crossing", "--objectives", "F_mxa"),
            ("objectives: unknown 'F_mxa', did you mean 'F_max'?", "E_rms"),
        ),
        (("describe", "nothing"), ("unknown plugin 'nothing'; `railsearch list` has all names",)),
        (("describe", "dycor"), ("unknown plugin 'dycor', did you mean 'dycors'?", "railsearch list")),
        (("describe", "physical-programming"), ("a preference function", "docs/preferences.md")),
        (("describe", "sklearn.svm.SVR"), ("a regressor of scikit-learn", "docs/strategies.md")),
        (("sample", "level-crossing", "--seed", "-1"), ("seed", "-1")),
        (("show", "."), ("holds no run",)),
    ],
)
def test_bad_input_ends_with_code_2_and_names_field_and_value(
    railsearch: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: tuple[str, ...], messages: tuple[str, ...]
) -> None:
    monkeypatch.chdir(tmp_path)
    refused(railsearch(*words), *messages)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("words", "messages"),
    [
        (("--budget", "19", "--objectives", "F_max"), ("budget", "at least 20", "19")),
        (("--budget", "0", "--objectives", "F_max"), ("budget", "0")),
        (("--strategy", "dycor"), ("unknown strategy 'dycor'", "did you mean 'dycors'")),
        ((), ("dycors handles one objective", "F_max, E_max", "asf", "nsga2")),
        (("--scalarise", "asf", "--objectives", "F_rms,E_max"), ("F_rms", "railsearch sample")),
        (("--scalarise", "asf", "--objectives", "F_max"), ("two objectives",)),
        (("--objectives", "F_max", "--set", "sigma=1"), ("strategy dycors", "'sigma'")),
        (("--objectives", "F_max", "--seed", "-3"), ("seed", "-3")),
        (("--objectives", "F_max", "--initial-seed", "-4"), ("initial-seed: an integer", "-4")),
        (("--objectives", "F_max", "--strategy", "cmaes", "--set", "population_size=1000000000"), ("cmaes needs at least",)),
        (("--objectives", "F_max", "--timeout", "0"), ("timeout", "0")),
        (("--objectives", "F_max", "--batch", "0"), ("batch", "0")),
        (("--objectives", "F_max", "--set", "rail.area=1"), ("rail.area", "--parameters", "railsearch init level-crossing")),
        (("--objectives", "F_max", "--set", "speed=1"), ("'speed'", "--parameters", "railsearch init level-crossing")),
        (("--scalarise", "nope", "--objectives", "F_max"), ("unknown scalariser 'nope'",)),
        (("--objectives", "F_max", "--storage", "nonsense"), ("--storage", "nonsense")),
        (("--objectives", "F_max", "--out", "/dev/null/run"), ("/dev/null", "a folder is needed, and there is a file")),
    ],
)
def test_a_bad_run_is_refused_before_anything_is_evaluated(
    railsearch: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: tuple[str, ...], messages: tuple[str, ...]
) -> None:
    monkeypatch.chdir(tmp_path)
    refused(railsearch("run", "level-crossing", *words), *messages)
    assert list(tmp_path.iterdir()) == []
    assert len(railsearch("run", "level-crossing", *words).err.splitlines()) <= 2


def test_list_and_describe(railsearch: Cli) -> None:
    rows = json.loads(railsearch("list", "strategy", "--json").out)
    assert {"dycors", "lmsrs", "random", "ga", "nsga2"} <= {row["name"] for row in rows}
    assert {row["distribution"] for row in rows} == {"railsearch"}
    documents = {row["kind"]: row for row in json.loads(railsearch("describe", "level-crossing", "--json").out)}
    variables = {variable["name"]: variable for variable in documents["problem"]["variables"]}
    assert (variables["xr1"]["unit"], variables["xr1"]["lower"], variables["xr1"]["upper"]) == ("MN/m", 50.0, 1200.0)
    parameters = {row["name"]: row for row in documents["problem"]["parameters"]}
    assert parameters["track.rail.young_modulus"]["source"]
    assert all(row["meaning"] for row in parameters.values())
    text = railsearch("describe", "dycors").out
    assert "sigma_start" in text
    for entry in json.loads(railsearch("list", "--json").out):
        assert railsearch("describe", entry["name"]).code == 0


def test_a_run_is_recorded_reported_and_not_repeated(railsearch: Cli, tmp_path: Path) -> None:
    words = ("run", "level-crossing", "--scalarise", "asf", "--strategy", "random", "--budget", 5, "--out", tmp_path / "run")
    first = railsearch(*words, "--seed", 7)
    assert first.code == 0, first.err
    document = json.loads((tmp_path / "run" / "result.json").read_text())
    assert (document["status"], document["budget"], document["seed"], document["failed"]) == ("complete", 5, 7, 0)
    assert [row["number"] for row in document["evaluations"]] == [1, 2, 3, 4, 5]
    assert document["evaluations"][0]["design"] == REFERENCE
    assert document["reference"]["origin"] == "given"
    assert document["scalariser"]["values"]["aspiration"]["F_max"] == 0.8 * document["reference"]["metrics"]["F_max"]
    assert {plugin["name"] for plugin in document["plugins"]} >= {"level-crossing", "random", "asf"}
    assert "numpy" in document["versions"]
    assert "better by" in first.out
    assert "F_max [N]" in first.out
    for name in ("report.html", "study.db", "figures"):
        assert (tmp_path / "run" / name).exists()
    assert {path.suffix for path in (tmp_path / "run" / "figures").iterdir()} == {".png", ".svg"}
    before = {
        path: path.stat().st_mtime_ns
        for path in (tmp_path / "run").rglob("*")
        if path.name in ("report.html", "result.json")
    }
    again = railsearch(*words, "--json")
    assert "complete" in again.err
    assert json.loads(again.out) == document
    assert {path: path.stat().st_mtime_ns for path in before} == before
    shown = railsearch("show", tmp_path / "run", "--json")
    assert json.loads(shown.out)["evaluations"] == document["evaluations"]
    assert json.loads(shown.out)["best"] == document["best"]


def test_another_run_does_not_touch_the_folder(railsearch: Cli, tmp_path: Path) -> None:
    words = ("run", "level-crossing", "--objectives", "F_max", "--strategy", "random", "--budget", 2, "--out", tmp_path)
    assert railsearch(*words, "--seed", 1).code == 0
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    refused(railsearch(*words, "--seed", 2), "another run", "seed: there 1, here 2", "Nothing was changed")
    other = ("run", "level-crossing", "--objectives", "E_max", "--strategy", "random", "--budget", 2, "--out", tmp_path)
    refused(railsearch(*other, "--seed", 1), "another run", "objectives")
    refused(railsearch(*words[:-3], 3, "--out", tmp_path, "--seed", 1), "another run", "budget: there 2, here 3")
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before


def test_a_storage_url_takes_many_runs_and_refuses_a_changed_one(railsearch: Cli, tmp_path: Path) -> None:
    url = f"sqlite:///{tmp_path / 'all.db'}"
    words = ("run", "ackley", "--strategy", "random", "--storage", url)
    assert railsearch(*words, "--budget", 2, "--seed", 1, "--out", tmp_path / "one").code == 0
    assert railsearch(*words, "--budget", 2, "--seed", 2, "--out", tmp_path / "two").code == 0
    answer = railsearch(*words, "--budget", 3, "--seed", 1, "--out", tmp_path / "three")
    refused(answer, "all.db", "budget: there 2, here 3")
    assert not (tmp_path / "three" / "run.json").exists(), "the refused command leaves no claim behind"
    assert len(json.loads(railsearch("show", tmp_path / "two", "--json").out)["evaluations"]) == 2


def test_failures_and_time_outs_are_results(railsearch: Cli, tmp_path: Path, install: Callable[..., None]) -> None:
    install(samples=sample_problems)
    words = ("run", "troubled", "--strategy", "random", "--budget", 25, "--seed", 3, "--timeout", 0.4, "--out", tmp_path)
    answer = railsearch(*words, "--json")
    assert answer.code == 0, answer.err
    document = json.loads(answer.out)
    assert len(document["evaluations"]) == 25
    reasons = " ".join(row["reason"] for row in document["evaluations"])
    assert all(word in reasons for word in ("no ballast", "time limit of 0.4 s exceeded", "process died", "distance is"))
    assert document["best"]["reason"] == ""


def test_two_objectives_give_a_front(railsearch: Cli, tmp_path: Path, install: Callable[..., None]) -> None:
    install(samples=sample_problems)
    answer = railsearch("run", "two", "--strategy", "nsga2", "--budget", 60, "--seed", 1, "--out", tmp_path)
    assert answer.code == 0, answer.err
    assert "front of" in answer.out
    document = json.loads((tmp_path / "result.json").read_text())
    assert len(document["front"]) > 2
    assert "of its" not in answer.out, "all are listed"
    table = tables.result_tables({**document, "front": (3 * document["front"])[:24]})[-1]
    assert isinstance(table, Table)
    assert (table.title, table.row_count) == ("front: 12 of its 24 designs, all are in result.json", 12)
    assert document["reference"]["metrics"]["comfort"] > 0, "a maximised quantity is shown with its natural sign"


def test_sample_prints_the_worst_values_as_a_section(railsearch: Cli) -> None:
    answer = railsearch("sample", "level-crossing", "--number", 4, "--seed", 1)
    section = tomllib.loads(answer.out)["worst"]
    rows = json.loads(railsearch("sample", "level-crossing", "--number", 4, "--seed", 1, "--json").out)["objectives"]
    assert all(row["worst"] <= section[name] <= 1.01 * row["worst"] for name, row in rows.items())
    assert set(section) == {"F_rms", "F_max", "E_rms", "E_max"}


def test_a_run_is_shown_from_anywhere_and_nothing_is_made_by_looking(
    railsearch: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "here").mkdir()
    (tmp_path / "there").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    words = ("run", "ackley", "--strategy", "random", "--budget", 2, "--seed", 1)
    assert railsearch(*words, "--storage", "sqlite:///record.db", "--out", "one").code == 0
    monkeypatch.chdir(tmp_path / "there")
    assert "2 of 2 evaluations" in railsearch("show", "../here/one").out
    (tmp_path / "here" / "record.db").rename(tmp_path / "record.db")
    (tmp_path / "here" / "one" / "result.json").unlink()
    refused(railsearch("show", "../here/one"), "no record at", "record.db")
    refused(railsearch("dashboard", "../here/one"), "no record at", "record.db")
    assert "2 of 2" in railsearch("show", "../here/one", "--storage", "sqlite:///../record.db").out
    assert list((tmp_path / "there").iterdir()) == []


def test_a_result_without_its_record_is_not_overwritten(railsearch: Cli, tmp_path: Path) -> None:
    words = ("run", "ackley", "--strategy", "random", "--budget", 2, "--seed", 1)
    assert railsearch(*words, "--out", tmp_path).code == 0
    (tmp_path / "study.db").unlink()
    before = (tmp_path / "result.json").read_bytes()
    refused(railsearch(*words, "--out", tmp_path), "study.db is gone", "another --out")
    assert (tmp_path / "result.json").read_bytes() == before


def test_sampled_worst_values_serve_any_problem(railsearch: Cli, install: Callable[..., None], tmp_path: Path) -> None:
    install(samples=sample_problems)
    path = tmp_path / "site.toml"
    path.write_text(railsearch("sample", "two", "--number", 40, "--seed", 1).out)
    words = (
        "run",
        "two",
        "-p",
        path,
        "--scalarise",
        "asf",
        "--budget",
        24,
        "--seed",
        1,
        "--out",
        tmp_path / "run",
        "--json",
    )
    document = json.loads(railsearch(*words).out)
    assert document["scalariser"]["values"]["worst"] == tomllib.loads(path.read_text())["worst"]


LIMITED = """
import resource, sys
resource.setrlimit(resource.RLIMIT_FSIZE, ({limit}, {limit}))
from railsearch.cli import main
sys.argv = ["railsearch", *{words!r}]
main()
"""


def test_a_full_disk_loses_nothing(railsearch: Cli, tmp_path: Path) -> None:
    words = ["run", "ackley", "--strategy", "random", "--budget", "30", "--seed", "1"]
    full = [*words, "--out", str(tmp_path / "full")]
    code = LIMITED.format(limit=130_000, words=full)
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert ended.returncode == 2, ended.stderr
    (message,) = re.findall(r"error: (.*)", ended.stderr)
    stored = int(re.search(r"(\d+) evaluations are safe", message)[1])  # type: ignore[index]
    assert 0 < stored < 30
    assert len(json.loads(railsearch("show", tmp_path / "full", "--json").out)["evaluations"]) == stored
    assert railsearch(*full).code == 0
    assert railsearch(*words, "--out", tmp_path / "roomy").code == 0
    first, second = (json.loads((tmp_path / name / "result.json").read_text()) for name in ("full", "roomy"))
    keys = ("design", "objectives", "metrics", "origin")
    assert [[row[key] for key in keys] for row in first["evaluations"]] == [
        [row[key] for key in keys] for row in second["evaluations"]
    ]


def test_a_batch_in_processes_finds_what_one_process_finds(railsearch: Cli, tmp_path: Path) -> None:
    words = ["run", "ackley", "--strategy", "ga", "--budget", 18, "--seed", 4, "--batch", 4, "--json"]
    answers = [railsearch(*words, "--workers", count, "--out", tmp_path / f"{count}") for count in (1, 2)]
    assert [answer.code for answer in answers] == [0, 0], answers[1].err
    found = [json.loads(answer.out)["evaluations"] for answer in answers]
    kept = ("number", "design", "objectives", "origin")
    assert [[e[key] for key in kept] for e in found[0]] == [[e[key] for key in kept] for e in found[1]]
    assert "workers: 3 would find no more than the 2 designs" in railsearch(*words[:-3], "--batch", 2, "--workers", 3).err


def test_an_initial_seed_is_shared_by_runs_of_different_seeds(railsearch: Cli, tmp_path: Path) -> None:
    words = ["run", "ackley", "--strategy", "lmsrs", "--budget", 30, "--initial-seed", 8, "--json"]
    runs = [railsearch(*words, "--seed", seed, "--out", tmp_path / f"{seed}") for seed in (1, 2)]
    designs = [[row["design"] for row in json.loads(run.out)["evaluations"]] for run in runs]
    assert designs[0][:20] == designs[1][:20]
    assert designs[0] != designs[1]


@pytest.mark.parametrize("own_storage", [False, True])
def test_a_run_refused_after_the_reference_design_leaves_no_record(
    railsearch: Cli, install: Callable[..., None], tmp_path: Path, own_storage: bool
) -> None:
    install(samples=sample_problems)
    site = tmp_path / "site.toml"
    words = ["run", "two", "-p", site, "--scalarise", "asf", "--strategy", "random", "--budget", 3, "--seed", 1]
    words += ["--out", tmp_path / "run", *(["--storage", f"sqlite:///{tmp_path / 'all.db'}"] if own_storage else [])]
    site.write_text("[scalariser.asf]\nworst = { left = 1.0 }\n")
    refused(railsearch(*words), "the aspiration of left must lie below its worst value", "2.6 and 1")
    assert [path.name for path in (tmp_path / "run").iterdir()] == [".lock"]
    site.write_text("[scalariser.asf]\nworst = { left = 100.0 }\n")
    answer = railsearch(*words, "--json")
    assert answer.code == 0, answer.err
    assert len(json.loads(answer.out)["evaluations"]) == 3


def test_a_reference_that_fails_leaves_no_record_of_a_run_that_needs_it(
    railsearch: Cli, install: Callable[..., None], tmp_path: Path
) -> None:
    class Broken(TwoObjectives):
        def simulate(self, design: Any) -> Any:
            if np.array_equal(design, self.reference):
                raise ZeroDivisionError("no ballast")
            return super().simulate(design)

    @hookimpl
    def railsearch_problems(register: Callable[[str, Any], None]) -> None:
        register("broken", Broken)

    plugin = types.ModuleType("samples")
    vars(plugin)["railsearch_problems"] = railsearch_problems
    install(samples=lambda: plugin)
    words = ("run", "broken", "--scalarise", "asf", "--strategy", "random", "--budget", 3, "--seed", 1, "--out", tmp_path)
    refused(railsearch(*words), "its evaluation failed", "give the scalariser its aspiration values")
    assert not (tmp_path / "run.json").exists()
    assert not (tmp_path / "study.db").exists()
