"""Extremes of a train-track-bridge system over its uncertain inputs: the inner problem of a study of worst cases."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from railsearch.distributions import RandomVector
from railsearch.hookspecs import hookimpl
from railsearch.interfaces import Host, TrackModel
from railsearch.parameters import amend_parameters, describe_parameters, parameter
from railsearch.space import FloatArray, Space, Variable
from railsearch_problems.bridge_criteria import (
    CRITERIA,
    FURTHER,
    TRACK_MODEL,
    BridgeProblem,
    chosen_criteria,
    extremes,
    reference_values,
)
from railsearch_problems.train_track_bridge_inputs import Inputs, searched_ranges, uncertain_inputs

# The reference needs a number where the track model may leave it to the spectrum.
TRACK: Mapping[str, Any] = {"irregularity_amplitude": 7.416e-7}
LARGEST, SMALLEST = "largest", "smallest"


@dataclass(frozen=True)
class Extreme:
    """Which end of the criteria is looked for."""

    extreme: str = parameter(LARGEST, meaning="the values of the criteria that are searched", choices=(LARGEST, SMALLEST))


class TrainTrackBridgeProblem(BridgeProblem):
    """Worst passages over a bridge: W_z, U_r, A_s and U_d over 16 uncertain inputs of train, track and bridge.

    Any choice of the criteria is maximised, or minimised with `search.extreme`; the sleeper acceleration by default. The
    variables are parameters of the track model with distributions (`inputs.distributions`); their ranges are the bounds of
    the distributions, percentiles where there are none. The reference is what the track's parameters say.
    """

    default_objectives: ClassVar[Sequence[str]] = ("A_s",)

    def __init__(
        self,
        model: TrackModel,
        track: Any,
        inputs: Inputs | None = None,
        objectives: Sequence[str] = (),
        extreme: str = LARGEST,
    ) -> None:
        inputs = inputs or Inputs()
        distributions = uncertain_inputs(track, inputs)
        space = _space(track, distributions, searched_ranges(track, inputs, distributions))
        maximised = extreme == LARGEST
        super().__init__(
            name="train-track-bridge",
            space=space,
            objectives=chosen_criteria(objectives or self.default_objectives, maximised),
            metrics=extremes((*CRITERIA, *FURTHER), maximised),
            reference=reference_values(track, space.names, space.lower, space.upper),
            distributions=distributions,
        )
        self.model = model
        self.track = track

    @classmethod
    def sections(cls, host: Host) -> Mapping[str, object]:
        """Track model parameters, uncertain inputs, and which extreme is searched."""
        track = amend_parameters(host.track_model(TRACK_MODEL).Parameters(), TRACK, "track")
        return {"track": track, "inputs": Inputs(), "search": Extreme()}

    @classmethod
    def make(cls, host: Host, objectives: Sequence[str], sections: Mapping[str, Any]) -> TrainTrackBridgeProblem:
        """The problem for a site. Raises InputError if a passage cannot be simulated, as it is or at the bounds."""
        track, model = sections["track"], host.track_model(TRACK_MODEL)
        model.check(track)
        made = cls(model, track, sections["inputs"], objectives, sections["search"].extreme)
        made.check()
        return made


def _space(track: Any, distributions: RandomVector, ranges: FloatArray) -> Space:
    known = {description.name: description for description in describe_parameters(track)}
    return Space(
        tuple(
            Variable(name, float(low), float(high), known[name].unit, False, known[name].meaning)
            for name, (low, high) in zip(distributions.names, ranges, strict=True)
        )
    )


@hookimpl
def railsearch_problems(register: Callable[[str, Any], None]) -> None:
    """Register the problem."""
    register("train-track-bridge", TrainTrackBridgeProblem)
