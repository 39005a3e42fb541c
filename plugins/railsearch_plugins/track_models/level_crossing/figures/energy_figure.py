"""Energy dissipated in the ballast under each sleeper, one design against another."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from railsearch_plugins.passage_figures.panels import (
    PanelFigure,
    draw_range,
    mark_window,
    new_panels,
)
from railsearch_plugins.passage_figures.passage import within
from railsearch_plugins.track_models.level_crossing.figures.crossing_passage import CrossingPassage
from railsearch_plugins.track_models.level_crossing.figures.site import BEYOND_CROSSING, POSITION, finish

TITLE = "Energy dissipated in the ballast under each sleeper"
QUANTITY = "Energy per sleeper [N·m]"
SHOWN = "Energy dissipated in the ballast damper under each sleeper over one passage, at the sleeper's position. "
BEYOND = "; those beyond it are drawn lightly."


def energy_range_figure(passages: Sequence[CrossingPassage]) -> Figure:
    """Energy under every measured sleeper, with the largest minus the smallest of them, the metric E_max."""
    made = new_panels(passages, TITLE, POSITION, QUANTITY)
    for passage in passages:
        energy = _draw_passage(made, passage)
        _draw_pair(made, passage, (int(np.argmin(energy)), int(np.argmax(energy))), passage.response.metrics["E_max"])
    _finish(made, passages, "range in the window")
    made.figure.set_label(
        f"{SHOWN}E_max is the largest minus the smallest of the measured sleepers before the crossing{BEYOND}"
    )
    return made.figure


def energy_difference_figure(passages: Sequence[CrossingPassage]) -> Figure:
    """Energy under every measured sleeper, with the largest difference between neighbours, the metric E_adjacent."""
    made = new_panels(passages, TITLE, POSITION, QUANTITY)
    for passage in passages:
        energy = _draw_passage(made, passage)
        steepest = int(np.argmax(np.abs(np.diff(energy))))
        pair = sorted((steepest, steepest + 1), key=lambda row: float(energy[row]))
        _draw_pair(made, passage, (pair[0], pair[1]), passage.response.metrics["E_adjacent"])
    _finish(made, passages, "adjacent sleepers")
    made.figure.set_label(
        f"{SHOWN}E_max is the largest difference between two adjacent ones of the measured sleepers before the crossing "
        f"(triangles){BEYOND}"
    )
    return made.figure


def _draw_passage(made: PanelFigure, passage: CrossingPassage) -> NDArray[np.float64]:
    """Draw the sleepers of a design; gives the energies of the measured ones."""
    _draw_sleepers(made.curves, passage, passage.measured, passage.label, 1.0)
    beyond = within(passage.sleeper_position, (passage.crossing_length, passage.crossing_length + BEYOND_CROSSING))
    _draw_sleepers(made.curves, passage, beyond, "_" + passage.label, 0.35)
    return passage.sleeper_energy[passage.measured]


def _draw_pair(made: PanelFigure, passage: CrossingPassage, rows: tuple[int, int], difference: float) -> None:
    curve = passage.sleeper_position[passage.measured], passage.sleeper_energy[passage.measured]
    draw_range(made, passage, curve, rows, (f"E_max\n{difference:.4f} N·m", 3))


def _draw_sleepers(axes: Axes, passage: CrossingPassage, mask: NDArray[np.bool_], label: str, alpha: float) -> None:
    axes.plot(
        passage.sleeper_position[mask],
        passage.sleeper_energy[mask],
        color=passage.colour,
        marker=passage.marker,
        markersize=5.5,
        markerfacecolor="white" if passage.marker == "o" else passage.colour,
        lw=1.0,
        alpha=alpha,
        label=label,
    )


def _finish(made: PanelFigure, passages: Sequence[CrossingPassage], ranges: str) -> None:
    first = passages[0]
    start = min(float(passage.sleeper_position[passage.measured][0]) for passage in passages)
    finish(made, first, (start - 0.6, first.crossing_length + BEYOND_CROSSING), ranges)
    mark_window(made.curves, (start - 0.3, 0.0), f"the {first.track.windows.energy_sleepers} measured sleepers")
