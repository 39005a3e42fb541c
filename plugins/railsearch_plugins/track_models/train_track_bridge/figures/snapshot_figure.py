"""Train, track and bridge at one time: a drawing with displacements exaggerated, and below it the displacements in mm."""

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from railsearch_plugins.passage_figures.panels import LEFT, NORMAL, RIGHT, SMALL, TITLE, WIDTH
from railsearch_plugins.passage_figures.passage import within
from railsearch_plugins.track_models.train_track_bridge.figures.bridge_passage import (
    ALONG,
    MILLI,
    BridgePassage,
    shade_bridge,
    with_bridge,
)
from railsearch_plugins.track_models.train_track_bridge.figures.snapshot_drawing import (
    BENCH,
    CARBODY_TOP,
    SUPPORT,
    Scene,
    carbody_half_length,
    draw_scene,
)
from railsearch_plugins.track_models.train_track_bridge.figures.snapshot_state import TrainState, train_state

LARGEST_DRAWN = 1.0
BEYOND_BRIDGE, BEYOND_TRAIN, SKY = 6.0, 1.5, 0.6
HEADER, BLOCK_TITLE, GAP, CURVES, AXIS, FOOTER = 0.55, 0.3, 0.1, 1.35, 0.62, 0.3
RAIL, SLEEPER, BALLAST, BRIDGE = "#222222", "#D55E00", "#B08D57", "#0072B2"


def snapshot_figure(passages: Sequence[BridgePassage]) -> Figure:
    """A block for every passage: the drawing to scale, and the displacements of rail, sleepers, ballast and bridge."""
    scenes = _scenes(passages)
    drawing = max(_drawing_height(scene) for scene in scenes)
    block = BLOCK_TITLE + drawing + GAP + CURVES + AXIS
    height = HEADER + len(scenes) * block + FOOTER
    figure = Figure(figsize=(WIDTH, height))
    figure.text(LEFT / WIDTH, 1.0 - 0.35 / height, "Train, track and bridge at one time", fontsize=TITLE, weight="bold")
    for row, scene in enumerate(scenes):
        top = height - HEADER - row * block
        _draw_block(figure, scene, top, drawing)
    handles, labels = figure.axes[1].get_legend_handles_labels()
    place = LEFT / WIDTH, 0.2 / height
    figure.legend(
        handles,
        labels,
        loc="center left",
        bbox_to_anchor=place,
        ncols=len(labels),
        fontsize=SMALL,
        frameon=False,
        borderaxespad=0.0,
    )
    figure.set_label(_caption(scenes))
    return figure


def exaggeration(largest: float) -> float:
    """The largest of 1, 2, 5, 10, … by which a `largest` displacement in m stays within LARGEST_DRAWN."""
    if largest <= 0.0:
        return 1.0
    decade = 10.0 ** math.floor(math.log10(LARGEST_DRAWN / largest))
    return max(step * decade for step in (1.0, 2.0, 5.0) if step * decade * largest <= LARGEST_DRAWN)


def _scenes(passages: Sequence[BridgePassage]) -> list[Scene]:
    """All passages with one factor and one view."""
    trains = [train_state(passage) for passage in passages]
    view = _view(passages, trains)
    largest = max(_largest(passage, train, view) for passage, train in zip(passages, trains, strict=True))
    factor = exaggeration(largest)
    return [Scene(passage, train, factor, view) for passage, train in zip(passages, trains, strict=True)]


def _view(passages: Sequence[BridgePassage], trains: Sequence[TrainState]) -> tuple[float, float]:
    """From the back of the last train or the bridge to the front of the first or beyond the bridge, in m."""
    half = max(carbody_half_length(passage) for passage in passages) + BEYOND_TRAIN
    centres = [carbody.centre for train in trains for carbody in train.carbodies]
    span = max(passage.span for passage in passages)
    return min(-BEYOND_BRIDGE, min(centres) - half), max(span + BEYOND_BRIDGE, max(centres) + half)


def _largest(passage: BridgePassage, train: TrainState, view: tuple[float, float]) -> float:
    """The largest displacement that is drawn, in m."""
    half = carbody_half_length(passage)
    ends = [abs(carbody.lowered(carbody.centre + end)) for carbody in train.carbodies for end in (-half, half)]
    rail = passage.history("snapshot_rail_displacement")[within(passage.history("rail_position"), view)]
    bridge = passage.history("snapshot_bridge_deflection")
    return float(max(*ends, np.abs(rail).max(), np.abs(bridge).max()))


def _limits(scene: Scene) -> tuple[float, float]:
    """Lowest and highest place of a drawing in m."""
    return scene.girder_bottom - SUPPORT - BENCH, CARBODY_TOP + LARGEST_DRAWN + SKY


def _drawing_height(scene: Scene) -> float:
    """Height in inches that makes the scale of a drawing the same in length and height."""
    low, high = _limits(scene)
    return (high - low) * (WIDTH - LEFT - RIGHT) / (scene.view[1] - scene.view[0])


def _draw_block(figure: Figure, scene: Scene, top: float, drawing: float) -> None:
    """Title, drawing and curves of one passage, from `top` in inches downwards."""
    width, height = WIDTH - LEFT - RIGHT, figure.get_figheight()
    foot = top - BLOCK_TITLE - drawing
    words = figure.text(LEFT / WIDTH, (top - 0.16) / height, f"{scene.passage.label}:  {_moment(scene)}", fontsize=NORMAL)
    words.set(color=scene.passage.colour, weight="bold")
    axes = figure.add_axes((LEFT / WIDTH, foot / height, width / WIDTH, _drawing_height(scene) / height))
    axes.set_xlim(*scene.view)
    axes.set_ylim(*_limits(scene))
    axes.set_aspect("equal")
    draw_scene(axes, scene)
    size = LEFT / WIDTH, (foot - GAP - CURVES) / height, width / WIDTH, CURVES / height
    first = figure.axes[1] if len(figure.axes) > 1 else None
    _draw_curves(figure.add_axes(size, sharex=axes, sharey=first), scene)


def _draw_curves(axes: Axes, scene: Scene) -> None:
    """Displacements in mm, downward: rail with the places of the wheels, sleepers, ballast off the bridge, bridge."""
    passage = scene.passage
    sleepers, step = passage.history("sleeper_position"), passage.snapshot_step
    off = ~within(sleepers, (0.0, passage.span))
    ballast = passage.history("snapshot_ballast_displacement")[off] / MILLI
    bridge = passage.history("snapshot_bridge_deflection") / MILLI
    axes.plot(passage.history("rail_position"), passage.history("snapshot_rail_displacement") / MILLI, color=RAIL, lw=1.2,
              label="rail")  # fmt: skip
    under = passage.history("rail_displacement")[step] / MILLI
    axes.plot(
        scene.train.axles, under, "o", color=RAIL, markerfacecolor="white", markersize=5, label="rail under the wheels"
    )
    sleeper = passage.history("snapshot_sleeper_displacement") / MILLI
    axes.plot(sleepers, sleeper, "s", color=SLEEPER, markersize=2.5, label="sleepers")
    axes.plot(sleepers[off], ballast, "^", color=BALLAST, markersize=2.5, label="ballast beside the bridge")
    axes.plot(passage.history("bridge_position"), bridge, color=BRIDGE, lw=1.8, label="bridge")
    shade_bridge([axes], 0.0, passage.span)
    axes.yaxis.set_inverted(True)
    axes.set_ylabel("Displacement [mm]", fontsize=SMALL)
    axes.set_xlabel(with_bridge(ALONG, [passage]), fontsize=NORMAL, labelpad=1)
    axes.tick_params(labelsize=SMALL)
    axes.grid(axis="y", color="#E3E3E3", lw=0.6)
    axes.set_axisbelow(True)


def _moment(scene: Scene) -> str:
    """When it is, and where the train is."""
    time = float(scene.passage.history("snapshot_time")[0])
    return f"{time:.3f} s after the start, first axle at {scene.train.axles[0]:.2f} m"


def _caption(scenes: Sequence[Scene]) -> str:
    moments = "; ".join(f"{scene.passage.label}: {_moment(scene)}" for scene in scenes)
    return (
        "The train, to scale in length and height and running to the right, with all displacements "
        f"{scenes[0].factor:g} times as large: of track and bridge from where they are without a train, of the vehicles "
        "from where they would stand on that track with its irregularity (carbodies: dotted). Heights of vehicles, "
        f"sleepers, ballast and girder are usual ones. Below, the displacements themselves, downward. {moments}."
    )
