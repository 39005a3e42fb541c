"""The figures of the study: mesh, deflection, force and energy, convergence."""

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from railsearch_plugins.track_models.imported_track.passage import simulate_passage

GROUND = {"ballast": "#B8A58C", "soft": "#E8D9B5", "stiff": "#9FB3C4"}
NAMES = {"ballast": "ballast", "soft": "soft soil", "stiff": "stiff ground"}
COLOURS = {"F_max": "#0072B2", "E_max": "#D55E00"}
NORMAL, SMALL = 10.0, 9.0
MAGNIFIED = 400.0
MILLI = 1e3
# Sleepers and rail are drawn this high above the ballast, in m.
SLEEPER, RAIL = 0.12, 0.3


def study_figures(problem, assembled, record):
    """Figures by name."""
    base = problem.simulated
    best = np.array(list(record["best"]["design"].values()), dtype=float)
    passing = base.figures({"reference": base.reference, "best": best})
    return {
        "mesh": mesh_figure(assembled),
        "deflection": deflection_figure(base, assembled),
        "force": passing["force"],
        "energy": passing["energy"],
        "convergence": convergence_figure(record),
    }


def mesh_figure(assembled):
    """The mesh with its materials, sleepers and rail; the pads that are designed in red."""
    figure, axes = _section_axes(assembled, 2.6)
    _draw_ground(axes, assembled, assembled.mesh.p)
    section = assembled.section
    pads = assembled.sleepers[np.argsort(np.abs(assembled.sleepers - section.jump))][: 2 * section.groups * section.in_group]
    axes.plot(assembled.sleepers, np.full(assembled.sleepers.size, SLEEPER), "s", color="#444444", ms=3.5, label="sleepers")
    axes.plot(pads, np.full(pads.size, 0.5 * (SLEEPER + RAIL)), "o", color="#D55E00", ms=3.0, label="designed pads")
    axes.plot([0.0, section.length], [RAIL, RAIL], color="#222222", lw=1.5, label="rail")
    _finish(axes, figure)
    return figure


def deflection_figure(base, assembled):
    """Track and ground, magnified, and the rail when the wheel stands over the jump."""
    parameters = base.track
    positions = simulate_passage(parameters).position
    step = int(np.argmin(np.abs(positions - assembled.section.jump)))
    made = simulate_passage(parameters, np.array([step]))
    # The export counts displacements upward, the passage downward: a linear track knows no difference.
    exported = np.empty(made.track.pattern.size)
    exported[made.track.pattern.order] = -made.passage.track_displacement[0]
    moved = np.stack([_at(exported, assembled.horizontal), _at(exported, assembled.vertical)])
    figure, axes = _section_axes(assembled, 4.2)
    axes.remove()
    down, section = figure.subplots(2, 1, sharex=True, height_ratios=(1.0, 2.0))
    rail = assembled.export.rail
    down.plot(rail[:, 0], MILLI * _at(exported, rail[:, 1].astype(int)), color="#222222", lw=1.5)
    down.axvline(positions[step], color="#D55E00", lw=1.0)
    down.set_ylabel("rail [mm]", fontsize=SMALL)
    down.grid(color="#E3E3E3", lw=0.6)
    _draw_ground(section, assembled, assembled.mesh.p + MAGNIFIED * moved)
    title = f"Wheel at {positions[step]:.2f} m, ground displacements magnified {MAGNIFIED:.0f} times, reference design"
    down.set_title(title, loc="left", fontsize=NORMAL)
    _finish(section, figure)
    return figure


def convergence_figure(record):
    """Every evaluation of the search, and the design with the best achievement so far, against the reference."""
    figure = Figure(figsize=(10.0, 4.0), layout="constrained")
    axes = figure.subplots()
    start, history = record["reference"]["metrics"], record["best"]["history"]
    for name, colour in COLOURS.items():
        values = np.array([row.get(name, np.nan) for row in record["evaluations"]]) / start[name]
        numbers = [entry["evaluation"] for entry in history] + [record["best"]["budget"]]
        best = [entry["metrics"][name] / start[name] for entry in history]
        axes.plot(np.arange(1, values.size + 1), values, "o", ms=3.0, color=colour, alpha=0.35, mew=0)
        axes.step(numbers, [*best, best[-1]], where="post", color=colour, label=f"{name} of the best design so far")
    axes.axhline(1.0, color="#888888", lw=0.8, ls=":")
    axes.set_xlabel("evaluation")
    axes.set_ylabel("value / reference")
    axes.set_ylim(0.0, 3.0)
    axes.grid(axis="y", color="#E3E3E3", lw=0.6)
    axes.legend(fontsize=SMALL, frameon=False)
    return figure


def _at(values, places):
    """Values of unknowns (k,), zero where they are held."""
    return np.where(places >= 0, values[places], 0.0)


def _section_axes(assembled, height):
    figure = Figure(figsize=(10.0, height), layout="constrained")
    return figure, figure.subplots()


def _draw_ground(axes, assembled, nodes):
    corners = nodes[:, assembled.mesh.t].transpose(2, 1, 0)
    for name, mask in assembled.materials.items():
        cells = PolyCollection(corners[mask], facecolor=GROUND[name], edgecolor="#777777", lw=0.15, label=NAMES[name])
        axes.add_collection(cells)


def _finish(axes, figure):
    axes.autoscale_view()
    axes.set_xlabel("position [m]", fontsize=SMALL)
    axes.set_ylabel("height [m]", fontsize=SMALL)
    axes.margins(x=0.01)
    figure.legend(*axes.get_legend_handles_labels(), loc="outside upper right", ncols=6, fontsize=SMALL, frameon=False)
