"""The track model `level-crossing`: a passage over it, and what is measured.

Compiled kernels, and what needs them, are loaded when used.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, ClassVar

from railsearch.interfaces import Passage, Quantity, Response, TrackExport
from railsearch_plugins.single_wheel import WHEEL_HISTORIES, WHEEL_METRICS
from railsearch_plugins.track_models.level_crossing.parameters import Geometry, LevelCrossingParameters

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class LevelCrossing:
    """One wheel crosses ballast track, embedded-rail slabs and ballast track again (Shang et al. 2023)."""

    Parameters = LevelCrossingParameters
    metrics: ClassVar[Sequence[Quantity]] = (
        *WHEEL_METRICS[:2],
        Quantity("E_rms", "N·m", "root mean square over the sleepers of the energy dissipated in the ballast"),
        Quantity("E_max", "N·m", "largest minus smallest energy dissipated in the ballast under a sleeper"),
        Quantity("E_adjacent", "N·m", "largest difference of that energy between neighbouring sleepers"),
        *WHEEL_METRICS[2:],
    )
    histories: ClassVar[Sequence[Quantity]] = (
        *WHEEL_HISTORIES,
        Quantity("sleeper_position", "m", "position of every sleeper"),
        Quantity("sleeper_energy", "N·m", "energy dissipated in the ballast under every sleeper over the passage"),
    )

    def warm_up(self) -> None:
        """Compile the kernels by a passage over a short crossing."""
        self.simulate(LevelCrossingParameters(geometry=Geometry(40.0, 16.0, 6.0, 1)))

    def check(self, parameters: LevelCrossingParameters) -> None:
        """Raise InputError for parameters that are not allowed or do not fit together."""
        from railsearch_plugins.track_models.level_crossing.checks import checked

        checked(parameters)

    def simulate(self, parameters: LevelCrossingParameters, histories: bool = False) -> Response:
        """Simulate one passage, from static equilibrium with the wheel on the left end of the track.

        Returns the metrics, and with `histories` the histories of `LevelCrossing.histories`: (t,) for the wheel, (s,) for
        the sleepers. Raises InputError for parameters that are not allowed, SimulationError if the solution diverges.
        """
        from railsearch_plugins.track_models.level_crossing import measures, passage
        from railsearch_plugins.track_models.level_crossing.checks import checked

        sound = checked(parameters)
        simulated = passage.simulate_passage(sound)
        series = measures.make_histories(sound, simulated)
        return Response(measures.measure(sound, series), series if histories else {})

    def figures(self, passages: Mapping[str, Passage], names: Sequence[str] = ()) -> Mapping[str, Figure]:
        """`force`, `energy`, `acceleration`, `zone`; if asked for `energy-adjacent`. Raises InputError for other names."""
        from railsearch_plugins.track_models.level_crossing.figures import crossing_figures

        return crossing_figures(passages, names)

    def export(self, parameters: LevelCrossingParameters, parts: bool = False) -> TrackExport:
        """The track for `imported-track`; with `parts`, the pads next to the crossing apart, in MN/m. Raises InputError."""
        from railsearch_plugins.track_models.level_crossing.checks import checked
        from railsearch_plugins.track_models.level_crossing.export import exported

        return exported(checked(parameters), parts)
