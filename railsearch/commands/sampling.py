"""The command that evaluates a design of experiments: sample."""

import math
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.table import Table

from railsearch.commands.options import (
    AsJson,
    Asked,
    Assignments,
    Parameters,
    ProblemName,
    asked_problem,
    command_line,
    messages,
    print_json,
    results,
)
from railsearch.commands.progress import sample_progress
from railsearch.design_problem import DesignProblem
from railsearch.errors import SimulationError
from railsearch.interfaces import Evaluation, Quantity
from railsearch.plugin_manager import Registry, load_plugins
from railsearch.run import MemoryRecord, Record
from railsearch.run_directory import write_whole
from railsearch.samples import (
    LEVELS,
    Experiment,
    ExperimentDesign,
    MeasureDesign,
    SampleFile,
    evaluate_samples,
    experiment_identity,
    natural_values,
    sample_file_document,
    summary,
)
from railsearch.seeding import checked_seed
from railsearch.simulation import Simulators, simulators
from railsearch.wording import quantity_label, readable

DESIGN_WORDS: Mapping[str, str] = {
    ExperimentDesign.RANDOM: "random designs",
    ExperimentDesign.LHS: "designs of a Latin hypercube",
    ExperimentDesign.SOBOL: "designs of a Sobol' sequence",
}


def sample(
    name: ProblemName,
    number: Annotated[int, typer.Option("--number", "--n", "-n", help="How many designs.", min=2)] = 400,
    design: Annotated[
        ExperimentDesign, typer.Option("--design", "-d", help="Independent designs, Latin hypercube or Sobol' sequence.")
    ] = ExperimentDesign.RANDOM,
    seed: Annotated[int | None, typer.Option("--seed", help="Seed; drawn and reported if not given.")] = None,
    parameters: Parameters = None,
    assigned: Assignments = None,
    objectives: Annotated[
        str, typer.Option("--objectives", metavar="F_max,E_max", help="Objectives; default: all that the problem can have.")
    ] = "",
    workers: Annotated[int, typer.Option("--workers", "-w", help="Processes that evaluate side by side.", min=1)] = 1,
    timeout: Annotated[
        float | None, typer.Option("--timeout", metavar="SECONDS", help="Time limit of one evaluation.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", metavar="FILE", help="Table to write, FILE.parquet or FILE.csv.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Evaluate a design of experiments: drawn from the distributions of the problem's variables, or within their bounds.

    With --out every design becomes a row of a table, a failed one too; quantiles are printed, and FILE.png shows histograms.
    The same command goes on where it was stopped, and with a larger --number if the design is random or sobol.

        railsearch sample level-crossing --design lhs --number 3000 --seed 1 --workers 2 --out samples.parquet

    Without --out the range of each objective is printed as the [worst] section of a site file, to be put there in place of
    what it has: the worst values are what scalarisers need.

    `--set` changes values of the site file, for instance `--set track.passage.speed=30`.
    """
    registry = load_plugins()
    available = ",".join(quantity.name for quantity in registry.get("problem", name).available_objectives)
    asked = asked_problem(registry, name, parameters, objectives or available, assigned=assigned)
    problem = asked.problem
    simulating = simulators(problem, timeout, workers)
    if out is None:
        experiment = Experiment(design, number, checked_seed(seed))
        evaluations = _evaluated(problem, experiment, MemoryRecord(), simulating)
        _print_ranges(problem, experiment, evaluations, as_json)
        return
    experiment, evaluations = sampled_into(out, registry, asked, (design, number, seed), simulating)
    _succeeded(evaluations)
    _draw(out.with_suffix(".png"), problem, evaluations)
    _print_summary(problem, experiment, evaluations, out, as_json)


def sampled_into(
    out: Path,
    registry: Registry,
    asked: Asked,
    wanted: tuple[ExperimentDesign | MeasureDesign, int, int | None],
    simulating: Simulators,
) -> tuple[Experiment, list[Evaluation]]:
    """Evaluate an experiment (its design, number and seed are `wanted`) into a file, as far as that has not been done."""
    (design, number, seed), problem, file = wanted, asked.problem, SampleFile(out, asked.problem)
    experiment = Experiment(design, number, _seed(seed, file))
    identity = experiment_identity(registry, asked.settings, problem, experiment)
    with file.claimed(sample_file_document(registry, problem, command_line(), identity)) as begun:
        evaluations = _evaluated(problem, experiment, file, simulating, out)
        if file.finish(evaluations, begun):
            messages.print(f"wrote {out}")
    return experiment, evaluations


def _seed(seed: int | None, file: SampleFile) -> int:
    """The given seed, else that of the samples which the file holds, else a new one."""
    stored = file.stored() if seed is None else None
    return checked_seed(seed if stored is None else stored["identity"]["seed"])


def _evaluated(
    problem: DesignProblem, experiment: Experiment, record: Record, simulating: Simulators, out: Path | None = None
) -> list[Evaluation]:
    """All evaluations of an experiment, `out` being where the record keeps them."""
    done = record.load()
    if len(done) == experiment.number:
        messages.print(f"complete: all {len(done)} samples are in {out}, nothing is evaluated")
    elif done:
        messages.print(f"continuing: {len(done)} of {experiment.number} samples are kept")
    messages.print(f"{problem.label}, design {experiment.design}, {experiment.number} samples, seed {experiment.seed}")
    try:
        with sample_progress(experiment.number, done) as watch:
            return evaluate_samples(problem, experiment, record, watch, simulating)
    except KeyboardInterrupt:
        kept = "" if out is None else ": what was finished is kept; the same command goes on from there"
        messages.print(f"stopped{kept}")
        sys.exit(130)


def _succeeded(evaluations: Sequence[Evaluation]) -> list[Evaluation]:
    """The evaluations that did not fail. Raises SimulationError if there is none."""
    succeeded = [evaluation for evaluation in evaluations if not evaluation.failed]
    if not succeeded:
        raise SimulationError(f"all {len(evaluations)} evaluations failed, the last one with: {evaluations[-1].reason}")
    return succeeded


def _draw(path: Path, problem: DesignProblem, evaluations: Sequence[Evaluation]) -> None:
    from railsearch.report.figures import drawn
    from railsearch.report.sample_figure import sample_figure

    write_whole(path, drawn(sample_figure(problem, evaluations), "png", path.stem))
    messages.print(f"wrote {path}")


def _print_summary(
    problem: DesignProblem, experiment: Experiment, evaluations: Sequence[Evaluation], out: Path, as_json: bool
) -> None:
    rows = summary(problem, evaluations)
    failed = sum(evaluation.failed for evaluation in evaluations)
    if as_json:
        about = {"problem": problem.name, "design": experiment.design, "seed": experiment.seed, "number": experiment.number}
        print_json(about | {"failed": failed, "file": str(out), "quantities": rows})
        return
    table = Table("quantity", box=None, pad_edge=False)
    keys = {"minimum": "minimum", **{f"q{level}": f"{level} %" for level in LEVELS}, "maximum": "maximum"}
    for heading in keys.values():
        table.add_column(heading, justify="right")
    table.add_column("meaning")
    for row in rows:
        table.add_row(quantity_label(row["name"], row["unit"]), *(readable(row[key]) for key in keys), row["meaning"])
    console = results()
    console.print(table)
    console.print(f"{experiment.number} samples, {failed} failed, seed {experiment.seed}; in {out}", soft_wrap=True)


def _print_ranges(problem: DesignProblem, experiment: Experiment, evaluations: Sequence[Evaluation], as_json: bool) -> None:
    succeeded = _succeeded(evaluations)
    rows = {q.name: _spread(q, natural_values(problem, succeeded, q.name)) for q in problem.objectives}
    number, seed, failed = experiment.number, experiment.seed, len(evaluations) - len(succeeded)
    if as_json:
        print_json({"problem": problem.name, "seed": seed, "number": number, "failed": failed, "objectives": rows})
        return
    typer.echo(f"# {number} {DESIGN_WORDS[experiment.design]}, seed {seed}, {failed} failed")
    typer.echo(_worst_section(problem.objectives, rows))


def _worst_section(objectives: Sequence[Quantity], rows: Mapping[str, Mapping[str, float]]) -> str:
    """A table of the objectives' ranges in comments, and the [worst] section of a site file."""
    table = Table("objective", "unit", "best", "median", "worst", "variation [%]", box=None, pad_edge=False)
    for objective in objectives:
        row = rows[objective.name]
        cells = [readable(row[key]) for key in ("best", "median", "worst", "variation_percent")]
        table.add_row(objective.name, objective.unit, *cells)
    console = results()
    with console.capture() as printed:
        console.print(table)
    lines = [f"# {line.rstrip()}" for line in printed.get().splitlines()]
    worst = {o.name: rounded_outward(rows[o.name]["worst"], up=not o.maximised) for o in objectives}
    return "\n".join([*lines, "[worst]", *(f"{name} = {value:g}" for name, value in worst.items())])


def rounded_outward(value: float, up: bool) -> float:
    """A value rounded to three significant digits, up or down."""
    step = 10.0 ** (math.floor(math.log10(abs(value))) - 2) if value else 1.0
    return float((math.ceil if up else math.floor)(value / step) * step)


def _spread(quantity: Quantity, values: Any) -> dict[str, float]:
    """Best, median and worst of values (n,), and their coefficient of variation in per cent."""
    ends = (float(values.max()), float(values.min()))
    best, worst = ends if quantity.maximised else ends[::-1]
    variation = float(100.0 * values.std() / abs(values.mean())) if values.mean() else 0.0
    return {"best": best, "median": float(np.median(values)), "worst": worst, "variation_percent": variation}
