"""The command line: built-in commands come in through the same hook as a stranger's."""

import logging
import sys
from collections.abc import Callable
from typing import Any

import typer

from railsearch.commands.campaign import campaign, export, init_campaign, report
from railsearch.commands.catalogue import describe, init, list_plugins
from railsearch.commands.choose import choose
from railsearch.commands.evaluation import evaluate, simulate
from railsearch.commands.options import messages
from railsearch.commands.progress import plain_warnings
from railsearch.commands.sampling import sample
from railsearch.commands.search import dashboard, run, show
from railsearch.commands.sensitivity import sensitivity
from railsearch.commands.track_export import export_track
from railsearch.errors import RailsearchError
from railsearch.hookspecs import hookimpl
from railsearch.plugin_manager import load_plugins

HELP = """Search for better railway transition zones on a budget of expensive vehicle-track simulations.

Begin with `railsearch list`, `railsearch describe level-crossing` and `railsearch evaluate level-crossing`; then search:

railsearch run level-crossing --scalarise asf --budget 400 --seed 1 --out my-run
"""


@hookimpl
def railsearch_commands(register: Callable[[str, Any], None]) -> None:
    """Register the built-in commands."""
    for name, command in (
        ("list", list_plugins),
        ("describe", describe),
        ("init", init),
        ("simulate", simulate),
        ("evaluate", evaluate),
        ("sample", sample),
        ("sensitivity", sensitivity),
        ("run", run),
        ("show", show),
        ("choose", choose),
        ("dashboard", dashboard),
        ("init-campaign", init_campaign),
        ("campaign", campaign),
        ("report", report),
        ("export", export),
        ("export-track", export_track),
    ):
        register(name, command)


def main() -> None:
    """Run the command line; an error that the user can mend ends it with code 2."""
    logging.getLogger("optuna").setLevel(logging.WARNING)
    app = typer.Typer(
        help=HELP, no_args_is_help=True, add_completion=False, pretty_exceptions_enable=False, rich_markup_mode="markdown"
    )
    try:
        registry = load_plugins()
        for warning in registry.warnings:
            messages.print(f"railsearch: warning: {warning}")
        for entry in registry.entries("command"):
            app.command(entry.name)(entry.plugin)
        with plain_warnings():
            app(prog_name="railsearch")
    except RailsearchError as error:
        messages.print(f"railsearch: error: {error}")
        sys.exit(2)
