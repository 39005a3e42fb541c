"""The benchmark's figures: ratios to the reference over the budgets, and median scores by problem."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from railsearch.report.campaign_figures import colour
from railsearch_peers.cells import BUDGETS, CellResult
from railsearch_peers.scores import CAP, REFERENCE, Key, Standing
from railsearch_peers.tables import participants

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from railsearch.space import FloatArray


def ratio_figure(standings: Sequence[Standing]) -> Figure:
    """The ratio R of every participant at every budget; below 1 is better than the reference."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 0.8 + 0.32 * len(standings)), layout="constrained")
    axes = figure.add_subplot()
    for place, budget in enumerate(BUDGETS):
        ratios = [standing.ratio[place] for standing in standings]
        axes.plot(ratios, range(len(standings)), "osD"[place], color=colour(place), label=f"{budget} evaluations")
    axes.axvline(1.0, color="0.4", linewidth=1.0)
    axes.set_yticks(range(len(standings)), [standing.strategy for standing in standings])
    axes.invert_yaxis()
    axes.set_xlim(left=0.0)
    axes.set_xlabel(f"mean score as a part of that of {REFERENCE}, on the same runs (less is better)")
    axes.grid(axis="x", color="0.9")
    axes.legend(frameon=False, fontsize="small")
    return figure


def score_figure(cells: Sequence[CellResult], scores: Mapping[Key, FloatArray]) -> Figure:
    """Median scores at the full budget, problems by participants, as a coloured table with numbers."""
    from matplotlib.figure import Figure

    names, problems = participants(cells), sorted({problem for problem, _, _ in scores})
    medians = np.array([[_median(scores, problem, name) for name in names] for problem in problems])
    figure = Figure(figsize=(2.2 + 0.62 * len(names), 1.6 + 0.3 * len(problems)), layout="constrained")
    axes = figure.add_subplot()
    image = axes.imshow(medians, cmap="viridis_r", vmin=0.0, vmax=CAP, aspect="auto")
    for (row, column), value in np.ndenumerate(medians):
        if np.isfinite(value):
            shade = "white" if value > 0.55 * CAP else "black"
            axes.text(column, row, f"{value:.2f}", ha="center", va="center", fontsize=7, color=shade)
    axes.set_xticks(range(len(names)), names, rotation=60, ha="right")
    axes.set_yticks(range(len(problems)), problems)
    figure.colorbar(image, label=f"median score after {BUDGETS[-1]} evaluations (0 best known, 1 random search)")
    return figure


def _median(scores: Mapping[Key, FloatArray], problem: str, name: str) -> float:
    own = [score[-1] for (place, other, _), score in scores.items() if (place, other) == (problem, name)]
    return float(np.median(own)) if own else np.nan
