"""What commands share: options, assignments, the problem that they ask for, and output."""

import json
import os
import shlex
import sys
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from railsearch.design_problem import DesignProblem
from railsearch.errors import InputError
from railsearch.parameters import nested
from railsearch.plugin_manager import Registry
from railsearch.problem_factory import ProblemSettings, amended_design, make_problem
from railsearch.run_directory import write_whole
from railsearch.site import Site, named_faults, preference_settings, read_site
from railsearch.space import FloatArray
from railsearch.storage import without_password

ProblemName = Annotated[str, typer.Argument(metavar="PROBLEM", help="Name of a problem; see `railsearch list problem`.")]
Parameters = Annotated[
    Path | None,
    typer.Option("--parameters", "-p", metavar="FILE.toml", help="Site file; `railsearch init PROBLEM` writes one."),
]
Assignments = Annotated[
    list[str] | None, typer.Option("--set", "-s", metavar="NAME=VALUE", help="Change one value; may be repeated.")
]
PreferenceFile = Annotated[
    Path | None,
    typer.Option("--preferences", metavar="FILE.toml", help="Preference functions and weights, for the scalariser."),
]
Objectives = Annotated[
    str,
    typer.Option("--objectives", metavar="F_max,E_max", help="Objectives to minimise; default: the problem's own choice."),
]
Folder = Annotated[Path, typer.Argument(metavar="DIR", help="Folder of a run or a campaign (its --out).")]
StorageUrl = Annotated[
    str | None, typer.Option("--storage", metavar="URL", help="Optuna storage URL; default: an SQLite file in DIR.")
]
DaskAddress = Annotated[
    str | None, typer.Option("--dask", metavar="ADDRESS", help="Work in a Dask cluster, for instance tcp://host:8786.")
]
Output = Annotated[
    Path | None, typer.Option("--out", "-o", metavar="FILE.toml", help="File to write; default: standard output.")
]
AsJson = Annotated[bool, typer.Option("--json", help="Print the result as JSON on standard output.")]

PIPE_WIDTH = 200
messages = Console(stderr=True, highlight=False, markup=False, soft_wrap=True)


@dataclass(frozen=True)
class Asked:
    """A problem as a command asked for it, and what the site file says besides."""

    problem: DesignProblem
    settings: ProblemSettings
    site: Site


def asked_problem(
    registry: Registry,
    name: str,
    parameters: Path | None,
    objectives: str = "",
    scalariser: str | None = None,
    preferences: Path | None = None,
    assigned: Sequence[str] | None = None,
) -> Asked:
    """The problem of a command, `assigned` changing values of the site file. Raises PluginError or InputError."""
    registry.entry("problem", name)
    site = read_site(parameters, registry, name) if parameters else Site(name)
    settings = ProblemSettings(
        name,
        tuple(part.strip() for part in objectives.split(",") if part.strip()),
        _merged(site.sections, nested(assignments(assigned))),
        scalariser,
        {**site.scalarisers.get(scalariser or "", {}), **preference_settings(registry, scalariser, preferences)},
        site.worst,
    )
    with named_faults(scalariser, preferences, site):
        return Asked(make_problem(registry, settings, str(parameters or "parameters")), settings, site)


def assignments(texts: Sequence[str] | None, option: str = "--set") -> dict[str, Any]:
    """Parse NAME=VALUE texts of an option, values written as in TOML, bare words being strings. Raises InputError."""
    parsed: dict[str, Any] = {}
    for text in texts or []:
        name, equals, value = text.partition("=")
        if not equals or not name.strip():
            raise InputError(f"{option}: NAME=VALUE is needed, received {text!r}")
        try:
            parsed[name.strip()] = tomllib.loads(f"value = {value}")["value"]
        except (ValueError, RecursionError):
            parsed[name.strip()] = value.strip()
    return parsed


def _merged(tables: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Nested tables with some of their values changed."""
    merged = dict(tables)
    for name, value in changes.items():
        inside = tables.get(name, {})
        merged[name] = _merged(inside, value) if isinstance(value, dict) and isinstance(inside, Mapping) else value
    return merged


def changed_design(problem: DesignProblem, texts: Sequence[str] | None) -> FloatArray:
    """The reference design with the assigned variables changed. Raises InputError for a name or value not allowed."""
    changes = assignments(texts)
    return amended_design(problem, changes)


def results() -> Console:
    """Where results are printed; units in brackets are not markup, and a file or pipe has no narrow lines."""
    console = Console(highlight=False, markup=False)
    if not console.is_terminal and "COLUMNS" not in os.environ:
        console.width = PIPE_WIDTH
    return console


def print_json(document: object) -> None:
    """Print a document on standard output, numbers to the last bit."""
    sys.stdout.write(json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False) + "\n")


def write_template(out: Path | None, text: str) -> None:
    """Print a template, or write it to a new file. Raises InputError if the file exists, StorageError."""
    if out is None:
        sys.stdout.write(text)
        return
    if out.exists():
        raise InputError(f"--out: {out} exists and is not overwritten; choose another name")
    write_whole(out, text.encode("utf-8"))
    messages.print(f"wrote {out}")


def command_line() -> str:
    """The command as it was given, without passwords."""
    words = list(sys.argv[1:])
    for position, word in enumerate(words[:-1]):
        if word == "--storage":
            words[position + 1] = without_password(words[position + 1])
    words = [f"--storage={without_password(word[10:])}" if word.startswith("--storage=") else word for word in words]
    return shlex.join(["railsearch", *words])
