"""Build the environments of a benchmark beside other libraries: one for each file in its folder `requirements`, and one for
railsearch where the benchmark is a distribution of its own.

    python benchmarks/environments.py peers build all              # or railsearch, pysot, soogo, …
    python benchmarks/environments.py surrogate_peers build all
    python benchmarks/environments.py peers list
"""

import argparse
import subprocess
import sys
import venv
from pathlib import Path

HERE = Path(__file__).resolve().parent
ENVIRONMENTS = ".environments"
RAILSEARCH = "railsearch"


def benchmarks() -> list[str]:
    """The benchmarks that have environments."""
    return sorted(path.parent.name for path in HERE.glob("*/requirements"))


def names(benchmark: Path) -> list[str]:
    """All environments of a benchmark: railsearch's own, if there is one, then the others in alphabetical order."""
    own = [RAILSEARCH] if (benchmark / "pyproject.toml").exists() else []
    return [*own, *sorted(path.stem for path in benchmark.glob("requirements/*.txt"))]


def what_to_install(benchmark: Path, name: str) -> list[str]:
    """The arguments of pip for an environment."""
    if name == RAILSEARCH:
        constraints = str(HERE.parent / "constraints.txt")
        return ["--constraint", constraints, "--editable", f"{HERE.parent}[coco]", "--editable", str(benchmark)]
    return ["--requirement", str(benchmark / "requirements" / f"{name}.txt")]


def build(benchmark: Path, name: str) -> None:
    """Make an environment anew."""
    folder = benchmark / ENVIRONMENTS / name
    venv.create(folder, clear=True, with_pip=True)
    subprocess.run(
        [folder / "bin" / "python", "-m", "pip", "install", "--quiet", *what_to_install(benchmark, name)], check=True
    )
    print(f"built {folder}")


def main() -> int:
    parser = argparse.ArgumentParser(description="Build the environments of a benchmark.")
    parser.add_argument("benchmark", choices=benchmarks())
    commands = parser.add_subparsers(required=True, dest="command")
    commands.add_parser("list", help="which environments there are")
    commands.add_parser("build", help="make one anew, or all").add_argument("name")
    asked = parser.parse_args()
    benchmark = HERE / asked.benchmark
    known = names(benchmark)
    if asked.command == "list":
        for name in known:
            print(f"{name}: {'built' if (benchmark / ENVIRONMENTS / name).exists() else 'not built'}")
        return 0
    if asked.name not in ("all", *known):
        parser.error(f"{asked.benchmark} has no environment {asked.name!r}; it has {', '.join(known)}")
    for name in known if asked.name == "all" else [asked.name]:
        build(benchmark, name)
    return 0


if __name__ == "__main__":
    sys.exit(main())
