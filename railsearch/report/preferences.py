"""Preference functions as a figure, with designs marked on them."""

from collections.abc import Iterable, Mapping, Sequence
from itertools import cycle, pairwise

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from railsearch.preferences import StatedPreference
from railsearch.preferences.functions import PreferenceFunction
from railsearch.space import FloatArray
from railsearch.wording import quantity_label, readable

# Okabe & Ito's colours for all kinds of colour vision.
CURVES = ("#0072B2", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
DASHES = ("-", "--", "-.")
MARKS = (("#000000", "*", 120), ("#D55E00", "o", 60))
OTHERS = "#999999"
POINTS = 400
ROOM = 0.08
COLUMNS = 3
LABEL_BOX = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.5}


def preference_figure(
    preferences: Sequence[StatedPreference],
    values: Mapping[str, Mapping[str, float]],
    others: Mapping[str, FloatArray] | None = None,
) -> Figure:
    """A panel for every quantity: its preference functions, and the designs on them.

    values: by quantity, of labelled designs; others: values (n,) by quantity of designs without a label.
    """
    quantities = list(dict.fromkeys(preference.quantity for preference in preferences))
    columns = min(COLUMNS, len(quantities))
    rows = -(-len(quantities) // columns)
    figure = Figure(figsize=(10.0, 1.2 + 3.0 * rows), layout="constrained")
    figure.suptitle("Preferences", x=0.01, ha="left", fontsize=12, fontweight="bold")
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes, quantity in zip(panels, quantities, strict=False):
        own = [preference for preference in preferences if preference.quantity == quantity]
        marks = {label: named[quantity.name] for label, named in values.items()}
        _draw(axes, own, marks, np.asarray((others or {}).get(quantity.name, ()), dtype=float))
    for axes in panels[len(quantities) :]:
        axes.set_axis_off()
    legend = _entries(panels[: len(quantities)])
    figure.legend(legend.values(), legend, loc="outside lower left", ncols=5, frameon=False, fontsize=10)
    figure.set_label(
        f"How much the values of each quantity are liked, from 0 to 100, and where the designs lie ({', '.join(values)}). "
        "Dotted lines stand where a preference function begins, bends or ends."
    )
    return figure


def _draw(axes: Axes, preferences: Sequence[StatedPreference], marks: Mapping[str, float], others: FloatArray) -> None:
    knots = sorted({knot for preference in preferences for knot in preference.function.knots})
    shown = np.array([*knots, *marks.values()])
    room = ROOM * np.ptp(shown)
    line = np.union1d(np.linspace(shown.min() - room, shown.max() + room, POINTS), knots)
    for knot in knots:
        axes.axvline(knot, color="#aaaaaa", lw=0.8, ls=":", zorder=1)
    looks = zip(cycle(CURVES), cycle(DASHES), _by_function(preferences), strict=False)
    for colour, dashes, (function, who) in looks:
        score = function.score
        axes.plot(line, score(line), color=colour, ls=dashes, lw=1.6, label=who, zorder=3)
        inside = others[(others >= line[0]) & (others <= line[-1])]
        if inside.size:
            axes.scatter(inside, score(inside), s=14, color=OTHERS, linewidths=0, zorder=4, label="other designs")
        _mark(axes, function, marks)
    _name_ranges(axes, preferences, line)
    quantity = preferences[0].quantity
    axes.set_title("\n".join(map(_title, preferences)), loc="left", fontsize=9)
    axes.set(xlabel=quantity_label(quantity.name, quantity.unit), ylabel="score", xlim=(line[0], line[-1]))
    bottom, top = axes.get_ylim()
    axes.set_ylim(min(bottom, -5.0), max(top, 105.0))
    axes.grid(alpha=0.3, axis="y")
    axes.spines[["top", "right"]].set_visible(False)


def _by_function(preferences: Sequence[StatedPreference]) -> list[tuple[PreferenceFunction, str]]:
    """The different functions, each with the names of the stakeholders who have it: their curves are one."""
    found: list[tuple[PreferenceFunction, str]] = []
    for preference in preferences:
        who = preference.stakeholder or "preference"
        # Functions made in Python may hold lists, which have no hash.
        place = next((place for place, (function, _) in enumerate(found) if function == preference.function), None)
        if place is None:
            found.append((preference.function, who))
        else:
            found[place] = (preference.function, f"{found[place][1]}, {who}")
    return found


def _title(preference: StatedPreference) -> str:
    who = f"{preference.stakeholder}: " if preference.stakeholder else ""
    return f"{who}{preference.function.function}, weight {preference.weight:.3g}"


def _mark(axes: Axes, function: PreferenceFunction, marks: Mapping[str, float]) -> None:
    """Mark labelled values on a curve, each with its score."""
    for (colour, marker, size), (label, value) in zip(MARKS, marks.items(), strict=False):
        (score,) = function.score(np.array([value]))
        axes.scatter([value], [score], s=size, color=colour, marker=marker, linewidths=0, zorder=6, label=label)
        axes.annotate(
            readable(float(round(score, 1))),
            (value, score),
            (7, 5),
            textcoords="offset points",
            color=colour,
            fontsize=9,
            zorder=7,
            bbox=LABEL_BOX,
        )


def _name_ranges(axes: Axes, preferences: Sequence[StatedPreference], line: FloatArray) -> None:
    """Write the names of the ranges between the knots of a class function, where there is one alone."""
    ((function, _), *others) = _by_function(preferences)
    if others or not function.ranges:
        return
    place = axes.get_xaxis_transform()
    for (low, high), name in zip(pairwise((line[0], *function.knots, line[-1])), function.ranges, strict=True):
        middle = 0.5 * (low + high)
        axes.text(middle, 0.03, name, transform=place, rotation=90, ha="center", va="bottom", fontsize=7, color="#666666")


def _entries(panels: Iterable[Axes]) -> dict[str, Artist]:
    """What stands in the legends of all panels, each once."""
    entries: dict[str, Artist] = {}
    for axes in panels:
        handles, labels = axes.get_legend_handles_labels()
        entries |= dict(zip(labels, handles, strict=True))
    return entries
