"""The numbers behind the figures of a campaign's page, for the script that shows them under the pointer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from railsearch.report.campaign_figures import colour, figure_name

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Entry = Mapping[str, Any]
DIGITS = 5


def plots(document: Entry, figures: Mapping[str, Figure]) -> dict[str, Any]:
    """For every figure over evaluations: its frame as shares of the picture, its axes, evaluation numbers and series.

    figures: the figures by name as campaign_figures makes them, drawn already, so that their frames are in place.
    """
    places = {strategy["label"]: place for place, strategy in enumerate(document["campaign"]["strategies"])}
    shown = {}
    for number, entry in enumerate(document["problems"], 1):
        curves, targets = (figure_name(number, kind, entry["label"]) for kind in ("curves", "targets"))
        if curves in figures:
            series = [_series(label, places[label], curve) for label, curve in entry["curves"].items()]
            shown[curves] = _plot(figures[curves], entry["numbers"], series, entry["measure"])
        if targets in figures:
            shown[targets] = _shares(figures[targets], entry["numbers"], entry["targets"]["ecdf"], places)
    if "all-targets" in figures:
        ecdf = document["ranking"]["ecdf"]
        shown["all-targets"] = _shares(figures["all-targets"], ecdf["numbers"], ecdf["shares"], places)
    return shown


def _shares(
    figure: Figure, numbers: Sequence[int], shares: Mapping[str, Sequence[float]], places: Mapping[str, int]
) -> dict[str, Any]:
    series = [_series(label, places[label], {"median": share}) for label, share in shares.items()]
    return _plot(figure, numbers, series, {"unit": "", "maximised": True})


def _plot(figure: Figure, numbers: Sequence[int], series: Sequence[Entry], measure: Entry) -> dict[str, Any]:
    axes = figure.axes[0]
    left, bottom, width, height = axes.get_position().bounds
    return {
        "frame": [round(edge, 5) for edge in (left, 1.0 - bottom - height, left + width, 1.0 - bottom)],
        "x": _axis(axes, "x"),
        "y": _axis(axes, "y"),
        "numbers": list(numbers),
        "unit": measure["unit"],
        "maximised": measure["maximised"],
        "series": list(series),
    }


def _axis(axes: Axes, which: str) -> list[float | bool]:
    limits, scale = (axes.get_xlim(), axes.get_xscale()) if which == "x" else (axes.get_ylim(), axes.get_yscale())
    return [float(limits[0]), float(limits[1]), scale == "log"]


def _series(label: str, place: int, curve: Entry) -> dict[str, Any]:
    made: dict[str, Any] = {"label": label, "place": place, "colour": colour(place), "values": _rounded(curve["median"])}
    if "lower" in curve:
        made |= {"lower": _rounded(curve["lower"]), "upper": _rounded(curve["upper"])}
    return made


def _rounded(values: Sequence[float | None]) -> list[float | None]:
    return [None if value is None else float(f"{value:.{DIGITS}g}") for value in values]
