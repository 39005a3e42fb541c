"""The crossing behind curves over position from its first interface."""

from itertools import pairwise

from matplotlib.axes import Axes

from railsearch_plugins.passage_figures.panels import SMALL, PanelFigure, close
from railsearch_plugins.track_models.level_crossing.figures.crossing_passage import CrossingPassage

BEYOND_CROSSING = 8.0
POSITION = "Position from the first interface [m]"
SLAB = "#DCE6EE"


def finish(made: PanelFigure, site: CrossingPassage, limits: tuple[float, float], ranges: str) -> None:
    """Close the panels, draw the site behind the curves and name its parts above them."""
    close(made, limits, ranges)
    _draw_site(made.curves, site, limits)


def _draw_site(axes: Axes, site: CrossingPassage, limits: tuple[float, float]) -> None:
    geometry = site.track.geometry
    edges = [geometry.slab_length * number for number in range(geometry.slab_count + 1)]
    for left, right in pairwise(edges):
        axes.axvspan(left, right, facecolor=SLAB, edgecolor="white", lw=1.5, zorder=0)
    for interface in (edges[0], edges[-1]):
        axes.axvline(interface, color="#222222", lw=1.0, ls=":")
    names = [f"slab {number + 1}" for number in range(geometry.slab_count)] if geometry.slab_count > 1 else ["slab"]
    parts = zip(["approach", *names, "departure"], [limits[0], *edges], [*edges, limits[1]], strict=True)
    for name, left, right in parts:
        axes.text(
            (left + right) / 2.0, 1.02, name, transform=axes.get_xaxis_transform(), ha="center", va="bottom", fontsize=SMALL
        )
