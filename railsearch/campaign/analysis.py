"""Everything that a campaign says, as one plain document: what the report, the statistics file and the tables show."""

import dataclasses
import re
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from typing import Any

import numpy as np

from railsearch.campaign.best_designs import best_design_document
from railsearch.campaign.cells import Campaign, CampaignProblem
from railsearch.campaign.comparison import (
    Compared,
    attainment_document,
    compared,
    comparison_document,
    complete_repetitions,
    front_distance_document,
)
from railsearch.campaign.conclusions import campaign_conclusion, leading, listed, problem_conclusion
from railsearch.campaign.measure import Measure, measure_of
from railsearch.campaign.ranking import ranking_document
from railsearch.campaign.results import CampaignResults, CellRecord
from railsearch.design_problem import DesignProblem
from railsearch.result import versions
from railsearch.space import FloatArray

FORMAT = "railsearch campaign statistics 1"
REASONS_LISTED = 5
TIME_LIMIT = re.compile(r"time limit of (\S+) s exceeded")

Pair = tuple[str, str]


def campaign_document(results: CampaignResults, skipped: Collection[Pair] = (), command: str = "") -> dict[str, Any]:
    """The statistics of a campaign in plain JSON types, all values with their natural sign, null for what is not finite.

    skipped: pairs (problem, strategy) that were left out by decision; they count as not applicable; command:
    the command line that runs the campaign. The bootstrap draws from a generator seeded by the campaign's seed: the same
    results give the same document.
    """
    generator = np.random.default_rng(results.campaign.seed)
    campaign = results.campaign
    problems, data = [], []
    for asked in campaign.problems:
        entry, own = _problem_entry(results, asked, skipped, generator)
        problems.append(entry)
        data.append(own)
    ranking = ranking_document(data, generator)
    cells = [cell for entry in problems for cell in entry["cells"]]
    return {
        "format": FORMAT,
        "status": "complete" if all(cell["complete"] == cell["planned"] for cell in cells) else "incomplete",
        "conclusion": campaign_conclusion(problems, ranking, campaign.budget),
        "notes": _notes(campaign, problems, ranking),
        "command": command,
        "campaign": dataclasses.asdict(campaign),
        "skipped": sorted(list(pair) for pair in skipped),
        "planned": sum(cell["planned"] for cell in cells),
        "complete": sum(cell["complete"] for cell in cells),
        "evaluations": sum(cell["evaluations"] for cell in cells),
        "failed": sum(cell["failed"] for cell in cells),
        "problems": problems,
        "ranking": ranking,
        "seeds": _seeds(results),
        "versions": versions(),
    }


def _problem_entry(
    results: CampaignResults, asked: CampaignProblem, skipped: Collection[Pair], generator: np.random.Generator
) -> tuple[dict[str, Any], Compared]:
    problem = results.problems[asked.label]
    records = {cell: record for cell, record in results.records.items() if cell.problem == asked.label}
    measure = measure_of(problem, asked, list(records.values()))
    data = compared(results, asked.label, measure)
    entry = {
        "label": asked.label,
        "title": problem.label,
        "measure": _measure(problem, measure),
        "not_applicable": [name for place, name in sorted(skipped) if place == asked.label],
        "compared": data.strategies,
        "repetitions": list(data.repetitions),
        **comparison_document(data, generator),
        "attainment": attainment_document(results, data, _signs(problem)) if problem.n_obj == 2 else {},
        "front_distance": front_distance_document(results, data, problem.pareto_front()),
        "cells": [_cells(results, asked.label, strategy.label, skipped) for strategy in results.campaign.strategies],
        "design": best_design_document(problem, records),
    }
    entry["leader"] = leading(entry) if data.curves else None
    entry["conclusion"] = problem_conclusion(entry, results.campaign.budget)
    return entry, data


def _measure(problem: DesignProblem, measure: Measure) -> dict[str, Any]:
    box = measure.box and {
        "ideal": _natural(problem, measure.box.ideal),
        "reference": _natural(problem, measure.box.reference),
        "source": measure.box.source,
    }
    return dataclasses.asdict(measure.quantity) | {"box": box}


def _natural(problem: DesignProblem, point: FloatArray) -> dict[str, float]:
    values = (_signs(problem) * point).tolist()
    return {quantity.name: value for quantity, value in zip(problem.objectives, values, strict=True)}


def _signs(problem: DesignProblem) -> FloatArray:
    return np.array([-1.0 if quantity.maximised else 1.0 for quantity in problem.objectives])


def _cells(results: CampaignResults, problem: str, strategy: str, skipped: Collection[Pair]) -> dict[str, Any]:
    """What became of the cells of one strategy on one problem, what an evaluation took, and why some failed."""
    records = [record for cell, record in results.records.items() if (cell.problem, cell.strategy) == (problem, strategy)]
    reasons = Counter(reason.strip().splitlines()[0] for record in records for reason in record.reasons if reason.strip())
    return {
        "strategy": strategy,
        "planned": 0 if (problem, strategy) in skipped else results.campaign.repetitions,
        "begun": len(records),
        "complete": len(complete_repetitions(results, problem, strategy)),
        "evaluations": sum(len(record.objectives) for record in records),
        "failed": sum(reasons.values()),
        "infeasible": sum(int(np.sum(~record.feasible & ~record.failed)) for record in records),
        "reasons": [{"reason": reason, "count": count} for reason, count in reasons.most_common(REASONS_LISTED)],
        "evaluation_seconds": _mean([record.durations for record in records]),
        "overhead_seconds": _mean([record.overheads for record in records]),
    }


def _mean(columns: Sequence[FloatArray]) -> float | None:
    """The mean of all values: most evaluations of a strategy may cost it nothing, and a few much."""
    values = np.concatenate([np.empty(0), *columns])
    return float(np.mean(values)) if values.size else None


def _seeds(results: CampaignResults) -> list[dict[str, Any]]:
    return [
        {"problem": cell.problem, "strategy": cell.strategy, "repetition": cell.repetition, "seed": _seed(record)}
        for cell, record in sorted(results.records.items())
    ]


def _seed(record: CellRecord) -> int | None:
    return record.identity.get("seed")


def _notes(campaign: Campaign, problems: Sequence[Mapping[str, Any]], ranking: Mapping[str, Any] | None) -> list[str]:
    """What restricts the conclusions."""
    notes = []
    for entry in problems:
        notes += _notes_of_problem(campaign, entry)
    if ranking is not None:
        missing = sorted({name for entry in problems for name in entry["compared"]} - set(ranking["strategies"]))
        if missing:
            notes.append(f"Ranks over the problems leave out {listed(missing)}: not compared on every problem.")
    return notes


def _notes_of_problem(campaign: Campaign, entry: Mapping[str, Any]) -> list[str]:
    label, notes = entry["label"], []
    planned = [cell for cell in entry["cells"] if cell["planned"]]
    left_out = [cell["strategy"] for cell in planned if cell["strategy"] not in entry["compared"]]
    unfinished = [cell for cell in planned if cell["complete"] < cell["planned"]]
    if unfinished:
        done, needed = sum(cell["complete"] for cell in planned), sum(cell["planned"] for cell in planned)
        runs = len(entry["repetitions"])
        notes.append(
            f"{label} is incomplete, {done} of {needed} runs are finished: {runs} of {campaign.repetitions} repetitions are "
            f"complete for all compared strategies, and only these count."
        )
    if left_out and entry["compared"]:
        notes.append(f"On {label}, {listed(left_out)} is left out of the comparison: without a complete run so far.")
    notes += [f"On {label}, {note}" for note in _limits_met(campaign, planned)]
    if entry["not_applicable"]:
        notes.append(f"On {label}, {listed(entry['not_applicable'])} is not applicable and was skipped.")
    return notes


def _limits_met(campaign: Campaign, cells: Sequence[Mapping[str, Any]]) -> list[str]:
    """Time limits at which evaluations failed although the campaign has another one by now."""
    counts: Counter[float] = Counter()
    for cell in cells:
        for row in cell["reasons"]:
            if limit := TIME_LIMIT.match(row["reason"]):
                counts[float(limit[1])] += row["count"]
    return [
        f"{count} evaluations failed at a time limit of {limit:g} s; the campaign now has "
        f"{'none' if campaign.timeout is None else f'{campaign.timeout:g} s'}, so that its runs are not all alike. "
        "A campaign of another name makes them again."
        for limit, count in sorted(counts.items())
        if limit != campaign.timeout
    ]
