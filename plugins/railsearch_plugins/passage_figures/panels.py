"""The frame of a comparison: curves over position, and the range of every passage beside them."""

from collections.abc import Sequence
from dataclasses import dataclass

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from railsearch.space import FloatArray
from railsearch_plugins.passage_figures.passage import DrawnPassage

WIDTH, HEIGHT = 10.0, 4.7
LEFT, RIGHT, BOTTOM, TOP = 0.85, 0.15, 0.8, 0.85
GAP, RANGE_WIDTH, USUAL_DESIGNS = 0.2, 0.95, 2
SMALL, NORMAL, TITLE = 9.0, 10.0, 12.0


@dataclass(frozen=True)
class PanelFigure:
    """A figure with the two panels of a comparison: curves over position, and the range of every passage beside them."""

    figure: Figure
    curves: Axes
    ranges: Axes


def new_panels(passages: Sequence[DrawnPassage], title: str, place: str, quantity: str) -> PanelFigure:
    """An empty comparison, wider where there are many passages, with room for the ranges of all of them."""
    width = WIDTH + RANGE_WIDTH * max(0, len(passages) - USUAL_DESIGNS)
    figure = Figure(figsize=(width, HEIGHT))
    beside = RANGE_WIDTH * max(len(passages), 2)
    bottom, height = BOTTOM / HEIGHT, 1.0 - (BOTTOM + TOP) / HEIGHT
    curves = figure.add_axes((LEFT / width, bottom, 1.0 - (LEFT + GAP + beside + RIGHT) / width, height))
    ranges = figure.add_axes((1.0 - (beside + RIGHT) / width, bottom, beside / width, height), sharey=curves)
    figure.text(LEFT / width, 1.0 - 0.35 / HEIGHT, title, fontsize=TITLE, weight="bold")
    curves.set_xlabel(place, fontsize=NORMAL)
    curves.set_ylabel(quantity, fontsize=NORMAL)
    for axes in (curves, ranges):
        axes.tick_params(labelsize=SMALL)
        axes.grid(axis="y", color="#E3E3E3", lw=0.6)
        axes.set_axisbelow(True)
    return PanelFigure(figure, curves, ranges)


def draw_range(
    made: PanelFigure,
    passage: DrawnPassage,
    curve: tuple[FloatArray, FloatArray],
    rows: tuple[int, int],
    words: tuple[str, int],
) -> None:
    """Mark two points of a curve (position, value), and span them by a bar in the panel of ranges.

    rows: where the lower and the upper point are; words: what stands under the bar, and the decimals of its numbers.
    """
    position, value = curve
    column = len(made.ranges.patches)
    low, high = rows
    for row, marker in ((low, "^"), (high, "v")):
        made.curves.plot(
            position[row], value[row], marker, color=passage.colour, markersize=9, markeredgecolor="white", zorder=5
        )
    made.ranges.bar(column, value[high] - value[low], 0.5, value[low], color=passage.colour, alpha=0.8)
    for row, offset, alignment in ((low, -3, "top"), (high, 3, "bottom")):
        made.ranges.annotate(
            f"{value[row]:.{words[1]}f}",
            (column, value[row]),
            (0, offset),
            textcoords="offset points",
            ha="center",
            va=alignment,
            fontsize=SMALL,
        )
    labels = [label.get_text() for label in made.ranges.get_xticklabels()] if column else []
    made.ranges.set_xticks(range(column + 1), [*labels, f"{passage.label}\n{words[0]}"])


def close(made: PanelFigure, limits: tuple[float, float], ranges: str) -> None:
    """Fix the limits with room for the numbers, and add the legend."""
    made.curves.set_xlim(*limits)
    low, high = made.curves.dataLim.intervaly
    room = 0.16 * (high - low)
    made.curves.set_ylim(low - room, high + 0.6 * room)
    columns = len(made.ranges.patches)
    made.ranges.set_title(ranges, fontsize=SMALL)
    made.ranges.set_xlim(-0.6, max(columns, 2) - 0.4)
    made.ranges.tick_params(axis="y", left=False, labelleft=False)
    made.ranges.tick_params(axis="x", length=0)
    handles, labels = made.curves.get_legend_handles_labels()
    made.figure.legend(
        handles,
        labels,
        loc="upper right",
        bbox_to_anchor=(1.0 - RIGHT / made.figure.get_figwidth(), 1.0 - 0.05 / HEIGHT),
        ncols=len(labels),
        fontsize=SMALL,
        frameon=False,
    )


def mark_window(axes: Axes, window: tuple[float, float], name: str) -> None:
    """A dimension line along the foot of the panel."""
    foot = axes.get_xaxis_transform()
    arrow = {"arrowstyle": "|-|", "mutation_scale": 3.0, "lw": 1.0, "shrinkA": 0.0, "shrinkB": 0.0}
    axes.annotate("", (window[0], 0.04), (window[1], 0.04), xycoords=foot, textcoords=foot, arrowprops=arrow)
    axes.text(window[0] + 0.2, 0.055, name, transform=foot, va="bottom", fontsize=SMALL)
