"""Spectra, seeded profiles and their fade-in against direct sums, Parseval's theorem and finite differences."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import welch

from railsearch_plugins.dynamics.irregularity import (
    Harmonics,
    evaluate,
    faded_in,
    fra_spectrum,
    german_spectrum,
    periodic_profile,
    seeded_harmonics,
    wave_orders,
)

PERIOD, SHORTEST, LONGEST = 600.0, 3.0, 150.0
ORDER = wave_orders(PERIOD, SHORTEST, LONGEST)
REFERENCE = Path(__file__).parents[1] / "reference" / "ttb" / "german_waves.json"
SPECTRA = {"german": german_spectrum, "fra": fra_spectrum}


def low_disturbance(wavenumber):
    return 4.032e-7 * german_spectrum(wavenumber)


def waves(seed=1, spectrum=low_disturbance, order=ORDER):
    return seeded_harmonics(PERIOD, order, spectrum, np.random.default_rng(seed))


def direct_sum(harmonics, positions):
    """r, dr/dx and d²r/dx² wave by wave."""
    wavenumber = 2.0 * np.pi * harmonics.order / harmonics.period
    angle = wavenumber[:, None] * positions + harmonics.phase[:, None]
    return np.stack(
        [
            harmonics.amplitude @ np.cos(angle),
            -(harmonics.amplitude * wavenumber) @ np.sin(angle),
            -(harmonics.amplitude * wavenumber**2) @ np.cos(angle),
        ]
    )


def test_german_spectrum_has_its_limits():
    # Ω → 0: 1/Ω_r²; Ω_r ≪ Ω ≪ Ω_c: 1/Ω²; Ω → ∞: Ω_c²/Ω⁴; at Ω_c with Ω_r neglected: half of 1/Ω².
    assert german_spectrum(1e-9) == pytest.approx(1.0 / 0.0206**2, rel=1e-9)
    assert german_spectrum(1e4) == pytest.approx(0.8246**2 / 1e16, rel=1e-7)
    assert german_spectrum(0.8246) == pytest.approx(0.5 / (0.8246**2 + 0.0206**2), rel=1e-12)


def test_fra_spectrum_falls_with_the_second_and_then_the_fourth_power():
    assert fra_spectrum(1e-5) == pytest.approx(0.25 / 1e-10, rel=1e-9)
    assert fra_spectrum(1e4) == pytest.approx(0.25 * 0.8245**2 / 1e16, rel=1e-7)
    assert fra_spectrum(0.8245) == pytest.approx(0.125 / 0.8245**2, rel=1e-12)


def test_waves_are_those_between_the_longest_and_the_shortest():
    assert PERIOD / ORDER[0] == LONGEST
    assert PERIOD / ORDER[-1] == SHORTEST
    np.testing.assert_array_equal(wave_orders(0.3, 0.1, 0.3), [1, 2, 3])  # 0.3/0.1 is just below 3
    np.testing.assert_array_equal(wave_orders(3 * 0.1, 0.07, 0.1), [3, 4])  # 3 · 0.1/0.1 is just above 3
    np.testing.assert_array_equal(wave_orders(10.0, 3.0, 9.0), [2, 3])


@pytest.mark.parametrize("lengths", [(600.0, 150.0, 3.0), (100.0, 3.0, 150.0), (600.0, 0.0, 150.0), (600.0, 140.0, 149.0)])
def test_bands_without_a_wave_are_refused(lengths):
    with pytest.raises(ValueError, match="period"):
        wave_orders(*lengths)


@pytest.mark.parametrize("spectrum", SPECTRA.values(), ids=SPECTRA)
def test_power_spectral_density_of_a_profile_is_the_spectrum(spectrum):
    profile = periodic_profile(waves(spectrum=spectrum))
    heights = profile.nodes[0]
    # One-sided density per rad/m of exactly one period: 2 |X|²/N² per ΔΩ.
    step = 2.0 * np.pi / PERIOD
    measured = 2.0 * np.abs(np.fft.rfft(heights) / heights.size) ** 2 / step
    np.testing.assert_allclose(measured[ORDER], spectrum(step * ORDER), rtol=1e-9)
    outside = np.delete(measured, ORDER)
    assert outside.max() < 1e-20 * measured.max()
    assert np.mean(heights**2) == pytest.approx(np.sum(spectrum(step * ORDER)) * step, rel=1e-12)


def test_welch_estimate_of_sampled_heights_is_the_spectrum():
    """The same through an estimator that knows nothing of the waves, on positions that are not the nodes."""
    long, step = 40.0 * PERIOD, 0.7
    order = wave_orders(long, SHORTEST, LONGEST)
    harmonics = seeded_harmonics(long, order, low_disturbance, np.random.default_rng(3))
    heights = evaluate(periodic_profile(harmonics), np.arange(0.0, long, step))[0]
    frequency, density = welch(heights, 1.0 / step, nperseg=2048)
    inside = (frequency > 1.2 / LONGEST) & (frequency < 0.95 / SHORTEST)
    ratio = density[inside] / (2.0 * np.pi) / low_disturbance(2.0 * np.pi * frequency[inside])
    assert np.mean(ratio) == pytest.approx(1.0, abs=0.03)
    # The deviation of an average of m independent segments is 1/√m, about a sixth.
    assert 0.05 < np.std(ratio) < 0.3


def test_variance_is_the_integral_of_the_spectrum():
    fine = np.linspace(2.0 * np.pi / LONGEST, 2.0 * np.pi / SHORTEST, 200_001)
    integral = np.trapezoid(low_disturbance(fine), fine)
    order = wave_orders(100.0 * PERIOD, SHORTEST, LONGEST)
    harmonics = seeded_harmonics(100.0 * PERIOD, order, low_disturbance, np.random.default_rng(0))
    assert np.sum(harmonics.amplitude**2) / 2.0 == pytest.approx(integral, rel=2e-3)


def test_profile_is_the_sum_of_its_waves_with_exact_derivatives():
    harmonics = waves()
    positions = np.random.default_rng(5).uniform(-1000.0, 1000.0, 500)
    expected = direct_sum(harmonics, positions)
    # Largest possible values: Σ a Ωⁿ. A node per 1/128 of the shortest wave: (ΩΔx)⁶/46080, and two powers less in d²r/dx².
    found, wavenumber = evaluate(periodic_profile(harmonics), positions), 2.0 * np.pi * harmonics.order / PERIOD
    for n, tolerance in enumerate((1e-12, 1e-10, 2e-8)):
        scale = np.sum(harmonics.amplitude * wavenumber**n)
        np.testing.assert_allclose(found[n], expected[n], atol=tolerance * scale, rtol=0.0)


def test_derivatives_are_those_of_the_heights_themselves():
    profile, step = periodic_profile(waves()), 1e-4
    positions = np.random.default_rng(6).uniform(-50.0, 200.0, 200)
    ahead, here, behind = (evaluate(profile, positions + shift) for shift in (step, 0.0, -step))
    np.testing.assert_allclose((ahead[:2] - behind[:2]) / (2.0 * step), here[1:], atol=1e-8)


def test_profile_and_amplitudes_are_those_of_an_independent_code():
    """A profile made by TTB-2D (Cantero 2022), heights printed to 1e-12 m or better."""
    reference = json.loads(REFERENCE.read_text(encoding="utf-8"))
    period, order = reference["period_m"], np.array(reference["order"])
    mine = seeded_harmonics(
        period, order, lambda wavenumber: 7.416e-7 * german_spectrum(wavenumber), np.random.default_rng(0)
    )
    np.testing.assert_array_equal(order, wave_orders(period, 3.0, 150.0))
    np.testing.assert_allclose(mine.amplitude, reference["amplitude_m"], rtol=1e-12)
    theirs = Harmonics(period, order, mine.amplitude, np.array(reference["phase_rad"]))
    heights = evaluate(periodic_profile(theirs), np.array(reference["position_m"]))[0]
    np.testing.assert_allclose(heights, reference["height_m"], atol=1e-11)


def test_a_wave_alone_is_a_cosine():
    harmonics = waves(order=np.array([7]))
    positions = np.linspace(-20.0, 20.0, 41)
    angle = 2.0 * np.pi * 7.0 / PERIOD * positions + harmonics.phase[0]
    np.testing.assert_allclose(
        evaluate(periodic_profile(harmonics), positions)[0], harmonics.amplitude[0] * np.cos(angle), atol=1e-15
    )


def test_same_seed_only_scales_with_the_roughness():
    positions = np.linspace(-100.0, 160.0, 301)
    low = evaluate(periodic_profile(waves(seed=4)), positions)
    rough = evaluate(periodic_profile(waves(seed=4, spectrum=lambda w: 4.0 * low_disturbance(w))), positions)
    other = evaluate(periodic_profile(waves(seed=5)), positions)
    # d²r/dx² comes from differences of r over the square of 0.02 m, which leaves 1e-10 of it to rounding.
    for many, few in zip(rough, low, strict=True):
        np.testing.assert_allclose(many, 2.0 * few, atol=1e-9 * np.abs(many).max(), rtol=0.0)
    assert abs(np.corrcoef(low[0], other[0])[0, 1]) < 0.9


def test_a_wave_keeps_its_phase_when_the_band_changes():
    narrow = waves(seed=8, order=wave_orders(PERIOD, 5.0, 60.0))
    wide = waves(seed=8)
    shared = np.isin(wide.order, narrow.order)
    np.testing.assert_array_equal(wide.phase[shared], narrow.phase)
    np.testing.assert_array_equal(wide.amplitude[shared], narrow.amplitude)


def test_phases_are_uniform():
    order = np.arange(1, 20_001)
    counts = np.histogram(waves(order=order).phase, bins=20, range=(0.0, 2.0 * np.pi))[0]
    assert counts.sum() == order.size
    assert np.sum((counts - 1000.0) ** 2 / 1000.0) < 43.8  # chi-squared with 19 degrees of freedom at 0.1 %


def test_fade_in_leaves_nothing_before_and_everything_after_and_is_smooth_between():
    profile = periodic_profile(waves())
    positions, step = np.linspace(-30.0, 0.0, 3001), 0.01
    full = evaluate(profile, positions)
    faded = faded_in(full, positions, -24.0, 15.0)
    assert not faded[:, positions <= -24.0].any()
    np.testing.assert_array_equal(faded[:, positions >= -9.0], full[:, positions >= -9.0])
    middle = np.argmin(np.abs(positions + 16.5))
    assert faded[0, middle] == pytest.approx(0.5 * full[0, middle], rel=1e-6)
    np.testing.assert_allclose((faded[:2, 2:] - faded[:2, :-2]) / (2.0 * step), faded[1:, 1:-1], atol=2e-6)
    assert np.abs(np.diff(faded[2])).max() < 1e-4  # no jump of the curvature at either end
