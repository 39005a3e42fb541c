"""Irregular tracks for the track models: spectra by name, seeded profiles, measured profiles, fade-in.

A profile is called with positions x (…) in m and gives R (3, …): height r in m, positive upward, dr/dx and d²r/dx² in
1/m, all of one twice differentiable function. The mathematics and the notation are in `dynamics.irregularity`.
"""

import importlib
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import CubicSpline

from railsearch.errors import InputError
from railsearch.seeding import checked_seed
from railsearch_plugins.dynamics.irregularity import (
    PeriodicProfile,
    evaluate,
    faded_in,
    fra_spectrum,
    german_spectrum,
    periodic_profile,
    seeded_harmonics,
    wave_orders,
)

FloatArray = NDArray[np.float64]

PERIOD = 600.0
"""Length in m after which a seeded profile repeats itself: a default that no run reaches and the longest wave fits into."""

SHORTEST_WAVE, LONGEST_WAVE = 3.0, 150.0
"""Wavelengths in m of a seeded profile (Shang et al. 2024)."""


@dataclass(frozen=True)
class Spectrum:
    """A power spectral density S = A_v · `density`(Ω) in m²/(rad/m), with `roughness` A_v in m² rad/m unless it is given."""

    density: Callable[[FloatArray], FloatArray]
    roughness: float
    meaning: str


SPECTRA: Mapping[str, Spectrum] = MappingProxyType(
    {
        "german": Spectrum(german_spectrum, 7.416e-7, "German spectrum, half-way between low and high disturbance"),
        "german-low": Spectrum(german_spectrum, 4.032e-7, "German spectrum, low disturbance"),
        "german-high": Spectrum(german_spectrum, 1.080e-6, "German spectrum, high disturbance"),
        **{
            f"fra-{number}": Spectrum(fra_spectrum, 1e-4 * roughness, f"Federal Railroad Administration, class {number}")
            for number, roughness in enumerate((1.2107, 1.0181, 0.6816, 0.5376, 0.2095, 0.0339), start=1)
        },
    }
)


class Profile(Protocol):
    """The unloaded rail."""

    def __call__(self, positions: ArrayLike, /) -> FloatArray:
        """R (3, …) at `positions` (…) in m. Raises InputError where the profile does not cover them."""


@dataclass(frozen=True)
class SeededProfile:
    """A generated profile. It raises InputError for positions further apart than its period, over which it repeats."""

    nodes: PeriodicProfile

    def __call__(self, positions: ArrayLike, /) -> FloatArray:
        """R (3, …) at `positions` (…) in m."""
        x, period = np.asarray(positions, dtype=float), self.nodes.spacing * self.nodes.nodes.shape[1]
        if x.size and np.ptp(x) > period:
            raise InputError(
                f"irregularity: the run is {np.ptp(x):g} m long and the generated profile repeats after {period:g} m; "
                "lengthen its period or shorten the run"
            )
        return evaluate(self.nodes, x)


@dataclass(frozen=True)
class MeasuredProfile:
    """A cubic spline (not-a-knot) through measured heights, and its derivatives; `name` says whose in messages."""

    name: str
    spline: CubicSpline

    def __call__(self, positions: ArrayLike, /) -> FloatArray:
        """R (3, …) at `positions` (…) in m. Raises InputError where none was measured."""
        x = np.asarray(positions, dtype=float)
        first, last = self.spline.x[0], self.spline.x[-1]
        if x.size and (x.min() < first or x.max() > last):
            raise InputError(
                f"{self.name}: the profile is too short: it covers {first:g} to {last:g} m and the wheels run from "
                f"{x.min():g} to {x.max():g} m; measure or extend it with heights of zero, or shorten the run"
            )
        return np.stack([self.spline(x, order) for order in range(3)])


@dataclass(frozen=True)
class FadedIn:
    """Another profile, zero up to `start`, all there `length` further on, both in m.

    Raises InputError for a length that is not positive: a profile that sets in at once hits the wheels.
    """

    profile: Profile
    start: float
    length: float

    def __post_init__(self) -> None:
        if not 0.0 < self.length < np.inf:
            raise InputError(
                f"irregularity fade-in: a length above 0 m is needed, received {self.length:g}; leave the fade-in out"
            )

    def __call__(self, positions: ArrayLike, /) -> FloatArray:
        """R (3, …) at `positions` (…) in m."""
        return faded_in(self.profile(positions), positions, self.start, self.length)


def level_track(positions: ArrayLike, /) -> FloatArray:
    """The profile of a level track: R = 0 (3, …) at `positions` (…)."""
    return np.zeros((3, *np.shape(positions)))


def spectrum_named(name: str) -> Spectrum:
    """The spectrum of that name: one of SPECTRA, or a `Spectrum` of any importable module as 'module:NAME'.

    Raises InputError that lists what there is for an unknown one.
    """
    if name in SPECTRA:
        return SPECTRA[name]
    module_name, separator, attribute = name.partition(":")
    if not separator:
        raise InputError(
            f"unknown spectrum '{name}'; there are {', '.join(SPECTRA)}, and any Spectrum of a module as 'module:NAME'"
        )
    try:
        found = getattr(importlib.import_module(module_name), attribute)
    except (ImportError, AttributeError, ValueError) as error:
        raise InputError(f"spectrum '{name}': {error}; give 'module:NAME' of what can be imported") from error
    if not isinstance(found, Spectrum):
        raise InputError(f"spectrum '{name}': a Spectrum is needed, received {type(found).__name__}")
    return found


def seeded_profile(
    spectrum: str | Spectrum = "german",
    seed: int = 0,
    *,
    roughness: float | None = None,
    period: float = PERIOD,
    shortest: float = SHORTEST_WAVE,
    longest: float = LONGEST_WAVE,
) -> SeededProfile:
    """A profile whose spectrum between the `longest` and the `shortest` wave is exactly that of `spectrum`.

    `roughness` A_v in m² rad/m replaces the spectrum's own and, for the same seed, scales the profile by √A_v. Lengths in m.
    Raises InputError for an unknown spectrum, a negative or infinite roughness, no integer seed ≥ 0, and lengths that leave
    no wave; and for a spectrum whose density is negative or not finite.
    """
    chosen = spectrum_named(spectrum) if isinstance(spectrum, str) else spectrum
    scale = chosen.roughness if roughness is None else roughness
    if not 0.0 <= scale < np.inf:
        raise InputError(f"irregularity amplitude: A_v ≥ 0 m² rad/m is needed, received {scale:g}; 0 is a level track")
    generator = np.random.default_rng(checked_seed(seed))
    try:
        order = wave_orders(period, shortest, longest)
    except ValueError as error:
        raise InputError(f"irregularity wavelengths: {error}") from None
    waves = seeded_harmonics(period, order, lambda wavenumber: scale * _density(chosen, wavenumber), generator)
    return SeededProfile(periodic_profile(waves))


def measured_profile(position: ArrayLike, height: ArrayLike, name: str = "irregularity") -> MeasuredProfile:
    """A cubic spline through `height` (k,) in m, positive upward, at ascending `position` (k,) in m.

    Linear interpolation would hit the wheels at every point measured. Raises InputError with `name` for fewer than four
    points, positions that do not ascend, and numbers that are not finite.
    """
    x, r = np.asarray(position, dtype=float), np.asarray(height, dtype=float)
    if x.ndim != 1 or x.shape != r.shape or x.size < 4:
        raise InputError(
            f"{name}: four or more positions with a height each are needed for a cubic spline, received shapes {x.shape} "
            f"and {r.shape}"
        )
    if not (np.isfinite(x).all() and np.isfinite(r).all()):
        raise InputError(f"{name}: finite positions and heights are needed; leave the gaps out")
    if not (steps := np.diff(x)).min() > 0.0:
        raise InputError(
            f"{name}: positions must ascend, received {x[steps.argmin() + 1]:g} m after {x[steps.argmin()]:g} m"
        )
    return MeasuredProfile(name, CubicSpline(x, r))


def profile_from_file(path: str | os.PathLike[str]) -> MeasuredProfile:
    """A measured profile from a text file: position and height in m, positive upward; # begins a comment.

    Columns are separated by blanks, commas or semicolons; the first line may be words. Raises InputError that names the file
    for what cannot be read, and as `measured_profile`.
    """
    try:
        lines = Path(path).read_text(encoding="utf-8").replace(",", " ").replace(";", " ").splitlines()
        table = np.loadtxt(lines[1:] if lines and _has_words(lines[0]) else lines, ndmin=2)
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    except ValueError as error:
        raise InputError(f"{path}: two columns of numbers, position and height in m, are needed: {error}") from None
    if table.shape[1] != 2:
        raise InputError(f"{path}: two columns, position and height in m, are needed, received {table.shape[1]}")
    return measured_profile(table[:, 0], table[:, 1], str(path))


def _has_words(line: str) -> bool:
    """Whether a line is neither a comment nor numbers."""
    try:
        np.array(line.split(), dtype=float)
    except ValueError:
        return not line.startswith("#")
    return False


def _density(spectrum: Spectrum, wavenumber: FloatArray) -> FloatArray:
    density = np.asarray(spectrum.density(wavenumber), dtype=float)
    if density.shape != wavenumber.shape or not (np.isfinite(density).all() and (density >= 0.0).all()):
        raise InputError(
            f"irregularity spectrum ({spectrum.meaning}): a density (m,) ≥ 0 and finite is needed for wavenumbers (m,); "
            "correct the spectrum"
        )
    return density
