"""Tables of a campaign for the terminal: what it will cost, and what it found."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from rich.table import Table

from railsearch.campaign.cells import Campaign
from railsearch.campaign.coordinator import CellTask
from railsearch.campaign.tasks import TaskProgress
from railsearch.wording import quantity_label, readable

STORING_SECONDS = 0.004
"""What the machinery adds to one evaluation, measured (benchmarks/README.md)."""


def cost_tables(
    campaign: Campaign,
    tasks: Sequence[CellTask],
    progress: TaskProgress,
    seconds: Mapping[str, float],
    workers: int,
) -> Iterator[Table | str]:
    """The cells by problem, what is recorded of them, and how long the rest would take."""
    cells = Counter(task.cell.problem for task in tasks)
    table = Table(box=None, pad_edge=False)
    for column in ("problem", "strategies", "cells", "evaluations to make", "seconds each", "hours of one worker"):
        table.add_column(column, justify="left" if column in ("problem", "strategies") else "right")
    for label, count in cells.items():
        names = dict.fromkeys(task.cell.strategy for task in tasks if task.cell.problem == label)
        missing = progress.missing[label]
        hours = missing * (seconds[label] + STORING_SECONDS) / 3600.0
        table.add_row(label, ", ".join(names), str(count), str(missing), f"{seconds[label]:.3g}", f"{hours:.2f}")
    yield table
    total = sum(progress.missing[label] * (seconds[label] + STORING_SECONDS) for label in cells) / 3600.0
    yield (
        f"{len(tasks)} cells of {campaign.budget} evaluations, {progress.complete} complete and {progress.evaluations} "
        f"evaluations recorded; about {total:.2f} hours of one worker, {total / workers:.2f} hours with {workers} "
        "(the strategies' own time comes on top)"
    )


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
    columns = ("strategy", "median", "lower quartile", "upper quartile", "best median in [%]", "overhead [ms]", "failed")
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
