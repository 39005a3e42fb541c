"""What wheels, carbodies and deck feel while the train passes, one passage against another."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from railsearch_plugins.passage_figures.passage import COLOURS, KILO
from railsearch_plugins.passage_figures.stack import Stack, add_legend, add_values, name_panel, new_stack
from railsearch_plugins.track_models.train_track_bridge.figures.bridge_passage import (
    AXLES,
    FIRST_AXLE,
    MILLI,
    BridgePassage,
    shade_bridge,
)

FORCE_PANEL, HISTORY_PANEL = 1.55, 1.25
AXLE_COLOURS = COLOURS[1:5]
ORDINALS = ("first", "second", "third", "fourth")
STATIC: Mapping[str, Any] = MappingProxyType({"color": "#555555", "lw": 0.9, "ls": "-."})


def contact_force_figure(passages: Sequence[BridgePassage]) -> Figure:
    """Contact force in kN of every axle over the position of the first one, a panel for each vehicle."""
    count = max(passage.vehicles for passage in passages)
    made = new_stack("Contact force of every axle", FIRST_AXLE, ["Contact force [kN]"] * count, FORCE_PANEL)
    for axes in made.panels[1:]:
        axes.sharey(made.panels[0])
    for passage in passages:
        _draw_forces(made, passage, alone=len(passages) == 1)
    _close(made, passages)
    for number, axes in enumerate(made.panels):
        name_panel(axes, f"vehicle {number + 1}")
    add_legend(made, _force_keys(passages))
    made.figure.set_label(
        "Force between wheelset and rail over the position of the first axle of the train, for the four axles of every "
        "vehicle. Triangles: the largest and the smallest force under a wheel on the bridge; a line of dashes and dots is "
        "the static load. Shaded: axles of the vehicle are on the bridge."
    )
    return made.figure


def histories_figure(passages: Sequence[BridgePassage]) -> Figure:
    """Acceleration of every carbody, deflection of the deck, and the irregularity under the first wheel."""
    count = max(passage.vehicles for passage in passages)
    quantities = ["Acceleration [m/s²]"] * count + ["Deflection [mm]", "Height [mm]"]
    made = new_stack("Carbodies, deck and irregularity", FIRST_AXLE, quantities, HISTORY_PANEL)
    for axes in made.panels[1:count]:
        axes.sharey(made.panels[0])
    for passage in passages:
        _draw_carbodies(made.panels[:count], passage)
        _draw_deck(made.panels[count], passage)
        irregularity = passage.history("irregularity")[:, 0] / MILLI
        made.panels[-1].plot(passage.first_axle, irregularity, color=passage.colour, lw=1.1, label=passage.label)
    _close(made, passages)
    made.panels[count].invert_yaxis()
    for number, axes in enumerate(made.panels[:count]):
        name_panel(axes, f"carbody of vehicle {number + 1}, downward")
    name_panel(made.panels[count], "deck at midspan, downward")
    name_panel(made.panels[-1], "irregularity under the first wheel, upward")
    add_legend(made, {passage.label: Line2D([], [], color=passage.colour, lw=1.5) for passage in passages})
    made.figure.set_label(
        "Acceleration at the centre of every carbody, with Sperling's comfort index W_z over the measured run; deflection "
        "of the deck at midspan, with its largest value U_d (triangle); and the height of the unloaded rail under the first "
        "wheel, over which all other wheels run as well. All over the position of the first axle; shaded: on the bridge are "
        "axles of the vehicle, of the train, the first wheel."
    )
    return made.figure


def _draw_forces(made: Stack, passage: BridgePassage, alone: bool) -> None:
    """All axles, coloured by axle if there is one passage `alone`, else by passage; extremes; static load."""
    force, front = passage.history("contact_force") / KILO, passage.first_axle
    for axle in range(force.shape[1]):
        vehicle, number = divmod(axle, AXLES)
        colour = AXLE_COLOURS[number] if alone else passage.colour
        name = f"_{passage.label}, axle {axle + 1}"
        made.panels[vehicle].plot(front, force[:, axle], color=colour, lw=0.8, alpha=0.85 if alone else 0.6, label=name)
    for axes in made.panels[: passage.vehicles]:
        look = STATIC if alone else {**STATIC, "color": passage.colour}
        axes.axhline(passage.static_load / KILO, **look, label="_static load")
    measured = np.where(passage.on_bridge, force, np.nan)
    for marker, place in (("v", np.nanargmax(measured)), ("^", np.nanargmin(measured))):
        step, axle = map(int, np.unravel_index(place, force.shape))
        axes, value = made.panels[axle // AXLES], float(force[step, axle])
        _mark(axes, passage, (float(front[step]), value), marker, f"{value:.4g} kN")
        add_values(axes)


def _draw_carbodies(panels: Sequence[Axes], passage: BridgePassage) -> None:
    for number, index in enumerate(passage.comfort):
        acceleration, label = passage.history("carbody_acceleration")[:, number], f"W_z {index:.4g}"
        panels[number].plot(passage.first_axle, acceleration, color=passage.colour, lw=1.1, label=label)
        add_values(panels[number])


def _draw_deck(axes: Axes, passage: BridgePassage) -> None:
    deflection = passage.history("deck_deflection") / MILLI
    axes.plot(passage.first_axle, deflection, color=passage.colour, lw=1.1, label=f"_{passage.label}")
    largest, value = int(np.argmax(deflection)), passage.response.metrics["U_d"] / MILLI
    _mark(axes, passage, (float(passage.first_axle[largest]), float(deflection[largest])), "^", f"U_d {value:.4g} mm")
    add_values(axes)


def _mark(axes: Axes, passage: BridgePassage, place: tuple[float, float], marker: str, words: str) -> None:
    """A triangle at an extreme, labelled by its value."""
    axes.plot(*place, marker, color=passage.colour, markersize=8, markeredgecolor="white", ls="", zorder=5, label=words)


def _close(made: Stack, passages: Sequence[BridgePassage]) -> None:
    """Limits with room for the names of the panels, and where what a panel shows is on the bridge."""
    fronts = [passage.first_axle for passage in passages]
    made.panels[0].set_xlim(min(float(front[0]) for front in fronts), max(float(front[-1]) for front in fronts))
    for axes in made.panels:
        axes.margins(y=0.08)
    behind, span = max((passage.behind for passage in passages), key=len), passages[0].span
    count = len(behind) // AXLES
    for number, axes in enumerate(made.panels):
        # Panels of vehicles come first, then the deck, which all axles load, and the irregularity under the first.
        own = behind[number * AXLES : (number + 1) * AXLES] if number < count else behind
        last = 0.0 if number > count else own[-1]
        shade_bridge([axes], float(own[0]), span + float(last))


def _force_keys(passages: Sequence[BridgePassage]) -> dict[str, Artist]:
    """What the colours mean: axles of a vehicle for one passage, passages for several."""
    keys: dict[str, Artist] = {
        passage.label: Line2D([], [], color=passage.colour, lw=1.5) for passage in passages if len(passages) > 1
    }
    if len(passages) == 1:
        keys |= {
            f"{word} axle": Line2D([], [], color=colour, lw=1.5) for word, colour in zip(ORDINALS, AXLE_COLOURS, strict=True)
        }
    return keys | {"static load": Line2D([], [], **STATIC)}
