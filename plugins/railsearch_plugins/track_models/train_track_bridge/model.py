"""The track model `train-track-bridge`: a passage over the bridge, and what is measured.

Compiled kernels, and what needs them, are loaded when used.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, ClassVar

from railsearch.interfaces import Passage, Quantity, Response
from railsearch_plugins.track_models.train_track_bridge.parameters import TrainTrackBridgeParameters

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class TrainTrackBridge:
    """A train crosses a simply supported bridge on ballast track (Shang et al. 2024)."""

    Parameters = TrainTrackBridgeParameters
    metrics: ClassVar[Sequence[Quantity]] = (
        Quantity("W_z", "", "Sperling index of the carbody accelerations, largest over the vehicles"),
        Quantity("U_r", "m", "largest downward displacement of the rail"),
        Quantity("A_s", "m/s²", "largest vertical acceleration of a sleeper"),
        Quantity("U_d", "m", "largest downward deflection of the deck in the middle of its span"),
        Quantity("carbody_acceleration_max", "m/s²", "largest acceleration at the centre of a carbody"),
        Quantity("contact_force_max", "N", "largest force under a wheel on the bridge"),
        Quantity("contact_force_min", "N", "smallest force under a wheel on the bridge; below zero the wheel would lift"),
        Quantity("bridge_acceleration_max", "m/s²", "largest vertical acceleration of the bridge"),
        Quantity("bridge_frequency_1", "Hz", "first frequency of the bare bridge with the meshed span"),
        Quantity("bridge_frequency_2", "Hz", "second frequency of the bare bridge with the meshed span"),
        Quantity("bridge_span", "m", "span, rounded to a whole number of elements"),
    )
    histories: ClassVar[Sequence[Quantity]] = (
        Quantity("time", "s", "time since the start"),
        Quantity("axle_position", "m", "position of every axle from the left support"),
        Quantity("contact_force", "N", "force under every wheelset, compression positive"),
        Quantity("rail_displacement", "m", "rail under every wheelset, downward"),
        Quantity("irregularity", "m", "irregularity under every wheelset, upward"),
        Quantity("carbody_acceleration", "m/s²", "centre of every carbody, downward"),
        Quantity("deck_deflection", "m", "deck in the middle of its span, downward"),
        Quantity("rail_position", "m", "position of every node of the rail"),
        Quantity("rail_lowest", "m", "largest downward displacement there"),
        Quantity("rail_highest", "m", "largest upward displacement there"),
        Quantity("sleeper_position", "m", "position of every sleeper"),
        Quantity("sleeper_acceleration_max", "m/s²", "largest acceleration of every sleeper"),
        Quantity("bridge_position", "m", "position of every node of the bridge"),
        Quantity("bridge_deflection_max", "m", "largest downward deflection there"),
        Quantity("bridge_acceleration_max", "m/s²", "largest acceleration there"),
        Quantity("snapshot_time", "s", "time of the snapshot"),
        Quantity("snapshot_rail_displacement", "m", "every node of the rail then, downward"),
        Quantity("snapshot_sleeper_displacement", "m", "every sleeper then, downward"),
        Quantity("snapshot_ballast_displacement", "m", "ballast under every sleeper then, downward; on the bridge its deck"),
        Quantity("snapshot_bridge_deflection", "m", "every node of the bridge then, downward"),
        Quantity("snapshot_carbody_displacement", "m", "centre of every carbody then, downward from a level rigid track"),
        Quantity("snapshot_carbody_pitch", "rad", "every carbody then, positive with its front down"),
        Quantity("snapshot_bogie_displacement", "m", "centre of every bogie then, downward from a level rigid track"),
        Quantity("snapshot_bogie_pitch", "rad", "every bogie then, positive with its front down"),
        Quantity("snapshot_wheel_displacement", "m", "every wheelset then, downward from a level rigid track"),
    )

    def warm_up(self) -> None:
        """Compile the kernels by a passage of one vehicle over a short bridge."""
        self.simulate(TrainTrackBridgeParameters(vehicles=1, bridge_length=6.0, start_position=-1.0, end_position=3.0))

    def check(self, parameters: TrainTrackBridgeParameters) -> None:
        """Raise InputError for parameters that are not allowed or do not fit together."""
        from railsearch_plugins.track_models.train_track_bridge.checks import checked

        checked(parameters)

    def simulate(self, parameters: TrainTrackBridgeParameters, histories: bool = False) -> Response:
        """Simulate one passage from static equilibrium on the level track.

        Returns the metrics, and with `histories` those of `TrainTrackBridge.histories`: (t,) in time, (t, w) per axle,
        (t, v) per vehicle, one value per node, sleeper or body, and snapshot_time (1,). Raises InputError for parameters
        that are not allowed, SimulationError if the solution diverges.
        """
        from railsearch_plugins.track_models.train_track_bridge import measures, passage
        from railsearch_plugins.track_models.train_track_bridge.checks import checked

        sound = checked(parameters)
        simulated = passage.simulate_passage(sound)
        series = measures.make_histories(simulated)
        return Response(measures.measure(sound, simulated, series), series if histories else {})

    def figures(self, passages: Mapping[str, Passage], names: Sequence[str] = ()) -> Mapping[str, Figure]:
        """`snapshot`, `force`, `histories` and `envelopes`. Raises InputError for other names."""
        from railsearch_plugins.track_models.train_track_bridge.figures import bridge_figures

        return bridge_figures(passages, names)
