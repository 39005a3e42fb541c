"""Commands that carry out one simulation: simulate, evaluate."""

import dataclasses
import io
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.table import Table

from railsearch.commands.options import (
    AsJson,
    Assignments,
    Objectives,
    Parameters,
    ProblemName,
    asked_problem,
    assignments,
    changed_design,
    command_line,
    messages,
    print_json,
    results,
)
from railsearch.errors import InputError, SimulationError
from railsearch.interfaces import Evaluation, Passage, TrackModel
from railsearch.parameters import amend_parameters, nested
from railsearch.plugin_manager import Entry, load_plugins
from railsearch.result import evaluation_document, values_of
from railsearch.run_directory import write_whole
from railsearch.site import track_section
from railsearch.wording import quantity_label, readable

ModelName = Annotated[
    str, typer.Argument(metavar="TRACK_MODEL", help="Name of a track model; see `railsearch list track-model`.")
]
Histories = Annotated[Path | None, typer.Option("--histories", metavar="FILE.npz", help="Write the histories to this file.")]
Report = Annotated[
    Path | None, typer.Option("--report", metavar="FILE.html", help="Write a page of metrics, figures and parameters.")
]


def simulate(
    name: ModelName,
    parameters: Parameters = None,
    assigned: Assignments = None,
    histories: Histories = None,
    report: Report = None,
    as_json: AsJson = False,
) -> None:
    """Simulate one passage with a track model and print its metrics.

    Parameters are SI and named as `railsearch describe TRACK_MODEL` lists them; a `track.` before them does no harm:

        railsearch simulate level-crossing --set passage.speed=30 --set zone.strengthened_sleepers=4

    With --report a page with figures is written, which needs nothing beside itself:

        railsearch simulate train-track-bridge --set snapshot_time=2.5 --report passage.html
    """
    _check_file("--histories", histories, ".npz")
    _check_file("--report", report, ".html")
    registry = load_plugins()
    model = registry.track_model(name)
    track = asked_track(model, name, parameters, assigned)
    response = model.simulate(track, histories=histories is not None or report is not None)
    if histories is not None:
        _write_histories(histories, response.histories)
    if report is not None:
        _write_page(report, registry.entry("track-model", name), model, Passage(track, response))
    if as_json:
        units = {quantity.name: quantity.unit for quantity in model.metrics}
        print_json(
            {"track_model": name, "parameters": dataclasses.asdict(track), "metrics": dict(response.metrics), "units": units}
        )
        return
    results().print(_values_table(model.metrics, response.metrics))


def asked_track(model: TrackModel, name: str, parameters: Path | None, assigned: Sequence[str] | None) -> Any:
    """The parameters of the track model `name` by a site file and assignments. Raises InputError."""
    start = amend_parameters(model.Parameters(), track_section(parameters) if parameters else {}, str(parameters))
    changes = {key.removeprefix("track."): value for key, value in assignments(assigned).items()}
    return amend_parameters(start, nested(changes), name)


def evaluate(
    name: ProblemName,
    parameters: Parameters = None,
    assigned: Assignments = None,
    objectives: Objectives = "",
    as_json: AsJson = False,
) -> None:
    """Evaluate one design of a problem, by default its reference design.

    railsearch evaluate level-crossing --set xr1=500 --set xs3=3
    """
    asked = asked_problem(load_plugins(), name, parameters, objectives)
    problem = asked.problem
    design = changed_design(problem, assigned)
    outcome = problem.finish(design, problem.simulate(design))
    evaluation = Evaluation(0, design, outcome.objectives, outcome.constraints, outcome.metrics, "given")
    document = evaluation_document(problem, evaluation)
    if not np.all(np.isfinite(outcome.objectives)):
        raise SimulationError(f"the evaluation failed: {document['objectives']} at {document['design']}")
    if as_json:
        print_json({"problem": name} | {key: document[key] for key in ("design", "metrics", "objectives")})
        return
    console = results()
    table = Table("variable", "unit", "value", box=None, pad_edge=False)
    for variable in problem.space.variables:
        table.add_row(variable.name, variable.unit, readable(document["design"][variable.name]))
    console.print(table)
    console.print(_values_table(problem.metrics or problem.objectives, values_of(problem, evaluation)))


def _values_table(quantities: Any, values: Any) -> Table:
    table = Table("quantity", "value", "meaning", box=None, pad_edge=False)
    for quantity in quantities:
        table.add_row(quantity_label(quantity.name, quantity.unit), readable(values[quantity.name]), quantity.meaning)
    return table


def _check_file(option: str, path: Path | None, suffix: str) -> None:
    """Raise InputError unless a file of this name could be written, before anything is simulated for it."""
    if path is None:
        return
    if path.suffix != suffix or path.is_dir():
        raise InputError(f"{option}: a file name that ends with {suffix} is needed, received {path}")
    if not path.parent.is_dir():
        raise InputError(f"{option}: a file in a folder that exists is needed, received {path}; make {path.parent} first")


def _write_page(path: Path, entry: Entry, model: TrackModel, passage: Passage) -> None:
    from railsearch.report.simulation_page import simulation_page

    write_whole(path, simulation_page(entry, model, passage, command_line()).encode("utf-8"))
    messages.print(f"wrote {path}")


def _write_histories(path: Path, histories: Any) -> None:
    content = io.BytesIO()
    np.savez_compressed(content, **histories)
    write_whole(path, content.getvalue())
    messages.print(f"wrote {path}: {', '.join(histories)}")
