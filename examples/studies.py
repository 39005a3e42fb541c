"""What the studies share: searches that go on after a stop, all in one record; numbers as tables in Markdown."""

import json
import logging
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from railsearch.commands.progress import run_progress
from railsearch.design_problem import DesignProblem
from railsearch.interfaces import Evaluation, Finding, Outcome
from railsearch.plugin_manager import Registry
from railsearch.problem_factory import ProblemSettings, given_designs, make_problem
from railsearch.report.figures import drawn
from railsearch.result import RunCommand
from railsearch.run import RunSettings, run_search
from railsearch.run_directory import write_whole
from railsearch.run_identity import run_identity
from railsearch.space import FloatArray
from railsearch.storage import StudyDescription, open_run, plain
from railsearch.study_note import study_note


@dataclass(frozen=True)
class Search:
    """What is searched, how, and under which label it is shown; `maximised`: the objective's largest value is wanted."""

    label: str
    asked: ProblemSettings
    settings: RunSettings
    maximised: bool = False


@dataclass(frozen=True)
class Searched:
    """A search that is done, with the problem, all evaluations in their order, and what its strategy found besides."""

    search: Search
    problem: DesignProblem
    evaluations: tuple[Evaluation, ...]
    findings: tuple[Finding, ...]


class Opposite(DesignProblem):
    """A problem of one objective, to be maximised."""

    def __init__(self, base: DesignProblem) -> None:
        (objective,) = base.objectives
        super().__init__(
            base.name,
            base.space,
            [replace(objective, maximised=not objective.maximised)],
            [metric for metric in base.metrics if metric.name != objective.name],
            base.reference,
        )
        self.base = base

    def warm_up(self) -> None:
        """Warm the base problem up."""
        self.base.warm_up()

    def simulate(self, design: FloatArray) -> Outcome:
        """The base problem's outcome, its objective negated."""
        outcome = self.base.simulate(design)
        return replace(outcome, objectives=-outcome.objectives)


def carry_out(registry: Registry, search: Search, folder: Path) -> Searched:
    """Carry out a search, or what is left of it after a stop; its record is the file study.db in the folder."""
    logging.getLogger("optuna").setLevel(logging.WARNING)
    folder.mkdir(parents=True, exist_ok=True)
    made, settings = make_problem(registry, search.asked), search.settings
    problem = Opposite(made) if search.maximised else made
    given = given_designs(problem)
    identity = plain(run_identity(registry, search.asked, problem, settings, given))
    names = tuple(objective.name for objective in problem.objectives)
    note = study_note(problem, RunCommand("a study in examples/", identity))
    study = StudyDescription(
        f"{search.label} / {settings.strategy} / seed {settings.seed}", identity, names, problem.n_ieq_constr, note
    )
    record = open_run(f"sqlite:///{(folder / 'study.db').resolve()}", study, problem.space)
    print(f"{search.label}: {problem.label}, {settings.strategy}, {settings.budget} evaluations", flush=True)
    with run_progress(problem, settings.budget) as watch:
        result = run_search(registry, problem, settings, given, record, watch)
    return Searched(search, problem, result.evaluations, result.findings)


def optimum(searched: Searched) -> dict[str, Any]:
    """The best design of a search in plain types: objective with its natural sign, metrics, and when it was found."""
    (objective,), evaluations = searched.problem.objectives, searched.evaluations
    best = evaluations[best_so_far([evaluation.objectives[0] for evaluation in evaluations])[-1]]
    return {
        "label": searched.search.label,
        "strategy": searched.search.settings.strategy,
        "budget": searched.search.settings.budget,
        "value": objective.sign * float(best.objectives[0]),
        "design": searched.problem.space.named(best.design),
        "metrics": dict(best.metrics),
        "found_at": best.number + 1,
        "resets": evaluations[-1].trajectory,
        "failed": sum(evaluation.failed for evaluation in evaluations),
    }


def improvements(searched: Searched) -> list[dict[str, Any]]:
    """Every evaluation of a search that was better than all before: its number, objective and metrics."""
    (objective,), evaluations = searched.problem.objectives, searched.evaluations
    rows = np.unique(best_so_far([evaluation.objectives[0] for evaluation in evaluations]))
    return [
        {
            "evaluation": evaluations[row].number + 1,
            "value": objective.sign * float(evaluations[row].objectives[0]),
            "metrics": dict(evaluations[row].metrics),
        }
        for row in rows
    ]


def simulated(problem: DesignProblem, design: FloatArray) -> dict[str, Any]:
    """A design with its metrics, in plain types."""
    return {"design": problem.space.named(design), "metrics": dict(problem.simulate(design).metrics)}


def best_so_far(values: Sequence[float]) -> np.ndarray[Any, np.dtype[np.int64]]:
    """For every evaluation the row (n,) of the best value until then; failed ones are NaN."""
    known = np.where(np.isnan(values), np.inf, values)
    better = np.concatenate([[True], known[1:] < np.minimum.accumulate(known)[:-1]])
    return np.asarray(np.maximum.accumulate(np.where(better, np.arange(known.size), 0)))


def table(header: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A table in Markdown; numbers with four significant digits, and no point in whole ones."""
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join(f"| {' | '.join(map(cell, line))} |" for line in lines) + "\n"


def cell(value: object) -> str:
    """A cell of a table: numbers with four significant digits, a thousand and more to the unit."""
    if not isinstance(value, float):
        return str(value)
    return f"{value:.0f}" if abs(value) >= 1000.0 or value == round(value) else f"{value:.4g}"


def percent(value: float, start: float) -> str:
    """A change in per cent with its sign, small ones with two decimals."""
    change = 100.0 * (value / start - 1.0)
    if abs(change) >= 1.0:
        return f"{change:+.1f} %"
    return f"{change:+.2f} %" if abs(change) >= 0.005 else "0.00 %"


def write_record(folder: Path, name: str, record: Mapping[str, Any]) -> None:
    """Write a record as JSON, whole or not at all."""
    text = json.dumps(record, indent=1, ensure_ascii=False, allow_nan=False)
    write_whole(folder / name, (text + "\n").encode("utf-8"))


def write_pictures(folder: Path, figures: Mapping[str, Figure]) -> None:
    """Write figures as PNG files."""
    for name, figure in figures.items():
        write_whole(folder / f"{name}.png", drawn(figure, "png", name))
