"""A labelled passage with the look of its curves, and the figures of a model by name."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from railsearch.errors import InputError
from railsearch.interfaces import Passage, Response
from railsearch.space import FloatArray

# Okabe & Ito's colours for all kinds of colour vision, after a dark grey for the design compared with.
COLOURS = ("#444444", "#D55E00", "#0072B2", "#009E73", "#CC79A7", "#E69F00")
MARKERS = ("o", "s", "^", "D", "v", "P")
KILO = 1e3
SAME_PLACE = 1e-9


@dataclass(frozen=True)
class DrawnPassage:
    """A label, the look of its curves, the track parameters and the simulated response with histories."""

    label: str
    colour: str
    marker: str
    track: Any
    response: Response


Drawn = TypeVar("Drawn", bound=DrawnPassage)


def drawn_figures(
    passages: Mapping[str, Passage],
    kind: type[Drawn],
    drawings: Mapping[str, Callable[[Sequence[Drawn]], Figure]],
    names: Sequence[str],
) -> dict[str, Figure]:
    """The figures of these names, of all labelled passages as `kind`. Raises InputError for a name that has no drawing."""
    for name in names:
        if name not in drawings:
            raise InputError(f"figures: unknown '{name}'; there are {', '.join(drawings)}")
    shown = [
        kind(label, COLOURS[row % len(COLOURS)], MARKERS[row % len(MARKERS)], passage.parameters, passage.response)
        for row, (label, passage) in enumerate(passages.items())
    ]
    return {name: drawings[name](shown) for name in names}


def within(position: FloatArray, limits: Sequence[float]) -> NDArray[np.bool_]:
    """Mask of the positions between two limits, both included."""
    return np.asarray((position >= limits[0] - SAME_PLACE) & (position <= limits[1] + SAME_PLACE))
