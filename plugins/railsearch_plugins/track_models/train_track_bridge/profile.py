"""The irregularity under the wheels: a generated profile, or a measured one from a file."""

from collections.abc import Callable
from functools import lru_cache
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline

from railsearch.errors import InputError
from railsearch_plugins.dynamics import irregularity
from railsearch_plugins.track_models.train_track_bridge.layout import FloatArray, run_of_first_axle
from railsearch_plugins.track_models.train_track_bridge.parameters import TrainTrackBridgeParameters

SPECTRA = {"german": irregularity.german_spectrum, "fra": irregularity.fra_spectrum}

Profile = Callable[[FloatArray], FloatArray]


def make_profile(parameters: TrainTrackBridgeParameters) -> Profile:
    """A function of positions (k,) in m from the bridge: r upward in m, dr/dx and d²r/dx² (3, k).

    A file is interpolated by a cubic spline and differentiated. Raises InputError for a file that is not a profile.
    """
    if parameters.irregularity_file:
        return _measured(*read_profile(parameters.irregularity_file))
    if parameters.irregularity_spectrum == "none" or parameters.irregularity_amplitude == 0.0:
        return lambda positions: np.zeros((3, positions.size))
    return _generated(parameters)


def read_profile(file: str) -> tuple[FloatArray, FloatArray]:
    """Positions (k,), ascending, and heights (k,) in m of a text file with these two columns, separated by commas or blanks.

    Lines that begin with # are comments. Raises InputError that names the file and what is wrong with it.
    """
    where = f"train-track-bridge.irregularity_file: {file}"
    try:
        state = Path(file).stat()
        return _read(file, where, (state.st_mtime_ns, state.st_size))
    except OSError as error:
        raise _unreadable(where, error) from None


@lru_cache(maxsize=4)
def _read(file: str, where: str, version: tuple[int, int]) -> tuple[FloatArray, FloatArray]:
    """As `read_profile`, once for each version of a file: every design of a search goes over the same profile."""
    try:
        text = Path(file).read_text(encoding="utf-8")
        table = np.loadtxt(text.replace(",", " ").replace(";", " ").splitlines(), ndmin=2)
    except ValueError as error:
        raise _unreadable(where, error) from None
    if table.shape[1:] != (2,) or table.shape[0] < 4 or not np.isfinite(table).all():
        raise InputError(f"{where}: two columns with four or more finite numbers are needed, received {table.shape}")
    if not (np.diff(table[:, 0]) > 0.0).all():
        raise InputError(f"{where}: positions must ascend, received a step of {np.diff(table[:, 0]).min():g} m; sort them")
    table.flags.writeable = False
    return table[:, 0], table[:, 1]


def _unreadable(where: str, error: Exception) -> InputError:
    return InputError(f"{where} cannot be read ({error}); give a text file of positions and heights in m, two columns")


def _measured(positions: FloatArray, heights: FloatArray) -> Profile:
    spline = CubicSpline(positions, heights)
    return lambda x: np.stack([spline(x, order) for order in range(3)])


def _generated(parameters: TrainTrackBridgeParameters) -> Profile:
    spectrum, amplitude = SPECTRA[parameters.irregularity_spectrum], parameters.irregularity_amplitude
    orders = irregularity.wave_orders(
        parameters.irregularity_period, parameters.irregularity_shortest, parameters.irregularity_longest
    )
    waves = irregularity.seeded_harmonics(
        parameters.irregularity_period,
        orders,
        lambda wavenumber: amplitude * spectrum(wavenumber),
        np.random.default_rng(parameters.irregularity_seed),
    )
    profile = irregularity.periodic_profile(waves)
    start, _ = run_of_first_axle(parameters)
    return lambda x: irregularity.faded_in(irregularity.evaluate(profile, x), x, start, parameters.irregularity_fade)
