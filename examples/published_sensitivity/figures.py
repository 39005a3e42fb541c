"""The figures of the study: importances with error bars, convergence with samples, finer grids, the camel's curves."""

import numpy as np
from matplotlib.figure import Figure

COLOURS = {"pce": "#0072B2", "pck": "#D55E00", "kriging": "#009E73"}
OFFSETS = {"pce": -0.22, "pck": 0.0, "kriging": 0.22}
DASHES = {"pce": "-", "pck": (0, (4, 4)), "kriging": "-"}
INK, NORMAL = "#1b1b1b", 9.0
TOP = "maximum"
SHOWN = ("E1", "A1", "P3", "P2", "A2", "P1")
LEAST = 1e-12


def study_figures(record):
    """Figures by name."""
    return {
        "importances": importance_figure(record),
        "convergence": convergence_figure(record),
        "grids": grid_figure(record),
        "camel": camel_figure(record),
    }


def importance_figure(record):
    """Importances of the truss over the number of samples: mean and standard deviation over the designs."""
    true, entries = record["exact"]["truss"]["importances"][TOP], _of(record, "truss")
    sizes = sorted({entry["samples"] for entry in entries})
    figure = Figure(figsize=(9.0, 5.0), layout="constrained")
    for axes, name in zip(figure.subplots(2, 3).ravel(), SHOWN, strict=True):
        axes.axhline(true[name], color=INK, lw=0.8)
        for entry in entries:
            values, key = np.array(entry["importances"][TOP][name]), entry["surrogate"]
            place = sizes.index(entry["samples"]) + OFFSETS[key]
            axes.errorbar(place, values.mean(), values.std(), fmt="o", ms=3, capsize=3, color=COLOURS[key], lw=1.2)
        axes.set_xticks(range(len(sizes)), sizes)
        axes.set_xlim(-0.5, len(sizes) - 0.5)
        axes.set_title(name, loc="left", fontsize=NORMAL + 1)
        _plain(axes)
    figure.supxlabel("samples", fontsize=NORMAL)
    figure.supylabel("importance in the largest deflection", fontsize=NORMAL)
    handles = [axes.plot([], [], "o", color=colour, label=name)[0] for name, colour in COLOURS.items()]
    figure.legend(handles=handles, loc="outside upper right", ncols=3, fontsize=NORMAL, frameon=False)
    return figure


def convergence_figure(record):
    """The largest error of an importance and of a curve over the number of samples: median, and range over the designs."""
    figure = Figure(figsize=(9.0, 3.6), layout="constrained")
    titles = {"largest_error": "error of an importance", "largest_curve_error": "error of a curve, of the range"}
    for axes, (key, title) in zip(figure.subplots(1, 2), titles.items(), strict=True):
        for name, colour in COLOURS.items():
            entries = [entry for entry in _of(record, "truss") if entry["surrogate"] == name]
            sizes, values = [entry["samples"] for entry in entries], [np.maximum(entry[key], LEAST) for entry in entries]
            axes.fill_between(sizes, [v.min() for v in values], [v.max() for v in values], color=colour, alpha=0.15, lw=0)
            axes.plot(sizes, [np.median(v) for v in values], "o-", color=colour, ms=4, label=name)
        axes.set_yscale("log")
        axes.set_xlabel("samples", fontsize=NORMAL)
        axes.set_title(title, loc="left", fontsize=NORMAL + 1)
        axes.grid(color="#E3E3E3", lw=0.6)
        _plain(axes)
    axes.legend(fontsize=NORMAL, frameon=False)
    return figure


def grid_figure(record):
    """How far importances are from those of the finest equal grid, over the number of grid values."""
    figure = Figure(figsize=(9.0, 3.6), layout="constrained")
    entries = record["grids"]
    finest = max((entry for entry in entries if entry["spacing"] == "equal"), key=lambda entry: entry["points"])
    kinds = {"importances": "weighted by the distance of neighbours", "unweighted": "all grid values alike"}
    panels = figure.subplots(1, 2, sharey=True)
    for axes, (key, title) in zip(panels, kinds.items(), strict=True):
        for spacing, style in (("logarithmic", "o-"), ("equal", "s--")):
            rows = [entry for entry in entries if entry["spacing"] == spacing and entry is not finest]
            errors = [max(abs(row[key][name] - share) for name, share in finest["importances"].items()) for row in rows]
            axes.loglog([row["points"] for row in rows], errors, style, ms=4, color=INK, label=f"{spacing} grids")
        axes.set_title(title, loc="left", fontsize=NORMAL + 1)
        axes.set_xlabel("grid values of each input", fontsize=NORMAL)
        axes.set_xticks([row["points"] for row in rows], [row["points"] for row in rows], minor=False)
        axes.minorticks_off()
        axes.grid(color="#E3E3E3", lw=0.6)
        _plain(axes)
    panels[0].set_ylabel("largest error of an importance", fontsize=NORMAL)
    axes.legend(fontsize=NORMAL, frameon=False)
    return figure


def camel_figure(record):
    """Extreme curves of the camel: true ones, and those of a surrogate of the first design."""
    figure = Figure(figsize=(9.0, 5.6), layout="constrained")
    curves = record["exact"]["camel"]["curves"]
    cells = [(sense, name) for sense in curves for name in curves[sense]]
    for axes, (sense, name) in zip(figure.subplots(2, 2).ravel(), cells, strict=True):
        grid = record["camel_values"][name]
        axes.plot(grid, curves[sense][name], color=INK, lw=3.0, alpha=0.25, label="true function")
        for entry in _of(record, "camel"):
            key = entry["surrogate"]
            axes.plot(grid, entry["curves"][sense][name], color=COLOURS[key], ls=DASHES[key], lw=1.2, label=key)
        axes.set_xlabel(name, fontsize=NORMAL)
        axes.set_title(f"{sense} of f", loc="left", fontsize=NORMAL + 1)
        _plain(axes)
    axes.legend(fontsize=NORMAL, frameon=False)
    return figure


def _of(record, case):
    return [entry for entry in record["surrogates"] if entry["case"] == case]


def _plain(axes):
    axes.spines[["top", "right"]].set_visible(False)
    axes.tick_params(labelsize=NORMAL - 1)
