"""The benchmark of surrogates beside other libraries, with the client that needs no environment of its own."""

import importlib
import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).resolve().parents[2] / "benchmarks"


@pytest.fixture
def compare(monkeypatch):
    """The driver, imported from its folder."""
    monkeypatch.syspath_prepend(str(BENCHMARKS / "surrogate_peers"))
    return importlib.import_module("compare")


def test_a_fit_is_measured_and_kept(compare, tmp_path):
    """What a client says of itself arrives, the tables are written, and a second record knows the first one's fits."""
    found = compare.cell(compare.PARTICIPANTS["pce"], 40, 0, 120.0)
    assert 0.0 < found["error"] < 0.1
    assert min(*found["fit"], *found["prediction"]) > 0.0
    assert set(found["versions"]) == {"railsearch", "numpy", "scipy"}
    compare.Record(tmp_path).keep("pce", 40, 0, found)
    again = compare.Record(tmp_path)
    assert again.has("pce", 40, 0)
    assert not again.has("pce", 40, 1)
    assert f"| pce | 1 | {found['error']:.2e} " in (tmp_path / "tables.md").read_text(encoding="utf-8")


def test_a_client_that_fails_is_recorded_with_the_reason(compare, tmp_path):
    found = compare.cell(compare.Participant("railsearch", "no-such-model", ""), 40, 0, 120.0)
    assert found == {"failed": "KeyError: 'no-such-model'"}
    assert compare.cell(compare.PARTICIPANTS["pce"], 40, 0, 0.01) == {"failed": "no answer within 0.01 s"}
    compare.Record(tmp_path).keep("pce", 40, 0, found)
    assert "| pce | 0 of 1 | KeyError: 'no-such-model' |" in (tmp_path / "tables.md").read_text(encoding="utf-8")


def test_slow_fits_have_fewer_seeds(compare, tmp_path):
    fits = {f"{name} 400 0": {"error": 1.0, "fit": [seconds] * 2} for name, seconds in {"quick": 1.0, "slow": 61.0}.items()}
    (tmp_path / "cells.json").write_text(json.dumps(fits))
    record = compare.Record(tmp_path)
    assert [record.seeds(name, 400, 5, 2) for name in ("quick", "slow", "not yet")] == [5, 2, 5]


def test_every_environment_is_pinned_and_known_to_the_builder():
    for benchmark, first in {"peers": "railsearch", "surrogate_peers": "chaospy"}.items():
        asked = [sys.executable, str(BENCHMARKS / "environments.py"), benchmark, "list"]
        said = subprocess.run(asked, capture_output=True, text=True, check=True).stdout.split("\n")
        files = sorted((BENCHMARKS / benchmark / "requirements").glob("*.txt"))
        assert said[0].startswith(f"{first}: ")
        assert len(said) - 1 == len(files) + (first == "railsearch")
        for line in (line for file in files for line in file.read_text().splitlines()):
            assert line.startswith("# ") or re.fullmatch(r"[A-Za-z0-9._-]+==[A-Za-z0-9.]+", line), line
