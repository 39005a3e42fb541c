"""What the pictures show of a passage over a level crossing, with positions measured from the first interface.

| symbol | meaning | shape | unit |
|---|---|---|---|
| x | position of the wheel from the first interface, positive in running direction | (t,) | m |
| x_i | position of sleeper i from the first interface | (s,) | m |
| E_i | energy dissipated in the ballast damper under sleeper i | (s,) | N·m |
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from railsearch.space import FloatArray
from railsearch_plugins.passage_figures.passage import DrawnPassage

MEGA = 1e6


@dataclass(frozen=True)
class Sleeper:
    """A sleeper as it is drawn: position in m, stiffness of its pad in MN/m, strengthened or not."""

    position: float
    pad_stiffness: float
    strengthened: bool


@dataclass(frozen=True)
class CrossingPassage(DrawnPassage):
    """A labelled passage over a level crossing."""

    @property
    def crossing_length(self) -> float:
        """Length of the crossing in m."""
        return float(self.track.geometry.crossing_length)

    @property
    def wheel_position(self) -> FloatArray:
        """x (t,)."""
        return self._from_interface("wheel_position")

    @property
    def sleeper_position(self) -> FloatArray:
        """x_i (s,), ascending."""
        return self._from_interface("sleeper_position")

    @property
    def sleeper_energy(self) -> FloatArray:
        """E_i (s,)."""
        return np.asarray(self.response.histories["sleeper_energy"])

    @property
    def force_window(self) -> tuple[float, float]:
        """Where the force is measured, in m."""
        windows = self.track.windows
        after = self.crossing_length if windows.force_after is None else windows.force_after
        return -float(windows.force_before), float(after)

    @property
    def measured(self) -> NDArray[np.bool_]:
        """Mask (s,) of the sleepers before the crossing whose energy is measured."""
        before = int(np.count_nonzero(self.sleeper_position < 0.0))
        rank = np.arange(self.sleeper_position.size)
        return np.asarray((rank < before) & (rank >= before - self.track.windows.energy_sleepers))

    def sleepers(self) -> list[Sleeper]:
        """All sleepers with their pads; the far side mirrors the approach."""
        position, zone = self.sleeper_position, self.track.zone
        before = int(np.count_nonzero(position < 0.0))
        ranks = [*range(before)[::-1], *range(position.size - before)]
        pads = zone.pad_stiffness[::-1]
        return [
            Sleeper(
                float(place),
                float(pads[rank] if rank < len(pads) else self.track.railpad.stiffness) / MEGA,
                rank < zone.strengthened_sleepers,
            )
            for place, rank in zip(position, ranks, strict=True)
        ]

    def _from_interface(self, history: str) -> FloatArray:
        return np.asarray(self.response.histories[history]) - float(self.track.geometry.approach_length)
