"""The irregularity under the wheels: a generated profile, or a measured one from a file."""

from functools import lru_cache
from pathlib import Path

from railsearch.errors import InputError
from railsearch_plugins.track_irregularity import (
    FadedIn,
    MeasuredProfile,
    Profile,
    level_track,
    profile_from_file,
    seeded_profile,
)
from railsearch_plugins.track_models.train_track_bridge.layout import run_of_first_axle
from railsearch_plugins.track_models.train_track_bridge.parameters import LEVEL, TrainTrackBridgeParameters


def make_profile(parameters: TrainTrackBridgeParameters) -> Profile:
    """The profile by position in m from the bridge. Raises InputError for a file that is not a profile."""
    if parameters.irregularity_file:
        return measured_profile(parameters.irregularity_file)
    if parameters.irregularity_spectrum == LEVEL:
        return level_track
    generated = seeded_profile(
        parameters.irregularity_spectrum,
        parameters.irregularity_seed,
        roughness=parameters.irregularity_amplitude,
        period=parameters.irregularity_period,
        shortest=parameters.irregularity_shortest,
        longest=parameters.irregularity_longest,
    )
    start, _ = run_of_first_axle(parameters)
    return FadedIn(generated, start, parameters.irregularity_fade)


def measured_profile(file: str) -> MeasuredProfile:
    """The profile of a text file of positions and heights in m. Raises InputError that says what is wrong with it."""
    where = f"train-track-bridge.irregularity_file: {file}"
    try:
        state = Path(file).stat()
    except OSError as error:
        raise InputError(f"{where}: cannot be read: {error.strerror}") from None
    try:
        return _read(file, (state.st_mtime_ns, state.st_size))
    except InputError as error:
        raise InputError(f"train-track-bridge.irregularity_file: {error}") from None


@lru_cache(maxsize=4)
def _read(file: str, version: tuple[int, int]) -> MeasuredProfile:
    """Once for each version of a file: every design of a search goes over the same profile."""
    return profile_from_file(file)
