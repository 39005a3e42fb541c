"""What the wheel and the carbody feel over position, one design against another."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from railsearch_plugins.passage_figures.panels import (
    PanelFigure,
    draw_range,
    mark_window,
    new_panels,
)
from railsearch_plugins.passage_figures.passage import KILO, within
from railsearch_plugins.track_models.level_crossing.figures.crossing_passage import CrossingPassage
from railsearch_plugins.track_models.level_crossing.figures.site import BEYOND_CROSSING, POSITION, finish

BEFORE_WINDOW = 3.0


@dataclass(frozen=True)
class WheelHistory:
    """How a history of the wheel is shown: the words, the metric that is its range, and how numbers are written."""

    title: str
    quantity: str
    history: str
    metric: str
    unit: str
    divisor: float
    decimals: int
    window: str


FORCE = WheelHistory(
    "Wheel-rail force around the crossing",
    "Wheel-rail force [kN]",
    "wheel_rail_force",
    "F_max",
    "kN",
    KILO,
    2,
    "force window",
)
ACCELERATION = WheelHistory(
    "Carbody acceleration around the crossing",
    "Carbody acceleration, downward [m/s²]",
    "carbody_acceleration",
    "A_max",
    "m/s²",
    1.0,
    3,
    "window of the acceleration",
)


def force_figure(passages: Sequence[CrossingPassage]) -> Figure:
    """Wheel-rail force in kN from before the force window to beyond the crossing, with the range F_max of every design."""
    made = new_panels(passages, FORCE.title, POSITION, FORCE.quantity)
    static = passages[0].track.vehicle.static_load / KILO
    made.curves.axhline(static, color="#888888", lw=0.8, ls="-.", label="static wheel load")
    _draw_histories(made, passages, FORCE)
    made.figure.set_label(
        "Force between wheel and rail over the position of the wheel. F_max is the largest minus the smallest force in the "
        "force window (triangles); the bars at the right span it."
    )
    return made.figure


def acceleration_figure(passages: Sequence[CrossingPassage]) -> Figure:
    """Carbody acceleration in m/s² from before the window to beyond the crossing, with the range A_max of every design."""
    made = new_panels(passages, ACCELERATION.title, POSITION, ACCELERATION.quantity)
    _draw_histories(made, passages, ACCELERATION)
    made.figure.set_label(
        "Vertical acceleration of the carbody over the position of the wheel. A_max is the largest minus the smallest "
        "acceleration in the window (triangles); the bars at the right span it."
    )
    return made.figure


def _draw_histories(made: PanelFigure, passages: Sequence[CrossingPassage], shown: WheelHistory) -> None:
    """The histories of all designs, their extremes in the window and the window itself."""
    first = passages[0]
    start, end = first.force_window
    limits = (start - BEFORE_WINDOW, max(end, first.crossing_length) + BEYOND_CROSSING)
    for passage in passages:
        position, value = passage.wheel_position, passage.response.histories[shown.history] / shown.divisor
        there, inside = within(position, limits), within(position, (start, end))
        made.curves.plot(position[there], value[there], color=passage.colour, lw=1.3, label=passage.label)
        text = f"{shown.metric}\n{passage.response.metrics[shown.metric] / shown.divisor:.3f} {shown.unit}"
        low, high = int(np.argmin(value[inside])), int(np.argmax(value[inside]))
        draw_range(made, passage, (position[inside], value[inside]), (low, high), (text, shown.decimals))
    finish(made, first, limits, "range in the window")
    mark_window(made.curves, (start, end), shown.window)
