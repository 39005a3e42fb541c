"""The wheel and an external plugin, in a fresh environment that has what they declare to need and nothing else."""

import json
import re
import shutil
import subprocess
import sys
import tomllib
import venv
from importlib.metadata import Distribution, distribution, distributions
from pathlib import Path

import pytest
from packaging.requirements import Requirement

from railsearch.wording import install_remedy

ROOT = Path(__file__).parents[1]
NOT_SOURCES = (".*", "build", "dist", "*.egg-info", "demo-run", "tests", "__pycache__")


@pytest.fixture(scope="module")
def fresh(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The bin folder of a new environment with railsearch and the example plugin installed from wheels."""
    folder = tmp_path_factory.mktemp("fresh")
    wheels, environment = folder / "wheels", folder / "environment"
    for source in (ROOT, ROOT / "examples" / "external_strategy"):
        copy = shutil.copytree(source, folder / source.name, ignore=shutil.ignore_patterns(*NOT_SOURCES))
        pip("wheel", "--no-deps", "--wheel-dir", str(wheels), str(copy))
    venv.create(environment, with_pip=False)
    inside = ("--python", str(environment / "bin" / "python"))
    pip(*inside, "install", "--no-deps", "--no-index", *map(str, wheels.glob("*.whl")))
    (packages,) = environment.glob("lib/python*/site-packages")
    link_requirements(packages)
    pip(*inside, "check")
    return environment / "bin"


def pip(*words: str) -> None:
    subprocess.run([sys.executable, "-m", "pip", "--quiet", *words], check=True)


def link_requirements(packages: Path) -> None:
    """Link what the distributions in a folder need, directly or indirectly, from this environment into it."""
    installed = list(distributions(path=[str(packages)]))
    names = {found.name for found in installed}
    open_ends: list[tuple[Distribution, tuple[str, ...]]] = [(found, ("",)) for found in installed]
    while open_ends:
        for requirement in required(*open_ends.pop()):
            if requirement.name not in names:
                names.add(requirement.name)
                needed = distribution(requirement.name)
                open_ends.append((needed, ("", *requirement.extras)))
                link(needed, packages)


def required(found: Distribution, extras: tuple[str, ...]) -> list[Requirement]:
    requirements = [Requirement(text) for text in found.requires or ()]
    return [r for r in requirements if r.marker is None or any(r.marker.evaluate({"extra": extra}) for extra in extras)]


def link(found: Distribution, packages: Path) -> None:
    for name in {file.parts[0] for file in found.files or ()} - {"..", "__pycache__"}:
        if not (packages / name).exists():
            (packages / name).symlink_to(Path(str(found.locate_file(name))))


def command(binaries: Path, folder: Path, *words: str) -> str:
    return subprocess.run(
        [str(binaries / "railsearch"), *words], cwd=folder, capture_output=True, text=True, check=True
    ).stdout


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


def test_an_external_strategy_searches_the_level_crossing(fresh: Path, tmp_path: Path) -> None:
    words = ("run", "level-crossing", "--scalarise", "asf", "--strategy", "pattern-search", "--budget", "12", "--seed", "1")
    document = json.loads(command(fresh, tmp_path, *words, "--out", "run", "--json"))
    assert len(document["evaluations"]) == 12
    plugin = next(plugin for plugin in document["plugins"] if plugin["kind"] == "strategy")
    assert (plugin["distribution"], plugin["version"]) == ("railsearch-pattern-search", "0.1.0")
    assert (tmp_path / "run" / "report.html").exists()


def test_the_external_strategy_passes_the_shipped_conformance_suite(fresh: Path, tmp_path: Path) -> None:
    code = (
        "from railsearch_pattern_search import PatternSearch as plugin; from railsearch.testing import check_strategy; "
        "check_strategy(plugin)"
    )
    subprocess.run([str(fresh / "python"), "-c", code], cwd=tmp_path, check=True)


def test_the_external_strategy_is_a_short_text() -> None:
    source = ROOT / "examples" / "external_strategy" / "railsearch_pattern_search.py"
    assert len(source.read_text().splitlines()) < 60


def test_every_remedy_for_a_missing_extra_names_one_that_exists() -> None:
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    sources = [
        path.read_text() for folder in ("railsearch", "plugins", "problems") for path in (ROOT / folder).rglob("*.py")
    ]
    named = {name for text in sources for name in re.findall(r"install_remedy\([\"'](\w+)[\"']\)", text)}
    assert named == {"coco", "dask", "gp", "postgresql"} <= set(extras)
    assert not [text for text in sources if re.search(r"pip install (?!'(\.|railsearch)\[\{)", text)]
    assert install_remedy("gp") == "`.venv/bin/pip install '.[gp]'` in a clone, else `pip install 'railsearch[gp]'`"
