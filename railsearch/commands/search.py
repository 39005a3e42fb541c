"""Commands around a search: run, show, dashboard."""

import json
import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from railsearch.campaign.directory import CampaignDirectory
from railsearch.commands.options import (
    AsJson,
    Asked,
    Assignments,
    DaskAddress,
    Folder,
    Objectives,
    Parameters,
    PreferenceFile,
    ProblemName,
    StorageUrl,
    asked_problem,
    assignments,
    command_line,
    messages,
    print_json,
    results,
)
from railsearch.commands.progress import run_progress
from railsearch.commands.stored_run import record_url, stored_document, stored_run, study_of
from railsearch.commands.tables import result_tables, sentence
from railsearch.dask_cluster import connected
from railsearch.design_problem import DesignProblem
from railsearch.errors import InputError, StorageError
from railsearch.parameters import describe_parameters
from railsearch.plugin_manager import Registry, load_plugins
from railsearch.problem_factory import given_designs
from railsearch.result import RunCommand, result_document
from railsearch.run import RunResult, RunSettings, make_strategy, run_search
from railsearch.run_directory import RESULT_FILE, RunDirectory
from railsearch.run_identity import all_settings, run_identity
from railsearch.seeding import checked_seed
from railsearch.simulation import Simulators
from railsearch.space import FloatArray, Space
from railsearch.storage import (
    STORAGE_PATIENCE,
    Patience,
    RunStorage,
    Storage,
    StudyDescription,
    check_storage,
    is_file,
    plain,
    server_claims,
    storage_url,
    without_password,
)


def run(
    name: ProblemName,
    strategy: Annotated[
        str, typer.Option("--strategy", help="Name of a strategy; see `railsearch list strategy`.")
    ] = "dycors",
    budget: Annotated[
        int, typer.Option("--budget", "-n", help="Evaluations to spend, the reference design's included.")
    ] = 200,
    seed: Annotated[
        int | None, typer.Option("--seed", help="Seed of all randomness; drawn and reported if not given.")
    ] = None,
    objectives: Objectives = "",
    scalarise: Annotated[
        str | None, typer.Option("--scalarise", metavar="NAME", help="Scalariser, for instance asf.")
    ] = None,
    preferences: PreferenceFile = None,
    parameters: Parameters = None,
    assigned: Assignments = None,
    batch: Annotated[int, typer.Option("--batch", help="Designs proposed at a time.")] = 1,
    timeout: Annotated[
        float | None, typer.Option("--timeout", metavar="SECONDS", help="Time limit of one evaluation.")
    ] = None,
    workers: Annotated[
        int, typer.Option("--workers", "-w", help="Designs of a batch evaluated at a time, in processes.", min=1)
    ] = 1,
    dask: DaskAddress = None,
    initial_seed: Annotated[
        int | None, typer.Option("--initial-seed", help="Seed of the initial design, if it is to differ from the seed.")
    ] = None,
    storage: StorageUrl = None,
    out: Annotated[Path | None, typer.Option("--out", "-o", metavar="DIR", help="Folder of the run.")] = None,
    as_json: AsJson = False,
) -> None:
    """Search a problem with a strategy until the budget is spent; record, tabulate and draw the result.

    The same command again continues a run that was stopped, or shows the result of a complete one. `--set` changes
    settings of the strategy, for instance `--set sigma_start=0.1`.

        railsearch run level-crossing --scalarise asf --strategy dycors --budget 400 --seed 1 --out my-run
    """
    registry = load_plugins()
    asked = asked_problem(registry, name, parameters, objectives, scalarise, preferences)
    settings = RunSettings(
        strategy,
        budget,
        _seed(seed, out),
        _strategy_settings(registry, asked, strategy, assigned),
        batch,
        timeout,
        None if initial_seed is None else checked_seed(initial_seed, "initial-seed"),
        workers,
    )
    given = given_designs(asked.problem, asked.site.given, f"{parameters}: [[given]]")
    make_strategy(registry, asked.problem, settings, len(given))
    identity = plain(run_identity(registry, asked.settings, asked.problem, settings, given))
    folder = RunDirectory(out or Path(f"{name}-{strategy}-seed{settings.seed}"))
    url = None if storage is None else storage_url(storage)
    document = {"command": command_line(), "storage": url and without_password(url), "identity": identity}
    with folder.claimed(document) as begun:
        command = RunCommand(begun["command"], identity)
        try:
            record = _claimed_record(url or folder.embedded_url, study_of(asked.problem, command), asked.problem.space)
        except StorageError:
            folder.withdraw(begun, document)
            raise
        simulating = None if dask is None else _in_cluster(dask, asked.problem, settings)
        result = _searched(registry, asked.problem, settings, given, record, folder, simulating)
        found = result_document(registry, asked.problem, command, result)
        _finish(folder, asked.problem, found, result)
    _print_result(found, as_json)


def show(folder: Folder, storage: StorageUrl = None, as_json: AsJson = False) -> None:
    """Show the result of a run: of a complete one as it was written, of an incomplete one from its record."""
    if CampaignDirectory(folder).held:
        raise InputError(f"DIR: {folder} holds a campaign; `railsearch report {folder}` shows it")
    directory = RunDirectory(folder)
    stored_document(directory)
    found = directory.stored_result() or _unfinished(directory, storage)
    _print_result(found, as_json)


def dashboard(
    folder: Folder,
    storage: StorageUrl = None,
    port: Annotated[int, typer.Option("--port", help="Port on 127.0.0.1.", min=1, max=65535)] = 8080,
) -> None:
    """Look into a run or a campaign in Optuna's dashboard, on 127.0.0.1; Ctrl-C ends it."""
    from optuna_dashboard import run_server

    of_campaign = CampaignDirectory(folder)
    if of_campaign.held:
        url = of_campaign.url(of_campaign.stored(), storage)
    else:
        directory = RunDirectory(folder)
        url = record_url(directory, stored_document(directory), storage)
    check_storage(url)
    messages.print(f"dashboard at http://127.0.0.1:{port}/ - end it with Ctrl-C")
    try:
        run_server(url, host="127.0.0.1", port=port)
    except OSError as error:
        raise InputError(f"--port: {port} cannot be used ({error.strerror}); choose another one") from None


def _seed(seed: int | None, out: Path | None) -> int:
    """The given seed, else that of the run which the folder holds, else a new one."""
    stored = RunDirectory(out).stored() if out is not None and seed is None else None
    return checked_seed(seed if stored is None else stored["identity"]["seed"])


def _strategy_settings(registry: Registry, asked: Asked, strategy: str, assigned: list[str] | None) -> dict[str, Any]:
    changed = assignments(assigned)
    _check_assigned(registry, asked, strategy, changed)
    settings = {**asked.site.strategies.get(strategy, {}), **changed}
    return all_settings(registry, "strategy", strategy, settings)


def _check_assigned(registry: Registry, asked: Asked, strategy: str, changed: dict[str, Any]) -> None:
    """Raise InputError for an assignment to a setting of the problem in place of one of the strategy."""
    name = asked.settings.name
    sections = registry.get("problem", name).sections(registry).items()
    known = {row.name for section, start in sections for row in describe_parameters(start, f"{section}.")}
    own = {row.name for row in describe_parameters(registry.get("strategy", strategy).Parameters())}
    for assigned in changed:
        if assigned not in own and any(assigned == full or full.endswith(f".{assigned}") for full in known):
            raise InputError(
                f"--set: '{assigned}' is a setting of the problem {name}, not of strategy {strategy}; it comes from a file: "
                f"`railsearch init {name}` writes one, --parameters takes it"
            )


def _claimed_record(url: str, study: StudyDescription, space: Space) -> RunStorage:
    """The record of a run; on a server it is this process's until it ends, in a file the folder is held already."""
    storage = Storage(url, Patience(0.0 if is_file(url) else STORAGE_PATIENCE, messages.print), server_claims(url))
    if not storage.claim(study.name):
        raise StorageError(f"{without_password(url)}: study '{study.name}' is in work by another process; wait for it")
    return storage.run(study, space)


def _in_cluster(address: str, problem: DesignProblem, settings: RunSettings) -> Simulators:
    from railsearch.dask_simulation import dask_simulators

    return dask_simulators(connected(address, messages.print), problem, settings.timeout, settings.batch_size)


def _searched(
    registry: Registry,
    problem: DesignProblem,
    settings: RunSettings,
    given: list[FloatArray],
    record: RunStorage,
    folder: RunDirectory,
    simulating: Simulators | None,
) -> RunResult:
    stored = len(record.load())
    limit = int(min(settings.budget, problem.space.size))
    if stored >= limit:
        messages.print(f"complete: all {stored} evaluations are in {folder.folder}, nothing is evaluated")
    elif stored:
        messages.print(f"continuing: {stored} of {limit} evaluations are in {folder.folder}")
    messages.print(f"{problem.label}, strategy {settings.strategy}, budget {settings.budget}, seed {settings.seed}")
    try:
        with run_progress(problem, limit) as watch:
            return run_search(registry, problem, settings, given, record, watch, simulating)
    except InputError:
        # A scalariser may turn out not to suit the problem once the reference design is known: the mended run is another.
        if all(evaluation.number == 0 and evaluation.origin == "given" for evaluation in record.load()):
            record.remove()
            folder.abandon()
        raise
    except KeyboardInterrupt:
        messages.print(
            f"stopped: {len(record.load())} evaluations are in {folder.folder}; the same command goes on from there"
        )
        sys.exit(130)


def _finish(folder: RunDirectory, problem: DesignProblem, found: dict[str, Any], result: RunResult) -> None:
    """Write result.json, figures and report, unless this result is there already."""
    from railsearch.report import run_figures, write_figures, write_report

    if folder.report.exists() and folder.stored_result() == plain(found):
        return
    messages.print("drawing the figures and the report")
    figures = run_figures(problem, result.evaluations)
    write_figures(folder.figures, figures)
    write_report(folder.report, found, figures)
    folder.write(RESULT_FILE, json.dumps(found, indent=1, ensure_ascii=False, allow_nan=False))
    messages.print(f"wrote {folder.result}, {folder.figures}, {folder.report}")


def _print_result(found: dict[str, Any], as_json: bool) -> None:
    if as_json:
        print_json(found)
    else:
        console = results()
        for table in result_tables(found):
            console.print(table)
            console.print()
        console.print(sentence(found), soft_wrap=True)


def _unfinished(directory: RunDirectory, storage: str | None) -> dict[str, Any]:
    """The result document of a run that has not come to its end."""
    registry = load_plugins()
    run = stored_run(registry, directory, storage)
    result = RunResult(run.evaluations, len(run.evaluations), 0)
    return result_document(registry, run.problem, run.command, result)
