from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet
import pytest

from railsearch.errors import InputError
from railsearch.samples import read_samples

HEADER = ("E [Pa]", "load", "remark", "deflection [mm]", "failed")


def written(folder: Path, text: str, name: str = "own.csv") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("separator", [",", ";", "\t"])
@pytest.mark.parametrize("begin", ["", "# measured in May\n# by hand\n", "\ufeff", "\ufeff# of a spreadsheet\n"])
def test_a_users_own_csv(tmp_path: Path, separator: str, begin: str) -> None:
    rows = (HEADER, ("2.1e11", "3", "fine", "1.5", ""), ("2e11", "4", "", "", ""), ("1e11", "5", "wet", "NaN", ""))
    path = written(tmp_path, begin + "".join(separator.join(row) + "\n" for row in rows))
    samples = read_samples(path, ["load", "E"])
    assert list(samples.inputs) == ["load", "E"]
    np.testing.assert_array_equal(samples.input_matrix(), [[3.0, 2.1e11], [4.0, 2e11], [5.0, 1e11]])
    np.testing.assert_array_equal(samples.input_matrix(["E"]), [[2.1e11], [2e11], [1e11]])
    assert list(samples.outputs) == ["deflection", "failed"]
    np.testing.assert_array_equal(samples.output("deflection"), [1.5, np.nan, np.nan])
    assert samples.input_units == {"load": "", "E": "Pa"}
    assert samples.output_units == {"deflection": "mm", "failed": ""}
    assert samples.number == 3
    assert samples.reasons == ("", "", "")
    assert not samples.about


def test_a_comment_may_be_long(tmp_path: Path) -> None:
    samples = read_samples(written(tmp_path, f"# {'measured ' * 200_000}\nx,y\n1,2\n"), ["x"])
    assert samples.output("y") == [2.0]


def test_a_users_own_parquet(tmp_path: Path) -> None:
    path = tmp_path / "own.parquet"
    pyarrow.parquet.write_table(pa.table({"x": [1, 2], "y [N]": [0.5, None], "note": ["a", "b"]}), path)
    samples = read_samples(path, ["x"])
    np.testing.assert_array_equal(samples.input_matrix(), [[1.0], [2.0]])
    np.testing.assert_array_equal(samples.output("y"), [0.5, np.nan])
    assert (samples.input_units, samples.output_units) == ({"x": ""}, {"y": "N"})


@pytest.mark.parametrize(
    ("text", "inputs", "message"),
    [
        ("x,y\n1,2\n", ["z"], "column 'z' is missing; there are x, y"),
        ("load,y\n1,2\n", ["laod"], "did you mean 'load'"),
        ("x;y\n1,5;2\n", ["x"], r"column 'x' is not one of numbers: row 1 has '1,5'; numbers with a decimal point"),
        ("x,y\n1,2\nsoft,3\n", ["x"], "row 2 has 'soft'"),
        ("x,x\n1,2\n", ["x"], "several columns 'x'"),
        ("x [m],x [mm]\n1,2\n", ["x"], "differ in their unit only"),
        ("x,y\n", ["x"], "there are no samples, only a header"),
        ("x,y\n1,2\n3\n", ["x"], "is not a csv table"),
        ("", ["x"], "it has no header"),
        ("# nothing\n", ["x"], "it has no header"),
    ],
)
def test_what_is_wrong_in_a_file_is_named(tmp_path: Path, text: str, inputs: list[str], message: str) -> None:
    path = written(tmp_path, text)
    with pytest.raises(InputError, match=message) as raised:
        read_samples(path, inputs)
    assert str(raised.value).startswith(str(path))


def test_an_output_without_numbers_is_refused_when_it_is_asked_for(tmp_path: Path) -> None:
    samples = read_samples(written(tmp_path, "x,y,z\n1,2,3\n4,high,6\n"), ["x"])
    np.testing.assert_array_equal(samples.output("z"), [3.0, 6.0])
    with pytest.raises(InputError, match="column 'y' is not one of numbers: row 2 has 'high'"):
        samples.output("y")
    with pytest.raises(InputError, match="there is no output 'zz', did you mean 'z'"):
        samples.output("zz")


@pytest.mark.parametrize("name", ["own.xlsx", "own.parquet", "absent.csv"])
def test_what_cannot_be_read_is_refused(tmp_path: Path, name: str) -> None:
    if not name.startswith("absent"):
        written(tmp_path, "x,y\n1,2\n", name)
    with pytest.raises(InputError, match=name):
        read_samples(tmp_path / name, ["x"])
