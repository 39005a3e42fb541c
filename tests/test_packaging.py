"""The wheel and an external plugin, installed into a fresh environment and run from there."""

import json
import shutil
import subprocess
import sys
import venv
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
NOT_SOURCES = (".*", "build", "dist", "*.egg-info", "demo-run", "tests", "__pycache__")


@pytest.fixture(scope="module")
def fresh(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The bin folder of a new environment with railsearch and the example plugin installed from wheels."""
    folder = tmp_path_factory.mktemp("fresh")
    wheels, environment = folder / "wheels", folder / "environment"
    for source in (ROOT, ROOT / "examples" / "external_strategy"):
        copy = shutil.copytree(source, folder / source.name, ignore=shutil.ignore_patterns(*NOT_SOURCES))
        pip(Path(sys.executable).parent, "wheel", "--no-deps", "--wheel-dir", str(wheels), str(copy))
    venv.create(environment, with_pip=True)
    pip(environment / "bin", "install", "--constraint", str(ROOT / "constraints.txt"), *map(str, wheels.glob("*.whl")))
    return environment / "bin"


def pip(binaries: Path, *words: str) -> None:
    subprocess.run([str(binaries / "python"), "-m", "pip", "--quiet", *words], check=True)


def command(binaries: Path, folder: Path, *words: str) -> str:
    return subprocess.run(
        [str(binaries / "railsearch"), *words], cwd=folder, capture_output=True, text=True, check=True
    ).stdout


@pytest.mark.xdist_group("fresh")
def test_plugins_are_listed_from_the_wheel(fresh: Path, tmp_path: Path) -> None:
    rows = {(row["kind"], row["name"]): row for row in json.loads(command(fresh, tmp_path, "list", "--json"))}
    assert {("strategy", "dycors"), ("surrogate", "rbf"), ("problem", "level-crossing"), ("scalariser", "asf")} <= set(rows)
    assert rows["strategy", "pattern-search"]["distribution"] == "railsearch-pattern-search"
    code = "import railsearch, railsearch_plugins; print(railsearch.__file__, railsearch_plugins.__file__)"
    listed = subprocess.run(
        [str(fresh / "python"), "-c", code],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
    ).stdout.split()
    assert all(str(fresh.parent) in path for path in listed)


@pytest.mark.xdist_group("fresh")
def test_an_external_strategy_searches_the_level_crossing(fresh: Path, tmp_path: Path) -> None:
    words = ("run", "level-crossing", "--scalarise", "asf", "--strategy", "pattern-search", "--budget", "12", "--seed", "1")
    document = json.loads(command(fresh, tmp_path, *words, "--out", "run", "--json"))
    assert len(document["evaluations"]) == 12
    plugin = next(plugin for plugin in document["plugins"] if plugin["kind"] == "strategy")
    assert (plugin["distribution"], plugin["version"]) == ("railsearch-pattern-search", "0.1.0")
    assert (tmp_path / "run" / "report.html").exists()


@pytest.mark.xdist_group("fresh")
def test_the_external_strategy_passes_the_shipped_conformance_suite(fresh: Path, tmp_path: Path) -> None:
    code = (
        "from railsearch_pattern_search import PatternSearch as plugin; from railsearch.testing import check_strategy; "
        "check_strategy(plugin)"
    )
    subprocess.run([str(fresh / "python"), "-c", code], cwd=tmp_path, check=True)


def test_the_external_strategy_is_a_short_text() -> None:
    source = ROOT / "examples" / "external_strategy" / "railsearch_pattern_search.py"
    assert len(source.read_text().splitlines()) < 60
