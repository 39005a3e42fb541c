"""What the benchmark keeps of each run: best values at the budgets, its start, its overhead; from campaigns, and as CSV."""

import csv
import hashlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np

from railsearch.campaign.cells import Cell
from railsearch.campaign.results import CampaignResults, CellRecord
from railsearch.errors import InputError
from railsearch.space import FloatArray
from railsearch.statistics import best_so_far
from railsearch_peers.peer import ENDED
from railsearch_peers.shared_start import START_ORIGINS, start_size

BUDGETS = (50, 100, 200)
BEST = tuple(f"best_{budget}" for budget in BUDGETS)
PLACES_OF_START = 12


@dataclass(frozen=True)
class CellResult:
    """A complete run.

    best: the best values (len(BUDGETS),) that the participant found, minimised, +inf without one; start: what its first
    designs hash to; overhead: mean seconds of the participant before an evaluation after the start; ended: why a peer
    ended before the budget was spent, empty if it did not.
    """

    problem: str
    strategy: str
    repetition: int
    seed: int
    start: str
    overhead: float
    ended: str
    best: tuple[float, ...]

    @property
    def key(self) -> tuple[str, str, int]:
        """Problem, strategy, repetition."""
        return self.problem, self.strategy, self.repetition


def cell_results(results: CampaignResults) -> list[CellResult]:
    """The complete runs of a campaign. Raises InputError for a budget other than the largest of BUDGETS."""
    if results.campaign.budget != BUDGETS[-1]:
        raise InputError(f"budget: the benchmark is read at {BUDGETS}, the campaign has {results.campaign.budget}")
    complete = {cell: record for cell, record in results.records.items() if len(record.origins) >= BUDGETS[-1]}
    return [_cell_result(cell, record) for cell, record in sorted(complete.items())]


def joined(records: Iterable[Sequence[CellResult]]) -> list[CellResult]:
    """The runs of several campaigns together. Raises InputError for a run that is in two of them."""
    cells: dict[tuple[str, str, int], CellResult] = {}
    for cell in (cell for record in records for cell in record):
        if cell.key in cells:
            raise InputError(f"records: {cell.strategy} on {cell.problem}, repetition {cell.repetition}, is in two of them")
        cells[cell.key] = cell
    return list(cells.values())


def unequal_starts(cells: Sequence[CellResult]) -> list[CellResult]:
    """The runs whose start is not that of most runs of their problem and repetition."""
    starts: dict[tuple[str, int], list[str]] = {}
    for cell in cells:
        starts.setdefault((cell.problem, cell.repetition), []).append(cell.start)
    usual = {place: max(sorted(found), key=found.count) for place, found in starts.items()}
    return [cell for cell in cells if cell.start != usual[cell.problem, cell.repetition]]


def write_cells(path: Path, cells: Sequence[CellResult]) -> None:
    """One row for each run, in alphabetical order."""
    names = [field.name for field in fields(CellResult)][:-1]
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([*names, *BEST])
        for cell in sorted(cells, key=lambda cell: cell.key):
            row = [getattr(cell, name) for name in names]
            writer.writerow([*row[:5], f"{cell.overhead:.6f}", cell.ended, *map(repr, cell.best)])


def read_cells(path: Path) -> list[CellResult]:
    """The runs of a file that `write_cells` wrote."""
    with path.open(encoding="utf-8", newline="") as file:
        return [
            CellResult(
                row["problem"],
                row["strategy"],
                int(row["repetition"]),
                int(row["seed"]),
                row["start"],
                float(row["overhead"]),
                row["ended"],
                tuple(float(row[name]) for name in BEST),
            )
            for row in csv.DictReader(file)
        ]


def _cell_result(cell: Cell, record: CellRecord) -> CellResult:
    own = np.array([not origin.startswith(ENDED) for origin in record.origins])
    found = np.where(record.feasible & own, record.objectives[:, 0], np.nan)
    best = np.nan_to_num(best_so_far(found), nan=np.inf)
    return CellResult(
        cell.problem,
        cell.strategy,
        cell.repetition,
        int(record.identity["seed"]),
        _fingerprint(record.designs),
        _overhead(record, own),
        next((origin.removeprefix(ENDED) for origin in record.origins if origin.startswith(ENDED)), ""),
        tuple(best[np.array(BUDGETS) - 1].tolist()),
    )


def _fingerprint(designs: FloatArray) -> str:
    start = np.ascontiguousarray(designs[: start_size(designs.shape[1])], dtype=float)
    return hashlib.sha256(start.tobytes()).hexdigest()[:PLACES_OF_START]


def _overhead(record: CellRecord, own: np.ndarray) -> float:
    searched = own & np.array([origin not in START_ORIGINS for origin in record.origins])
    return float(np.mean(record.overheads[searched])) if searched.any() else 0.0
