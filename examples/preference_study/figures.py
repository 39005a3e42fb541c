"""The figures of the study."""

import numpy as np
from matplotlib.figure import Figure

from examples.preference_study.record import worst_score
from examples.preference_study.tables import compromises
from railsearch.preferences import scores
from railsearch.report.preferences import preference_figure
from railsearch.result import stated_preferences

# Okabe & Ito's colours for all kinds of colour vision.
COLOURS = {"E_max": "#D55E00", "A_max": "#0072B2", "C_cap": "#009E73"}
SMALL, NORMAL = 9.0, 10.0


def study_figures(problem, record, points):
    """Preference curves with the compromise; scores of all designs; points; histories; the compromise along the track.

    problem: design problem B, scalarised by the own preferences; points: what the surrogates were fitted to, by column.
    """
    best = _best(record, "own")
    passing = problem.figures({"no measures": problem.reference, "compromise": _vector(best)})
    marked = {"compromise": best["metrics"], record["designs"][0]["label"]: record["designs"][0]["metrics"]}
    return {
        "preferences": preference_figure(stated_preferences(problem), marked),
        "scores": _scores(record, "own"),
        "points": _points(stated_preferences(problem), record, best, points),
        "histories": _histories(record),
        **passing,
    }


def _best(record, name):
    """The compromise with the highest worst score over all routes."""
    return max(compromises(record, name).values(), key=lambda entry: worst_score(entry, name))


def _vector(entry):
    return np.array(list(entry["design"].values()), dtype=float)


def _scores(record, name):
    """The scores of every design, objective by objective; a line under each at its worst one."""
    entries = {entry["label"]: entry for entry in record["designs"]} | compromises(record, name)
    figure = Figure(figsize=(10.0, 4.4), layout="constrained")
    axes = figure.subplots()
    width = 0.8 / len(COLOURS)
    for row, (objective, colour) in enumerate(COLOURS.items()):
        heights = [entry["scores"][name][objective] for entry in entries.values()]
        places = np.arange(len(entries)) + (row - 1) * width
        axes.bar(places, heights, width, color=colour, label=objective)
    for column, entry in enumerate(entries.values()):
        worst = worst_score(entry, name)
        axes.plot([column - 0.45, column + 0.45], [worst, worst], color="#222222", lw=1.2)
        axes.text(column, 102.0, f"{worst:.1f}", ha="center", va="bottom", fontsize=SMALL, weight="bold")
    axes.set_xticks(range(len(entries)), [label.replace(" ", "\n", 1) for label in entries], fontsize=SMALL)
    axes.set_ylim(0.0, 122.0)
    axes.set_ylabel("score")
    axes.set_title(
        f"Scores by the {name} ranges; the line and the number are the worst of a design", loc="left", fontsize=NORMAL
    )
    axes.legend(fontsize=SMALL, frameon=False, ncols=3, loc="upper left")
    return figure


def _points(preferences, record, best, points):
    """The points in the plane of the simulated objectives, coloured by their worst score; compromise and optima marked."""
    figure = Figure(figsize=(10.0, 4.6), layout="constrained")
    axes = figure.subplots()
    worst = scores(preferences, points).min(axis=1)
    order = np.argsort(worst)
    drawn = axes.scatter(points["A_max"][order], points["E_max"][order], c=worst[order], s=9, lw=0, cmap="viridis")
    figure.colorbar(drawn, ax=axes, label="worst score")
    for entry, marker in zip([*record["designs"], best | {"label": "compromise"}], "osD^vX", strict=True):
        place = entry["metrics"]["A_max"], entry["metrics"]["E_max"]
        axes.plot(*place, marker, ms=9, color="#D55E00", mec="white", label=entry["label"])
    axes.set_xlabel("A_max [m/s²]")
    axes.set_ylabel("E_max [N·m]")
    figure.legend(fontsize=SMALL, loc="outside lower center", ncols=6, frameon=False)
    return figure


def _histories(record):
    """The worst score of the best design so far, by the own and by the published ranges."""
    figure = Figure(figsize=(10.0, 3.8), layout="constrained")
    axes = figure.subplots()
    for name, style in zip(record["preferences"], ("-", "--"), strict=True):
        optimum = record["found"]["direct"][name]
        numbers = [entry["evaluation"] for entry in optimum["history"]]
        values = [100.0 - entry["value"] for entry in optimum["history"]]
        axes.step(
            [*numbers, optimum["budget"]],
            [*values, values[-1]],
            where="post",
            color="#222222",
            ls=style,
            label=f"direct search, {name} ranges",
        )
    axes.set_xlabel("evaluation")
    axes.set_ylabel("worst score of the best design so far")
    axes.grid(axis="y", color="#E3E3E3", lw=0.6)
    axes.legend(fontsize=SMALL, frameon=False)
    return figure
