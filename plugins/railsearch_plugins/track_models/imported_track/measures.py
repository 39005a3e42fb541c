"""Measures of a passage over an imported track; symbols and metrics are those of `single_wheel`."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from railsearch_plugins.single_wheel import carbody_acceleration, check_finite, passage_metrics
from railsearch_plugins.track_models.imported_track.checks import MODEL, SAME_PLACE, measured_supports, windows_of
from railsearch_plugins.track_models.imported_track.parameters import ImportedTrackParameters
from railsearch_plugins.track_models.imported_track.passage import Simulated
from railsearch_plugins.track_models.imported_track.track import ImportedMatrices

FloatArray = NDArray[np.float64]


def make_histories(parameters: ImportedTrackParameters, simulated: Simulated) -> dict[str, FloatArray]:
    """The histories of a passage by name. Raises SimulationError if one of them is not finite."""
    passage, supports = simulated.passage, simulated.track.supports
    displacement, velocity = passage.vehicle_displacement, passage.vehicle_velocity
    histories: dict[str, FloatArray] = {
        "time": parameters.passage.time_step * np.arange(simulated.position.size, dtype=np.float64),
        "wheel_position": simulated.position,
        "wheel_rail_force": passage.force[:, 0],
        "rail_displacement": (passage.motion - simulated.contact.irregularity)[:, 0, 0],
        "wheel_displacement": displacement[:, -1],
        "carbody_acceleration": carbody_acceleration(simulated.vehicle, displacement, velocity),
        "support_position": supports.position,
        "support_energy": supports.damping * passage.support_integrals,
    }
    check_finite(histories, MODEL, parameters.passage.time_step)
    return histories


def measure(
    parameters: ImportedTrackParameters, track: ImportedMatrices, histories: Mapping[str, FloatArray]
) -> dict[str, float]:
    """The metrics of a passage by name."""
    first, last, _, _ = windows_of(parameters, track)
    position = histories["wheel_position"]
    window = (position >= first - SAME_PLACE) & (position <= last + SAME_PLACE)
    return passage_metrics(
        histories["wheel_rail_force"][window],
        histories["carbody_acceleration"][window],
        histories["support_energy"][measured_supports(parameters, track)],
    )
