"""The command that takes a track model's matrices elsewhere: export-track."""

from pathlib import Path
from typing import Annotated

import typer

from railsearch.commands.evaluation import ModelName, asked_track
from railsearch.commands.options import Assignments, Parameters, messages
from railsearch.errors import InputError
from railsearch.plugin_manager import load_plugins
from railsearch.track_files import FORMATS, write_track

Out = Annotated[Path, typer.Option("--out", "-o", metavar="DIR", help="Folder to write, without a site.toml yet.")]
Format = Annotated[str, typer.Option("--format", help=f"{' or '.join(FORMATS)}: all in one file, or MatrixMarket files.")]
Parts = Annotated[bool, typer.Option("--parts", help="Write what is designed (the pads next to a crossing) as parts.")]


def export_track(
    name: ModelName,
    out: Out,
    parameters: Parameters = None,
    assigned: Assignments = None,
    file_format: Format = "npz",
    parts: Parts = False,
) -> None:
    """Write the matrices of a track with tables of rail and supports, and a site file of `imported-track` that reads them.

    railsearch export-track level-crossing --parts --out my-track
    railsearch simulate imported-track --parameters my-track/site.toml
    """
    registry = load_plugins()
    model = registry.track_model(name)
    if not hasattr(model, "export"):
        able = [e.name for e in registry.entries("track-model") if hasattr(e.plugin, "export")]
        raise InputError(
            f"TRACK_MODEL: {name} has no matrices to export, those of {', '.join(able)} can be; name one of them"
        )
    for path in write_track(out, model.export(asked_track(model, name, parameters, assigned), parts), file_format):
        messages.print(f"wrote {path}")
