"""The marginal histograms of a sample: of its objectives and metrics, with quantiles, and of its variables."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure, SubFigure
from matplotlib.ticker import FuncFormatter, MaxNLocator

from railsearch.design_problem import DesignProblem
from railsearch.distributions import Marginal
from railsearch.interfaces import Evaluation, Quantity
from railsearch.result import quantities
from railsearch.samples import LEVELS, input_distributions, natural_values
from railsearch.space import FloatArray, Variable
from railsearch.wording import quantity_label

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Okabe & Ito's colours for all kinds of colour vision.
OUTPUT, INPUT, LINE = "#0072B2", "#999999", "#D55E00"
INK = "#1b1b1b"
PANEL = (2.7, 2.05)
COLUMNS = 4
MOST_BINS = 40
WHOLE_NUMBERS_SHOWN = 40
DENSITY_POINTS = 201
# A quantile's name is left out where it would stand on another one's: nearer than this share of the axis.
LABEL_GAP = 0.14
# Exponents of ten from and below which numbers are written out, and the letters that fit below a panel.
PLAIN = (-3, 5)
LONGEST_LABEL = 32
# The middle first: where there is no room for all names, it is the last to go.
LABELLED_FIRST = (50, 99, 1, 90)


def sample_figure(problem: DesignProblem, evaluations: Sequence[Evaluation]) -> Figure:
    """Draw the histograms of all finite values; lines are the quantiles, curves the distributions of the variables."""
    succeeded = [evaluation for evaluation in evaluations if not evaluation.failed]
    outputs, variables = quantities(problem), problem.space.variables
    rows = -(-len(outputs) // COLUMNS), -(-len(variables) // COLUMNS)
    figure = Figure(figsize=(COLUMNS * PANEL[0], sum(rows) * PANEL[1] + 1.1), layout="constrained")
    grid = figure.add_gridspec(2, 1, height_ratios=rows)
    above, below = figure.add_subfigure(grid[0]), figure.add_subfigure(grid[1])
    failed = len(evaluations) - len(succeeded)
    _title(above, f"Objectives and metrics of {problem.name}, {len(succeeded)} samples, {failed} failed")
    for axes, quantity in zip(_panels(above, rows[0], len(outputs)), outputs, strict=True):
        _draw_output(axes, quantity, natural_values(problem, succeeded, quantity.name))
    _title(below, f"Variables, {len(evaluations)} samples")
    designs = np.array([evaluation.design for evaluation in evaluations])
    marginals = input_distributions(problem).marginals.values()
    panels = _panels(below, rows[1], len(variables))
    for axes, variable, marginal, values in zip(panels, variables, marginals, designs.T, strict=True):
        _draw_input(axes, variable, marginal, values)
    figure.set_label(
        f"Histograms of all samples. Lines: quantiles at {', '.join(map(str, LEVELS))} %. Curves: the distributions that "
        "the variables were drawn from."
    )
    return figure


def _title(part: SubFigure, text: str) -> None:
    part.suptitle(text, x=0.01, ha="left", fontsize=11, fontweight="bold", color=INK)


def _panels(part: SubFigure, rows: int, count: int) -> list[Axes]:
    """The first `count` panels of a grid, the others not drawn; those on the left say what is counted."""
    panels = list(part.subplots(rows, COLUMNS, squeeze=False).ravel())
    for place, axes in enumerate(panels):
        axes.set_visible(place < count)
        axes.spines[["top", "right"]].set_visible(False)
        axes.tick_params(labelsize=8, colors=INK)
        axes.xaxis.set_major_locator(MaxNLocator(4))
        axes.yaxis.set_major_locator(MaxNLocator(3, integer=True))
        if place % COLUMNS == 0:
            axes.set_ylabel("samples", fontsize=8)
    return panels[:count]


def _draw_output(axes: Axes, quantity: Quantity, values: FloatArray) -> None:
    values = values[np.isfinite(values)]
    _label(axes, quantity.name, quantity.unit, values)
    if not values.size:
        axes.text(0.5, 0.5, "no values", transform=axes.transAxes, ha="center", fontsize=9, color=INK)
        return
    axes.hist(values, _edges(values).tolist(), color=OUTPUT, alpha=0.75, lw=0)
    low, high = axes.get_xlim()
    named: list[float] = []
    for level in LABELLED_FIRST:
        place = float(np.quantile(values, level / 100.0))
        axes.axvline(place, color=LINE, lw=1.4 if level == 50 else 0.9)
        if all(abs(place - other) > LABEL_GAP * (high - low) for other in named):
            named.append(place)
            where = axes.get_xaxis_transform()
            axes.text(place, 1.01, f"{level} %", transform=where, ha="center", va="bottom", fontsize=7.5, color=LINE)


def _draw_input(axes: Axes, variable: Variable, marginal: Marginal, values: FloatArray) -> None:
    _label(axes, variable.name, variable.unit, values)
    edges = _whole_edges(values) if variable.integer else _edges(values)
    axes.hist(values, edges.tolist(), color=INPUT, alpha=0.75, lw=0, rwidth=0.8 if variable.integer else None)
    if variable.integer:
        axes.xaxis.set_major_locator(MaxNLocator(4, integer=True))
    points = np.linspace(edges[0], edges[-1], DENSITY_POINTS)
    axes.plot(points, values.size * (edges[1] - edges[0]) * marginal.pdf(points), color=LINE, lw=1.2)
    axes.set_ylim(bottom=0.0)


def _label(axes: Axes, name: str, unit: str, values: FloatArray) -> None:
    """Name and unit below a panel; a power of ten goes with the unit where the numbers would be long."""
    largest = np.abs(values).max(initial=0.0)
    exponent = int(np.floor(np.log10(largest))) if largest else 0
    if not PLAIN[0] <= exponent < PLAIN[1]:
        power = 3 * (exponent // 3)
        axes.xaxis.set_major_formatter(FuncFormatter(lambda value, place: f"{value / 10.0**power:g}"))
        unit = f"$10^{{{power}}}$ {unit}".rstrip()
    label = quantity_label(name, unit)
    axes.set_xlabel(label if len(label) <= LONGEST_LABEL else f"{name}\n[{unit}]", fontsize=9)


def _edges(values: FloatArray) -> FloatArray:
    """The borders of bins of one width, as many as Freedman & Diaconis (1981) advise, but no more than can be seen."""
    return np.histogram_bin_edges(values, min(MOST_BINS, len(np.histogram_bin_edges(values, "auto")) - 1))


def _whole_edges(values: FloatArray) -> FloatArray:
    """Borders of bins around every whole number, or around several ones where there are too many."""
    low, high = values.min(), values.max()
    step = -(-(high - low + 1.0) // WHOLE_NUMBERS_SHOWN)
    return np.arange(low - 0.5, high + 0.5 + step, step)
