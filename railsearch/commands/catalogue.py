"""Commands that tell what there is: list, describe, init."""

import dataclasses
import inspect
from typing import Annotated, Any

import typer
from rich.table import Column, Table

from railsearch.commands.options import (
    AsJson,
    Output,
    print_json,
    results,
    write_template,
)
from railsearch.design_problem import DesignProblem
from railsearch.errors import InputError, PluginError
from railsearch.parameters import Description, describe_parameters
from railsearch.plugin_manager import KINDS, Entry, Registry, load_plugins
from railsearch.preferences import FUNCTIONS
from railsearch.problem_factory import ProblemSettings, make_problem
from railsearch.site import site_template
from railsearch.wording import closest, readable

Kind = Annotated[str | None, typer.Argument(metavar="[KIND]", help=f"One of {', '.join(KINDS)}; default: all.")]
Name = Annotated[str, typer.Argument(metavar="NAME", help="Name of a plugin of any kind; see `railsearch list`.")]


def list_plugins(kind: Kind = None, as_json: AsJson = False) -> None:
    """List what is installed: problems, strategies, surrogates, scalarisers, track models, commands."""
    if kind is not None and kind not in KINDS:
        raise InputError(f"KIND: received {kind!r}{closest(kind, list(KINDS))}; there are {', '.join(KINDS)}")
    entries = load_plugins().entries(kind)
    if as_json:
        print_json([_entry_document(entry) for entry in entries])
        return
    table = Table("kind", _names("name", [entry.name for entry in entries]), "what", "from", box=None, pad_edge=False)
    for entry in entries:
        origin = entry.provenance
        table.add_row(entry.kind, entry.name, entry.summary, f"{origin.distribution} {origin.version}")
    results().print(table)


def describe(name: Name, as_json: AsJson = False) -> None:
    """Describe a plugin: variables with units and bounds, objectives, parameters with defaults and sources.

    A name that several kinds share (a track model and a problem, say) is described for all of them.
    """
    registry = load_plugins()
    entries = registry.called(name)
    if not entries:
        raise PluginError(_unknown(registry, name))
    documents = [_description(registry, entry) for entry in entries]
    if as_json:
        print_json(documents)
        return
    for document in documents:
        _print_description(document)


def init(
    name: Annotated[str, typer.Argument(metavar="PROBLEM", help="Problem to write a site file for.")],
    out: Output = None,
) -> None:
    """Write a commented site file with every default, to be edited and given to the other commands as --parameters."""
    write_template(out, site_template(load_plugins(), name))


def _unknown(registry: Registry, name: str) -> str:
    """What is said of a name that no plugin has."""
    if name.replace("_", "-") in FUNCTIONS:
        return f"'{name}' is no plugin but a preference function; docs/preferences.md has all of them"
    if name.startswith("sklearn."):
        return f"'{name}' is no plugin but, where it is a regressor of scikit-learn, a surrogate; see docs/strategies.md"
    hint = closest(name, sorted({entry.name for entry in registry.entries()}))
    return f"unknown plugin '{name}'{hint}; `railsearch list` has all names"


def _entry_document(entry: Entry) -> dict[str, Any]:
    document = {"kind": entry.kind, "name": entry.name, "summary": entry.summary}
    return document | dataclasses.asdict(entry.provenance)


def _description(registry: Registry, entry: Entry) -> dict[str, Any]:
    document = _entry_document(entry) | {"documentation": inspect.cleandoc(entry.plugin.__doc__ or "")}
    if entry.members:
        return document | {"members": list(entry.members), "parameters": []}
    if entry.kind == "problem":
        sections = entry.plugin.sections(registry).items()
        document |= _made(registry, entry)
        parameters = [d for section, start in sections for d in describe_parameters(start, section + ".")]
    elif entry.kind == "command":
        parameters = []
    else:
        parameters = list(describe_parameters(entry.plugin.Parameters()))
    if entry.kind == "strategy":
        document["capabilities"] = dataclasses.asdict(entry.plugin.capabilities)
    if entry.kind == "track-model":
        document["metrics"] = [dataclasses.asdict(quantity) for quantity in entry.plugin.metrics]
        document["histories"] = [dataclasses.asdict(quantity) for quantity in entry.plugin.histories]
    return document | {"parameters": [dataclasses.asdict(description) for description in parameters]}


def _made(registry: Registry, entry: Entry) -> dict[str, Any]:
    """Variables, reference design and quantities of a problem; why not, where something is missing that it needs."""
    try:
        problem = make_problem(registry, ProblemSettings(entry.name))
    except PluginError as error:
        return {"unavailable": str(error)}
    available = entry.plugin.available_objectives or problem.objectives
    return {
        "variables": _variables(problem),
        "reference": None if problem.reference is None else problem.space.named(problem.reference),
        "objectives": [dataclasses.asdict(quantity) for quantity in available],
        "metrics": [dataclasses.asdict(quantity) for quantity in problem.metrics],
    }


def _variables(problem: DesignProblem) -> list[dict[str, Any]]:
    marginals = {} if problem.distributions is None else problem.distributions.marginals
    return [
        dataclasses.asdict(variable) | {"distribution": str(marginals[variable.name]) if marginals else None}
        for variable in problem.space.variables
    ]


def _print_description(document: dict[str, Any]) -> None:
    console = results()
    console.rule(f"{document['kind']} {document['name']}", align="left")
    console.print(
        f"{document['documentation']}\n\nfrom {document['distribution']} {document['version']} ({document['module']})\n"
    )
    if "unavailable" in document:
        console.print(f"it cannot be made here: {document['unavailable']}\n", soft_wrap=True)
    if "members" in document:
        console.print(f"in place of NAME: {', '.join(document['members'])}\n")
    for title in ("variables", "objectives", "metrics", "histories"):
        if document.get(title):
            console.print(_quantities(title, document[title], document.get("reference") or {}))
    if "capabilities" in document:
        console.print("capabilities: " + (", ".join(k for k, v in document["capabilities"].items() if v) or "none") + "\n")
    if document["parameters"]:
        console.print(_parameters([Description(**row) for row in document["parameters"]]))


def _quantities(title: str, rows: list[dict[str, Any]], reference: dict[str, Any]) -> Table:
    table = Table(title.removesuffix("s"), "unit", "meaning", box=None, pad_edge=False)
    if title == "variables":
        for column in ("kind", "from", "to", "reference"):
            table.add_column(column, justify="right")
    random = any(row.get("distribution") for row in rows)
    if random:
        table.add_column("distribution")
    for row in rows:
        cells = [row["name"], row["unit"], row["meaning"]]
        if title == "variables":
            cells += ["integer" if row["integer"] else "real", readable(row["lower"]), readable(row["upper"])]
            cells.append(readable(reference.get(row["name"])))
            cells += [row["distribution"]] if random else []
        table.add_row(*cells)
    table.add_row()
    return table


def _names(title: str, names: list[str]) -> Column:
    """A column whose entries are shown whole, because they are to be typed."""
    return Column(title, min_width=max((len(name) for name in names), default=0), no_wrap=True)


def _parameters(descriptions: list[Description]) -> Table:
    table = Table(_names("parameter", [row.name for row in descriptions]), box=None, pad_edge=False)
    for title in ("default", "unit", "allowed", "meaning", "source"):
        table.add_column(title, overflow="fold")
    for row in descriptions:
        default = "not given" if row.default is None else readable(row.default)
        table.add_row(row.name, default, row.unit, row.allowed, row.meaning, row.source)
    return table
