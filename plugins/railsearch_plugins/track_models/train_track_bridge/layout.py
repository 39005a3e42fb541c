"""Where things stand around a bridge: axles, mesh, sleepers, span, and the numbering of the unknowns."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from railsearch_plugins.dynamics.numbering import number_along
from railsearch_plugins.track_models.train_track_bridge.parameters import TrainTrackBridgeParameters, Vehicle

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

# Shares of an element or a step that are rounding.
ROUNDING = 1e-6


@dataclass(frozen=True)
class Layout:
    """Nodes of the rail (k,), sleepers (s,) and nodes of the bridge (b,) in m; the node under each sleeper (s,)."""

    element: float
    nodes: FloatArray
    sleepers: FloatArray
    sleeper_nodes: IntArray
    bridge_nodes: FloatArray

    @property
    def span(self) -> float:
        """Span of the bridge in m, a whole number of elements."""
        return float(self.bridge_nodes[-1])

    @property
    def on_bridge(self) -> NDArray[np.bool_]:
        """Which sleepers (s,) stand on the bridge, its supports included."""
        rounding = ROUNDING * self.element
        return (self.sleepers >= -rounding) & (self.sleepers <= self.span + rounding)


@dataclass(frozen=True)
class Numbering:
    """Unknowns in natural order along the track: rail (k, 2), bridge (b, 2), sleepers (s,), ballast (s,); −1 is held.

    The ballast of a sleeper on the bridge is the vertical unknown of the bridge under it.
    """

    rail: IntArray
    bridge: IntArray
    sleepers: IntArray
    ballast: IntArray
    size: int


def axle_offsets(vehicle: Vehicle, count: int) -> FloatArray:
    """Distances (4 count,) in m of all axles behind the first, front to back."""
    arm, half = vehicle.bogie_distance, vehicle.axle_distance
    one = np.array([0.0, 2.0 * half, 2.0 * arm, 2.0 * (arm + half)])
    return np.concatenate([one + number * vehicle.pitch for number in range(count)])


def element_length(parameters: TrainTrackBridgeParameters) -> float:
    """Length of all beam elements in m."""
    return parameters.sleeper_spacing / parameters.elements_per_spacing


def meshed_span(parameters: TrainTrackBridgeParameters) -> float:
    """The span in m, rounded to a whole number of elements."""
    return element_length(parameters) * round(parameters.bridge_length / element_length(parameters))


def run_of_first_axle(parameters: TrainTrackBridgeParameters) -> tuple[float, float]:
    """Positions of the first axle at the start and at the end of the run, in m."""
    start, end = parameters.start_position, parameters.end_position
    if start is None:
        start = -parameters.approach_length - parameters.irregularity_fade
    if end is None:
        train = float(axle_offsets(parameters.vehicle, parameters.vehicles)[-1])
        end = meshed_span(parameters) + train + parameters.departure_length
    return start, end


def first_axle(parameters: TrainTrackBridgeParameters) -> tuple[FloatArray, float]:
    """Positions (t,) of the first axle in m and the time step in s, the largest that divides the run and is allowed."""
    start, end = run_of_first_axle(parameters)
    duration = (end - start) / parameters.speed
    steps = math.ceil(duration / parameters.time_step - ROUNDING)
    return np.asarray(start + (end - start) / steps * np.arange(steps + 1)), duration / steps


def snapshot_step(parameters: TrainTrackBridgeParameters) -> int:
    """The step at snapshot_time; not given, that at which the middle of the train is nearest to the middle of the span."""
    front, time_step = first_axle(parameters)
    if parameters.snapshot_time is not None:
        return min(round(parameters.snapshot_time / time_step), front.size - 1)
    middle = front - 0.5 * axle_offsets(parameters.vehicle, parameters.vehicles)[-1]
    return int(np.argmin(np.abs(middle - 0.5 * parameters.bridge_length)))


def make_layout(parameters: TrainTrackBridgeParameters) -> Layout:
    """Sleepers at multiples of their spacing from x = 0, some beyond the outermost axles; rail nodes between them."""
    spacing, parts = parameters.sleeper_spacing, parameters.elements_per_spacing
    start, end = run_of_first_axle(parameters)
    last_axle = float(axle_offsets(parameters.vehicle, parameters.vehicles)[-1])
    margin, element = parameters.margin_sleepers, element_length(parameters)
    first = math.floor(min(start - last_axle, 0.0) / spacing + ROUNDING) - margin
    last = math.ceil(max(end, meshed_span(parameters)) / spacing - ROUNDING) + margin
    numbers = np.arange(first, last + 1)
    return Layout(
        element,
        np.asarray(element * np.arange(first * parts, last * parts + 1)),
        np.asarray(spacing * numbers),
        (numbers - first) * parts,
        np.asarray(element * np.arange(round(parameters.bridge_length / element) + 1)),
    )


def number_unknowns(layout: Layout) -> Numbering:
    """Number ballast, sleepers, bridge and rail by position: the half-bandwidth is 6 with two elements per spacing.

    The supports of the bridge are held.
    """
    on, first_bridge = layout.on_bridge, int(np.searchsorted(layout.nodes, -ROUNDING))
    under = layout.sleeper_nodes.astype(float)
    bridge_at = first_bridge + np.arange(layout.bridge_nodes.size)
    bridge_counts = np.full(bridge_at.size, 2)
    bridge_counts[[0, -1]] = 1
    (own, sleepers, bridge, rail), size = number_along(
        [
            (under[~on], np.ones((~on).sum(), dtype=np.int64)),
            (under, np.ones(under.size, dtype=np.int64)),
            (bridge_at.astype(float), bridge_counts),
            (np.arange(layout.nodes.size, dtype=float), np.full(layout.nodes.size, 2)),
        ]
    )
    bridge_unknowns = np.stack([bridge, bridge + 1], axis=1)
    bridge_unknowns[[0, -1]] = [[-1, bridge[0]], [-1, bridge[-1]]]
    ballast = np.empty(under.size, dtype=np.int64)
    ballast[~on] = own
    ballast[on] = bridge_unknowns[layout.sleeper_nodes[on] - first_bridge, 0]
    return Numbering(np.stack([rail, rail + 1], axis=1), bridge_unknowns, sleepers, ballast, size)
