"""Pictures of trains on a bridge: time histories, envelopes along the track, and train, track and bridge at one time."""

from collections.abc import Mapping, Sequence

from matplotlib.figure import Figure

from railsearch.interfaces import Passage
from railsearch_plugins.passage_figures.passage import drawn_figures
from railsearch_plugins.track_models.train_track_bridge.figures.bridge_passage import BridgePassage
from railsearch_plugins.track_models.train_track_bridge.figures.envelope_figure import envelope_figure
from railsearch_plugins.track_models.train_track_bridge.figures.history_figures import (
    contact_force_figure,
    histories_figure,
)
from railsearch_plugins.track_models.train_track_bridge.figures.snapshot_figure import snapshot_figure

DRAWINGS = {
    "snapshot": snapshot_figure,
    "force": contact_force_figure,
    "histories": histories_figure,
    "envelopes": envelope_figure,
}


def bridge_figures(passages: Mapping[str, Passage], names: Sequence[str]) -> dict[str, Figure]:
    """The figures of these names, all without any. Raises InputError for an unknown name."""
    return drawn_figures(passages, BridgePassage, DRAWINGS, names or tuple(DRAWINGS))
