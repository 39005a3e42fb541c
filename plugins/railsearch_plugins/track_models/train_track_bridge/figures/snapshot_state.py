"""Where the bodies of a train are in a snapshot, and how far from where they would stand.

| symbol | meaning | shape | unit |
|---|---|---|---|
| z, θ | displacement, downward, and pitch, front down, of a body in the snapshot | scalar | m, rad |
| z⁰, θ⁰ | those of the train standing on the unloaded track with its irregularity | scalar | m, rad |

What is drawn is z − z⁰ and θ − θ⁰: wheels then stay on the rail, whose displacement is from the unloaded track as well.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from railsearch.space import FloatArray
from railsearch_plugins.dynamics.vehicles import at_rest
from railsearch_plugins.track_models.train_track_bridge.assembly import make_train
from railsearch_plugins.track_models.train_track_bridge.figures.bridge_passage import AXLES, BridgePassage
from railsearch_plugins.track_models.train_track_bridge.snapshot import BODIES, CARBODY, FIRST_BOGIE, SECOND_BOGIE


@dataclass(frozen=True)
class Body:
    """A carbody or bogie: its centre in m along the track, z − z⁰ in m and θ − θ⁰ in rad."""

    centre: float
    displacement: float
    pitch: float

    def lowered(self, position: float) -> float:
        """How far it is lowered at a position, in m."""
        return self.displacement + self.pitch * (position - self.centre)


@dataclass(frozen=True)
class TrainState:
    """The train in a snapshot: axles (w,) in m, their wheels lowered (w,) in m, carbodies, two bogies each."""

    axles: FloatArray
    wheels: FloatArray
    carbodies: Sequence[Body]
    bogies: Sequence[Body]


def train_state(passage: BridgePassage) -> TrainState:
    """The train in the snapshot of a passage."""
    step, vehicle = passage.snapshot_step, passage.track.vehicle
    axles, level = passage.history("axle_position")[step], -passage.history("irregularity")[step]
    centres = axles[::AXLES] - vehicle.bogie_distance - vehicle.axle_distance
    standing = at_rest(make_train(passage.track), level)[: BODIES * centres.size].reshape(-1, BODIES)
    carbody, carbody_pitch, bogie, bogie_pitch = (
        passage.history(f"snapshot_{name}")
        for name in ("carbody_displacement", "carbody_pitch", "bogie_displacement", "bogie_pitch")
    )
    carbodies = [
        Body(float(centre), float(carbody[row] - rest[CARBODY]), float(carbody_pitch[row] - rest[CARBODY + 1]))
        for row, (centre, rest) in enumerate(zip(centres, standing, strict=True))
    ]
    rests = standing[:, [FIRST_BOGIE, SECOND_BOGIE]].ravel(), standing[:, [FIRST_BOGIE + 1, SECOND_BOGIE + 1]].ravel()
    places = (centres[:, None] + vehicle.bogie_distance * np.array([1.0, -1.0])).ravel()
    bogies = [Body(*map(float, values)) for values in zip(places, bogie - rests[0], bogie_pitch - rests[1], strict=True)]
    return TrainState(axles, passage.history("snapshot_wheel_displacement") - level, carbodies, bogies)
