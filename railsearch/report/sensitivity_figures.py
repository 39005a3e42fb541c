"""Pictures of a sensitivity analysis of one output, from its document: importances, curves, thresholds, the surrogate."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MaxNLocator, PercentFormatter

from railsearch.wording import quantity_label, readable

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Okabe & Ito's colours for all kinds of colour vision.
WORST, TOTAL, SINGLE = "#0072B2", "#E69F00", "#999999"
LINES = ("#56B4E9", "#009E73", "#E69F00", "#D55E00", "#CC79A7", "#0072B2", "#000000", "#999999")
SAFE = "#009E73"
INK = "#1b1b1b"
COLUMNS = 4
PANEL = (2.7, 2.0)
# Exponents of ten from and below which numbers are written out.
PLAIN = (-3, 5)
LONGEST_LABEL = 32

Document = Mapping[str, Any]


def sensitivity_figures(criterion: Document) -> dict[str, Figure]:
    """All figures of one output by name."""
    return {
        "importances": importance_figure(criterion),
        "extremes": curve_figure(criterion),
        "thresholds": threshold_figure(criterion),
        "surrogate": surrogate_figure(criterion),
    }


def importance_figure(criterion: Document) -> Figure:
    """Shares of the inputs by three measures, the most important in the worst case on top."""
    importances = criterion["importances"]
    names = sorted(importances, key=lambda name: importances[name])
    total = dict(zip(criterion["sobol"]["inputs"], criterion["sobol"]["total"], strict=True))
    half = dict(zip(criterion["sobol"]["inputs"], criterion["sobol"]["total_half_width"], strict=True))
    single = criterion["one_at_a_time"]["importances"]
    figure = Figure(figsize=(8.0, 0.42 * len(names) + 1.3), layout="constrained")
    axes = figure.subplots()
    place = np.arange(len(names))
    axes.barh(place + 0.27, [importances[name] for name in names], 0.26, color=WORST, label="worst case (A-1AT)")
    axes.barh(
        place, [total[name] for name in names], 0.26, color=TOTAL, label="variance (Sobol' total index)",
        xerr=[half[name] for name in names], error_kw={"ecolor": INK, "elinewidth": 0.8},
    )  # fmt: skip
    axes.barh(place - 0.27, [single[name] for name in names], 0.26, color=SINGLE, label="one at a time, from the middle")
    _spread_lines(axes, criterion, names)
    _model_marks(axes, criterion, names)
    axes.set_yticks(place, names, fontsize=9)
    axes.xaxis.set_major_formatter(PercentFormatter(1.0))
    axes.set_xlim(left=0.0)
    _plain(axes)
    axes.legend(loc="lower right", fontsize=8, frameon=False)
    _title(figure, f"What moves {_label(criterion)}")
    figure.set_label(
        f"Shares of the inputs in {criterion['name']}: of the movement of its largest values when all other inputs do their "
        "worst, of its variance (the total indices sum to more than one where inputs interact), and with all other inputs "
        "in the middle of their ranges. Lines hold 95 % of what is estimated."
    )
    return figure


def _spread_lines(axes: Axes, criterion: Document, names: Sequence[str]) -> None:
    """Over the bars of the worst case, where most refits have them."""
    if spread := criterion["spread"]:
        ends = {row["name"]: (row["lower"], row["upper"]) for row in spread["factors"]}
        axes.hlines(np.arange(len(names)) + 0.27, *np.array([ends[name] for name in names]).T, color=INK, lw=0.8)


def _model_marks(axes: Axes, criterion: Document, names: Sequence[str]) -> None:
    """Over the bars of the variance, the total indices of the model itself."""
    if measures := criterion["on_model"]:
        found = measures["sobol"]
        places = [found["inputs"].index(name) for name in names]
        shares, widths = (_numbers(found[key])[places] for key in ("total", "total_half_width"))
        axes.errorbar(
            shares,
            np.arange(len(names)),
            xerr=widths,
            fmt="D",
            ms=3.5,
            color=INK,
            lw=0.8,
            label="variance, on the model itself",
        )


def curve_figure(criterion: Document) -> Figure:
    """Largest and smallest values of the output over every input, all others doing their best or worst."""
    factors = criterion["extremes"]["factors"]
    figure, panels = _panels(len(factors), f"Extremes of {_label(criterion)} over each input")
    for axes, factor in zip(panels, factors, strict=True):
        grid = _numbers(factor["grid"])
        low, high = (_numbers(factor[sense]["values"]) for sense in ("minimum", "maximum"))
        axes.fill_between(grid, low, high, color=WORST, alpha=0.12, lw=0)
        axes.plot(grid, high, color=WORST, lw=1.5)
        axes.plot(grid, low, color=WORST, lw=1.0, ls="--")
        _name(axes, factor)
    _share_heights(panels)
    figure.set_label(
        f"Largest (line) and smallest (dashes) {criterion['name']} with the input held at a value and all others anywhere "
        "in their ranges. The more the line moves, the more important is the input in the worst case."
    )
    return figure


def threshold_figure(criterion: Document) -> Figure:
    """Threshold-based response over every input, with the ranges that keep the limit state out of reach."""
    document = criterion["thresholds"]
    grids = {factor["name"]: factor for factor in criterion["extremes"]["factors"]}
    factors = list(grids.values())
    figure, panels = _panels(len(factors), f"Can {_label(criterion)} come to a threshold?")
    for colour, threshold in zip(_colours(len(document["thresholds"])), document["thresholds"], strict=True):
        for axes, found in zip(panels, threshold["factors"], strict=True):
            grid = _numbers(grids[found["name"]]["grid"])
            axes.plot(grid, _numbers(found["curve"]), color=colour, lw=1.4)
            for low, high in found["safe"] if found["critical"] else ():
                axes.axvspan(low, high, color=colour, alpha=0.12, lw=0)
    for axes, factor in zip(panels, factors, strict=True):
        _name(axes, factor)
    _share_heights(panels)
    values = [f"{readable(threshold['value'])} {criterion['unit']}".rstrip() for threshold in document["thresholds"]]
    handles = [panels[0].lines[k] for k in range(len(values))]
    figure.legend(handles, values, loc="outside lower center", ncols=min(len(values), 5), fontsize=8, frameon=False)
    figure.set_label(
        f"The {criterion['name']} that comes nearest to each threshold with the input held at a value: on the threshold "
        "where it can be reached, beside it where it cannot. Shaded: ranges of the input that keep the limit state out of "
        "reach whatever the others are."
    )
    return figure


def surrogate_figure(criterion: Document) -> Figure:
    """Predictions of samples that were held out over their true values."""
    true, predicted = (_numbers(criterion["held_out"][key]) for key in ("true", "predicted"))
    figure = Figure(figsize=(8.0, 3.6), layout="constrained")
    axes, errors = figure.subplots(1, 2)
    ends = [min(true.min(), predicted.min()), max(true.max(), predicted.max())]
    axes.plot(ends, ends, color=SINGLE, lw=1.0)
    axes.plot(true, predicted, ".", color=WORST, ms=4, alpha=0.7)
    axes.set_ylabel(f"predicted {_label(criterion)}", fontsize=9)
    errors.axhline(0.0, color=SINGLE, lw=1.0)
    errors.plot(true, predicted - true, ".", color=WORST, ms=4, alpha=0.7)
    errors.set_ylabel("predicted less simulated", fontsize=9)
    for panel in (axes, errors):
        panel.set_xlabel(f"simulated {_label(criterion)}", fontsize=9)
        _plain(panel)
    error = criterion["surrogate"]["generalisation"]
    _title(figure, f"The surrogate of {criterion['name']}: error {error:.1e} of the variance")
    figure.set_label(
        f"{len(true)} samples that were held out, predicted by a surrogate of the others. Everything is found on the "
        "surrogate of all samples: where the points lie far from the lines, it says little about the model."
    )
    return figure


def _panels(count: int, title: str) -> tuple[Figure, list[Axes]]:
    rows = -(-count // COLUMNS)
    figure = Figure(figsize=(COLUMNS * PANEL[0], rows * PANEL[1] + 0.9), layout="constrained")
    panels = list(figure.subplots(rows, COLUMNS, squeeze=False).ravel())
    for place, axes in enumerate(panels):
        axes.set_visible(place < count)
        _plain(axes)
        axes.xaxis.set_major_locator(MaxNLocator(4))
    _title(figure, title)
    return figure, panels[:count]


def _share_heights(panels: Sequence[Axes]) -> None:
    ends = np.array([axes.get_ylim() for axes in panels])
    for axes in panels:
        axes.set_ylim(ends[:, 0].min(), ends[:, 1].max())


def _name(axes: Axes, factor: Document) -> None:
    """Name and unit below a panel; a power of ten goes with the unit where the numbers would be long."""
    largest, unit = max(abs(factor["lower"]), abs(factor["upper"])), factor["unit"]
    exponent = int(np.floor(np.log10(largest))) if largest else 0
    if not PLAIN[0] <= exponent < PLAIN[1]:
        power = 3 * (exponent // 3)
        axes.xaxis.set_major_formatter(FuncFormatter(lambda value, place: f"{value / 10.0**power:g}"))
        unit = f"$10^{{{power}}}$ {unit}".rstrip()
    label = quantity_label(factor["name"], unit)
    axes.set_xlabel(label if len(label) <= LONGEST_LABEL else f"{factor['name']}\n[{unit}]", fontsize=9)


def _plain(axes: Axes) -> None:
    axes.spines[["top", "right"]].set_visible(False)
    axes.tick_params(labelsize=8, colors=INK)


def _title(figure: Figure, text: str) -> None:
    figure.suptitle(text, x=0.01, ha="left", fontsize=11, fontweight="bold", color=INK)


def _label(criterion: Document) -> str:
    return quantity_label(criterion["name"], criterion["unit"])


def _colours(count: int) -> list[str]:
    return [LINES[k % len(LINES)] for k in range(count)]


def _numbers(values: Sequence[float | None]) -> Any:
    return np.array([np.nan if value is None else value for value in values], dtype=float)
