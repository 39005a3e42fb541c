"""Pictures of passages over an imported track: wheel-rail force and energy dissipated per support."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from railsearch.interfaces import Passage
from railsearch.space import FloatArray
from railsearch_plugins.passage_figures.panels import close, draw_range, mark_window, new_panels
from railsearch_plugins.passage_figures.passage import KILO, DrawnPassage, drawn_figures, within

POSITION = "Position [m]"


def force_figure(passages: Sequence[DrawnPassage]) -> Figure:
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


def energy_figure(passages: Sequence[DrawnPassage]) -> Figure:
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
    passages: Sequence[DrawnPassage],
    words: tuple[str, str, str],
    shown: tuple[str, str, float],
    metric: tuple[str, str, int],
    edges: tuple[str, str],
    level: float | None,
) -> Figure:
    """Curves of all designs and their ranges between the edges, two fields of the windows."""
    (title, quantity, name), (place, history, divisor), (key, unit, decimals) = words, shown, metric
    made = new_panels(passages, title, POSITION, quantity)
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


def _window(passage: DrawnPassage, edges: tuple[str, str], position: FloatArray) -> tuple[float, float]:
    given = [getattr(passage.track.windows, edge) for edge in edges]
    first, last = (
        float(end) if value is None else value for value, end in zip(given, (position[0], position[-1]), strict=True)
    )
    return first, last


DRAWINGS = {"force": force_figure, "energy": energy_figure}


def track_figures(passages: Mapping[str, Passage], names: Sequence[str]) -> dict[str, Figure]:
    """The figures of these names, all without any. Raises InputError for an unknown name."""
    return drawn_figures(passages, DrawnPassage, DRAWINGS, names or tuple(DRAWINGS))
