"""Wheel-rail force over position, and energy per sleeper, one design against another."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from railsearch.space import FloatArray
from railsearch_problems.level_crossing_figures.passage import KILO, Passage, within

WIDTH, HEIGHT = 10.0, 4.7
LEFT, RIGHT, BOTTOM, TOP = 0.85, 0.15, 0.8, 0.85
GAP, RANGE_WIDTH = 0.2, 0.95
BEFORE_WINDOW = 3.0
BEYOND_CROSSING = 8.0
POSITION = "Position from the first interface [m]"
SLAB = "#DCE6EE"
SMALL, NORMAL, TITLE = 9.0, 10.0, 12.0


@dataclass(frozen=True)
class Panels:
    """The two panels of a comparison: curves over position, and the range of every design beside them."""

    curves: Axes
    ranges: Axes


def force_figure(passages: Sequence[Passage]) -> Figure:
    """Wheel-rail force in kN from before the force window to beyond the crossing, with the range F_max of every design."""
    figure, panels = _panels(passages, "Wheel-rail force around the crossing", "Wheel-rail force [kN]")
    first = passages[0]
    start, end = first.force_window
    limits = (start - BEFORE_WINDOW, max(end, first.crossing_length) + BEYOND_CROSSING)
    panels.curves.axhline(
        first.track.vehicle.static_load / KILO, color="#888888", lw=0.8, ls="-.", label="static wheel load"
    )
    for passage in passages:
        shown, inside = within(passage.wheel_position, limits), within(passage.wheel_position, (start, end))
        panels.curves.plot(
            passage.wheel_position[shown], passage.force[shown], color=passage.colour, lw=1.3, label=passage.label
        )
        text = f"F_max\n{passage.response.metrics['F_max'] / KILO:.3f} kN"
        _draw_range(panels, passage, (passage.wheel_position[inside], passage.force[inside]), text, 2)
    _finish(figure, panels, first, limits)
    _mark_window(panels.curves, (start, end), "force window")
    figure.set_label(
        "Force between wheel and rail over the position of the wheel. F_max is the largest minus the smallest force in the "
        "force window (triangles); the bars at the right span it."
    )
    return figure


def energy_figure(passages: Sequence[Passage]) -> Figure:
    """Energy dissipated in the ballast under every measured sleeper, with E_max; those beyond the crossing lightly."""
    figure, panels = _panels(passages, "Energy dissipated in the ballast under each sleeper", "Energy per sleeper [N·m]")
    first = passages[0]
    for passage in passages:
        position, energy = passage.sleeper_position[passage.measured], passage.sleeper_energy[passage.measured]
        _draw_sleepers(panels.curves, passage, passage.measured, passage.label, 1.0)
        beyond = within(passage.sleeper_position, (passage.crossing_length, passage.crossing_length + BEYOND_CROSSING))
        _draw_sleepers(panels.curves, passage, beyond, "_" + passage.label, 0.35)
        text = f"E_max\n{passage.response.metrics['E_max']:.4f} N·m"
        _draw_range(panels, passage, (position, energy), text, 3)
    start = min(float(passage.sleeper_position[passage.measured][0]) for passage in passages)
    _finish(figure, panels, first, (start - 0.6, first.crossing_length + BEYOND_CROSSING))
    _mark_window(panels.curves, (start - 0.3, 0.0), f"the {first.track.windows.energy_sleepers} measured sleepers")
    figure.set_label(
        "Energy dissipated in the ballast damper under each sleeper over one passage, at the sleeper's position. E_max is "
        "the largest minus the smallest of the measured sleepers before the crossing; those beyond it are drawn lightly."
    )
    return figure


def _panels(passages: Sequence[Passage], title: str, quantity: str) -> tuple[Figure, Panels]:
    figure = Figure(figsize=(WIDTH, HEIGHT))
    beside = RANGE_WIDTH * max(len(passages), 2)
    bottom, height = BOTTOM / HEIGHT, 1.0 - (BOTTOM + TOP) / HEIGHT
    curves = figure.add_axes((LEFT / WIDTH, bottom, 1.0 - (LEFT + GAP + beside + RIGHT) / WIDTH, height))
    ranges = figure.add_axes((1.0 - (beside + RIGHT) / WIDTH, bottom, beside / WIDTH, height), sharey=curves)
    figure.text(LEFT / WIDTH, 1.0 - 0.35 / HEIGHT, title, fontsize=TITLE, weight="bold")
    curves.set_xlabel(POSITION, fontsize=NORMAL)
    curves.set_ylabel(quantity, fontsize=NORMAL)
    ranges.set_title("range in the window", fontsize=SMALL)
    for axes in (curves, ranges):
        axes.tick_params(labelsize=SMALL)
        axes.grid(axis="y", color="#E3E3E3", lw=0.6)
        axes.set_axisbelow(True)
    return figure, Panels(curves, ranges)


def _draw_sleepers(axes: Axes, passage: Passage, mask: NDArray[np.bool_], label: str, alpha: float) -> None:
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


def _draw_range(panels: Panels, passage: Passage, curve: tuple[FloatArray, FloatArray], text: str, decimals: int) -> None:
    """Mark the extremes of a curve (position, value), and span them by a bar in the panel of ranges."""
    position, value = curve
    column = len(panels.ranges.patches)
    low, high = int(np.argmin(value)), int(np.argmax(value))
    for row, marker in ((low, "^"), (high, "v")):
        panels.curves.plot(
            position[row], value[row], marker, color=passage.colour, markersize=9, markeredgecolor="white", zorder=5
        )
    panels.ranges.bar(column, value[high] - value[low], 0.5, value[low], color=passage.colour, alpha=0.8)
    for row, offset, alignment in ((low, -3, "top"), (high, 3, "bottom")):
        panels.ranges.annotate(
            f"{value[row]:.{decimals}f}",
            (column, value[row]),
            (0, offset),
            textcoords="offset points",
            ha="center",
            va=alignment,
            fontsize=SMALL,
        )
    labels = [label.get_text() for label in panels.ranges.get_xticklabels()] if column else []
    panels.ranges.set_xticks(range(column + 1), [*labels, f"{passage.label}\n{text}"])


def _finish(figure: Figure, panels: Panels, site: Passage, limits: tuple[float, float]) -> None:
    """Fix the limits with room for the numbers, draw the site behind the curves and name its parts above them."""
    panels.curves.set_xlim(*limits)
    low, high = panels.curves.dataLim.intervaly
    room = 0.16 * (high - low)
    panels.curves.set_ylim(low - room, high + 0.6 * room)
    columns = len(panels.ranges.patches)
    panels.ranges.set_xlim(-0.6, max(columns, 2) - 0.4)
    panels.ranges.tick_params(axis="y", left=False, labelleft=False)
    panels.ranges.tick_params(axis="x", length=0)
    _draw_site(panels.curves, site, limits)
    handles, labels = panels.curves.get_legend_handles_labels()
    figure.legend(
        handles,
        labels,
        loc="upper right",
        bbox_to_anchor=(1.0 - RIGHT / WIDTH, 1.0 - 0.05 / HEIGHT),
        ncols=len(labels),
        fontsize=SMALL,
        frameon=False,
    )


def _draw_site(axes: Axes, site: Passage, limits: tuple[float, float]) -> None:
    geometry = site.track.geometry
    edges = [geometry.slab_length * number for number in range(geometry.slab_count + 1)]
    for left, right in pairwise(edges):
        axes.axvspan(left, right, facecolor=SLAB, edgecolor="white", lw=1.5, zorder=0)
    for interface in (edges[0], edges[-1]):
        axes.axvline(interface, color="#222222", lw=1.0, ls=":")
    names = [f"slab {number + 1}" for number in range(geometry.slab_count)]
    parts = zip(["approach", *names, "departure"], [limits[0], *edges], [*edges, limits[1]], strict=True)
    for name, left, right in parts:
        axes.text(
            (left + right) / 2.0, 1.02, name, transform=axes.get_xaxis_transform(), ha="center", va="bottom", fontsize=SMALL
        )


def _mark_window(axes: Axes, window: tuple[float, float], name: str) -> None:
    """A dimension line along the foot of the panel."""
    foot = axes.get_xaxis_transform()
    arrow = {"arrowstyle": "|-|", "mutation_scale": 3.0, "lw": 1.0, "shrinkA": 0.0, "shrinkB": 0.0}
    axes.annotate("", (window[0], 0.04), (window[1], 0.04), xycoords=foot, textcoords=foot, arrowprops=arrow)
    axes.text(window[0] + 0.2, 0.055, name, transform=foot, va="bottom", fontsize=SMALL)
