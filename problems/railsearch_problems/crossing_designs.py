"""What the design problems on a level crossing share: ranges of variables, their space, checks at the door."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from railsearch.errors import InputError
from railsearch.interfaces import Quantity, TrackModel
from railsearch.parameters import parameter
from railsearch.space import FloatArray, Space, Variable
from railsearch.wording import closest

TRACK_MODEL = "level-crossing"
MEGA = 1e6
PUBLISHED = "Shang et al. 2023"
SAME_LENGTH = 1e-6

Meaning = tuple[str, bool, str]
"""Unit of a variable, whether it is an integer, and what it is."""

PAD_MEANINGS: Mapping[str, Meaning] = {
    "xr1": ("MN/m", False, "stiffness of the third railpad from the crossing"),
    "xr2": ("MN/m", False, "stiffness of the second railpad from the crossing"),
    "xr3": ("MN/m", False, "stiffness of the railpad adjacent to the crossing"),
}
STRENGTHENED_MEANINGS: Mapping[str, Meaning] = {
    "xn": ("", True, "strengthened sleepers, counted from the crossing"),
}
STRIP_MEANING = "length of Type II strip from the approach side of the crossing"


@dataclass(frozen=True)
class PadBounds:
    """Range of a pad stiffness."""

    lower: float = parameter(50.0, unit="MN/m", meaning="softest railpad", source=PUBLISHED, above=0.0)
    upper: float = parameter(1200.0, unit="MN/m", meaning="stiffest railpad", source=PUBLISHED, above=0.0)


@dataclass(frozen=True)
class StrengthenedBounds:
    """Range of the number of strengthened sleepers."""

    lower: int = parameter(0, meaning="fewest strengthened sleepers", source=PUBLISHED, minimum=0)
    upper: int = parameter(20, meaning="most strengthened sleepers", source=PUBLISHED, minimum=1)


def bounded_space(bounds: Any, meanings: Mapping[str, Meaning]) -> Space:
    """The space of variables with `bounds` (a field with lower and upper each) and these meanings."""
    return Space(
        tuple(
            Variable(name, getattr(bounds, name).lower, getattr(bounds, name).upper, unit, integer, meaning)
            for name, (unit, integer, meaning) in meanings.items()
        )
    )


def chosen_objectives(available: Sequence[Quantity], names: Sequence[str]) -> list[Quantity]:
    """The quantities of these names. Raises InputError for an unknown or repeated name."""
    known = {quantity.name: quantity for quantity in available}
    for name in names:
        if name not in known:
            raise InputError(f"objectives: unknown '{name}'{closest(name, list(known))}; there are {', '.join(known)}")
    if len(set(names)) != len(names):
        raise InputError(f"objectives: each may be named once, received {', '.join(names)}")
    return [known[name] for name in names]


def check_corners(model: TrackModel, space: Space, parameters: Callable[[FloatArray], Any]) -> None:
    """Raise InputError if the track `parameters` of the design at all lower or at all upper bounds cannot be built."""
    for bound, design in (("lower", space.lower), ("upper", space.upper)):
        try:
            model.check(parameters(design))
        except InputError as error:
            raise InputError(f"variables: at the {bound} bounds {error}") from None


def whole_steps(zone: Any, per_metre: float) -> tuple[FloatArray, float]:
    """The sleeper distances (k,) and the strip length of a zone in steps, of which there are `per_metre` in a metre.

    Raises InputError if one of them is no whole multiple.
    """
    lengths = np.array([*zone.sleeper_distances, zone.type_2_strip_length]) * per_metre
    if np.any(np.abs(lengths - np.round(lengths)) > SAME_LENGTH):
        raise InputError(
            f"track.zone: sleeper distances and strip length are whole multiples of {1.0 / per_metre:g} m in this problem, "
            f"received {zone.sleeper_distances} m and {zone.type_2_strip_length} m"
        )
    whole = np.round(lengths)
    return whole[:-1], float(whole[-1])


def three_pads(zone: Any) -> FloatArray:
    """The pad stiffnesses (3,) of a zone in MN/m. Raises InputError if there are more or fewer."""
    if len(zone.pad_stiffness) != 3:
        raise InputError(
            f"track.zone.pad_stiffness: this problem needs three pads, the last adjacent to the crossing, "
            f"received {len(zone.pad_stiffness)}"
        )
    return np.array(zone.pad_stiffness) / MEGA
