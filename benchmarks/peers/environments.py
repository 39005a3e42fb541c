"""Build the environments of the peers benchmark: one for each peer, and one for railsearch with the strategies `peer` and
`started`.

    python benchmarks/peers/environments.py build all          # or railsearch, pysot, soogo, …
    python benchmarks/peers/environments.py list
"""

import argparse
import subprocess
import sys
import venv
from pathlib import Path

HERE = Path(__file__).resolve().parent
ENVIRONMENTS = HERE / ".environments"
REQUIREMENTS = HERE / "requirements"
PROJECT = HERE.parent.parent
RAILSEARCH = "railsearch"


def names() -> list[str]:
    """All environments: railsearch's own, then the peers in alphabetical order."""
    return [RAILSEARCH, *sorted(path.stem for path in REQUIREMENTS.glob("*.txt"))]


def what_to_install(name: str) -> list[str]:
    """The arguments of pip for an environment."""
    if name == RAILSEARCH:
        constraints = str(PROJECT / "constraints.txt")
        return ["--constraint", constraints, "--editable", f"{PROJECT}[coco]", "--editable", str(HERE)]
    return ["--requirement", str(REQUIREMENTS / f"{name}.txt")]


def build(name: str) -> None:
    """Make an environment anew."""
    folder = ENVIRONMENTS / name
    venv.create(folder, clear=True, with_pip=True)
    subprocess.run([folder / "bin" / "python", "-m", "pip", "install", "--quiet", *what_to_install(name)], check=True)
    print(f"built {folder}")


def main() -> int:
    parser = argparse.ArgumentParser(description="Build the environments of the peers benchmark.")
    commands = parser.add_subparsers(required=True, dest="command")
    commands.add_parser("list", help="which environments there are")
    commands.add_parser("build", help="make one anew, or all").add_argument("name", choices=["all", *names()])
    asked = parser.parse_args()
    if asked.command == "list":
        for name in names():
            print(f"{name}: {'built' if (ENVIRONMENTS / name).exists() else 'not built'}")
        return 0
    for name in names() if asked.name == "all" else [asked.name]:
        build(name)
    return 0


if __name__ == "__main__":
    sys.exit(main())
