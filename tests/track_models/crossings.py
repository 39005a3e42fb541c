"""Level crossings that several tests use."""

from dataclasses import replace

from railsearch_plugins.track_models.level_crossing.parameters import (
    Geometry,
    Irregularity,
    LevelCrossingParameters,
    Passage,
    Railpad,
    Windows,
    Zone,
)

REFERENCE = (1120, 1120, 1120, 8, 6, 6, 4, 0)
BUMPS = Irregularity((0.0, 9.0, 17.0, 25.0, 33.0, 60.0), (0.0, 1e-4, -2e-4, 3e-4, 0.0, 1e-4))


def design_a(design, reading="per rail seat", element_length=0.1, time_step=1e-3):
    """Problem A: [xr1, xr2, xr3 in MN/m, xn, xs1, xs2, xs3, xl in 0.1 m]."""
    *pads, strengthened, far, middle, near, strip = design
    return LevelCrossingParameters(
        railpad=Railpad(reading=reading),
        zone=Zone(tuple(1e6 * pad for pad in pads), int(strengthened), (0.1 * far, 0.1 * middle, 0.1 * near), 0.1 * strip),
        passage=Passage(element_length=element_length, time_step=time_step),
    )


def design_b(design, reading="per rail seat", element_length=0.05, time_step=1e-3):
    """Problem B: [xs in 0.05 m, xn, xr1, xr2, xr3 in MN/m, xl in 0.05 m], other pads 78 MN/m, one slab."""
    spacing, strengthened, *pads, strip = design
    distance = 0.05 * spacing
    return LevelCrossingParameters(
        geometry=Geometry(total_length=128.0, slab_count=1),
        railpad=Railpad(78e6, 120e3 * 78 / 1120, reading),
        zone=Zone(
            tuple(1e6 * pad for pad in pads), int(strengthened), (distance,) * int(5.0 / distance + 1e-9), 0.05 * strip
        ),
        passage=Passage(element_length=element_length, time_step=time_step),
    )


def short_crossing(element_length=0.2, strip=3.33):
    """A track of 35 m with every kind of thing on it, sleepers off the nodes and sections of no whole number of elements."""
    return LevelCrossingParameters(
        geometry=Geometry(35.0, 14.0, 5.03, 2),
        zone=Zone((100e6, 300e6, 900e6), 3, (0.63, 0.5, 0.31), strip),
        passage=Passage(element_length=element_length),
        windows=Windows(energy_sleepers=10),
    )


def symmetric_crossing():
    """A track that is its own mirror image."""
    return replace(short_crossing(strip=0.0), geometry=Geometry(40.0, 14.5, 5.5, 2))
