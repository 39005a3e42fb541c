"""Tables of a campaign for the terminal: what it will cost, and what it found."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from rich.table import Table

from railsearch.campaign.cells import Campaign
from railsearch.campaign.coordinator import CellTask
from railsearch.campaign.tasks import TaskProgress
from railsearch.wording import quantity_label, readable

STORING_SECONDS = 0.005
"""What the machinery adds to one evaluation, measured (benchmarks/README.md)."""
PROPOSALS = (
    "some 5 to 100 ms per evaluation of one with a surrogate (most with expected improvement), up to 10 ms of others, and "
    "more with more variables and evaluations"
)
"""Measured on the 8 variables of the level crossing in runs of 100 evaluations."""


def cost_tables(
    campaign: Campaign,
    tasks: Sequence[CellTask],
    progress: TaskProgress,
    seconds: Mapping[str, float],
    workers: int,
) -> Iterator[Table | str]:
    """The cells by problem and strategy, what is recorded of them, and how long the rest would take."""
    table = Table(box=None, pad_edge=False)
    for column in ("problem", "strategy", "cells", "complete", "evaluations to make", "one evaluation [s]", "time"):
        table.add_column(column, justify="left" if column in ("problem", "strategy") else "right")
    for problem, strategy in dict.fromkeys((task.cell.problem, task.cell.strategy) for task in tasks):
        own = [task for task in tasks if (task.cell.problem, task.cell.strategy) == (problem, strategy)]
        missing = [task.evaluations - progress.stored[task.cell] for task in own]
        time = duration(sum(missing) * (seconds[problem] + STORING_SECONDS))
        numbers = (len(own), missing.count(0), sum(missing))
        table.add_row(problem, strategy, *map(str, numbers), f"{seconds[problem]:.3g}", time)
    yield table
    total = sum(count * (seconds[label] + STORING_SECONDS) for label, count in progress.missing.items())
    shared = f", {duration(total / workers)} with {workers} workers" if workers > 1 else ""
    yield (
        f"{len(tasks)} cells of {campaign.budget} evaluations, {progress.complete} complete and {progress.evaluations} "
        f"evaluations recorded; the rest takes about {duration(total)}{shared}. What the strategies themselves calculate "
        f"comes on top: {PROPOSALS}"
    )


def duration(seconds: float) -> str:
    """A time to plan with."""
    if seconds < 90.0:
        return f"{seconds:.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 5400.0 else f"{seconds / 3600.0:.1f} h"


def campaign_tables(found: Mapping[str, Any]) -> Iterator[Table]:
    """For each problem its strategies by the median of their final values."""
    for entry in found["problems"]:
        if entry["fixed_budget"]:
            yield _overview(entry, found["campaign"]["budget"])


def _overview(entry: Mapping[str, Any], budget: int) -> Table:
    title = (
        f"{entry['label']}: {quantity_label(entry['measure']['name'], entry['measure']['unit'])} after {budget} evaluations"
    )
    table = Table(box=None, pad_edge=False, title=title, title_justify="left")
    columns = (
        "strategy",
        "median",
        "lower quartile",
        "upper quartile",
        "best median in [% of resamples]",
        "mean overhead [ms]",
        "failed",
    )
    for column in columns:
        table.add_column(column, justify="left" if column == "strategy" else "right")
    cells = {cell["strategy"]: cell for cell in entry["cells"]}
    rows = sorted(entry["fixed_budget"], key=lambda row: _order(entry, row["places"][-1]["median"]))
    for row in rows:
        final, cell = row["places"][-1], cells[row["strategy"]]
        share = entry["probability_best"][row["strategy"]]
        overhead = cell["overhead_seconds"]
        table.add_row(
            row["strategy"],
            *(readable(final[key]) for key in ("median", "lower", "upper")),
            f"{100.0 * share:.0f}",
            "–" if overhead is None else f"{1e3 * overhead:.1f}",
            str(cell["failed"]),
        )
    return table


def _order(entry: Mapping[str, Any], median: float | None) -> float:
    if median is None:
        return float("inf")
    return -median if entry["measure"]["maximised"] else median
