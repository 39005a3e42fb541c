"""Vertical track irregularity: power spectra, seeded harmonics and the periodic profile that they make.

symbol  meaning                                              shape    unit           source
λ       wavelength                                           scalar   m
P       period of a profile; ΔΩ = 2π/P                       scalar   m
k       order of a wave, λ = P/k                             (m,)     -
Ω       wavenumber 2π/λ = kΔΩ                                (m,)     rad/m
S       one-sided power spectral density, ∫₀^∞ S dΩ = var r  (m,)     m²/(rad/m)
A_v     roughness of a spectrum                              scalar   m² rad/m
a, φ    amplitudes √(2 S ΔΩ) and phases                      (m,)     m, rad         Shinozuka & Jan (1972)
r       height of the rail over its level, positive upward   (…)      m
R       r, dr/dx and d²r/dx²                                 (3, …)   m, -, 1/m
w       fade-in: 0 before the profile begins, 1 later        (…)      -

Only the phases are random, so a profile of a given seed has its spectrum exactly, and A_v scales it as √A_v.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

NODES_PER_WAVE = 128
"""Nodes per shortest wavelength: the quintics between them keep r to 4e-13 of its amplitude and d²r/dx² to 1e-8."""

ROUNDING = 1e-12
"""A period that is a multiple of the longest or shortest wavelength but for rounding holds that wave."""


@dataclass(frozen=True)
class Harmonics:
    """Waves a cos(Ω x + φ), (m,), of which `order` k (m,) fit into one `period` P in m."""

    period: float
    order: IntArray
    amplitude: FloatArray
    phase: FloatArray


@dataclass(frozen=True)
class PeriodicProfile:
    """R (3, n) at n nodes `spacing` m apart over one period; node 0 is at x = 0."""

    spacing: float
    nodes: FloatArray


def german_spectrum(wavenumber: ArrayLike) -> FloatArray:
    """S/A_v (m,) of the German spectra at `wavenumber` Ω (m,) in rad/m.

    S/A_v = Ω_c²/((Ω² + Ω_r²)(Ω² + Ω_c²)) with Ω_r 0.0206 and Ω_c 0.8246 rad/m. A_v is 4.032e-7 m² rad/m for low and
    1.080e-6 for high disturbance (Claus & Schiehlen 1998, Modeling and simulation of railway bogie structural vibrations).
    """
    square, lower, upper = np.square(np.asarray(wavenumber, dtype=float)), 0.0206**2, 0.8246**2
    return np.asarray(upper / ((square + lower) * (square + upper)))


def fra_spectrum(wavenumber: ArrayLike) -> FloatArray:
    """S/A_v (m,) of the vertical spectra of the Federal Railroad Administration at `wavenumber` Ω (m,) in rad/m.

    S/A_v = k Ω_c²/(Ω² (Ω² + Ω_c²)) with k = 0.25 and Ω_c 0.8245 rad/m for all classes. A_v is 1.2107, 1.0181, 0.6816,
    0.5376, 0.2095 and 0.0339 cm² rad/m for classes 1 to 6 (Lei & Noda 2002, Journal of Sound and Vibration 258, 147).
    Some programs take the same A_v with 2π in place of k, which is another spectrum.
    """
    square, upper = np.square(np.asarray(wavenumber, dtype=float)), 0.8245**2
    return np.asarray(0.25 * upper / (square * (square + upper)))


def wave_orders(period: float, shortest: float, longest: float) -> IntArray:
    """The orders k (m,) of all waves with lengths P/k from `shortest` to `longest`, for `period` P, all in m.

    Raises ValueError unless 0 < shortest ≤ longest ≤ period and at least one wave lies in between.
    """
    if not 0.0 < shortest <= longest <= period:
        raise ValueError(f"0 < shortest ≤ longest ≤ period is needed, received {shortest:g}, {longest:g} and {period:g} m")
    first, last = np.ceil(period / longest * (1.0 - ROUNDING)), np.floor(period / shortest * (1.0 + ROUNDING))
    if first > last:
        raise ValueError(f"no wave of a period of {period:g} m is between {shortest:g} and {longest:g} m long")
    return np.arange(int(first), int(last) + 1)


def seeded_harmonics(
    period: float, order: IntArray, spectrum: Callable[[FloatArray], FloatArray], generator: np.random.Generator
) -> Harmonics:
    """Waves of orders k (m,) with amplitudes a = √(2 S ΔΩ) and phases φ uniform on [0, 2π).

    `spectrum` gives S in m²/(rad/m) of Ω (m,) in rad/m. The wave of order k of one seed has the same phase whatever the
    longest and the shortest wave are. Source: Shinozuka & Jan 1972.
    """
    step = 2.0 * np.pi / period
    wavenumber: FloatArray = step * order.astype(np.float64)
    phases = generator.uniform(0.0, 2.0 * np.pi, int(order.max()))
    return Harmonics(period, order, np.sqrt(2.0 * step * spectrum(wavenumber)), phases[order - 1])


def periodic_profile(harmonics: Harmonics) -> PeriodicProfile:
    """The profile r = Σ a cos(Ω x + φ) with dr/dx and d²r/dx² at its nodes, by inverse Fourier transforms."""
    count = NODES_PER_WAVE * int(harmonics.order.max())
    waves = 0.5 * count * harmonics.amplitude * np.exp(1j * harmonics.phase)
    spectrum = np.zeros((3, count // 2 + 1), dtype=complex)
    spectrum[:, harmonics.order] = waves * (2j * np.pi / harmonics.period * harmonics.order) ** np.arange(3)[:, None]
    return PeriodicProfile(harmonics.period / count, np.fft.irfft(spectrum, count))


def evaluate(profile: PeriodicProfile, positions: ArrayLike) -> FloatArray:
    """R (3, …) at `positions` (…) in m: the quintic that has the r, dr/dx and d²r/dx² of both neighbouring nodes.

    dr/dx and d²r/dx² are those of the quintic itself, so that all three belong to one twice differentiable function.
    """
    count, spacing = profile.nodes.shape[1], profile.spacing
    scaled = np.asarray(positions, dtype=float) / spacing
    whole = np.floor(scaled)
    share, left = scaled - whole, whole.astype(np.int64) % count
    powers = (spacing ** np.arange(3)).reshape(3, *[1] * scaled.ndim)
    start, end = profile.nodes[:, left] * powers, profile.nodes[:, (left + 1) % count] * powers
    return _quintic(start, end, share) / powers


def faded_in(values: FloatArray, positions: ArrayLike, start: float, length: float) -> FloatArray:
    """R (3, …) of w r for R (3, …) of r at `positions` (…) in m.

    w = s³(10 − 15s + 6s²) with s = (x − start)/length clipped to [0, 1], so that d²(w r)/dx² is continuous.
    """
    s = np.clip((np.asarray(positions, dtype=float) - start) / length, 0.0, 1.0)
    w = s**3 * (10.0 + s * (6.0 * s - 15.0))
    dw = 30.0 * (s * (1.0 - s)) ** 2 / length
    ddw = 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / length**2
    r, dr, ddr = values
    return np.stack([w * r, w * dr + dw * r, w * ddr + 2.0 * dw * dr + ddw * r])


def _quintic(start: FloatArray, end: FloatArray, s: FloatArray) -> FloatArray:
    """Value, slope and curvature (3, …) at s (…) of the quintic on [0, 1] with those (3, …) at its ends."""
    a, b, c = start[0], start[1], 0.5 * start[2]
    rise, slope, bend = end[0] - a - b - c, end[1] - b - 2.0 * c, end[2] - 2.0 * c
    d = 10.0 * rise - 4.0 * slope + 0.5 * bend
    e = -15.0 * rise + 7.0 * slope - bend
    f = 6.0 * rise - 3.0 * slope + 0.5 * bend
    return np.stack(
        [
            a + s * (b + s * (c + s * (d + s * (e + s * f)))),
            b + s * (2.0 * c + s * (3.0 * d + s * (4.0 * e + s * 5.0 * f))),
            2.0 * c + s * (6.0 * d + s * (12.0 * e + s * 20.0 * f)),
        ]
    )
