import json
import math
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet
import pytest
from uncertain_problem import BREAKS, DISTRIBUTIONS, plugin

from command_line import Answer, refused
from railsearch.commands import sampling
from railsearch.distributions import random_vector
from railsearch.samples import ExperimentDesign, read_samples
from railsearch.samples.journal import Journal

Cli = Callable[..., Answer]


@pytest.fixture
def sample(railsearch: Cli, install: Callable[..., None], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Cli:
    """The command, in a folder of its own, with the problems of the tests and without the figure, which takes a second."""
    install(samples=plugin)
    monkeypatch.setattr(sampling, "_draw", lambda path, problem, evaluations: None)
    monkeypatch.chdir(tmp_path)
    return lambda *words: railsearch("sample", *words)


def lasting(path: Path) -> Any:
    """All of a file but the seconds that each sample took: they differ from one process to the next."""
    if path.suffix == ".parquet":
        table = pyarrow.parquet.read_table(path)
        return table.drop_columns("seconds"), table.schema
    lines = path.read_bytes().splitlines()
    return [line.rpartition(b",")[0] if k > 1 else line for k, line in enumerate(lines)]


def same(one: Path, other: Path) -> bool:
    """Whether two files are the same but for the seconds."""
    if one.suffix == ".csv":
        return bool(lasting(one) == lasting(other))
    (table, schema), (other_table, other_schema) = lasting(one), lasting(other)
    return bool(table.equals(other_table)) and bool(schema.equals(other_schema, check_metadata=True))


def frame(path: str) -> dict[str, list[Any]]:
    columns: dict[str, list[Any]] = pyarrow.parquet.read_table(path).to_pydict()
    return columns


WORDS = ("uncertain", "--n", 60, "--seed", 1, "--design", "lhs")


def test_the_table_has_a_row_for_every_sample_in_order_with_natural_signs(sample: Cli) -> None:
    assert sample(*WORDS, "--out", "s.parquet").code == 0
    columns = frame("s.parquet")
    named = ["number", "load", "sag", "variable seconds", "comfort", "quantity load", "gap", "extra", "constraint 1"]
    assert list(columns) == [*named, "reason", "seconds"]
    assert columns["number"] == list(range(1, 61))
    assert all(isinstance(value, int) for name in ("number", "variable seconds") for value in columns[name])
    load, sag, factor = (np.array(columns[name]) for name in ("load", "sag", "variable seconds"))
    for row in np.flatnonzero(load <= BREAKS):
        assert columns["comfort"][row] == -load[row] * factor[row], "a maximised objective has its natural sign"
        assert columns["quantity load"][row] == load[row]
        assert columns["constraint 1"][row] == sag[row]
        assert columns["extra"][row] == sag[row] ** 2
        assert columns["gap"][row] == (None if sag[row] < -2.0 else 2.0 * sag[row])
        assert columns["reason"][row] is None
        assert columns["seconds"][row] > 0.0


def test_units_and_provenance_are_in_the_file(sample: Cli) -> None:
    assert sample(*WORDS, "--out", "s.parquet").code == 0
    schema = pyarrow.parquet.read_schema("s.parquet")
    assert schema.field("load").metadata == {b"unit": b"kN", b"meaning": b"weight of the train"}
    about = json.loads(schema.metadata[b"about"])
    assert about["command"] == "railsearch sample uncertain --n 60 --seed 1 --design lhs --out s.parquet"
    identity = about["identity"]
    assert (identity["seed"], identity["number"], identity["design"], identity["problem"]) == (1, 60, "lhs", "uncertain")
    assert identity["distributions"]["load"] == "lognormal(mean=50, cov=0.3)"
    assert {"railsearch", "python", "numpy"} <= set(about["versions"])


@pytest.mark.parametrize("out", ["s.parquet", "s.csv"])
@pytest.mark.parametrize("design", list(ExperimentDesign))
def test_the_same_command_makes_the_same_file(sample: Cli, tmp_path: Path, out: str, design: ExperimentDesign) -> None:
    words = ("uncertain", "--n", 20, "--seed", 8, "--design", design, "--out", out)
    assert sample(*words).code == 0
    first = tmp_path / f"first{Path(out).suffix}"
    (tmp_path / out).rename(first)
    assert sample(*words).code == 0
    assert same(tmp_path / out, first)
    assert not list(tmp_path.glob("*.journal"))


@pytest.mark.parametrize("out", ["s.parquet", "s.csv"])
def test_a_latin_hypercube_in_the_file_has_one_value_in_every_stratum(sample: Cli, out: str) -> None:
    assert sample(*WORDS, "--out", out).code == 0
    samples = read_samples(Path(out))
    levels = random_vector(DISTRIBUTIONS).cdf(samples.input_matrix())
    for k in (0, 1):
        np.testing.assert_array_equal(np.sort(np.floor(60 * levels[:, k])), np.arange(60))
    # Whole numbers: 60 samples in the shares 1/9, 3/9 and 5/9, up to the stratum at each border.
    counts = np.unique(samples.inputs["seconds"], return_counts=True)[1]
    assert np.all(np.abs(counts - 60 * np.array([1, 3, 5]) / 9) < 2)


def test_both_formats_hold_the_same_numbers_to_the_last_bit(sample: Cli) -> None:
    for out in ("s.parquet", "s.csv"):
        assert sample(*WORDS, "--out", out).code == 0
    parquet, csv = read_samples(Path("s.parquet")), read_samples(Path("s.csv"))
    assert list(csv.inputs) == list(parquet.inputs) == ["load", "sag", "seconds"]
    assert list(csv.outputs) == list(parquet.outputs) == ["comfort", "load", "gap", "extra", "constraint 1"]
    for name, values in {**parquet.inputs}.items():
        np.testing.assert_array_equal(csv.inputs[name], values)
    for name, values in {**parquet.outputs}.items():
        np.testing.assert_array_equal(csv.outputs[name], values)
    assert csv.reasons == parquet.reasons
    assert csv.input_units == parquet.input_units == {"load": "kN", "sag": "mm", "seconds": ""}
    assert csv.output_units == parquet.output_units
    assert parquet.output_units["gap"] == "mm"
    assert csv.about["identity"] == parquet.about["identity"]


@pytest.mark.parametrize("out", ["s.parquet", "s.csv"])
def test_a_failure_is_a_row_with_its_reason(sample: Cli, out: str) -> None:
    answer = sample(*WORDS, "--out", out)
    assert answer.code == 0
    samples = read_samples(Path(out))
    broken = samples.inputs["load"] > BREAKS
    assert 0 < broken.sum() < 60
    for row in range(60):
        load = samples.inputs["load"][row]
        reason = f'SimulationError: the rail breaks,\nsays "{load:.0f} kN"' if broken[row] else ""
        assert samples.reasons[row] == reason
    for values in samples.outputs.values():
        assert np.isnan(values[broken]).all()
    assert f"60 samples, {broken.sum()} failed" in answer.out


def test_statistics_are_those_of_the_samples_that_succeeded(sample: Cli) -> None:
    document = json.loads(sample(*WORDS, "--out", "s.parquet", "--json").out)
    samples = read_samples(Path("s.parquet"))
    assert document["failed"] == sum(bool(reason) for reason in samples.reasons)
    rows = {row["name"]: row for row in document["quantities"]}
    assert list(rows) == ["comfort", "load", "gap"]
    for name, row in rows.items():
        values = samples.output(name)
        values = np.sort(values[np.isfinite(values)])
        assert row["values"] == len(values)
        assert (row["minimum"], row["maximum"]) == (values[0], values[-1])
        for level in (1, 50, 90, 99):
            place = level / 100.0 * (len(values) - 1)
            low = math.floor(place)
            between = values[low] + (place - low) * (values[min(low + 1, len(values) - 1)] - values[low])
            assert row[f"q{level}"] == pytest.approx(between, rel=1e-12)
    assert rows["comfort"]["maximum"] < 0.0
    table = sample(*WORDS, "--out", "s.parquet").out
    assert "comfort [kN]" in table
    assert "90 %" in table


def test_time_outs_and_deaths_of_two_processes_are_rows_of_their_own_samples(sample: Cli, tmp_path: Path) -> None:
    words = ("troubled", "--n", 20, "--seed", 3, "--timeout", 0.4, "--workers", 2, "--out", "s.parquet")
    assert sample(*words).code == 0
    samples = read_samples(tmp_path / "s.parquet")
    expected = {-4: "no ballast", -3: "distance is nan", -2: "distance is inf", -1: "1 values are needed"}
    expected |= {3: "time limit of 0.4 s exceeded", 4: "process died"}
    counts = samples.inputs["count"]
    assert set(expected) & set(counts) >= {-4, 3, 4}, "the seed must have them"
    for count, reason in zip(counts, samples.reasons, strict=True):
        assert expected.get(count, "") in reason
        assert bool(reason) == (count in expected)


def test_if_everything_fails_the_rows_are_kept_and_the_command_says_so(sample: Cli) -> None:
    refused(sample("hopeless", "--n", 3, "--seed", 1, "--out", "s.csv"), "all 3 evaluations failed", "no way")
    samples = read_samples(Path("s.csv"))
    assert samples.reasons == ("ValueError: no way",) * 3
    assert np.isnan(samples.output("distance")).all()
    refused(sample("hopeless", "--n", 3, "--seed", 1), "all 3 evaluations failed", "no way")


@pytest.mark.parametrize("design", ["random", "sobol"])
def test_a_design_that_can_grow_goes_on_and_ends_as_if_made_at_once(sample: Cli, tmp_path: Path, design: str) -> None:
    for out in ("s.parquet", "s.csv"):
        words = ("uncertain", "--seed", 2, "--design", design, "--out", out)
        assert sample(*words, "--n", 40).code == 0
        whole = tmp_path / f"whole{Path(out).suffix}"
        (tmp_path / out).rename(whole)
        assert sample(*words, "--n", 17).code == 0
        assert read_samples(Path(out)).number == 17
        answer = sample(*words, "--n", 40)
        assert "continuing: 17 of 40 samples are kept" in answer.err
        assert same(tmp_path / out, whole)


def test_what_is_complete_is_not_evaluated_again(sample: Cli, tmp_path: Path) -> None:
    assert sample(*WORDS, "--out", "s.parquet").code == 0
    before = (tmp_path / "s.parquet").read_bytes()
    answer = sample(*WORDS[:3], "--design", "lhs", "--workers", 2, "--out", "s.parquet")
    assert "complete: all 60 samples are in s.parquet, nothing is evaluated" in answer.err
    assert "seed 1" in answer.out, "the seed of the file is taken when none is given"
    assert (tmp_path / "s.parquet").read_bytes() == before


@pytest.mark.parametrize(
    ("words", "messages"),
    [
        (("uncertain", "--n", 60, "--seed", 2, "--design", "lhs"), ("seed: there 1, here 2",)),
        (("uncertain", "--n", 60, "--seed", 1, "--design", "sobol"), ("design: there", "lhs", "sobol")),
        (("uncertain", "--n", 61, "--seed", 1, "--design", "lhs"), ("Latin hypercube of 60", "of 61", "random or sobol")),
        (("uncertain", "--n", 59, "--seed", 1, "--design", "lhs"), ("a sample of 60, more than 59", "ask for 60")),
        (("ball", "--n", 60, "--seed", 1, "--design", "lhs"), ("problem: there", "uncertain", "ball")),
    ],
)
def test_another_command_on_the_same_file_is_refused_with_reason_and_remedy(
    sample: Cli, tmp_path: Path, words: tuple[object, ...], messages: tuple[str, ...]
) -> None:
    assert sample(*WORDS, "--out", "s.parquet").code == 0
    before = (tmp_path / "s.parquet").read_bytes()
    refused(sample(*words, "--out", "s.parquet"), *messages, "s.parquet", "Nothing was changed", "use another --out")
    assert (tmp_path / "s.parquet").read_bytes() == before
    assert not list(tmp_path.glob("*.journal"))


def test_parameters_of_a_site_identify_a_sample(sample: Cli, tmp_path: Path) -> None:
    words = ("ackley", "--n", 8, "--seed", 1, "--out", "s.csv")
    assert sample(*words, "--set", "function.dimension=3").code == 0
    assert len(read_samples(tmp_path / "s.csv").inputs) == 3
    refused(sample(*words, "--set", "function.dimension=4"), "dimension: there 3, here 4", "--set function.dimension=3")
    (tmp_path / "site.toml").write_text("[function]\ndimension = 3\n")
    assert "complete" in sample(*words, "--parameters", "site.toml").err
    assert "dimension: there 3, here 5" in sample(*words, "-p", "site.toml", "--set", "function.dimension=5").err


@pytest.mark.parametrize("name", ["s.parquet", "s.csv"])
def test_a_file_of_somebody_else_is_left_alone(sample: Cli, tmp_path: Path, name: str) -> None:
    if name == "s.csv":
        (tmp_path / name).write_text("load,comfort\n1,2\n")
    else:
        pyarrow.parquet.write_table(pa.table({"load": [1.0]}), name)
    before = (tmp_path / name).read_bytes()
    refused(sample(*WORDS, "--out", name), "holds something else than samples", "use another --out")
    assert (tmp_path / name).read_bytes() == before
    (tmp_path / name).write_bytes(b"\xff\x00 nothing of the kind")
    refused(sample(*WORDS, "--out", name), "is not a", "use another --out")


def test_a_changed_table_is_not_taken_for_the_experiment(sample: Cli, tmp_path: Path) -> None:
    words = ("uncertain", "--seed", 1, "--out", "s.csv")
    assert sample(*words, "--n", 20).code == 0
    lines = (tmp_path / "s.csv").read_text().split("\n")
    lines[4] = "3,12.5" + lines[4][lines[4].index(",", 2) :]
    (tmp_path / "s.csv").write_text("\n".join(lines))
    refused(sample(*words, "--n", 30), "differs from this experiment at sample 3")


@pytest.mark.parametrize(
    ("words", "messages"),
    [
        (("ball", "--out", "s.xlsx"), ("--out", ".parquet or .csv", "s.xlsx")),
        (("ball", "--out", "/dev/null/s.csv"), ("/dev/null: a folder is needed, and there is a file",)),
        (("ball", "--n", 2, "--timeout", 0), ("timeout", "positive", "0")),
        (("ball", "--set", "track.speed=3"), ("unknown section [track]",)),
        (("ball", "--objectives", "mass"), ("distance", "mass")),
        (("ball", "--seed", "-1", "--out", "s.csv"), ("seed", "-1")),
    ],
)
def test_bad_input_is_refused(sample: Cli, tmp_path: Path, words: tuple[object, ...], messages: tuple[str, ...]) -> None:
    refused(sample(*words), *messages)
    assert list(tmp_path.iterdir()) == []


def test_a_journal_that_was_cut_off_in_a_line_goes_on(sample: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert sample(*WORDS, "--out", "s.parquet").code == 0
    (tmp_path / "s.parquet").rename(tmp_path / "whole.parquet")
    with monkeypatch.context() as killed:
        killed.setattr(Journal, "remove", lambda journal: None)
        assert sample(*WORDS, "--out", "s.parquet").code == 0
    (tmp_path / "s.parquet").unlink()
    content = (tmp_path / "s.parquet.journal").read_bytes()
    for length in (0, 10, content.index(b"\n") + 1, len(content) // 2, content.rindex(b"\n") - 5):
        (tmp_path / "s.parquet.journal").write_bytes(content[:length])
        assert sample(*WORDS, "--out", "s.parquet").code == 0
        assert same(tmp_path / "s.parquet", tmp_path / "whole.parquet")
        (tmp_path / "s.parquet").unlink()


def test_a_kill_between_the_file_and_the_end_of_its_journal_changes_nothing(
    sample: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as killed:
        killed.setattr(Journal, "remove", lambda journal: None)
        assert sample(*WORDS, "--out", "s.parquet").code == 0
    before = (tmp_path / "s.parquet").read_bytes()
    assert (tmp_path / "s.parquet.journal").exists()
    assert "nothing is evaluated" in sample(*WORDS, "--out", "s.parquet").err
    assert (tmp_path / "s.parquet").read_bytes() == before
    assert not (tmp_path / "s.parquet.journal").exists()


def test_a_table_that_grows_may_be_stopped_too(sample: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    words = ("uncertain", "--seed", 2, "--design", "sobol", "--out", "s.csv")
    assert sample(*words, "--n", 40).code == 0
    (tmp_path / "s.csv").rename(tmp_path / "whole.csv")
    assert sample(*words, "--n", 17).code == 0
    evaluated = 0
    append = Journal.append

    def interrupted(journal: Journal, entry: Any) -> None:
        nonlocal evaluated
        evaluated += 1
        if evaluated == 9:
            raise KeyboardInterrupt
        append(journal, entry)

    with monkeypatch.context() as stopped:
        stopped.setattr(Journal, "append", interrupted)
        answer = sample(*words, "--n", 40)
    assert answer.code == 130
    assert "the same command goes on" in answer.err
    assert read_samples(tmp_path / "s.csv").number == 17
    refused(sample(*words, "--n", 30), "a sample of 40, more than 30")
    assert "continuing: 25 of 40" in sample(*words, "--n", 40).err
    assert same(tmp_path / "s.csv", tmp_path / "whole.csv")


def test_without_a_file_the_ranges_are_a_section_of_a_site(sample: Cli, tmp_path: Path) -> None:
    for design in ExperimentDesign:
        answer = sample("two", "--n", 30, "--seed", 4, "--design", design)
        assert answer.code == 0
        assert set(tomllib.loads(answer.out)["worst"]) == {"left", "right"}
    assert list(tmp_path.iterdir()) == []
    document = json.loads(sample("uncertain", "--n", 30, "--seed", 4, "--json").out)
    comfort = document["objectives"]["comfort"]
    assert comfort["best"] > comfort["worst"], "the objective is maximised"
    assert document["failed"] > 0


def test_the_distributions_are_described(railsearch: Cli, install: Callable[..., None]) -> None:
    install(samples=plugin)
    text = railsearch("describe", "uncertain").out
    assert "lognormal(mean=50, cov=0.3)" in text
    assert "distribution" in text
    assert "distribution" not in railsearch("describe", "ball").out.split("from")[-1]
    (document,) = json.loads(railsearch("describe", "uncertain", "--json").out)
    assert [row["distribution"] for row in document["variables"]][1] == "normal(mean=0, std=1)"
    (plain,) = json.loads(railsearch("describe", "ball", "--json").out)
    assert {row["distribution"] for row in plain["variables"]} == {None}
