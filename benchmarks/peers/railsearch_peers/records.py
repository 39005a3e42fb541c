"""The runs of the benchmark: those of campaigns, and those of an earlier evaluation whose campaigns are not at hand."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from railsearch.campaign.directory import CampaignDirectory
from railsearch.campaign.identity import campaign_of
from railsearch.campaign.reading import read_campaign
from railsearch.errors import InputError
from railsearch.plugin_manager import load_plugins
from railsearch_peers.cells import CellResult, cell_results, joined, read_cells

CELLS = "cells.csv"
SCORES = "scores.json"


@dataclass(frozen=True)
class Gathered:
    """The runs of all records, what was planned, by campaign, and the known optima by problem.

    campaigns: the identity of each, its problems as a list of labels, and how many of its runs are planned and complete.
    """

    cells: list[CellResult]
    campaigns: list[dict[str, Any]]
    optima: dict[str, float]


def gathered(folders: Sequence[Path]) -> Gathered:
    """Read campaigns. Raises InputError for a run that is in two of them."""
    registry = load_plugins()
    records, campaigns, optima = [], [], {}
    for folder in folders:
        directory = CampaignDirectory(folder)
        stored = directory.stored()
        results = read_campaign(registry, directory.url(stored), campaign_of(stored["identity"]))
        records.append(cell_results(results))
        planned = len(list(results.campaign.cells()))
        problems = sorted(results.problems)
        campaigns.append({**stored["identity"], "problems": problems, "planned": planned, "complete": len(records[-1])})
        for label, problem in results.problems.items():
            front = problem.pareto_front()
            if front is not None:
                optima[label] = float(front[0, 0])
    return Gathered(joined(records), campaigns, optima)


def read_results(folder: Path) -> Gathered:
    """What an evaluation wrote to its folder. Raises InputError where one of its files is missing."""
    for name in (CELLS, SCORES):
        if not (folder / name).is_file():
            raise InputError(f"earlier: {folder} has no {name}; name a folder that this program has written to")
    written = json.loads((folder / SCORES).read_text(encoding="utf-8"))
    return Gathered(read_cells(folder / CELLS), written["campaigns"], written["optima"])


def continued(earlier: Gathered, record: Gathered) -> Gathered:
    """A record with those runs of an earlier evaluation that it lacks; of a run that both have, the record's."""
    runs = {cell.key: cell for cell in earlier.cells} | {cell.key: cell for cell in record.cells}
    campaigns = {_named(campaign): campaign for campaign in [*earlier.campaigns, *record.campaigns]}
    counted = [{**campaign, "complete": _complete(campaign, runs)} for campaign in campaigns.values()]
    return Gathered(list(runs.values()), counted, earlier.optima | record.optima)


def _named(campaign: Mapping[str, Any]) -> tuple[Any, ...]:
    return campaign["campaign"], campaign["seed"], tuple(campaign["strategies"]), tuple(campaign["problems"])


def _complete(campaign: Mapping[str, Any], runs: Mapping[tuple[str, str, int], CellResult]) -> int:
    """How many of a campaign's runs there are."""
    return sum(
        problem in campaign["problems"] and strategy in campaign["strategies"] and repetition <= campaign["repetitions"]
        for problem, strategy, repetition in runs
    )
