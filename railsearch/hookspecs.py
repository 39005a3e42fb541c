"""The hooks, nothing else. Each receives `register(name, plugin)`; a name may be taken once.

A name `FAMILY:NAME`, with NAME as it stands, registers a family instead of a plugin: its `members()` are the names that it
knows, and `member(name)` is the plugin that goes by `FAMILY:name`; it raises PluginError for others.
"""

from collections.abc import Callable
from typing import Any

import pluggy

hookspec = pluggy.HookspecMarker("railsearch")
hookimpl = pluggy.HookimplMarker("railsearch")

Register = Callable[[str, Any], None]


@hookspec
def railsearch_track_models(register: Register) -> None:
    """Register classes of the shape `interfaces.TrackModel`."""


@hookspec
def railsearch_surrogates(register: Register) -> None:
    """Register classes of the shape `interfaces.Surrogate`."""


@hookspec
def railsearch_strategies(register: Register) -> None:
    """Register classes of the shape `interfaces.Strategy`."""


@hookspec
def railsearch_scalarisers(register: Register) -> None:
    """Register classes of the shape `interfaces.Scalariser`."""


@hookspec
def railsearch_problems(register: Register) -> None:
    """Register subclasses of `design_problem.DesignProblem`."""


@hookspec
def railsearch_commands(register: Register) -> None:
    """Register functions as commands of the command line; typer reads their signature and docstring."""
