"""Pictures of passages over a level crossing: what the wheel and the ballast feel, and the zone to scale."""

from collections.abc import Mapping, Sequence

from matplotlib.figure import Figure

from railsearch.interfaces import Passage
from railsearch_plugins.passage_figures.passage import drawn_figures
from railsearch_plugins.track_models.level_crossing.figures.crossing_passage import CrossingPassage
from railsearch_plugins.track_models.level_crossing.figures.energy_figure import (
    energy_difference_figure,
    energy_range_figure,
)
from railsearch_plugins.track_models.level_crossing.figures.wheel_figures import acceleration_figure, force_figure
from railsearch_plugins.track_models.level_crossing.figures.zone_figure import zone_figure

DRAWINGS = {
    "force": force_figure,
    "energy": energy_range_figure,
    "energy-adjacent": energy_difference_figure,
    "acceleration": acceleration_figure,
    "zone": zone_figure,
}
USUAL = ("force", "energy", "acceleration", "zone")


def crossing_figures(passages: Mapping[str, Passage], names: Sequence[str]) -> dict[str, Figure]:
    """The figures of these names, the usual ones without any. Raises InputError for an unknown name."""
    return drawn_figures(passages, CrossingPassage, DRAWINGS, names or USUAL)
