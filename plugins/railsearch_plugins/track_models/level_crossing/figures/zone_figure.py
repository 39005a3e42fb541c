"""A drawing of the crossing and its transition zones to scale, in longitudinal section, one block per design.

Along the track everything is to scale, as are rail and slab in height. What the track model has no dimension for is
drawn with a usual one: a sleeper 0.30 m wide at its base and 0.21 m high, 0.30 m of ballast under it. Pads and strip,
a centimetre thick, are drawn 0.10 m thick so that their colour can be read.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Polygon, Rectangle
from matplotlib.text import Text

from railsearch_plugins.track_models.level_crossing.figures.crossing_passage import MEGA, CrossingPassage, Sleeper

RAIL_HEIGHT = 0.159
LAYER = 0.10
PAD_WIDTH = 0.20
SLEEPER_BASE, SLEEPER_CROWN, SLEEPER_HEIGHT = 0.30, 0.22, 0.21
BALLAST_BELOW = 0.30
SLEEPER_TOP = -RAIL_HEIGHT - LAYER
SLEEPER_BOTTOM = SLEEPER_TOP - SLEEPER_HEIGHT
BALLAST_BOTTOM = SLEEPER_BOTTOM - BALLAST_BELOW
GROUND_BOTTOM = BALLAST_BOTTOM - 0.10

RAIL, BALLAST, GROUND, SLAB = "#5F6368", "#E6DAC3", "#CDBFA6", "#D5D9DD"
SLEEPER, STRENGTHENED = "#F7F7F7", "#2B2B2B"
TYPE_1, TYPE_2 = "#F4C7DD", "#A3346F"
HATCH = "////"

WIDTH, MARGIN, GAP = 10.0, 0.35, 0.35
HEADER, BLOCK_TITLE, AXIS, FOOTER = 0.55, 0.32, 0.50, 1.30
DETAIL_WIDTH = (WIDTH - 2 * MARGIN - GAP) / 2
OVERVIEW_LEAD, BEYOND_STRENGTHENED = 5.0, 1.0
DETAIL_INSIDE, BEYOND_DISTANCES = 1.0, 0.9
SKY_OVERVIEW, SKY_DETAIL = 0.12, 0.48
DIMENSION_LINE, DIMENSION_TEXT = 0.16, 0.20
SMALL, NORMAL, TITLE = 9.0, 10.0, 12.0
NARROW = 0.3
NOTE = "Above the rail: sleeper distances [m]. In the ballast: pad stiffness [MN/m]. Pads and strip are drawn 0.1 m thick."


@dataclass(frozen=True)
class Sheet:
    """Where things stand on the drawing: limits of the views in m along the track, heights of their axes in inches."""

    overview: tuple[float, float]
    details: tuple[tuple[float, float], tuple[float, float]]
    designs: int

    @property
    def overview_height(self) -> float:
        """Height of an overview that makes its scale the same in length and height."""
        return (SKY_OVERVIEW - GROUND_BOTTOM) * (WIDTH - 2 * MARGIN) / (self.overview[1] - self.overview[0])

    @property
    def detail_height(self) -> float:
        """Height of a detail, in the same way."""
        return (SKY_DETAIL - GROUND_BOTTOM) * DETAIL_WIDTH / (self.details[0][1] - self.details[0][0])

    @property
    def block(self) -> float:
        """Height of all that belongs to one design."""
        return BLOCK_TITLE + self.overview_height + AXIS + self.detail_height + AXIS

    @property
    def height(self) -> float:
        """Height of the figure."""
        return HEADER + self.designs * self.block + FOOTER

    def axes(self, figure: Figure, left: float, foot: float, width: float, height: float) -> Axes:
        """Axes at a place and of a size in inches."""
        return figure.add_axes((left / WIDTH, foot / self.height, width / WIDTH, height / self.height))

    def text(self, figure: Figure, left: float, foot: float, words: str) -> Text:
        """Words at a place in inches."""
        return figure.text(left / WIDTH, foot / self.height, words, fontsize=NORMAL)


def zone_figure(passages: Sequence[CrossingPassage]) -> Figure:
    """For every design the whole crossing, and below it both interfaces enlarged; one scale in length and height."""
    sheet, norm = _sheet(passages), _pad_norm(passages)
    figure = Figure(figsize=(WIDTH, sheet.height))
    title = sheet.text(figure, MARGIN, sheet.height - 0.35, "The crossing and its transition zones, to scale")
    title.set(fontsize=TITLE, weight="bold")
    for number, passage in enumerate(passages):
        _draw_block(figure, sheet, passage, sheet.height - HEADER - number * sheet.block, norm)
    _draw_key(figure, sheet, passages[0])
    _draw_pad_scale(figure, sheet, norm)
    figure.set_label(
        "Longitudinal section of the crossing for each design: the whole of it, and both interfaces enlarged. Positions, "
        "rail and slab are to scale; pads and strip, about a centimetre thick, are drawn 0.1 m thick so that their colour "
        "can be read."
    )
    return figure


def _draw_block(figure: Figure, sheet: Sheet, passage: CrossingPassage, top: float, norm: LogNorm) -> None:
    """One design: its name, the overview, and the details side by side."""
    title = sheet.text(figure, MARGIN, top - 0.16, f"{passage.label}:  {_summary(passage)}")
    title.set(color=passage.colour, weight="bold")
    foot = top - BLOCK_TITLE - sheet.overview_height
    axes = sheet.axes(figure, MARGIN, foot, WIDTH - 2 * MARGIN, sheet.overview_height)
    _draw_view(axes, passage, sheet.overview, SKY_OVERVIEW, norm)
    for side, view in enumerate(sheet.details):
        left = MARGIN + side * (DETAIL_WIDTH + GAP)
        axes = sheet.axes(figure, left, foot - AXIS - sheet.detail_height, DETAIL_WIDTH, sheet.detail_height)
        _draw_view(axes, passage, view, SKY_DETAIL, norm)
        _draw_dimensions(axes, passage, side)


def _sheet(passages: Sequence[CrossingPassage]) -> Sheet:
    """Views that are wide enough for all designs: the details show one sleeper more than those with a chosen distance."""
    strengthened = [abs(s.position) for p in passages for s in p.sleepers() if s.strengthened and s.position < 0.0]
    geometry = passages[0].track.geometry
    lead = max([OVERVIEW_LEAD, *(place + BEYOND_STRENGTHENED for place in strengthened)])
    before = max(sum(passage.track.zone.sleeper_distances) for passage in passages) + BEYOND_DISTANCES
    length, inside = geometry.crossing_length, min(DETAIL_INSIDE, geometry.crossing_length)
    overview = (-min(lead, geometry.approach_length), length + min(lead, geometry.departure_length))
    return Sheet(overview, ((-before, inside), (length - inside, length + before)), len(passages))


def _pad_norm(passages: Sequence[CrossingPassage]) -> LogNorm:
    """A logarithmic scale over all pads, because it is the ratio of stiffnesses that counts."""
    pads = [sleeper.pad_stiffness for passage in passages for sleeper in passage.sleepers()]
    low, high = min(pads), max(pads)
    return LogNorm(low / 1.25, high * 1.25) if high / low < 1.25 else LogNorm(low, high)


def _summary(passage: CrossingPassage) -> str:
    zone = passage.track.zone
    strip = f"Type II strip {zone.type_2_strip_length:g} m" if zone.type_2_strip_length else "no Type II strip"
    return f"{zone.strengthened_sleepers} strengthened sleepers on each side, {strip}"


def _draw_view(axes: Axes, passage: CrossingPassage, view: tuple[float, float], sky: float, norm: LogNorm) -> None:
    axes.set_xlim(*view)
    axes.set_ylim(GROUND_BOTTOM, sky)
    axes.set_aspect("equal")
    axes.set_yticks([])
    axes.tick_params(labelsize=SMALL)
    axes.set_xlabel("Position from the first interface [m]", fontsize=SMALL, labelpad=1)
    axes.spines[["left", "right", "top"]].set_visible(False)
    _draw_ground(axes, passage, view)
    _draw_crossing(axes, passage)
    for sleeper in passage.sleepers():
        if view[0] - SLEEPER_BASE < sleeper.position < view[1] + SLEEPER_BASE:
            _draw_sleeper(axes, sleeper, norm)
    _add_box(axes, (view[0], -RAIL_HEIGHT, view[1], 0.0), RAIL, "rail")


def _draw_ground(axes: Axes, passage: CrossingPassage, view: tuple[float, float]) -> None:
    _add_box(axes, (view[0], GROUND_BOTTOM, view[1], BALLAST_BOTTOM), GROUND, "subgrade")
    surface = SLEEPER_TOP - 0.06
    for left, right in ((view[0], 0.0), (passage.crossing_length, view[1])):
        if left < right:
            _add_box(axes, (left, BALLAST_BOTTOM, right, surface), BALLAST, "ballast")


def _draw_crossing(axes: Axes, passage: CrossingPassage) -> None:
    """Slabs with their joints and, under the embedded rail, the strip of Type II and then of Type I."""
    geometry, slab = passage.track.geometry, passage.track.slab
    bottom = -math.sqrt(12.0 * slab.second_moment / slab.area)
    _add_box(axes, (0.0, BALLAST_BOTTOM, passage.crossing_length, bottom), GROUND, "subgrade")
    for number in range(geometry.slab_count):
        edges = (number * geometry.slab_length, bottom, (number + 1) * geometry.slab_length, 0.0)
        _add_box(axes, edges, SLAB, "slab", edgecolor="#222222", linewidth=1.0)
    change, end = passage.track.zone.type_2_strip_length, passage.crossing_length
    if change > 0.0:
        strip = (0.0, SLEEPER_TOP, change, -RAIL_HEIGHT)
        _add_box(axes, strip, TYPE_2, "Type II strip", edgecolor="white", linewidth=0.0, hatch=HATCH)
    if change < end:
        _add_box(axes, (change, SLEEPER_TOP, end, -RAIL_HEIGHT), TYPE_1, "Type I strip")


def _draw_sleeper(axes: Axes, sleeper: Sleeper, norm: LogNorm) -> None:
    base, crown, x = SLEEPER_BASE / 2, SLEEPER_CROWN / 2, sleeper.position
    corners = [
        (x - base, SLEEPER_BOTTOM),
        (x + base, SLEEPER_BOTTOM),
        (x + crown, SLEEPER_TOP),
        (x - crown, SLEEPER_TOP),
    ]
    name, colour = ("strengthened sleeper", STRENGTHENED) if sleeper.strengthened else ("sleeper", SLEEPER)
    edge = "white" if sleeper.strengthened else "#555555"
    axes.add_patch(Polygon(corners, facecolor=colour, edgecolor=edge, linewidth=0.7, label=name))
    pad = (x - PAD_WIDTH / 2, SLEEPER_TOP, x + PAD_WIDTH / 2, -RAIL_HEIGHT)
    _add_box(axes, pad, colormaps["viridis"](float(norm(sleeper.pad_stiffness))), "pad")


def _draw_dimensions(axes: Axes, passage: CrossingPassage, side: int) -> None:
    """Sleeper distances above the rail and pad stiffnesses in the ballast, next to the interface of a side (0, 1)."""
    count = max(len(passage.track.zone.sleeper_distances), len(passage.track.zone.pad_stiffness))
    approach = [sleeper for sleeper in passage.sleepers() if sleeper.position < 0.0]
    departure = [sleeper for sleeper in passage.sleepers() if sleeper.position > 0.0]
    near = departure[:count] if side else approach[::-1][:count]
    places = [passage.crossing_length if side else 0.0, *(sleeper.position for sleeper in near)]
    narrow = min(passage.track.zone.sleeper_distances) < NARROW
    arrow = {"arrowstyle": "<->", "mutation_scale": 7.0, "lw": 0.8, "shrinkA": 0.0, "shrinkB": 0.0}
    axes.vlines(places, 0.0, DIMENSION_LINE + 0.04, color="#777777", lw=0.6)
    for start, end in pairwise(places):
        axes.annotate("", (start, DIMENSION_LINE), (end, DIMENSION_LINE), arrowprops=arrow)
        axes.text((start + end) / 2, DIMENSION_TEXT, f"{abs(end - start):.3g}", ha="center", va="bottom", fontsize=SMALL)
    for sleeper in near:
        axes.text(
            sleeper.position,
            (SLEEPER_BOTTOM + BALLAST_BOTTOM) / 2,
            f"{sleeper.pad_stiffness:.0f}",
            ha="center",
            va="center",
            fontsize=SMALL,
            rotation=90.0 if narrow else 0.0,
        )


def _draw_key(figure: Figure, sheet: Sheet, site: CrossingPassage) -> None:
    strip = site.track.strip
    handles = [
        Patch(facecolor=STRENGTHENED, edgecolor="white", label="strengthened sleeper"),
        Patch(facecolor=SLEEPER, edgecolor="#555555", label="sleeper"),
        Patch(facecolor=TYPE_1, label=f"Type I strip, {strip.type_1_stiffness / MEGA:g} MN/m²"),
        Patch(
            facecolor=TYPE_2, edgecolor="white", hatch=HATCH, label=f"Type II strip, {strip.type_2_stiffness / MEGA:g} MN/m²"
        ),
        Patch(facecolor=RAIL, label="rail"),
        Patch(facecolor=SLAB, edgecolor="#222222", label="slab"),
        Patch(facecolor=BALLAST, label="ballast"),
        Patch(facecolor=GROUND, label="subgrade"),
    ]
    place = (MARGIN / WIDTH, 0.42 / sheet.height)
    figure.legend(
        handles=handles, loc="lower left", bbox_to_anchor=place, ncols=3, fontsize=SMALL, frameon=False, borderaxespad=0
    )
    note = sheet.text(figure, MARGIN, 0.14, NOTE)
    note.set_fontsize(SMALL)


def _draw_pad_scale(figure: Figure, sheet: Sheet, norm: LogNorm) -> None:
    bar = sheet.axes(figure, WIDTH - MARGIN - 3.1, 0.88, 3.0, 0.16)
    figure.colorbar(ScalarMappable(norm, colormaps["viridis"]), cax=bar, orientation="horizontal", ticks=_ticks(norm))
    bar.minorticks_off()
    bar.xaxis.set_major_formatter("{x:.4g}")
    bar.tick_params(labelsize=SMALL)
    bar.set_xlabel("pad stiffness [MN/m], logarithmic", fontsize=SMALL, labelpad=2)


def _ticks(norm: LogNorm) -> list[float]:
    """Numbers 1, 2, 5 times powers of ten inside the scale, its ends where it holds fewer than two of them."""
    low, high = float(norm.vmin or 1.0), float(norm.vmax or 1.0)
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    inside = [step * 10.0**decade for decade in decades for step in (1, 2, 5) if low <= step * 10.0**decade <= high]
    return inside if len(inside) > 1 else [low, high]


def _add_box(
    axes: Axes,
    edges: tuple[float, float, float, float],
    colour: str | tuple[float, ...],
    name: str,
    edgecolor: str = "none",
    linewidth: float = 0.0,
    hatch: str = "",
) -> None:
    """A rectangle from its left, bottom, right and top edge."""
    left, bottom, right, top = edges
    box = Rectangle(
        (left, bottom),
        right - left,
        top - bottom,
        facecolor=colour,
        edgecolor=edgecolor,
        linewidth=linewidth,
        hatch=hatch,
        label=name,
    )
    axes.add_patch(box)
