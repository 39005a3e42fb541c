"""The figures of the study."""

import numpy as np
from matplotlib.figure import Figure

from railsearch.problem_factory import ProblemSettings, make_problem

# Okabe & Ito's colours for all kinds of colour vision.
COLOURS = {"F_rms": "#56B4E9", "F_max": "#0072B2", "E_rms": "#E69F00", "E_max": "#D55E00", "asf": "#009E73"}
SMALL, NORMAL = 9.0, 10.0
# Designs before the search proper; the background of the histories is grey until then.
INITIAL = 20.0


def study_figures(registry, record):
    """Histories; mean levels against ranges; force and energy of the reference and the optima along the track."""
    problem = make_problem(registry, ProblemSettings("level-crossing", (), record["sections"]))
    designs = {"reference": problem.reference} | {
        f"best {optimum['label']}": np.array(list(optimum["design"].values()), dtype=float) for optimum in record["optima"]
    }
    passing = problem.figures({label: designs[label] for label in ("reference", "best F_max", "best E_max", "best asf")})
    return {
        "histories": _histories(record),
        "measures": _measures(record),
        "force": passing["force"],
        "energy": problem.figures(designs)["energy"],
    }


def _histories(record):
    """Best so far against the reference: every measure by its own search, and both objectives by that of their scalar."""
    figure = Figure(figsize=(10.0, 4.4), layout="constrained")
    alone, both = figure.subplots(1, 2, sharey=True)
    *single, asf = record["optima"]
    for optimum in single:
        _draw_history(alone, record, optimum, optimum["label"])
    for name in ("F_max", "E_max"):
        _draw_history(both, record, asf, name)
    alone.set_title("The best so far of every measure, each by a search of its own", loc="left", fontsize=NORMAL)
    both.set_title("F_max and E_max of the design with the best asf so far", loc="left", fontsize=NORMAL)
    alone.set_ylabel("value / reference")
    for axes in (alone, both):
        axes.set_xlabel("evaluation")
        axes.axhline(1.0, color="#888888", lw=0.8, ls=":")
        axes.axvspan(0.0, INITIAL, color="#EEEEEE", lw=0.0, zorder=0)
        axes.set_xlim(left=0.0)
        axes.grid(axis="y", color="#E3E3E3", lw=0.6)
        axes.legend(fontsize=SMALL, frameon=False)
    return figure


def _draw_history(axes, record, optimum, name):
    start = record["reference"]["metrics"][name]
    numbers = [entry["evaluation"] for entry in optimum["history"]]
    values = [entry["metrics"][name] / start for entry in optimum["history"]]
    axes.step([*numbers, optimum["budget"]], [*values, values[-1]], where="post", color=COLOURS[name], label=name)


def _measures(record):
    """The measures of random designs against the reference, and those of the optima."""
    figure = Figure(figsize=(10.0, 4.4), layout="constrained")
    sampled, found = figure.subplots(1, 2)
    names, start = list(record["measures"]), record["reference"]["metrics"]
    generator = np.random.default_rng(1)
    for column, name in enumerate(names):
        values = np.array(record["random"]["values"][name]) / start[name]
        places = column + generator.uniform(-0.25, 0.25, values.size)
        sampled.plot(places, values, "o", ms=3.5, color=COLOURS[name], alpha=0.6, mew=0)
    sampled.set_title(f"{record['random']['number']} random designs", loc="left", fontsize=NORMAL)
    width = 0.8 / len(record["optima"])
    for row, optimum in enumerate(record["optima"]):
        heights = [optimum["metrics"][name] / start[name] for name in names]
        places = np.arange(len(names)) + (row - 0.5 * (len(record["optima"]) - 1)) * width
        found.bar(places, heights, width, color=COLOURS[optimum["label"]], label=f"optimum of {optimum['label']}")
    found.set_title("The optima", loc="left", fontsize=NORMAL)
    found.legend(fontsize=SMALL, frameon=False)
    for axes in (sampled, found):
        axes.set_xticks(range(len(names)), names)
        axes.set_ylabel("value / reference")
        axes.axhline(1.0, color="#888888", lw=0.8, ls=":")
        axes.grid(axis="y", color="#E3E3E3", lw=0.6)
        axes.set_axisbelow(True)
    return figure
