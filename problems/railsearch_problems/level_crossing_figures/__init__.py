"""Pictures of a level crossing that compare designs: wheel-rail force, energy in the ballast, and the zone to scale."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from railsearch.interfaces import TrackModel

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def crossing_figures(model: TrackModel, parameters: Mapping[str, Any]) -> dict[str, Figure]:
    """The figures `force`, `energy` and `zone` for the track parameters of one or more labelled designs.

    Each design is simulated once, with histories. The label of a figure is its caption.
    """
    from railsearch_problems.level_crossing_figures.passage import compared_passages
    from railsearch_problems.level_crossing_figures.passage_figures import energy_figure, force_figure
    from railsearch_problems.level_crossing_figures.zone_figure import zone_figure

    passages = compared_passages(model, parameters)
    return {"force": force_figure(passages), "energy": energy_figure(passages), "zone": zone_figure(passages)}
