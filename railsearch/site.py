"""A site file (TOML): the problem's parameters, variable bounds, given designs, strategy and scalariser settings."""

import dataclasses
import json
import re
import tomllib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from railsearch.errors import InputError, located
from railsearch.parameters import allowed_values, make_parameters
from railsearch.plugin_manager import Registry
from railsearch.preferences import GroupPreferenceParameters
from railsearch.problem_factory import ProblemSettings, checked_sections, make_problem, natural_worst


@dataclass(frozen=True)
class Site:
    """What a site file says; sections, strategies and scalarisers as (nested) tables that have been checked."""

    problem: str
    path: Path | None = None
    sections: Mapping[str, Any] = field(default_factory=dict)
    given: tuple[Mapping[str, float], ...] = ()
    worst: Mapping[str, Any] = field(default_factory=dict)
    strategies: Mapping[str, Mapping[str, object]] = field(default_factory=dict)
    scalarisers: Mapping[str, Mapping[str, object]] = field(default_factory=dict)


def read_site(path: Path, registry: Registry, problem: str) -> Site:
    """Read and check a site file for a problem. Raises InputError naming the file, the field and what is allowed."""
    document = read_toml(path)
    named = document.pop("problem", problem)
    if named != problem:
        raise InputError(f"{path}: problem: this file describes '{named}', asked for is '{problem}'")
    strategies = _settings_tables(document.pop("strategy", {}), "strategy", registry, path)
    scalarisers = _settings_tables(document.pop("scalariser", {}), "scalariser", registry, path)
    given = document.pop("given", [])
    if not (isinstance(given, list) and all(isinstance(row, dict) for row in given)):
        raise InputError(f"{path}: given: tables [[given]] of variables are needed, received {given!r}")
    worst = document.pop("worst", {})
    if not isinstance(worst, dict):
        raise InputError(f"{path}: worst: a table [worst] of objectives is needed, received {worst!r}")
    checked_sections(registry, problem, document, str(path))
    return Site(problem, path, document, tuple(given), worst, strategies, scalarisers)


def site_template(registry: Registry, problem: str) -> str:
    """A commented site file with every default of a problem, of all strategies and of all scalarisers."""
    lines = [
        f"# A site for the problem {problem}. Every value is the default; SI units unless the comment says otherwise.",
        '# A list may stand in a text file beside this one (columns; # begins a comment): { file = "x.csv", column = 1 }',
        f"problem = {json.dumps(problem)}",
    ]
    for section, start in registry.get("problem", problem).sections(registry).items():
        lines += _table(section, start)
    lines += _worst_table(registry, problem)
    lines += ["", "# Designs to evaluate first, after the reference design, whose values hold where none is given."]
    lines += ["# [[given]]", "# VARIABLE = VALUE"]
    for kind in ("strategy", "scalariser"):
        for entry in registry.entries(kind):
            lines += _table(f"{kind}.{entry.name}", entry.plugin.Parameters())
    return "\n".join(lines) + "\n"


def preference_settings(registry: Registry, scalariser: str | None, path: Path | None) -> dict[str, Any]:
    """What a preference file (TOML) sets of a scalariser; nothing without a file.

    Raises InputError for a fault in the file, without a scalariser, and for one that does not take what the file has.
    """
    if path is None:
        return {}
    document = read_toml(path)
    make_parameters(GroupPreferenceParameters, document, str(path))
    able = [
        entry.name
        for entry in registry.entries("scalariser")
        if set(document) <= {field.name for field in dataclasses.fields(entry.plugin.Parameters)}
    ]
    if scalariser is None or registry.entry("scalariser", scalariser).name not in able:
        which = "no scalariser is named" if scalariser is None else f"scalariser {scalariser} does not take them"
        raise InputError(f"{path}: it has {', '.join(document)}, but {which}; name one that does: {', '.join(able)}")
    return document


@contextmanager
def named_faults(scalariser: str | None, preferences: Path | None, site: Site | None = None) -> Iterator[None]:
    """Have errors in settings of a scalariser name the preference file or the site file that they come from."""
    try:
        yield
    except InputError as error:
        found = str(error).removeprefix(f"{scalariser}.")
        setting = re.split(r"\W", found, maxsplit=1)[0]
        if preferences is not None and setting in {field.name for field in dataclasses.fields(GroupPreferenceParameters)}:
            raise InputError(f"{preferences}: {found}") from None
        if site is not None and found != str(error) and setting in site.scalarisers.get(scalariser or "", {}):
            raise InputError(f"{site.path}: scalariser.{error}") from None
        raise


def _worst_table(registry: Registry, problem: str) -> Iterator[str]:
    made = make_problem(registry, ProblemSettings(problem))
    known = natural_worst(made)
    yield from (
        "",
        f"# Worst values of the objectives, for scalarisers; `railsearch sample {problem}` finds them.",
        "[worst]",
    )
    for quantity in made.available_objectives or made.objectives:
        yield f"# {quantity.meaning or quantity.name}" + (f" [{quantity.unit}]" if quantity.unit else "")
        yield f"{quantity.name} = {known[quantity.name]!r}" if quantity.name in known else f"# {quantity.name} ="


def read_toml(path: Path) -> dict[str, Any]:
    """A TOML file with the columns of other files that it names. Raises InputError if one of them cannot be read."""
    try:
        document = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: is not a TOML file: {error}") from None
    columns: dict[str, Any] = _with_columns(document, path)
    return columns


def _with_columns(value: Any, path: Path) -> Any:
    """The document with every table {file = …, column = …} replaced by that column of a file beside it.

    A table {file = …} alone becomes the whole path of a file beside it.
    """
    if isinstance(value, list):
        return [_with_columns(entry, path) for entry in value]
    if not isinstance(value, dict):
        return value
    if set(value) == {"file", "column"}:
        return _column(path, value["file"], value["column"])
    if set(value) == {"file"} and isinstance(value["file"], str):
        return str((path.parent / value["file"]).resolve())
    return {key: _with_columns(entry, path) for key, entry in value.items()}


def _column(path: Path, file: object, column: object) -> list[float]:
    if not isinstance(file, str) or isinstance(column, bool) or not isinstance(column, int) or column < 1:
        raise InputError(f"{path}: file = NAME and column = 1, 2, … are needed, received {file!r} and {column!r}")
    table = path.parent / file
    try:
        lines = table.read_text(encoding="utf-8").replace(",", " ").replace(";", " ").splitlines()
        values = np.loadtxt(lines, ndmin=2)[:, column - 1]
    except OSError as error:
        raise InputError(f"{table}: cannot be read: {error.strerror}") from None
    except (ValueError, IndexError) as error:
        raise InputError(f"{table}: numbers in {column} or more columns are needed: {error}") from None
    return [float(value) for value in values]


def _settings_tables(tables: object, kind: str, registry: Registry, path: Path) -> dict[str, Mapping[str, object]]:
    if not isinstance(tables, dict) or not all(isinstance(table, dict) for table in tables.values()):
        raise InputError(f"{path}: {kind}: tables [{kind}.NAME] are needed, received {tables!r}")
    for name, table in tables.items():
        with located(f"{path}: [{kind}.{name}]"):
            plugin = registry.get(kind, name)
        make_parameters(plugin.Parameters, table, f"{path}: {kind}.{name}")
    return tables


def _table(name: str, group: Any) -> Iterator[str]:
    fields = dataclasses.fields(group)
    plain = [item for item in fields if not dataclasses.is_dataclass(getattr(group, item.name))]
    if plain:
        yield from ("", f"[{name}]")
    for item in plain:
        yield from _assignment(item, getattr(group, item.name))
    for item in fields:
        if item not in plain:
            yield from _table(f"{name}.{item.name}", getattr(group, item.name))


def _assignment(item: Any, value: object) -> Iterator[str]:
    meta = item.metadata
    unit, allowed, source = meta.get("unit"), allowed_values(meta), meta.get("source")
    words = [meta.get("meaning", "") + (f" [{unit}]" if unit else ""), allowed and f"allowed {allowed}", source]
    yield "# " + "; ".join(word for word in words if word)
    yield f"# {item.name} =" if value is None else f"{item.name} = {toml_value(value)}"


def toml_value(value: object) -> str:
    """A plain value as it is written in a TOML file."""
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{json.dumps(key)} = {toml_value(entry)}" for key, entry in value.items()) + "}"
    if isinstance(value, tuple):
        return "[" + ", ".join(toml_value(entry) for entry in value) + "]"
    return json.dumps(value, ensure_ascii=False)


def track_section(path: Path) -> Mapping[str, Any]:
    """The track model's parameters of a site file, unchecked. Raises InputError if there are none."""
    document = read_toml(path)
    if not isinstance(document.get("track"), dict):
        raise InputError(
            f"{path}: a section [track] with the track model's parameters is needed; there are {list(document)}"
        )
    track: Mapping[str, Any] = document["track"]
    return track
