"""The track model `imported-track`: a passage over it, and what is measured."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from railsearch.interfaces import Passage as SimulatedPassage
from railsearch.interfaces import Quantity, Response
from railsearch_plugins.single_wheel import WHEEL_HISTORIES, WHEEL_METRICS
from railsearch_plugins.track_models.imported_track.parameters import Files, ImportedTrackParameters, Passage

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class ImportedTrack:
    """One wheel crosses a track whose matrices come from any finite element program.

    M, C and K are read from MatrixMarket, MATLAB or NumPy files with tables of rail nodes and supports, and parts of the
    track can be scaled. docs/imported-track.md says how to export them; `railsearch export-track` writes them for a model of
    ours.
    """

    Parameters = ImportedTrackParameters
    metrics: ClassVar[Sequence[Quantity]] = (
        *WHEEL_METRICS[:2],
        Quantity("E_rms", "N·m", "root mean square over the measured supports of the energy dissipated in them"),
        Quantity("E_max", "N·m", "largest minus smallest energy dissipated in a measured support"),
        Quantity("E_adjacent", "N·m", "largest difference of that energy between neighbouring supports"),
        *WHEEL_METRICS[2:],
    )
    histories: ClassVar[Sequence[Quantity]] = (
        *WHEEL_HISTORIES,
        Quantity("support_position", "m", "position of every support"),
        Quantity("support_energy", "N·m", "energy dissipated in every support over the passage"),
    )

    def __init__(self) -> None:
        self._warned_of: Files | None = None

    def warm_up(self) -> None:
        """Compile the kernels by passages over a stretch of the sample track."""
        from railsearch_plugins.track_models.imported_track import passage

        short = ImportedTrackParameters(passage=Passage(end=2.0))
        for route in passage.ROUTES:
            passage.simulate_passage(short, route=route)

    def check(self, parameters: ImportedTrackParameters) -> None:
        """Raise InputError for parameters and files that are not allowed or do not fit together; warn of odd units."""
        from railsearch_plugins.track_models.imported_track.checks import checked
        from railsearch_plugins.track_models.imported_track.passage import check_stable

        sound, track = checked(parameters)
        check_stable(sound)
        self._warn(sound, track)

    def simulate(self, parameters: ImportedTrackParameters, histories: bool = False) -> Response:
        """Simulate one passage, from static equilibrium with the wheel at the start of the run.

        Returns the metrics, and with `histories` those of `ImportedTrack.histories`: (t,) for the wheel, (s,) for the
        supports. Raises InputError for parameters that are not allowed, SimulationError if the solution diverges.
        """
        from railsearch_plugins.track_models.imported_track import measures, passage
        from railsearch_plugins.track_models.imported_track.checks import checked

        sound, track = checked(parameters)
        self._warn(sound, track)
        simulated = passage.simulate_passage(sound)
        series = measures.make_histories(sound, simulated)
        metrics = measures.measure(sound, simulated.track, series)
        return Response(metrics, {name: np.asarray(values) for name, values in series.items()} if histories else {})

    def figures(self, passages: Mapping[str, SimulatedPassage], names: Sequence[str] = ()) -> Mapping[str, Figure]:
        """`force` and `energy`. Raises InputError for other names."""
        from railsearch_plugins.track_models.imported_track.figures import track_figures

        return track_figures(passages, names)

    def _warn(self, parameters: ImportedTrackParameters, track: object) -> None:
        """Warn of odd units once per set of files."""
        from railsearch_plugins.track_models.imported_track.checks import warn_of_units

        if parameters.files != self._warned_of:
            self._warned_of = parameters.files
            warn_of_units(parameters, track)  # type: ignore[arg-type]
