"""The benchmark's tables, in Markdown."""

from collections.abc import Mapping, Sequence
from statistics import median

import numpy as np

from railsearch_peers.cells import BUDGETS, CellResult
from railsearch_peers.scores import FLOOR, REFERENCE, Ranking, Standing

AT = " / ".join(map(str, BUDGETS))


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table, the first column to the left, the others to the right."""
    marks = ["---", *["---:"] * (len(head) - 1)]
    return "\n".join("| " + " | ".join(row) + " |" for row in (head, marks, *rows)) + "\n"


def standings_table(standings: Sequence[Standing], cells: Sequence[CellResult]) -> str:
    """Everybody beside the reference."""
    head = [
        "participant",
        "runs, problems",
        f"mean score at {AT}",
        f"ratio to {REFERENCE}",
        "win share",
        "p over the problems (signed-rank, Holm)",
        f"problems better, worse at {BUDGETS[-1]} (rank-sum, Holm)",
        "overhead [ms]",
    ]
    rows = [
        [
            standing.strategy,
            f"{standing.runs}, {standing.problems}",
            _numbers(standing.mean),
            _numbers(standing.ratio),
            _numbers(standing.wins),
            _numbers(standing.p_value),
            f"{standing.significant[0]}, {standing.significant[1]}",
            _overhead(standing.strategy, cells),
        ]
        for standing in standings
    ]
    return table(head, rows)


def ranking_table(ranking: Ranking) -> str:
    """Mean ranks, the best at the full budget first."""
    last = ranking.ranks[-1].mean_ranks
    rows = [
        [ranking.strategies[place], _numbers([ranks.mean_ranks[place] for ranks in ranking.ranks])]
        for place in np.argsort(last, kind="stable")
    ]
    return table(["participant", f"mean rank at {AT}"], rows)


def ranking_words(ranking: Ranking) -> str:
    """What the ranks rest on, and from which difference on they differ."""
    last = ranking.ranks[-1]
    difference = f"; they differ from {last.critical_difference:.2f} on (Nemenyi, 5 %)" if last.critical_difference else ""
    return (
        f"Ranks of {len(ranking.strategies)} participants by their medians; problems: {len(ranking.problems)}, runs of each "
        f"on them: {ranking.runs}{difference}."
    )


def medians_table(cells: Sequence[CellResult], best_known: Mapping[str, float], place: int) -> str:
    """Median and quartiles of the best values after BUDGETS[place] evaluations, by problem and participant."""
    names = participants(cells)
    found: dict[tuple[str, str], list[float]] = {}
    for cell in cells:
        found.setdefault((cell.problem, cell.strategy), []).append(cell.best[place])
    rows = [
        [problem, f"{best_known[problem]:.5g}", *(_quartiles(found.get((problem, name))) for name in names)]
        for problem in sorted(best_known)
    ]
    return table(["problem", "best known", *names], rows)


def participants(cells: Sequence[CellResult]) -> list[str]:
    """The reference first, random search last."""
    others = sorted({cell.strategy for cell in cells} - {REFERENCE, FLOOR})
    return [REFERENCE, *others, FLOOR]


def _overhead(strategy: str, cells: Sequence[CellResult]) -> str:
    return f"{1e3 * median(cell.overhead for cell in cells if cell.strategy == strategy):.1f}"


def _numbers(values: Sequence[float] | np.ndarray) -> str:
    return " / ".join(f"{value:.2f}" if value >= 0.005 or value == 0.0 else f"{value:.0e}" for value in values)


def _quartiles(values: Sequence[float] | None) -> str:
    if not values:
        return "-"
    lower, middle, upper = np.quantile(values, (0.25, 0.5, 0.75))
    return f"{middle:.4g} ({lower:.4g} … {upper:.4g})"
