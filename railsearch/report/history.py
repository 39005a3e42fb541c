"""The history of a search: every evaluation by origin, the best so far, the incumbent, resets and failures."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from railsearch.design_problem import DesignProblem
from railsearch.interfaces import Evaluation, Quantity
from railsearch.result import reference_evaluation
from railsearch.run import front
from railsearch.space import FloatArray

Mask = NDArray[np.bool_]

# Okabe & Ito's colours for all kinds of colour vision; an origin keeps its colour from run to run.
KNOWN_ORIGINS = {
    "given": ("#000000", "*"),
    "initial": ("#999999", "o"),
    "perturbation": ("#0072B2", "o"),
    "tree-search": ("#D55E00", "^"),
    "offspring": ("#0072B2", "o"),
    "random": ("#56B4E9", "o"),
    "unseen": ("#CC79A7", "D"),
}
OTHER_ORIGINS = (("#009E73", "s"), ("#E69F00", "v"), ("#56B4E9", "P"), ("#CC79A7", "X"))
SHARE_SHOWN = 0.9
ROOM = 0.6
WIDE_RANGE = 100.0
# matplotlib.markers.CARETUPBASE: a triangle that stands below its point.
BEYOND_EDGE: Final = 6
HOLLOW_BEYOND_EDGE: Final = "^"
# Labels that begin with an underscore stay out of the legend.
BEYOND = "_beyond"
LEAST = "least so far"
LABEL_BOX = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.0}


def history_figure(problem: DesignProblem, evaluations: Sequence[Evaluation]) -> Figure:
    """Draw the history: values over evaluations for one objective; the objective space for two; a panel each for more.

    Where designs were evaluated and none is feasible, their violations over the evaluations.
    """
    violations = not any(evaluation.feasible for evaluation in evaluations) and _has_infeasible(evaluations)
    count = 1 if violations else len(problem.objectives)
    figure = Figure(figsize=(10.0, 4.8 if count < 3 else 1.2 + 2.4 * count), layout="constrained")
    figure.suptitle("Search history", x=0.01, ha="left", fontsize=12, fontweight="bold")
    if violations:
        _draw_violations(figure.subplots(), evaluations)
    elif count == 2:
        _draw_objective_space(figure.subplots(), problem, evaluations)
    else:
        for axes, position in zip(figure.subplots(count, squeeze=False)[:, 0], range(count), strict=True):
            _draw_values(axes, problem, evaluations, position)
    figure.set_label(_caption(figure, evaluations))
    return figure


def _caption(figure: Figure, evaluations: Sequence[Evaluation]) -> str:
    """What the marks mean that are in the figure."""
    marks = {artist.get_label() for axes in figure.axes for artist in (*axes.lines, *axes.collections)}
    space = any(str(mark).startswith("front of") for mark in marks)
    kinds = {str(mark).partition(" (")[0] for mark in marks}
    told = [
        ("Every evaluation by how it came about", True),
        (", in the space of both objectives, and the front of designs that no other one dominates", space),
        ("; the line is the best so far", "best so far" in kinds),
        (", the dashed line the incumbent, the best since the last reset", "incumbent" in kinds),
        (
            "; none is feasible. Drawn is by how much each violates the constraints, summed; the line is the least so far",
            LEAST in kinds,
        ),
        (". Hollow marks are infeasible designs", _has_infeasible(evaluations)),
        (". Triangles stand for values beyond the edge", BEYOND in kinds),
        (". Crosses at the lower edge stand for failed evaluations", "failed" in kinds),
    ]
    return "".join(words for words, there in told if there) + "."


def incumbents(evaluations: Sequence[Evaluation], values: FloatArray) -> FloatArray:
    """The best value (n,) since the last reset, at every evaluation; NaN as long as there is none."""
    trajectories = np.array([evaluation.trajectory for evaluation in evaluations])
    best = np.full(values.size, np.nan)
    for trajectory in np.unique(trajectories):
        inside = trajectories == trajectory
        best[inside] = np.fmin.accumulate(values[inside])
    return best


def resets(evaluations: Sequence[Evaluation]) -> list[int]:
    """The numbers, from 1, of the evaluations with which a new trajectory begins."""
    return [after.number + 1 for before, after in pairwise(evaluations) if after.trajectory > before.trajectory]


def upper_limit(values: FloatArray) -> float:
    """Where the picture ends, so that a few bad values do not squash the rest."""
    low, high, top = values.min(), np.quantile(values, SHARE_SHOWN), values.max()
    limit = high + ROOM * (high - low)
    return float(top if limit >= top or limit <= low else limit)


def _draw_values(axes: Axes, problem: DesignProblem, evaluations: Sequence[Evaluation], position: int) -> None:
    values = np.array([e.objectives[position] for e in evaluations])
    feasible = np.where([e.feasible for e in evaluations], values, np.nan)
    sign = problem.objectives[position].sign
    numbers = np.arange(1.0, values.size + 1.0)
    if np.isfinite(feasible).any():
        low, limit = _window(feasible, values)
        shown = np.clip(values, low, limit)
        _draw_origins(axes, evaluations, numbers, sign * shown, np.abs(shown - values) > 0.0)
        axes.step(
            numbers, sign * np.fmin.accumulate(feasible), where="post", color="black", lw=1.6, label="best so far", zorder=4
        )
        if resets(evaluations):
            best = sign * np.minimum(incumbents(evaluations, feasible), limit)
            axes.step(numbers, best, where="post", color="black", lw=1.0, ls="--", label="incumbent", zorder=3)
    _mark_resets(axes, evaluations)
    _mark_failures(axes, evaluations)
    axes.set(xlabel="evaluation", ylabel=_axis_label(problem.objectives[position]), xlim=(0, values.size + 1))
    _legend(axes)


def _draw_violations(axes: Axes, evaluations: Sequence[Evaluation]) -> None:
    values = np.array([evaluation.violation for evaluation in evaluations])
    numbers = np.arange(1.0, values.size + 1.0)
    known = values[np.isfinite(values)]
    wide = known.max() > WIDE_RANGE * known.min()
    limit = np.inf if wide else upper_limit(known)
    _draw_origins(axes, evaluations, numbers, np.minimum(values, limit), values > limit)
    axes.step(numbers, np.fmin.accumulate(values), where="post", color="black", lw=1.6, label=LEAST, zorder=4)
    _mark_resets(axes, evaluations)
    _mark_failures(axes, evaluations)
    axes.set(
        xlabel="evaluation",
        ylabel="violation of the constraints",
        xlim=(0, values.size + 1),
        yscale="log" if wide else "linear",
    )
    _legend(axes)


def _window(feasible: FloatArray, values: FloatArray) -> tuple[float, float]:
    """Between which values (n,) the picture is, so that all good feasible ones are in it; NaN where there is none."""
    known = feasible[np.isfinite(feasible)]
    low, limit = float(known.min()), upper_limit(known)
    if limit <= low:
        known = values[np.isfinite(values)]
        return float(known.min()), max(low, upper_limit(known))
    return low - ROOM * (limit - low), limit


def _draw_objective_space(axes: Axes, problem: DesignProblem, evaluations: Sequence[Evaluation]) -> None:
    made = [evaluation for evaluation in evaluations if not evaluation.failed]
    if made:
        _draw_made(axes, problem, made)
    failed = sum(evaluation.failed for evaluation in evaluations)
    axes.set(xlabel=_axis_label(problem.objectives[0]), ylabel=_axis_label(problem.objectives[1]))
    axes.set_title(f"{len(evaluations)} evaluations, {failed} failed", loc="left", fontsize=10)
    _legend(axes)


def _draw_made(axes: Axes, problem: DesignProblem, evaluations: Sequence[Evaluation]) -> None:
    """Points by origin, the front as a line, and the reference design by name."""
    signs = np.array([quantity.sign for quantity in problem.objectives])
    values = np.array([evaluation.objectives for evaluation in evaluations])
    feasible = values[[evaluation.feasible for evaluation in evaluations]]
    members = np.array(sorted(tuple(member.objectives) for member in front(evaluations)))
    lows, limits = np.array([_axis_window(axes, row, signs[row], feasible[:, row], values[:, row]) for row in range(2)]).T
    limits = np.maximum(limits, members.max(axis=0))
    shown = np.clip(values, lows, limits)
    x, y = (signs * shown).T
    _draw_origins(axes, evaluations, x, y, np.any(shown != values, axis=1))
    label = f"front of {len(members)}"
    axes.step(*(signs * members).T, where="post", color="black", lw=1.4, label=label, zorder=4)
    reference = reference_evaluation(problem, evaluations)
    if reference is not None:
        right, up = signs * np.clip(reference.objectives, lows, limits)
        axes.annotate("reference", (right, up), (8, 8), textcoords="offset points", fontsize=10, zorder=7, bbox=LABEL_BOX)


def _axis_window(axes: Axes, row: int, sign: float, feasible: FloatArray, values: FloatArray) -> tuple[float, float]:
    """Where an axis of the objective space ends, for values (n,) as they are minimised; nowhere if it is logarithmic."""
    natural = sign * values
    if natural.min() > 0.0 and natural.max() > WIDE_RANGE * natural.min():
        axes.set(**{"xscale" if row == 0 else "yscale": "log"})
        return -np.inf, np.inf
    return _window(feasible, values)


def _draw_origins(axes: Axes, evaluations: Sequence[Evaluation], x: FloatArray, y: FloatArray, beyond: Mask) -> None:
    """Points by origin, hollow where a design is infeasible, triangles where a value lies beyond the edge."""
    origins = list(dict.fromkeys(evaluation.origin for evaluation in evaluations))
    others = iter(OTHER_ORIGINS * len(origins))
    of = np.array([evaluation.origin for evaluation in evaluations])
    feasible = np.array([evaluation.feasible for evaluation in evaluations])
    there = np.isfinite(y)
    for origin in origins:
        colour, marker = KNOWN_ORIGINS.get(origin) or next(others)
        size, level = (110, 6) if marker == "*" else (22, 5)
        filled: dict[str, Any] = {"color": colour, "linewidths": 0, "zorder": level}
        hollow: dict[str, Any] = {"facecolors": "none", "edgecolors": colour, "linewidths": 0.8, "zorder": level}
        mine = (of == origin) & there
        label: str | None = f"{origin} ({np.count_nonzero(of == origin)})"
        kinds: tuple[tuple[Any, Mask, Any], ...] = (
            (filled, mine & feasible, BEYOND_EDGE),
            (hollow, mine & ~feasible, HOLLOW_BEYOND_EDGE),
        )
        for look, kind, edge in kinds:
            inside, outside = kind & ~beyond, kind & beyond
            if kind.any():
                axes.scatter(x[inside], y[inside], s=size, marker=marker, label=label, **look)
                label = None
            if outside.any():
                axes.scatter(x[outside], y[outside], s=22, marker=edge, label=BEYOND, **look)


def _has_infeasible(evaluations: Sequence[Evaluation]) -> bool:
    return any(not evaluation.failed and not evaluation.feasible for evaluation in evaluations)


def _mark_resets(axes: Axes, evaluations: Sequence[Evaluation]) -> None:
    for number in resets(evaluations):
        axes.axvline(number - 0.5, color="#CC79A7", lw=1.0)
        axes.annotate(
            f"reset at {number}",
            (number - 0.5, 1.0),
            xycoords=("data", "axes fraction"),
            xytext=(3, -3),
            textcoords="offset points",
            rotation=90,
            va="top",
            fontsize=9,
            color="#8C4A70",
            zorder=7,
            bbox=LABEL_BOX,
        )


def _mark_failures(axes: Axes, evaluations: Sequence[Evaluation]) -> None:
    failed = [evaluation.number + 1 for evaluation in evaluations if evaluation.failed]
    if failed:
        place = axes.get_xaxis_transform()
        axes.scatter(
            failed,
            [0.02] * len(failed),
            s=28,
            c="#D55E00",
            marker="x",
            transform=place,
            label=f"failed ({len(failed)})",
            zorder=6,
        )


def _legend(axes: Axes) -> None:
    axes.grid(alpha=0.3)
    axes.spines[["top", "right"]].set_visible(False)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, fontsize=10)


def _axis_label(quantity: Quantity) -> str:
    return f"{quantity.name} [{quantity.unit}]" if quantity.unit else quantity.name
