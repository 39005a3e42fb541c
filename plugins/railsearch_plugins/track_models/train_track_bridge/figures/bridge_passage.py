"""What the pictures show of a passage over a bridge; positions are from its left support.

| symbol | meaning | shape | unit |
|---|---|---|---|
| x₁ | position of the first axle | (t,) | m |
| x_a | positions of all axles | (t, w) | m |
| W_z | Sperling's index of every carbody | (v,) | - |
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from railsearch.space import FloatArray
from railsearch_plugins.passage_figures.passage import DrawnPassage
from railsearch_plugins.track_models.train_track_bridge.assembly import make_train
from railsearch_plugins.track_models.train_track_bridge.measures import (
    comfort_indices,
    measured_sleepers,
    wheels_on_bridge,
)

AXLES = 4
MILLI = 1e-3
BRIDGE = "#DCE6EE"
FIRST_AXLE = "Position of the first axle from the left support [m]"
ALONG = "Position from the left support [m]"


@dataclass(frozen=True)
class BridgePassage(DrawnPassage):
    """A labelled passage over a bridge."""

    def history(self, name: str) -> FloatArray:
        """A history by name."""
        return np.asarray(self.response.histories[name])

    @property
    def vehicles(self) -> int:
        """How many vehicles the train has."""
        return int(self.track.vehicles)

    @property
    def span(self) -> float:
        """The meshed span in m."""
        return float(self.response.metrics["bridge_span"])

    @property
    def first_axle(self) -> FloatArray:
        """x₁ (t,)."""
        return self.history("axle_position")[:, 0]

    @property
    def static_load(self) -> float:
        """Static load of a wheelset in N."""
        return float(make_train(self.track).static_load[0])

    @property
    def behind(self) -> FloatArray:
        """How far each axle (w,) is behind the first, in m."""
        first = self.history("axle_position")[0]
        return np.asarray(first[0] - first)

    @property
    def on_bridge(self) -> NDArray[np.bool_]:
        """Mask (t, w) of the wheels whose forces are measured: those on the bridge."""
        return wheels_on_bridge(self.track, self.history("axle_position"), self.span)

    @property
    def comfort(self) -> FloatArray:
        """W_z (v,)."""
        return comfort_indices(self.track, self.response.histories)

    @property
    def measured_sleepers(self) -> NDArray[np.bool_]:
        """Mask (s,) of the sleepers that count for A_s."""
        return measured_sleepers(self.track, self.history("sleeper_position"), self.span)

    @property
    def snapshot_step(self) -> int:
        """The step of the snapshot."""
        return int(np.argmin(np.abs(self.history("time") - self.history("snapshot_time")[0])))


def shade_bridge(panels: Sequence[Axes], start: float, end: float) -> None:
    """The bridge behind curves: from support to support, or where the first axle is while others are on it."""
    for axes in panels:
        axes.axvspan(start, end, facecolor=BRIDGE, edgecolor="none", zorder=0, label="_bridge")


def with_bridge(place: str, passages: Sequence[BridgePassage]) -> str:
    """The name of a horizontal axis, with what is shaded."""
    return f"{place}; shaded: the bridge, {passages[0].span:g} m"
