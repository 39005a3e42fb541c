"""The figures of a campaign. One drawing serves the files and the page; in it, every artist of a strategy can be found.

An artist of the strategy at position i has the identifier `strategy-i-KIND`, by which the page's script shows and hides it.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

from railsearch.report.markup import labelled
from railsearch.space import FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Entry = Mapping[str, Any]

# Okabe & Ito's colours for all kinds of colour vision, yellow left out: it cannot be seen on white. Their number and that
# of the dashes have no common divisor, so that 28 strategies differ in one of them.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
DASHES: tuple[Any, ...] = ("-", (0, (6, 2)), (0, (1.5, 1.5)), (0, (7, 2, 1.5, 2)))
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "*", "<", ">", "p")
INK = "#1b1b1b"
SIZE = (5.8, 3.9)
BANDS = {"quartiles": ("lower", "upper"), "confidence": ("confidence_lower", "confidence_upper")}
SURFACES = ("quarter", "line", "most")
LOGARITHMIC_EVALUATIONS = 1000
WIDE_RANGE = 30.0
START_LEFT_OUT = 0.05
MARKS = 7
BANDS_SHOWN = 3
FEW = 4
LABEL_GAP = 0.062
LABEL_LENGTH = 24
MOST_RANK_TICKS = 12


def campaign_figures(document: Entry, bands: Sequence[str] = ("quartiles",)) -> dict[str, Figure]:
    """The figures of a campaign's document by name: for each problem curves and targets, then over all problems.

    bands: which of the bands in BANDS are drawn around the medians.
    """
    places = {strategy["label"]: place for place, strategy in enumerate(document["campaign"]["strategies"])}
    figures: dict[str, Figure] = {}
    for number, entry in enumerate(document["problems"], 1):
        if entry["compared"]:
            named = problem_figures(entry, places, bands)
            figures |= {figure_name(number, kind, entry["label"]): figure for kind, figure in named.items()}
    ranking = document["ranking"]
    if ranking is not None:
        ecdf = ranking["ecdf"]
        title = f"Targets reached, all {len(ranking['problems'])} problems"
        figures["all-targets"] = targets_figure(title, ecdf["numbers"], ecdf["shares"], places)
        if not ranking["untested"]:
            figures["all-ranks"] = ranks_figure(ranking, places)
    return figures


def figure_name(number: int, kind: str, label: str) -> str:
    """A name fit for files and identifiers: the number of the problem, the kind of the figure, the label."""
    return f"{number}-{kind}-{re.sub(r'[^A-Za-z0-9]+', '-', label).strip('-').lower()}"


def problem_figures(entry: Entry, places: Mapping[str, int], bands: Sequence[str]) -> dict[str, Figure]:
    """The figures of one problem by kind."""
    figures = {"curves": curves_figure(entry, places, bands)}
    if entry["targets"] is not None:
        figures["targets"] = targets_figure("Targets reached", entry["numbers"], entry["targets"]["ecdf"], places)
    if entry["attainment"]:
        figures["attainment"] = attainment_figure(entry, places)
    return figures


def curves_figure(entry: Entry, places: Mapping[str, int], bands: Sequence[str]) -> Figure:
    """The median of the best value so far over the evaluations, for every strategy, with bands."""
    figure, axes = _figure(f"Best {entry['measure']['name']} so far")
    ends, with_bands = {}, banded(entry)
    for strategy, curve in entry["curves"].items():
        place, numbers = places[strategy], np.array(entry["numbers"])
        median = _numbers(curve["median"])
        ends[place] = median[-1]
        _line(axes, place, numbers, median)
        for band in bands if strategy in with_bands else ():
            low, high = (_numbers(curve[key]) for key in BANDS[band])
            axes.fill_between(
                numbers, low, high, step="post", color=colour(place), alpha=0.15, lw=0, gid=f"strategy-{place}-{band}"
            )
    _value_axis(axes, entry)
    _evaluation_axis(axes, entry["numbers"])
    _label_ends(axes, ends, places)
    figure.set_label(_curves_caption(entry, bands, len(with_bands)))
    return figure


def targets_figure(
    title: str, numbers: Sequence[int], shares: Mapping[str, Sequence[float]], places: Mapping[str, int]
) -> Figure:
    """The share of pairs of repetition and target that are reached after so many evaluations."""
    figure, axes = _figure(title)
    for strategy, share in shares.items():
        _line(axes, places[strategy], np.array(numbers), _numbers(share))
    axes.set(ylabel="share of targets reached", ylim=(-0.02, 1.02))
    _evaluation_axis(axes, numbers)
    _label_ends(axes, {places[strategy]: share[-1] for strategy, share in shares.items()}, places)
    figure.set_label(
        "Share of all pairs of repetition and target that are reached after so many evaluations. Targets lie between the "
        "first value and the best one found, denser towards the best. Higher and further left is better."
    )
    return figure


def attainment_figure(entry: Entry, places: Mapping[str, int]) -> Figure:
    """What half of the repetitions attain in the space of two objectives, and thin, what a quarter and three quarters do."""
    figure, axes = _figure("What half of the repetitions attain")
    objectives = entry["design"]["problem"]["objectives"]
    signs = np.array([-1.0 if objective["maximised"] else 1.0 for objective in objectives])
    for strategy, levels in entry["attainment"].items():
        for kind, corners in zip(SURFACES, levels, strict=True):
            if corners:
                _surface(axes, strategy, places[strategy], kind, signs, np.array(corners))
    axes.set(**dict(zip(("xlabel", "ylabel"), map(labelled, objectives), strict=True)))
    if axes.get_legend_handles_labels()[0]:
        axes.legend(frameon=False, fontsize=9)
    figure.set_label(
        "Attainment surfaces: what half of the repetitions reach or better (thick), a quarter and three quarters (thin)."
    )
    return figure


def ranks_figure(ranking: Entry, places: Mapping[str, int]) -> Figure:
    """The critical-difference diagram: mean ranks, and bars over strategies that cannot be told apart."""
    names, ranks, groups = ranking["strategies"], ranking["mean_ranks"], ranking["groups"]
    rows = len(names) - len(names) // 2
    figure = Figure(figsize=(SIZE[0], 1.3 + 0.16 * len(groups) + 0.24 * rows), layout="constrained")
    axes = figure.subplots()
    axes.set_title("Mean ranks", loc="left", fontsize=11, fontweight="bold")
    begin = 0.9 + 0.4 * len(groups)
    order = sorted(range(len(names)), key=lambda index: ranks[index])
    for position, index in enumerate(order):
        left = position < rows
        depth = begin + 0.6 * (position if left else len(names) - 1 - position)
        _rank(axes, names[index], places[names[index]], (ranks[index], depth, 1.0 if left else float(len(names))))
    for row, group in enumerate(groups):
        ends = [min(ranks[index] for index in group) - 0.03, max(ranks[index] for index in group) + 0.03]
        axes.plot(ends, [0.35 + 0.4 * row] * 2, color=INK, lw=3.5, solid_capstyle="butt", gid=f"group-{row}")
    _rank_axis(axes, ranking, begin + 0.6 * (rows - 1))
    figure.set_label(
        f"Mean ranks over {len(ranking['problems'])} problems, 1 is best. Strategies under one bar cannot be told apart "
        f"(critical difference CD = {ranking['critical_difference']:.2f} at {100.0 * ranking['level']:g} %, Friedman test "
        f"p = {ranking['p_value']:.3g})."
    )
    return figure


def banded(entry: Entry) -> list[str]:
    """The strategies whose bands are drawn: all of few, otherwise the best ones at the end."""
    if len(entry["compared"]) <= FEW:
        return list(entry["compared"])
    worst = -np.inf if entry["measure"]["maximised"] else np.inf
    ends = {name: worst if curve["median"][-1] is None else curve["median"][-1] for name, curve in entry["curves"].items()}
    return sorted(ends, key=lambda name: ends[name], reverse=entry["measure"]["maximised"])[:BANDS_SHOWN]


def swatch(place: int) -> Figure:
    """A piece of a strategy's line, for legends."""
    from matplotlib.lines import Line2D

    figure = Figure(figsize=(0.5, 0.16))
    figure.patch.set_alpha(0.0)
    figure.add_artist(Line2D([0.02, 0.5, 0.98], [0.5, 0.5, 0.5], markevery=[1], **_look(place)))
    return figure


def colour(place: int) -> str:
    """The colour of the strategy at a position."""
    return COLOURS[place % len(COLOURS)]


def short(label: str) -> str:
    """A label that fits beside a curve."""
    return label if len(label) <= LABEL_LENGTH else label[: LABEL_LENGTH - 1] + "…"


def spread(values: FloatArray, gap: float) -> FloatArray:
    """Places (n,) between 0 and 1 as near to values (n,) as their order and a gap between them allow."""
    order = np.argsort(values, kind="stable")
    offsets = gap * np.arange(values.size)
    wanted = values[order] - offsets
    # Isotonic means of neighbours that would overlap keep every group centred on its own curves.
    groups: list[list[float]] = []
    for value in wanted:
        groups.append([value])
        while len(groups) > 1 and np.mean(groups[-2]) > np.mean(groups[-1]):
            groups[-2:] = [groups[-2] + groups[-1]]
    free = np.concatenate([np.full(len(group), np.mean(group)) for group in groups])
    placed = np.empty(values.size)
    placed[order] = np.clip(free, 0.0, max(0.0, 1.0 - gap * (values.size - 1))) + offsets
    return placed


def _figure(title: str) -> tuple[Figure, Axes]:
    figure = Figure(figsize=SIZE, layout="constrained")
    axes = figure.subplots()
    axes.set_title(title, loc="left", fontsize=11, fontweight="bold")
    axes.grid(alpha=0.25)
    axes.spines[["top", "right"]].set_visible(False)
    return figure, axes


def _look(place: int) -> dict[str, Any]:
    return {
        "color": colour(place),
        "linestyle": DASHES[place % len(DASHES)],
        "linewidth": 1.7,
        "marker": MARKERS[place % len(MARKERS)],
        "markersize": 4.5,
    }


def _line(axes: Axes, place: int, numbers: np.ndarray[Any, Any], values: FloatArray) -> None:
    every = max(1, numbers.size // MARKS)
    start = (place * every) // 5 % every
    axes.plot(
        numbers,
        values,
        drawstyle="steps-post",
        markevery=(start, every),
        gid=f"strategy-{place}-line",
        zorder=3,
        **_look(place),
    )


def _surface(axes: Axes, label: str, place: int, kind: str, signs: FloatArray, corners: FloatArray) -> None:
    """A staircase through the corners (p, 2), given with their natural sign; thin but for the middle one."""
    lowest = corners * signs
    lowest = lowest[np.argsort(lowest[:, 0], kind="stable")]
    x, y = np.repeat(lowest[:, 0], 2)[1:], np.repeat(lowest[:, 1], 2)[:-1]
    look = _look(place) | ({"label": short(label)} if kind == "line" else {"linewidth": 0.6, "marker": ""})
    every = max(1, x.size // MARKS)
    axes.plot(signs[0] * x, signs[1] * y, markevery=every, gid=f"strategy-{place}-{kind}", **look)


def _evaluation_axis(axes: Axes, numbers: Sequence[int]) -> None:
    budget = numbers[-1]
    if budget > LOGARITHMIC_EVALUATIONS:
        axes.set(xscale="log", xlim=(1, budget))
    else:
        axes.set_xlim(0, budget)
    axes.set_xlabel("evaluation")


def _value_axis(axes: Axes, entry: Entry) -> None:
    """Scale and limits of the values: logarithmic over a wide range; a steep start is cut off at the edge."""
    measure, numbers = entry["measure"], np.array(entry["numbers"])
    bands = np.array([[_numbers(curve[key]) for key in ("lower", "upper", "median")] for curve in entry["curves"].values()])
    axes.set_ylabel(labelled(measure))
    finite = bands[np.isfinite(bands)]
    if not finite.size:
        return
    if finite.min() > 0.0 and finite.max() > WIDE_RANGE * finite.min():
        axes.set_yscale("log")
        return
    later = bands[:, :, numbers >= START_LEFT_OUT * numbers[-1]]
    later = later[np.isfinite(later)]
    low, high = (later.min(), later.max()) if later.size else (finite.min(), finite.max())
    room = 0.05 * (high - low) or 0.05 * abs(high) or 1.0
    axes.set_ylim(low - room, high + room)


def _label_ends(axes: Axes, ends: Mapping[int, float], places: Mapping[str, int]) -> None:
    """Names of the strategies beside the ends of their curves, moved apart where they would overlap."""
    names = {place: label for label, place in places.items()}
    shown = {place: value for place, value in ends.items() if np.isfinite(value)}
    if not shown:
        return
    to_axes = axes.transData + axes.transAxes.inverted()
    edge = axes.get_xlim()[1]
    heights = np.clip([to_axes.transform((edge, value))[1] for value in shown.values()], 0.0, 1.0)
    for place, height, text in zip(shown, heights, spread(heights, LABEL_GAP), strict=True):
        beside: dict[str, Any] = {"transform": axes.transAxes, "color": colour(place), "clip_on": False}
        axes.plot([1.0, 1.05], [height, text], lw=0.7, gid=f"strategy-{place}-pointer", **beside)
        axes.text(1.06, text, short(names[place]), va="center", fontsize=10, gid=f"strategy-{place}-label", **beside)


def _rank(axes: Axes, name: str, place: int, where: tuple[float, float, float]) -> None:
    """A strategy's line from its rank down and out to its name; where: rank, depth, and the edge of the name."""
    rank, depth, edge = where
    left = edge < rank or edge == 1.0
    axes.plot([rank, rank, edge], [0.0, depth, depth], color=colour(place), lw=1.3, gid=f"strategy-{place}-rank")
    axes.annotate(
        f"{short(name)}  {rank:.2f}" if left else f"{rank:.2f}  {short(name)}",
        (edge, depth),
        (-4 if left else 4, 0),
        textcoords="offset points",
        ha="right" if left else "left",
        va="center",
        fontsize=10,
        annotation_clip=False,
    )


def _rank_axis(axes: Axes, ranking: Entry, depth: float) -> None:
    """Ranks along the top, the critical difference above them."""
    count = len(ranking["strategies"])
    axes.set(xlim=(0.9, count + 0.1), ylim=(depth + 0.5, -2.0))
    difference = ranking["critical_difference"]
    if difference <= count - 1:
        axes.plot([1.0, 1.0 + difference], [-1.6, -1.6], color=INK, lw=1.2, marker="|", markersize=7)
        axes.annotate(f"CD = {difference:.2f}", (1.0 + difference, -1.6), (6, 0), textcoords="offset points", va="center")
    axes.xaxis.tick_top()
    axes.set_xticks(range(1, count + 1), minor=True)
    axes.set_xticks(range(1, count + 1, 1 + (count - 1) // MOST_RANK_TICKS))
    axes.spines[["left", "right", "bottom"]].set_visible(False)
    axes.spines["top"].set_position(("data", 0.0))
    axes.yaxis.set_visible(False)


def _curves_caption(entry: Entry, bands: Sequence[str], shown: int) -> str:
    measure = entry["measure"]
    which = "" if shown == len(entry["compared"]) else f" for the best {shown}"
    return (
        f"Median of the best {measure['name']} so far over {len(entry['repetitions'])} repetitions, with "
        f"{_band_words(bands)}{which}. {'Higher' if measure['maximised'] else 'Lower'} is better."
    )


def _band_words(bands: Sequence[str]) -> str:
    words = {"quartiles": "the band between the quartiles", "confidence": "the 95 % confidence band of the median"}
    return " or ".join(words[band] for band in bands)


def _numbers(values: Sequence[float | None]) -> FloatArray:
    return np.array([np.nan if value is None else value for value in values], dtype=float)
