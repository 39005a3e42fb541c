"""Largest and smallest values along the track, one passage against another."""

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from railsearch.space import FloatArray
from railsearch_plugins.passage_figures.stack import add_legend, add_values, name_panel, new_stack
from railsearch_plugins.track_models.train_track_bridge.figures.bridge_passage import (
    ALONG,
    MILLI,
    BridgePassage,
    shade_bridge,
    with_bridge,
)

PANEL = 1.45
BEYOND = 5.0
QUANTITIES = ["Deflection [mm]", "Acceleration [m/s²]", "Acceleration [m/s²]", "Displacement [mm]"]
NAMES = [
    "bridge, largest downward deflection",
    "bridge, largest acceleration",
    "sleepers, largest acceleration",
    "rail, lowest and highest, downward",
]


def envelope_figure(passages: Sequence[BridgePassage]) -> Figure:
    """Deflection and acceleration of the bridge, acceleration of every sleeper, lowest and highest rail."""
    made = new_stack("Largest values along the track", with_bridge(ALONG, passages), QUANTITIES, PANEL)
    deflection, acceleration, sleepers, rail = made.panels
    for passage in passages:
        _draw_bridge(deflection, passage, passage.history("bridge_deflection_max") / MILLI, "mm")
        _draw_bridge(acceleration, passage, passage.history("bridge_acceleration_max"), "m/s²")
        _draw_sleepers(sleepers, passage)
        _draw_rail(rail, passage)
    made.panels[0].set_xlim(*_limits(passages))
    for axes, name in zip(made.panels, NAMES, strict=True):
        axes.margins(y=0.1)
        name_panel(axes, name)
        add_values(axes)
    for axes in (acceleration, sleepers):
        axes.set_ylim(bottom=0.0)
    for axes in (deflection, rail):
        axes.invert_yaxis()
    shade_bridge(made.panels, 0.0, passages[0].span)
    add_legend(made, {passage.label: Line2D([], [], color=passage.colour, lw=1.5) for passage in passages})
    made.figure.set_label(
        "Envelopes of the measured run along the track: largest deflection and acceleration of the bridge, largest "
        "acceleration of every sleeper (filled: those of which A_s is the largest), and how low and how high the rail "
        "comes; U_r is its largest displacement."
    )
    return made.figure


def _draw_bridge(axes: Axes, passage: BridgePassage, values: FloatArray, unit: str) -> None:
    """Values (b,) at the nodes of the bridge, the largest of them as the label."""
    label = f"{values.max():.4g} {unit}"
    axes.plot(passage.history("bridge_position"), values, color=passage.colour, lw=1.3, label=label)


def _draw_sleepers(axes: Axes, passage: BridgePassage) -> None:
    """Measured sleepers filled, the others hollow."""
    position, value = passage.history("sleeper_position"), passage.history("sleeper_acceleration_max")
    measured, label = passage.measured_sleepers, f"A_s {passage.response.metrics['A_s']:.4g} m/s²"
    for mask, face, name in ((measured, passage.colour, label), (~measured, "white", f"_{passage.label}, not measured")):
        axes.plot(
            position[mask],
            value[mask],
            passage.marker,
            color=passage.colour,
            markerfacecolor=face,
            markersize=3.5,
            markeredgewidth=0.7,
            label=name,
        )


def _draw_rail(axes: Axes, passage: BridgePassage) -> None:
    """The band between the highest and the lowest rail."""
    position = passage.history("rail_position")
    lowest, highest = passage.history("rail_lowest") / MILLI, -passage.history("rail_highest") / MILLI
    label = f"U_r {passage.response.metrics['U_r'] / MILLI:.4g} mm"
    axes.plot(position, lowest, color=passage.colour, lw=1.1, label=label)
    axes.plot(position, highest, color=passage.colour, lw=1.1, label=f"_{passage.label}, highest")
    axes.fill_between(position, highest, lowest, color=passage.colour, alpha=0.08, lw=0.0)


def _limits(passages: Sequence[BridgePassage]) -> tuple[float, float]:
    """The measured stretch and a little more, no further than the rail."""
    first = passages[0]
    rail, before = first.history("rail_position"), max(first.track.approach_length, first.track.sleeper_margin) + BEYOND
    after = max(first.track.departure_length, first.track.sleeper_margin) + BEYOND
    return max(float(rail[0]), -before), min(float(rail[-1]), first.span + after)
