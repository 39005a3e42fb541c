"""Design of the ballast track on and before a bridge: railpads, ballast depth and sleepers."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from railsearch.hookspecs import hookimpl
from railsearch.interfaces import Host, Outcome, TrackModel
from railsearch.parameters import parameter
from railsearch.space import FloatArray
from railsearch_problems.bridge_criteria import (
    CRITERIA,
    FURTHER,
    TRACK_MODEL,
    BridgeProblem,
    chosen_criteria,
    reference_values,
)
from railsearch_problems.crossing_designs import Meaning, bounded_space

STUDY = "Shang et al. 2024"


@dataclass(frozen=True)
class PadBounds:
    """Range of the pad stiffness."""

    lower: float = parameter(1e8, unit="N/m", meaning="softest railpads", source=STUDY, above=0.0)
    upper: float = parameter(1.5e9, unit="N/m", meaning="stiffest railpads", source=STUDY, above=0.0)


@dataclass(frozen=True)
class DepthBounds:
    """Range of the ballast depth."""

    lower: float = parameter(0.3, unit="m", meaning="least ballast depth", source=STUDY, above=0.0)
    upper: float = parameter(0.6, unit="m", meaning="largest ballast depth", source=STUDY, above=0.0)


@dataclass(frozen=True)
class SleeperBounds:
    """Range of the sleeper mass."""

    lower: float = parameter(220.0, unit="kg", meaning="lightest sleepers", source=STUDY, above=0.0)
    upper: float = parameter(325.0, unit="kg", meaning="heaviest sleepers", source=STUDY, above=0.0)


@dataclass(frozen=True)
class Bounds:
    """The ranges in which the search looks, by variable."""

    pad_stiffness: PadBounds = PadBounds()
    ballast_depth: DepthBounds = DepthBounds()
    sleeper_mass: SleeperBounds = SleeperBounds()


@dataclass(frozen=True)
class Limits:
    """What the criteria may not exceed; those without a limit are free."""

    W_z: float | None = parameter(None, meaning="largest Sperling index", above=0.0)
    U_r: float | None = parameter(None, unit="m", meaning="largest displacement of the rail", above=0.0)
    A_s: float | None = parameter(None, unit="m/s²", meaning="largest acceleration of a sleeper", above=0.0)
    U_d: float | None = parameter(None, unit="m", meaning="largest deflection of the deck", above=0.0)

    @property
    def given(self) -> dict[str, float]:
        """The limits that there are, by criterion."""
        return {name: limit for name, limit in dataclasses.asdict(self).items() if limit is not None}


# The worst of 400 random designs (seed 1), rounded up.
WORST = {"W_z": 1.71, "U_r": 1.5e-3, "A_s": 4.58, "U_d": 9.26e-4}
MEANINGS: Mapping[str, Meaning] = {
    "pad_stiffness": ("N/m", False, "stiffness of the railpads on a sleeper"),
    "ballast_depth": ("m", False, "depth of the ballast under the sleepers"),
    "sleeper_mass": ("kg", False, "mass of a sleeper"),
}


class TrainTrackBridgeDesignProblem(BridgeProblem):
    """Ballast track over a bridge: railpad stiffness, ballast depth and sleeper mass, for ride, rail, sleepers and deck.

    Any choice of W_z, U_r, A_s and U_d is minimised; U_r and A_s by default. Any of them may have a limit (`limits`), which
    is a constraint: value/limit − 1 ≤ 0. The reference design is what the track's parameters say.
    """

    default_objectives: ClassVar[Sequence[str]] = ("U_r", "A_s")

    def __init__(
        self,
        model: TrackModel,
        track: Any,
        bounds: Bounds | None = None,
        objectives: Sequence[str] = (),
        limits: Limits | None = None,
    ) -> None:
        space = bounded_space(bounds or Bounds(), MEANINGS)
        self.limits = (limits or Limits()).given
        super().__init__(
            name="train-track-bridge-design",
            space=space,
            objectives=chosen_criteria(objectives or self.default_objectives),
            metrics=(*CRITERIA, *FURTHER),
            reference=reference_values(track, space.names, space.lower, space.upper),
            worst=WORST,
            n_constraints=len(self.limits),
        )
        self.model = model
        self.track = track

    @classmethod
    def sections(cls, host: Host) -> Mapping[str, object]:
        """Track model parameters, bounds of the variables, and limits of the criteria."""
        return {"track": host.track_model(TRACK_MODEL).Parameters(), "variables": Bounds(), "limits": Limits()}

    @classmethod
    def make(cls, host: Host, objectives: Sequence[str], sections: Mapping[str, Any]) -> TrainTrackBridgeDesignProblem:
        """The problem for a site. Raises InputError if a passage cannot be simulated, as it is or at the bounds."""
        model, track = host.track_model(TRACK_MODEL), sections["track"]
        model.check(track)
        made = cls(model, track, sections["variables"], objectives, sections["limits"])
        made.check()
        return made

    def simulate(self, design: FloatArray) -> Outcome:
        """One passage over the bridge with a design (3,)."""
        outcome = super().simulate(design)
        exceeded = [outcome.metrics[name] / limit - 1.0 for name, limit in self.limits.items()]
        return dataclasses.replace(outcome, constraints=np.array(exceeded, dtype=float))


@hookimpl
def railsearch_problems(register: Callable[[str, Any], None]) -> None:
    """Register the problem."""
    register("train-track-bridge-design", TrainTrackBridgeDesignProblem)
