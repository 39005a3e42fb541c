"""The command that finds out which inputs move the worst response: sensitivity."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer

from railsearch.commands.options import (
    AsJson,
    Assignments,
    Parameters,
    asked_problem,
    assignments,
    command_line,
    messages,
    print_json,
    results,
)
from railsearch.commands.progress import study_progress
from railsearch.commands.sensitivity_sources import ProblemSource, Source, own_source
from railsearch.commands.sensitivity_words import print_study
from railsearch.errors import InputError
from railsearch.plugin_manager import Registry, load_plugins
from railsearch.run_directory import make_folder, write_whole
from railsearch.samples import ExperimentDesign
from railsearch.sensitivity.thresholds import LIMITS, UPPER
from railsearch.sensitivity_study import (
    StudySettings,
    check_study,
    study_document,
    study_samples,
)
from railsearch.simulation import simulators


def sensitivity(
    name: Annotated[
        str | None,
        typer.Argument(metavar="[PROBLEM]", help="Problem whose variables are the inputs; not for data of your own."),
    ] = None,
    number: Annotated[
        int, typer.Option("--samples", "-n", help="How many samples of the problem are evaluated.", min=10)
    ] = 1000,
    design: Annotated[
        ExperimentDesign, typer.Option("--design", "-d", help="How the samples are drawn.")
    ] = ExperimentDesign.LHS,
    data: Annotated[
        Path | None,
        typer.Option("--data", metavar="FILE", help="Samples that there are, .parquet or .csv, in place of new ones."),
    ] = None,
    distributions: Annotated[
        Path | None,
        typer.Option("--distributions", metavar="FILE.toml", help="Distributions of the inputs of data of your own."),
    ] = None,
    criteria: Annotated[
        str,
        typer.Option("--criterion", "-c", metavar="A_s,U_d", help="Outputs to analyse; default: the problem's objectives."),
    ] = "",
    thresholds: Annotated[
        str, typer.Option("--thresholds", metavar="14.7,19.6", help="Limits of the one criterion, in its unit.")
    ] = "",
    limit: Annotated[str, typer.Option("--limit", help=f"Which side of a threshold fails: {' or '.join(LIMITS)}.")] = UPPER,
    surrogate: Annotated[str, typer.Option("--surrogate", help="See `railsearch list surrogate`.")] = "pce",
    surrogate_set: Annotated[
        list[str] | None, typer.Option("--surrogate-set", metavar="NAME=VALUE", help="Change one setting of the surrogate.")
    ] = None,
    points: Annotated[int, typer.Option("--points", help="Grid values of each input.", min=2)] = 100,
    level: Annotated[
        float, typer.Option("--level", help="Percentile, as a fraction, that bounds an input without bounds.")
    ] = 0.01,
    refits: Annotated[
        int,
        typer.Option("--refits", metavar="B", help="Spread of the importances over fits to B parts of the samples.", min=0),
    ] = 0,
    on_model: Annotated[
        int,
        typer.Option(
            "--on-model",
            metavar="N",
            help="Sobol' indices and elementary effects of the problem itself too, by N (2d + 3) more evaluations of it "
            "with d inputs; a power of two.",
            min=0,
        ),
    ] = 0,
    confirm: Annotated[
        bool, typer.Option(help="Evaluate the problem where its surrogates have their largest and smallest values.")
    ] = True,
    seed: Annotated[int | None, typer.Option("--seed", help="Seed; drawn and reported if not given.")] = None,
    parameters: Parameters = None,
    assigned: Assignments = None,
    workers: Annotated[int, typer.Option("--workers", "-w", help="Processes that evaluate side by side.", min=1)] = 1,
    timeout: Annotated[
        float | None, typer.Option("--timeout", metavar="SECONDS", help="Time limit of one evaluation.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", metavar="DIR", help="Folder for samples, results and report.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Find out which inputs move the worst response, and which ranges keep a limit state out of reach (A-1AT).

    Samples of the problem are evaluated, or read with --data; a surrogate is fitted to each criterion; every input is held
    on a grid while all others do their worst. Beside the importances stand Sobol' indices, elementary effects and
    one-at-a-time shares. The extremes are confirmed by the problem. The same command goes on where it was stopped.

        railsearch sensitivity train-track-bridge --samples 3000 -w 2 --criterion U_r --thresholds 0.002,0.0025 --seed 1

    Data of your own need no problem: a table of inputs and outputs, and a file with a table [distributions.INPUT] for each
    input (distribution = "normal", mean = …, std = …, and unit if you like):

        railsearch sensitivity --data measured.csv --distributions inputs.toml --criterion deflection
    """
    registry, folder = load_plugins(), out or Path(f"{name or (data.stem if data else 'data')}-sensitivity")
    source: Source
    if name is None:
        source = own_source(data, distributions, on_model, seed)
    elif distributions is not None:
        raise InputError("--distributions: they belong to data of your own; those of a problem are in its site file")
    else:
        asked = asked_problem(registry, name, parameters, _all_objectives(registry, name), assigned=assigned)
        simulating, wanted = partial(simulators, asked.problem, timeout, workers), (design, number, seed)
        source = ProblemSource(registry, asked, folder, data, wanted, on_model, confirm, simulating)
    chosen = tuple(dict.fromkeys(part.strip() for part in criteria.split(",") if part.strip())) or source.default
    set_values, limits = assignments(surrogate_set, "--surrogate-set"), _thresholds(thresholds, chosen)
    settings = StudySettings(chosen, limits, points, surrogate, set_values, level, limit, refits)
    check_study(registry, settings, source.inputs, source.outputs)
    found = source.collected()
    settings = replace(settings, seed=found.seed)
    with study_progress() as watcher:
        studies = study_samples(registry, found.data, settings, watcher, found.model)
    studies = source.confirmed(studies)
    document = study_document(found.data, settings, studies, command_line())
    make_folder(folder)
    write_whole(folder / "sensitivity.json", json.dumps(document, ensure_ascii=False, allow_nan=False).encode())
    _draw(folder, document)
    if as_json:
        print_json(document)
        return
    for study in studies:
        print_study(study)
    results().print(f"seed {settings.seed}; everything is in {folder}")


def _draw(folder: Path, document: Mapping[str, Any]) -> None:
    from railsearch.report.figures import write_figures
    from railsearch.report.sensitivity_figures import sensitivity_figures
    from railsearch.report.sensitivity_page import write_sensitivity_report

    messages.print("drawing the figures and the report")
    figures = {criterion["name"]: sensitivity_figures(criterion) for criterion in document["criteria"]}
    named = {f"{name}-{kind}": figure for name, kinds in figures.items() for kind, figure in kinds.items()}
    write_figures(folder / "figures", named)
    write_sensitivity_report(folder / "report.html", document, figures)
    messages.print(f"wrote {folder / 'report.html'}, {folder / 'figures'}, {folder / 'sensitivity.json'}")


def _all_objectives(registry: Registry, name: str) -> str:
    return ",".join(quantity.name for quantity in registry.get("problem", name).available_objectives)


def _thresholds(text: str, criteria: Sequence[str]) -> dict[str, list[float]]:
    if not text.strip():
        return {}
    if len(criteria) != 1:
        raise InputError(
            f"--thresholds: they belong to one criterion, received {', '.join(criteria)}; name it with --criterion"
        )
    try:
        return {criteria[0]: [float(part) for part in text.split(",")]}
    except ValueError:
        raise InputError(f"--thresholds: numbers with commas between them are needed, received {text!r}") from None
