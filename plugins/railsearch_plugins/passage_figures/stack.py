"""Panels one above the other that share their horizontal axis."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from railsearch_plugins.passage_figures.panels import BOTTOM, LEFT, NORMAL, RIGHT, SMALL, TITLE, TOP, WIDTH

GAP = 0.36
ABOVE = 1.02


@dataclass(frozen=True)
class Stack:
    """A figure of panels, top to bottom."""

    figure: Figure
    panels: Sequence[Axes]


def new_stack(title: str, place: str, quantities: Sequence[str], panel_height: float) -> Stack:
    """Empty panels, one for each quantity, over a common `place`; heights in inches."""
    count = len(quantities)
    height = TOP + BOTTOM + count * panel_height + (count - 1) * GAP
    figure = Figure(figsize=(WIDTH, height))
    figure.text(LEFT / WIDTH, 1.0 - 0.35 / height, title, fontsize=TITLE, weight="bold")
    panels: list[Axes] = []
    for row, quantity in enumerate(quantities):
        foot = height - TOP - (row + 1) * panel_height - row * GAP
        size = LEFT / WIDTH, foot / height, 1.0 - (LEFT + RIGHT) / WIDTH, panel_height / height
        axes = figure.add_axes(size, sharex=panels[0] if panels else None)
        axes.set_ylabel(quantity, fontsize=SMALL)
        axes.tick_params(labelsize=SMALL, labelbottom=row == count - 1)
        axes.grid(axis="y", color="#E3E3E3", lw=0.6)
        axes.set_axisbelow(True)
        panels.append(axes)
    panels[-1].set_xlabel(place, fontsize=NORMAL)
    figure.align_ylabels(panels)
    return Stack(figure, panels)


def name_panel(axes: Axes, name: str) -> None:
    """Words above a panel, on its left."""
    axes.text(0.0, ABOVE, name, transform=axes.transAxes, fontsize=SMALL, va="bottom")


def add_values(axes: Axes) -> None:
    """The labels of a panel's curves and marks above it, on its right."""
    axes.legend(
        loc="lower right",
        bbox_to_anchor=(1.0, 1.0),
        ncols=4,
        fontsize=SMALL,
        frameon=False,
        borderaxespad=0.1,
        borderpad=0.1,
    )


def add_legend(made: Stack, handles: Mapping[str, Artist]) -> None:
    """A legend of labelled artists, in one line beside the title."""
    place = 1.0 - RIGHT / WIDTH, 1.0 - 0.29 / made.figure.get_figheight()
    made.figure.legend(
        list(handles.values()),
        list(handles),
        loc="center right",
        bbox_to_anchor=place,
        ncols=len(handles),
        fontsize=SMALL,
        frameon=False,
        borderaxespad=0.0,
    )
