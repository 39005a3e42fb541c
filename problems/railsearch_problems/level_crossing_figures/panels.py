"""The frame of a comparison: curves over position with the site behind them, and the range of every design beside."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from railsearch.space import FloatArray
from railsearch_problems.level_crossing_figures.passage import Passage

WIDTH, HEIGHT = 10.0, 4.7
LEFT, RIGHT, BOTTOM, TOP = 0.85, 0.15, 0.8, 0.85
GAP, RANGE_WIDTH, USUAL_DESIGNS = 0.2, 0.95, 2
BEYOND_CROSSING = 8.0
POSITION = "Position from the first interface [m]"
SLAB = "#DCE6EE"
SMALL, NORMAL, TITLE = 9.0, 10.0, 12.0


@dataclass(frozen=True)
class PanelFigure:
    """A figure with the two panels of a comparison: curves over position, and the range of every design beside them."""

    figure: Figure
    curves: Axes
    ranges: Axes


def new_panels(passages: Sequence[Passage], title: str, quantity: str) -> PanelFigure:
    """An empty comparison, wider where there are many designs, with room for the ranges of all of them."""
    width = WIDTH + RANGE_WIDTH * max(0, len(passages) - USUAL_DESIGNS)
    figure = Figure(figsize=(width, HEIGHT))
    beside = RANGE_WIDTH * max(len(passages), 2)
    bottom, height = BOTTOM / HEIGHT, 1.0 - (BOTTOM + TOP) / HEIGHT
    curves = figure.add_axes((LEFT / width, bottom, 1.0 - (LEFT + GAP + beside + RIGHT) / width, height))
    ranges = figure.add_axes((1.0 - (beside + RIGHT) / width, bottom, beside / width, height), sharey=curves)
    figure.text(LEFT / width, 1.0 - 0.35 / HEIGHT, title, fontsize=TITLE, weight="bold")
    curves.set_xlabel(POSITION, fontsize=NORMAL)
    curves.set_ylabel(quantity, fontsize=NORMAL)
    for axes in (curves, ranges):
        axes.tick_params(labelsize=SMALL)
        axes.grid(axis="y", color="#E3E3E3", lw=0.6)
        axes.set_axisbelow(True)
    return PanelFigure(figure, curves, ranges)


def draw_range(
    made: PanelFigure,
    passage: Passage,
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


def finish(made: PanelFigure, site: Passage, limits: tuple[float, float], ranges: str) -> None:
    """Close the panels, draw the site behind the curves and name its parts above them."""
    close(made, limits, ranges)
    _draw_site(made.curves, site, limits)


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


def _draw_site(axes: Axes, site: Passage, limits: tuple[float, float]) -> None:
    geometry = site.track.geometry
    edges = [geometry.slab_length * number for number in range(geometry.slab_count + 1)]
    for left, right in pairwise(edges):
        axes.axvspan(left, right, facecolor=SLAB, edgecolor="white", lw=1.5, zorder=0)
    for interface in (edges[0], edges[-1]):
        axes.axvline(interface, color="#222222", lw=1.0, ls=":")
    names = [f"slab {number + 1}" for number in range(geometry.slab_count)] if geometry.slab_count > 1 else ["slab"]
    parts = zip(["approach", *names, "departure"], [limits[0], *edges], [*edges, limits[1]], strict=True)
    for name, left, right in parts:
        axes.text(
            (left + right) / 2.0, 1.02, name, transform=axes.get_xaxis_transform(), ha="center", va="bottom", fontsize=SMALL
        )
