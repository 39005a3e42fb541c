"""Pictures of an imported track that compare designs: wheel-rail force and energy dissipated per support."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from railsearch.interfaces import TrackModel
from railsearch.space import FloatArray

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from railsearch_problems.level_crossing_figures.passage import Passage

KILO = 1e3
POSITION = "Position [m]"


def track_figures(model: TrackModel, parameters: Mapping[str, Any]) -> dict[str, Figure]:
    """The figures `force` and `energy` for the track parameters of labelled designs, each simulated once."""
    from railsearch_problems.level_crossing_figures.passage import compared_passages

    passages = compared_passages(model, parameters)
    return {"force": force_figure(passages), "energy": energy_figure(passages)}


def force_figure(passages: Sequence[Passage]) -> Figure:
    """Wheel-rail force in kN over the whole run, with its range in the force window, F_max, of every design."""
    static = passages[0].track.vehicle.static_load / KILO
    figure = _compared(
        passages,
        ("Wheel-rail force", "Wheel-rail force [kN]", "force window"),
        ("wheel_position", "wheel_rail_force", KILO),
        ("F_max", "kN", 2),
        ("force_from", "force_to"),
        level=static,
    )
    figure.set_label(
        "Force between wheel and rail over the position of the wheel; the line of dashes and dots is the static wheel load. "
        "F_max is the largest minus the smallest force in the force window (triangles); the bars at the right span it."
    )
    return figure


def energy_figure(passages: Sequence[Passage]) -> Figure:
    """Energy dissipated in every support, with its range over the measured ones, E_max, of every design."""
    figure = _compared(
        passages,
        ("Energy dissipated per support", "Energy per support [N·m]", "measured supports"),
        ("support_position", "support_energy", 1.0),
        ("E_max", "N·m", 3),
        ("energy_from", "energy_to"),
        level=None,
    )
    figure.set_label(
        "Energy dissipated in the damper of every support over one passage. E_max is the largest minus the smallest of the "
        "measured supports (triangles); the bars at the right span it."
    )
    return figure


def _compared(
    passages: Sequence[Passage],
    words: tuple[str, str, str],
    shown: tuple[str, str, float],
    metric: tuple[str, str, int],
    edges: tuple[str, str],
    level: float | None,
) -> Figure:
    """Curves of all designs and their ranges between the edges, two fields of the windows."""
    from railsearch_problems.level_crossing_figures.panels import close, draw_range, mark_window, new_panels
    from railsearch_problems.level_crossing_figures.passage import within

    (title, quantity, name), (place, history, divisor), (key, unit, decimals) = words, shown, metric
    made = new_panels(passages, title, quantity)
    made.curves.set_xlabel(POSITION)
    if level is not None:
        made.curves.axhline(level, color="#888888", lw=0.8, ls="-.")
    for passage in passages:
        position, value = passage.response.histories[place], passage.response.histories[history] / divisor
        inside = within(position, _window(passage, edges, position))
        made.curves.plot(position, value, color=passage.colour, lw=1.2, label=passage.label)
        rows = int(np.argmin(value[inside])), int(np.argmax(value[inside]))
        text = f"{key}\n{passage.response.metrics[key] / divisor:.{decimals + 1}f} {unit}"
        draw_range(made, passage, (position[inside], value[inside]), rows, (text, decimals))
    position = passages[0].response.histories[place]
    close(made, (float(position[0]), float(position[-1])), "range in the window")
    mark_window(made.curves, _window(passages[0], edges, position), name)
    return made.figure


def _window(passage: Passage, edges: tuple[str, str], position: FloatArray) -> tuple[float, float]:
    given = [getattr(passage.track.windows, edge) for edge in edges]
    first, last = (
        float(end) if value is None else value for value, end in zip(given, (position[0], position[-1]), strict=True)
    )
    return first, last
