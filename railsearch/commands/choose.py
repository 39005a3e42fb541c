"""Command choose: preferences applied to the designs that a search has found."""

from pathlib import Path
from typing import Annotated, Any

import typer

from railsearch.choice import Choice, choice_document
from railsearch.choice import choose as ranked
from railsearch.commands.options import AsJson, Folder, StorageUrl, command_line, messages, print_json, results
from railsearch.commands.stored_run import stored_run
from railsearch.commands.tables import preference_scores_table, quantities_table, ranking_table, variables_table
from railsearch.plugin_manager import load_plugins
from railsearch.run_directory import RunDirectory
from railsearch.site import named_faults, preference_settings, read_toml

ALONE, GROUP = "preference-minmax", "imap"


def choose(
    folder: Folder,
    preferences: Annotated[
        Path,
        typer.Option("--preferences", metavar="FILE.toml", help="Preference functions and weights (docs/preferences.md)."),
    ],
    scalarise: Annotated[
        str | None,
        typer.Option(
            "--scalarise", metavar="NAME", help=f"How scores become one; default: {ALONE}, with stakeholders {GROUP}."
        ),
    ] = None,
    top: Annotated[int, typer.Option("--top", help="How many candidates to list.", min=1)] = 10,
    storage: StorageUrl = None,
    as_json: AsJson = False,
) -> None:
    """Choose among the best designs of a run with several objectives, finished or not, by stated preferences.

    Candidates are the feasible designs that no other one dominates in the objectives of the run; of a scalarised run
    the objectives behind the scalar count. A preference may be on any other metric too. Writes choice-FILE.html into DIR.

        railsearch choose my-front --preferences preferences.toml
    """
    registry = load_plugins()
    name = scalarise or (GROUP if {"stakeholders", "aggregation"} & set(read_toml(preferences)) else ALONE)
    settings = preference_settings(registry, name, preferences)
    directory = RunDirectory(folder)
    run = stored_run(registry, directory, storage)
    with named_faults(name, preferences):
        choice = ranked(registry, run.problem, run.evaluations, name, settings)
    document = choice_document(choice, top)
    _write_page(directory, choice, preferences)
    if as_json:
        print_json(document)
        return
    console = results()
    tables = (ranking_table, preference_scores_table, quantities_table, variables_table)
    for table in tables:
        console.print(table(document))
        console.print()
    console.print(_sentence(document), soft_wrap=True)


def _write_page(directory: RunDirectory, choice: Choice, preferences: Path) -> None:
    from railsearch.report.choice_page import choice_page

    name = f"choice-{preferences.stem}.html"
    directory.write(name, choice_page(choice, f"{choice.problem.label}: choice by {preferences.name}", command_line()))
    messages.print(f"wrote {directory.folder / name}")


def _sentence(document: dict[str, Any]) -> str:
    best = document["best"]
    return (
        f"chosen: evaluation {best['number']}, first of {document['candidates']} designs that no other one dominates among "
        f"{document['evaluations']} evaluations"
    )
