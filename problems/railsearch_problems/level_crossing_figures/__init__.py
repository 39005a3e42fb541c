"""Pictures of a level crossing that compare designs: what the wheel and the ballast feel, and the zone to scale."""

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
    from railsearch_problems.level_crossing_figures.energy_figure import energy_range_figure
    from railsearch_problems.level_crossing_figures.passage import compared_passages
    from railsearch_problems.level_crossing_figures.wheel_figures import force_figure
    from railsearch_problems.level_crossing_figures.zone_figure import zone_figure

    passages = compared_passages(model, parameters)
    return {"force": force_figure(passages), "energy": energy_range_figure(passages), "zone": zone_figure(passages)}


def preference_figures(model: TrackModel, parameters: Mapping[str, Any]) -> dict[str, Figure]:
    """The figures `energy` (differences between adjacent sleepers), `acceleration` and `zone`, made likewise."""
    from railsearch_problems.level_crossing_figures.energy_figure import energy_difference_figure
    from railsearch_problems.level_crossing_figures.passage import compared_passages
    from railsearch_problems.level_crossing_figures.wheel_figures import acceleration_figure
    from railsearch_problems.level_crossing_figures.zone_figure import zone_figure

    passages = compared_passages(model, parameters)
    return {
        "energy": energy_difference_figure(passages),
        "acceleration": acceleration_figure(passages),
        "zone": zone_figure(passages),
    }
