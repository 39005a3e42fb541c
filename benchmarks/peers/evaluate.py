"""Scores, tables and figures of the peers benchmark, from the folders of its campaigns, finished or not.

    python benchmarks/peers/evaluate.py record record-slow record-ours --out benchmarks/results/peers
    python benchmarks/peers/evaluate.py record-slow --earlier benchmarks/results/peers --out benchmarks/results/peers

The second adds runs to results whose other campaigns are not at hand; of a run that both have, the campaign's counts.
Writes cells.csv (one row a run), scores.json, tables.md and the figures, and keeps best_known.json beside this file: the
best values ever found of problems whose optimum is not known.
"""

import argparse
import json
import os
import platform
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
from railsearch_peers.cells import BUDGETS, CellResult, unequal_starts, write_cells
from railsearch_peers.figures import ratio_figure, score_figure
from railsearch_peers.records import CELLS, SCORES, Gathered, continued, gathered, read_results
from railsearch_peers.scores import REFERENCE, Ranking, Standing, ranking, scored, standings
from railsearch_peers.tables import medians_table, ranking_table, ranking_words, standings_table

from railsearch.errors import InputError
from railsearch.report.figures import write_figures
from railsearch.result import versions

HERE = Path(__file__).resolve().parent
BEST_KNOWN = HERE / "best_known.json"


@dataclass(frozen=True)
class Found:
    """How the participants stand."""

    standings: list[Standing]
    rankings: list[Ranking]


def best_known(cells: Sequence[CellResult], optima: Mapping[str, float]) -> dict[str, float]:
    """The known optima, otherwise the best values ever found; new ones are kept in best_known.json."""
    kept = json.loads(BEST_KNOWN.read_text(encoding="utf-8")) if BEST_KNOWN.exists() else {}
    found = {problem: min(c.best[-1] for c in cells if c.problem == problem) for problem in {c.problem for c in cells}}
    open_ones = {problem: min(value, kept.get(problem, np.inf)) for problem, value in found.items() if problem not in optima}
    if open_ones != {problem: kept.get(problem) for problem in open_ones}:
        BEST_KNOWN.write_text(json.dumps({**kept, **open_ones}, indent=1, sort_keys=True) + "\n", encoding="utf-8")
    return {problem: open_ones.get(problem, optima.get(problem, np.inf)) for problem in found}


def rankings(record: Gathered) -> list[Ranking]:
    """Over all problems those who are planned on all of them; then everybody, where everybody has runs."""
    problems = {label for campaign in record.campaigns for label in campaign["problems"]}
    whole = [c for c in record.campaigns if set(c["problems"]) == problems]
    present = {cell.strategy for cell in record.cells}
    everybody = sorted(present)
    widely = sorted(present & {label for campaign in whole for label in campaign["strategies"]})
    groups = [widely] if widely == everybody else [widely, everybody]
    return [found for group in groups if (found := ranking(record.cells, group)) is not None]


def document(record: Gathered, known: Mapping[str, float], found: Found) -> dict[str, Any]:
    """Everything that the tables say, with what is needed to make it again."""
    return {
        "date": datetime.now(UTC).date().isoformat(),
        "commit": _commit(),
        "status": "complete" if all(c["complete"] == c["planned"] for c in record.campaigns) else "incomplete, provisional",
        "campaigns": record.campaigns,
        "versions": versions(),
        "machine": {"processor": _processor(), "cores": os.cpu_count(), "system": platform.system()},
        "optima": dict(sorted(record.optima.items())),
        "best_known": dict(sorted(known.items())),
        "ended_early": [f"{_named(cell)}: {cell.ended}" for cell in record.cells if cell.ended],
        "unequal_starts": [_named(cell) for cell in unequal_starts(record.cells)],
        "standings": [asdict(standing) for standing in found.standings],
        "rankings": [asdict(ranks) for ranks in found.rankings],
    }


def page(record: Gathered, known: Mapping[str, float], found: Found, said: Mapping[str, Any]) -> str:
    """The tables with the sentences around them."""
    runs = ", ".join(f"{c['campaign']} {c['complete']} of {c['planned']} runs" for c in record.campaigns)
    libraries = ", ".join(f"{name} {version}" for name, version in said["versions"].items())
    machine = said["machine"]
    parts = [
        "# Peers benchmark\n",
        f"Record {said['status']}: {runs}; evaluated on {said['date']} at commit {said['commit']}.\n",
        f"{machine['processor']}, {machine['cores']} cores; {libraries}.\n",
        f"## Beside {REFERENCE}\n",
        standings_table(found.standings, record.cells),
    ]
    for ranks in found.rankings:
        parts += ["## Ranks\n", ranking_words(ranks) + "\n", ranking_table(ranks)]
    for place, budget in enumerate(BUDGETS):
        parts += [f"## Medians (quartiles) after {budget} evaluations\n", medians_table(record.cells, known, place)]
    for title, rows in (("Peers that ended early", said["ended_early"]), ("Other starts", said["unequal_starts"])):
        if rows:
            parts += [f"## {title}\n", "\n".join(f"- {row}" for row in rows) + "\n"]
    return "\n".join(parts)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("folders", nargs="+", type=Path, help="folders of the campaigns")
    parser.add_argument("--earlier", type=Path, help="folder of results whose runs are kept where the campaigns lack them")
    parser.add_argument("--out", type=Path, required=True, help="folder of the results")
    asked = parser.parse_args()
    try:
        record = gathered(asked.folders)
        if asked.earlier is not None:
            record = continued(read_results(asked.earlier), record)
    except InputError as error:
        parser.error(str(error))
    known = best_known(record.cells, record.optima)
    found = Found(standings(record.cells, known), rankings(record))
    said = document(record, known, found)
    asked.out.mkdir(parents=True, exist_ok=True)
    write_cells(asked.out / CELLS, record.cells)
    numbers = json.dumps(said, indent=1, default=_plain, allow_nan=False)
    (asked.out / SCORES).write_text(numbers + "\n", encoding="utf-8")
    (asked.out / "tables.md").write_text(page(record, known, found, said), encoding="utf-8")
    pictures = {
        "ratios": ratio_figure(found.standings),
        "scores": score_figure(record.cells, scored(record.cells, known)),
    }
    write_figures(asked.out, pictures)
    print(f"wrote {asked.out}")
    return 0


def _named(cell: CellResult) -> str:
    return f"{cell.strategy} on {cell.problem}, repetition {cell.repetition}"


def _plain(value: object) -> object:
    if isinstance(value, np.ndarray):
        return np.where(np.isfinite(value), value, None).tolist()
    raise TypeError(f"{type(value).__name__} has no plain form")


def _commit() -> str:
    answer = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=HERE, capture_output=True, text=True, check=False)
    return answer.stdout.strip() or "unknown"


def _processor() -> str:
    information = Path("/proc/cpuinfo")
    lines = information.read_text().splitlines() if information.exists() else []
    models = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return models[0] if models else platform.processor()


if __name__ == "__main__":
    sys.exit(main())
