"""Commands around a campaign: campaign, report, export."""

import signal
import sys
from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import typer

from railsearch.campaign.capability import Refusal, capable_cells, check_capable, refusals
from railsearch.campaign.cells import Campaign, Cell
from railsearch.campaign.coordinator import CellTask, Coordinator, failure_message
from railsearch.campaign.definition import load_campaign
from railsearch.campaign.directory import CampaignDirectory
from railsearch.campaign.identity import campaign_identity, campaign_of
from railsearch.campaign.places import Places, places_here
from railsearch.campaign.problems import make_problems
from railsearch.campaign.reading import read_campaign
from railsearch.campaign.results import CampaignResults
from railsearch.campaign.tasks import TaskProgress, cell_tasks, check_recorded, evaluation_seconds, is_complete, recorded
from railsearch.campaign.template import campaign_template
from railsearch.commands.campaign_progress import campaign_progress
from railsearch.commands.campaign_tables import campaign_tables, cost_tables
from railsearch.commands.options import (
    AsJson,
    DaskAddress,
    Folder,
    Output,
    ProblemName,
    StorageUrl,
    command_line,
    messages,
    print_json,
    results,
    write_template,
)
from railsearch.dask_cluster import connected
from railsearch.design_problem import DesignProblem
from railsearch.errors import CampaignError, InputError
from railsearch.interfaces import Evaluation
from railsearch.plugin_manager import Registry, load_plugins
from railsearch.storage import (
    STORAGE_PATIENCE,
    Patience,
    Storage,
    claims_of,
    is_file,
    read_progress,
    storage_url,
    without_password,
)

if TYPE_CHECKING:
    from railsearch.campaign.recorded_runs import RecordedRuns

CampaignFile = Annotated[
    Path, typer.Argument(metavar="FILE.toml", help="Campaign file; `railsearch init-campaign PROBLEM` writes one.")
]
Workers = Annotated[int, typer.Option("--workers", "-w", help="Processes of this machine that run cells.", min=1)]


class Format(StrEnum):
    """Formats of an export."""

    PARQUET = "parquet"
    CSV = "csv"
    IOHPROFILER = "iohprofiler"


@dataclass(frozen=True)
class _Prepared:
    """A campaign that may begin."""

    registry: Registry
    campaign: Campaign
    problems: Mapping[str, DesignProblem]
    skipped: Sequence[Refusal]
    tasks: Sequence[CellTask]


def campaign(
    file: CampaignFile,
    workers: Workers = 1,
    dask: DaskAddress = None,
    batch_workers: Annotated[
        int, typer.Option("--batch-workers", help="Evaluations of a batch at a time, within each cell.", min=1)
    ] = 1,
    storage: StorageUrl = None,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", metavar="DIR", help="Folder of the campaign; default: its name.")
    ] = None,
    take: Annotated[
        list[Path] | None,
        typer.Option(
            "--take",
            metavar="results.parquet",
            help="Take over the complete runs that another folder of the same campaign has in its table; may be repeated.",
        ),
    ] = None,
    skip_incapable: Annotated[
        bool, typer.Option("--skip-incapable", help="Leave out the pairs of a strategy and a problem that it cannot search.")
    ] = False,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Show the cells and what they would cost; nothing is recorded.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Compare strategies on problems: every strategy on every problem, repeated with other seeds, on one budget.

    Every evaluation is stored before the next one is asked for. The same command continues a campaign that was stopped, adds
    what was added to the file, and makes the report. Several such commands may share one server (--storage postgresql://…).

        railsearch campaign examples/campaign_level_crossing/campaign.toml --workers 2 --out my-campaign
    """
    if dask is not None and workers > 1:
        raise InputError("--workers, --dask: either processes of this machine or the workers of a cluster do the work")
    prepared = _prepared(file, skip_incapable)
    directory = CampaignDirectory(out or Path(prepared.campaign.name))
    given_url = None if storage is None else storage_url(storage)
    url = given_url or directory.embedded_url
    identity = campaign_identity(prepared.registry, prepared.campaign, prepared.problems)
    document = {
        "command": command_line(),
        "storage": given_url and without_password(given_url),
        "identity": identity,
        "skipped": [[refusal.problem, refusal.strategy, refusal.reason] for refusal in prepared.skipped],
    }
    changes = directory.changes(document)
    stored = read_progress(url, f"{prepared.campaign.name}/")
    check_recorded(prepared.tasks, stored, without_password(url))
    known = _taken(take, prepared, identity) if take else {}
    for change in changes.compatible:
        messages.print(f"changed: {change}")
    if take:
        new = [task for task in prepared.tasks if task.cell in known and not is_complete(task, stored)]
        messages.print(f"taking over: {len(new)} complete runs with {sum(task.evaluations for task in new)} evaluations")
    if dry_run:
        _print_cost(prepared, recorded(prepared.tasks, stored, known), workers)
        return
    with directory.claimed(document):
        failed = _carried_out(prepared, url, dask, workers, batch_workers, known)
        found = _report(prepared.registry, directory, document, url)
    _print_found(found, as_json)
    if failed:
        raise CampaignError(failed)


def init_campaign(name: ProblemName, out: Output = None) -> None:
    """Write a commented campaign file for a problem: all strategies that can search it, everything else to choose.

    railsearch init-campaign level-crossing --out my-campaign.toml
    """
    write_template(out, campaign_template(load_plugins(), name))


def report(folder: Folder, storage: StorageUrl = None, as_json: AsJson = False) -> None:
    """Make the report of a campaign from its record, finished or not, while it runs or afterwards."""
    directory = CampaignDirectory(folder)
    stored = directory.stored()
    url = directory.url(stored, storage)
    _print_found(_report(load_plugins(), directory, stored, url), as_json)


def export(
    folder: Folder,
    out: Annotated[Path, typer.Option("--out", "-o", metavar="PATH", help="File, or folder for iohprofiler.")],
    form: Annotated[Format | None, typer.Option("--format", "-f", help="Default: what the file's name ends with.")] = None,
    storage: StorageUrl = None,
) -> None:
    """Export the evaluations of a campaign: one tidy table (parquet, csv), or IOHprofiler's format for IOHanalyzer.

    railsearch export my-campaign --out evaluations.csv
    railsearch export my-campaign --format iohprofiler --out for-iohanalyzer
    """
    from railsearch.campaign.export import write_csv, write_iohprofiler, write_parquet

    chosen = form or _format_of(out)
    directory = CampaignDirectory(folder)
    stored = directory.stored()
    url = directory.url(stored, storage)
    gathered = read_campaign(load_plugins(), url, campaign_of(stored["identity"]))
    match chosen:
        case Format.PARQUET:
            write_parquet(gathered, out, stored["identity"])
        case Format.CSV:
            write_csv(gathered, out)
        case Format.IOHPROFILER:
            write_iohprofiler(gathered, out)
    messages.print(f"wrote {out}")


def _prepared(file: Path, skip_incapable: bool) -> _Prepared:
    registry = load_plugins()
    defined = load_campaign(registry, file)
    problems = make_problems(registry, defined)
    refused = refusals(registry, defined, problems)
    check_capable(defined, refused, skip_incapable)
    for refusal in refused:
        messages.print(f"left out: {refusal.strategy} on {refusal.problem}: {refusal.reason}")
    tasks = cell_tasks(registry, defined, problems, capable_cells(defined, refused), command_line())
    return _Prepared(registry, defined, problems, refused, tasks)


def _taken(paths: Sequence[Path], prepared: _Prepared, identity: Mapping[str, Any]) -> "dict[Cell, RecordedRuns]":
    from railsearch.campaign.recorded_runs import complete_runs

    return complete_runs(paths, prepared.tasks, identity)


def _carried_out(
    prepared: _Prepared, url: str, dask: str | None, workers: int, batch_workers: int, known: "Mapping[Cell, RecordedRuns]"
) -> str:
    """Carry the cells out; what could not be finished, in words."""
    patience = Patience(0.0 if is_file(url) else STORAGE_PATIENCE, messages.print)
    stored = read_progress(url, f"{prepared.campaign.name}/")
    before = recorded(prepared.tasks, stored)
    if before.complete == len(prepared.tasks):
        messages.print(f"complete: all {before.evaluations} evaluations are recorded, nothing is evaluated")
        return ""
    if before.evaluations:
        messages.print(f"continuing: {before.evaluations} evaluations and {before.complete} complete cells are recorded")
    cells, evaluations = len(prepared.tasks), sum(task.evaluations for task in prepared.tasks)
    messages.print(f"{cells} cell{'s' * (cells > 1)}, {evaluations} evaluations")
    unfinished = [task for task in prepared.tasks if not is_complete(task, stored)]
    places = _places(prepared.registry, dask, min(workers, len(unfinished)))
    with (
        closing(Storage(url, patience, claims_of(url))) as store,
        campaign_progress(prepared.problems, prepared.tasks, before) as watcher,
    ):

        def made(task: CellTask) -> Sequence[Evaluation]:
            cell = task.cell
            return known[cell].evaluations(cell, prepared.problems[cell.problem]) if cell in known else ()

        coordinator = Coordinator(store, unfinished, prepared.campaign.timeout, batch_workers, watcher, made)
        # A batch system ends a job with SIGTERM: it is answered like Ctrl-C.
        signal.signal(signal.SIGTERM, signal.default_int_handler)
        try:
            coordinator.carry_out(places)
        except KeyboardInterrupt:
            done = sum(entry.evaluations for entry in read_progress(url, f"{prepared.campaign.name}/").values())
            messages.print(f"stopped: {done} evaluations are recorded; the same command goes on from there")
            sys.exit(130)
    return failure_message(coordinator.failed) if coordinator.failed else ""


def _places(registry: Registry, dask: str | None, workers: int) -> Places:
    if dask is None:
        return places_here(registry, workers)
    from railsearch.campaign.dask_places import DaskPlaces

    return DaskPlaces(connected(dask, messages.print))


def _print_cost(prepared: _Prepared, progress: TaskProgress, workers: int) -> None:
    messages.print("timing one evaluation of each problem; nothing is recorded")
    seconds = {label: evaluation_seconds(problem) for label, problem in prepared.problems.items()}
    for table in cost_tables(prepared.campaign, prepared.tasks, progress, seconds, workers):
        results().print(table)


def _report(registry: Registry, directory: CampaignDirectory, stored: Mapping[str, Any], url: str) -> dict[str, Any]:
    """Statistics, figures, report and table of a campaign, from its storage alone."""
    from railsearch.campaign.analysis import campaign_document
    from railsearch.campaign.export import write_parquet
    from railsearch.report import write_figures
    from railsearch.report.campaign_figures import campaign_figures
    from railsearch.report.campaign_page import write_campaign_report

    messages.print("reading the record, drawing the report")
    gathered = read_campaign(registry, url, campaign_of(stored["identity"]))
    skipped = {(problem, strategy) for problem, strategy, _ in stored["skipped"]}
    found = campaign_document(gathered, skipped, stored["command"])
    write_parquet(gathered, directory.results, stored["identity"])
    directory.write_statistics(found)
    write_figures(directory.figures, campaign_figures(found))
    write_campaign_report(directory.report, found, _pictures(gathered, found))
    messages.print(f"wrote {directory.report}, {directory.figures}, {directory.statistics}, {directory.results}")
    return found


def _pictures(gathered: CampaignResults, found: Mapping[str, Any]) -> dict[str, Any]:
    """The problems' own pictures of reference and best design, by label."""
    pictures = {}
    for entry in found["problems"]:
        problem, shown = gathered.problems[entry["label"]], entry["design"]
        designs = {
            name: np.array([shown[name]["design"][variable] for variable in problem.space.names], dtype=float)
            for name in ("reference", "best")
            if shown[name]
        }
        if "best" in designs:
            pictures[entry["label"]] = problem.figures(designs)
    return pictures


def _print_found(found: dict[str, Any], as_json: bool) -> None:
    if as_json:
        print_json(found)
        return
    console = results()
    for table in campaign_tables(found):
        console.print(table)
        console.print()
    for line in (found["conclusion"], *found["notes"]):
        console.print(line, soft_wrap=True)


def _format_of(path: Path) -> Format:
    try:
        return Format(path.suffix.removeprefix("."))
    except ValueError:
        known = ", ".join(form.value for form in Format)
        raise InputError(f"--format: cannot be told from the name {path.name}; give one of {known}") from None
