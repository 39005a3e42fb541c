"""Train, track and bridge to scale in longitudinal section, lowered by their displacements, many times as large.

Along the track everything is to scale. What the track model has no dimension for is drawn with a usual one: carbodies,
bogie frames, wheels, rail, sleepers, and a girder a sixteenth of the span deep.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Polygon

from railsearch.space import FloatArray
from railsearch_plugins.passage_figures.panels import SMALL
from railsearch_plugins.passage_figures.passage import within
from railsearch_plugins.track_models.train_track_bridge.figures.bridge_passage import BridgePassage
from railsearch_plugins.track_models.train_track_bridge.figures.snapshot_state import Body, TrainState

WHEEL_RADIUS = 0.46
BOGIE_FOOT, BOGIE_TOP, BEYOND_AXLE = 0.50, 0.86, 0.45
CARBODY_FOOT, CARBODY_TOP, BETWEEN_CARBODIES, BEYOND_BOGIE = 1.15, 3.85, 0.8, 2.2
RAIL_BOTTOM, SLEEPER_WIDTH, SLEEPER_BOTTOM, BALLAST_TOP = -0.17, 0.26, -0.38, -0.22
GIRDER_SHARE, SHALLOWEST, DEEPEST = 1.0 / 16.0, 0.6, 3.2
SUPPORT, BENCH = 0.9, 1.2
EDGE_ROOM = 1.0
RAIL, SLEEPER, BALLAST, GROUND, GIRDER = "#3A3F44", "#8A8F94", "#E6DAC3", "#CDBFA6", "#B9CBDA"
EDGE, GHOST, SPRING = "#222222", "#9A9A9A", "#666666"


@dataclass(frozen=True)
class Scene:
    """One passage in its snapshot: what is drawn, how many times as large displacements are, the view in m."""

    passage: BridgePassage
    train: TrainState
    factor: float
    view: tuple[float, float]

    @property
    def ballast_bottom(self) -> float:
        """Height of the foot of the ballast, and of the deck, in m from the rail's head."""
        return SLEEPER_BOTTOM - float(self.passage.track.ballast_depth)

    @property
    def girder_bottom(self) -> float:
        """Height of the foot of the girder in m."""
        return self.ballast_bottom - girder_depth(self.passage)

    def lowered(self, height: float, displacement: FloatArray) -> FloatArray:
        """Heights (k,) lowered by displacements (k,) in m as they are drawn."""
        return height - self.factor * displacement


def girder_depth(passage: BridgePassage) -> float:
    """Depth of the girder in m."""
    return min(max(GIRDER_SHARE * passage.span, SHALLOWEST), DEEPEST)


def carbody_half_length(passage: BridgePassage) -> float:
    """Half the length of a carbody in m: nearly half the pitch, and always beyond the bogies."""
    vehicle = passage.track.vehicle
    least = vehicle.bogie_distance + vehicle.axle_distance + BEYOND_AXLE
    if passage.vehicles == 1:
        return float(vehicle.bogie_distance + max(BEYOND_BOGIE, vehicle.axle_distance + BEYOND_AXLE))
    return float(max(least, 0.5 * (vehicle.pitch - BETWEEN_CARBODIES)))


def draw_scene(axes: Axes, scene: Scene) -> None:
    """Bridge, track and train, from the ground up."""
    _draw_bridge(axes, scene)
    _draw_track(axes, scene)
    _draw_train(axes, scene)
    axes.set_axis_off()


def _draw_bridge(axes: Axes, scene: Scene) -> None:
    """The deflected girder on its supports, and the ground on either side with its abutments."""
    position, span = scene.passage.history("bridge_position"), scene.passage.span
    deflection = scene.passage.history("snapshot_bridge_deflection")
    deck, foot = scene.lowered(scene.ballast_bottom, deflection), scene.lowered(scene.girder_bottom, deflection)
    bench, floor = scene.girder_bottom - SUPPORT, scene.girder_bottom - SUPPORT - BENCH
    for edge, outward in ((0.0, -1.0), (span, 1.0)):
        far = min(scene.view[0], -1.0) if outward < 0.0 else max(scene.view[1], span + 1.0)
        wall, nose = edge + 0.35 * outward, edge - 0.8 * outward
        corners = [(far, scene.ballast_bottom), (wall, scene.ballast_bottom), (wall, bench), (nose, bench)]
        axes.add_patch(Polygon([*corners, (nose, floor), (far, floor)], facecolor=GROUND, edgecolor="none", label="ground"))
    axes.fill_between(position, foot, deck, facecolor=GIRDER, edgecolor=EDGE, lw=0.7, label="girder")
    axes.plot(position, deck, color=EDGE, lw=1.0, label="deck")
    triangle = [(0.0, scene.girder_bottom), (-0.5, bench), (0.5, bench)]
    axes.add_patch(Polygon(triangle, facecolor="white", edgecolor=EDGE, lw=0.8, label="fixed support"))
    roller = Circle((span, scene.girder_bottom - 0.5 * SUPPORT), 0.5 * SUPPORT)
    roller.set(facecolor="white", edgecolor=EDGE, linewidth=0.8, label="movable support")
    axes.add_patch(roller)


def _draw_track(axes: Axes, scene: Scene) -> None:
    """Ballast between sleepers and deck or ground, sleepers, rail."""
    passage = scene.passage
    sleepers, rail = passage.history("sleeper_position"), passage.history("rail_position")
    seen, seen_rail = (within(places, (scene.view[0] - EDGE_ROOM, scene.view[1] + EDGE_ROOM)) for places in (sleepers, rail))
    under = passage.history("snapshot_sleeper_displacement")[seen]
    top = scene.lowered(BALLAST_TOP, under)
    foot = scene.lowered(scene.ballast_bottom, passage.history("snapshot_ballast_displacement")[seen])
    axes.fill_between(sleepers[seen], foot, top, facecolor=BALLAST, edgecolor="none", label="ballast")
    height = RAIL_BOTTOM - SLEEPER_BOTTOM
    axes.bar(sleepers[seen], height, SLEEPER_WIDTH, scene.lowered(SLEEPER_BOTTOM, under), color=SLEEPER, label="sleepers")
    head = passage.history("snapshot_rail_displacement")[seen_rail]
    axes.fill_between(
        rail[seen_rail], scene.lowered(RAIL_BOTTOM, head), scene.lowered(0.0, head), facecolor=RAIL, edgecolor="none"
    )
    axes.plot(rail[seen_rail], scene.lowered(0.0, head), color=RAIL, lw=1.2, label="rail")


def _draw_train(axes: Axes, scene: Scene) -> None:
    """Wheels, bogies and carbodies with their suspensions, front to back; dotted where a carbody would stand."""
    vehicle, train = scene.passage.track.vehicle, scene.train
    half = carbody_half_length(scene.passage)
    for number, carbody in enumerate(train.carbodies):
        pair = train.bogies[2 * number : 2 * number + 2]
        for bogie in pair:
            _draw_spring(axes, scene, bogie.centre, (bogie, BOGIE_TOP), (carbody, CARBODY_FOOT))
            for place in (bogie.centre + vehicle.axle_distance, bogie.centre - vehicle.axle_distance):
                axle = Body(place, float(train.wheels[np.argmin(np.abs(train.axles - place))]), 0.0)
                _draw_spring(axes, scene, place, (axle, WHEEL_RADIUS), (bogie, BOGIE_FOOT))
            length = vehicle.axle_distance + BEYOND_AXLE
            _draw_body(axes, scene, bogie, (length, BOGIE_FOOT, BOGIE_TOP), ("bogie", "#6E747A"))
        standing = Body(carbody.centre, 0.0, 0.0)
        outline = _corners(scene, standing, (half, CARBODY_FOOT, CARBODY_TOP))
        axes.add_patch(Polygon(outline, fill=False, edgecolor=GHOST, lw=0.7, ls=":", label="standing carbody"))
        _draw_body(axes, scene, carbody, (half, CARBODY_FOOT, CARBODY_TOP), ("carbody", scene.passage.colour))
        middle = 0.5 * (CARBODY_FOOT + CARBODY_TOP) - scene.factor * carbody.displacement
        axes.text(carbody.centre, middle, f"{number + 1}", ha="center", va="center", fontsize=SMALL)
    for place, lowered in zip(train.axles, train.wheels, strict=True):
        wheel = Circle((place, WHEEL_RADIUS - scene.factor * lowered), WHEEL_RADIUS, zorder=4)
        wheel.set(facecolor="white", edgecolor=EDGE, linewidth=0.9, label="wheel")
        axes.add_patch(wheel)


def _draw_body(axes: Axes, scene: Scene, body: Body, size: tuple[float, float, float], look: tuple[str, str]) -> None:
    """A body of half a length, from foot to top, under its name and in its colour."""
    name, colour = look
    corners = _corners(scene, body, size)
    axes.add_patch(Polygon(corners, facecolor=colour, alpha=0.22, edgecolor="none", zorder=3))
    axes.add_patch(Polygon(corners, fill=False, edgecolor=colour, lw=1.1, zorder=3, label=name))


def _corners(scene: Scene, body: Body, size: tuple[float, float, float]) -> Sequence[tuple[float, float]]:
    """The corners of a body, tilted by shear: lengths stay to scale however large displacements are drawn."""
    half, foot, top = size
    back, front = body.centre - half, body.centre + half
    rear, lead = scene.factor * body.lowered(back), scene.factor * body.lowered(front)
    return [(back, foot - rear), (front, foot - lead), (front, top - lead), (back, top - rear)]


def _draw_spring(axes: Axes, scene: Scene, place: float, lower: tuple[Body, float], upper: tuple[Body, float]) -> None:
    """A suspension as a line between two bodies at their heights."""
    heights = [height - scene.factor * body.lowered(place) for body, height in (lower, upper)]
    axes.plot([place, place], heights, color=SPRING, lw=1.4, zorder=2, label="_suspension")
