"""Spectra by name, seeded and measured profiles, and what is refused at the door."""

import math
from types import ModuleType

import numpy as np
import pytest

from railsearch.errors import InputError
from railsearch_plugins.track_irregularity import (
    SPECTRA,
    FadedIn,
    Spectrum,
    level_track,
    measured_profile,
    profile_from_file,
    seeded_profile,
    spectrum_named,
)

POSITIONS = np.linspace(-130.0, 160.0, 2901)


@pytest.fixture
def foreign_module(monkeypatch):
    module = ModuleType("foreign_spectra")
    module.white = Spectrum(np.ones_like, 2e-9, "white")
    module.number = 3
    module.falling_below_zero = Spectrum(lambda wavenumber: 1.0 - wavenumber, 1e-9, "negative beyond 1 rad/m")
    monkeypatch.setitem(__import__("sys").modules, "foreign_spectra", module)


@pytest.mark.parametrize("name", SPECTRA)
def test_every_spectrum_falls_and_makes_a_profile_of_its_own_variance(name):
    spectrum = SPECTRA[name]
    order = np.arange(4, 201)
    step = 2.0 * math.pi / 600.0
    density = spectrum.roughness * spectrum.density(step * order)
    assert (np.diff(density) < 0.0).all()
    heights = seeded_profile(name, seed=1)(np.arange(0.0, 600.0, 0.5))[0]
    assert np.mean(heights**2) == pytest.approx(step * density.sum(), rel=1e-6)


def test_german_disturbances_and_fra_classes_are_ordered():
    assert SPECTRA["german-low"].roughness < SPECTRA["german"].roughness < SPECTRA["german-high"].roughness
    assert SPECTRA["german"].roughness == pytest.approx(0.5 * (4.032e-7 + 1.080e-6), rel=1e-12)
    classes = [SPECTRA[f"fra-{number}"].roughness for number in range(1, 7)]
    assert classes == sorted(classes, reverse=True)
    # cm² rad/m as printed
    assert classes == pytest.approx([1.2107e-4, 1.0181e-4, 0.6816e-4, 0.5376e-4, 0.2095e-4, 0.0339e-4], rel=1e-12)


def test_best_american_class_is_rougher_than_german_high_disturbance_only_in_long_waves():
    """k A_v of class 6 is 8.5e-7 m² rad/m, between the two German levels where Ω_r does not matter."""
    wavenumber = np.array([2.0 * math.pi / 5.0])
    level = {name: SPECTRA[name].roughness * SPECTRA[name].density(wavenumber)[0] for name in SPECTRA}
    assert level["german-low"] < level["fra-6"] < level["german-high"] < level["fra-5"]


def test_roughness_only_scales_the_profile_of_a_seed():
    one = seeded_profile("german", 3, roughness=4.032e-7)(POSITIONS)
    other = seeded_profile("german", 3, roughness=10.80e-7)(POSITIONS)
    # d²r/dx² comes from differences of r over the square of 0.02 m, which leaves 1e-10 of it to rounding.
    for rough, smooth in zip(other, one, strict=True):
        np.testing.assert_allclose(rough, math.sqrt(10.80 / 4.032) * smooth, atol=1e-9 * np.abs(rough).max(), rtol=0.0)
    np.testing.assert_array_equal(seeded_profile("german-low", 3)(POSITIONS), one)
    np.testing.assert_array_equal(seeded_profile("german", 3, roughness=0.0)(POSITIONS), level_track(POSITIONS))


@pytest.mark.parametrize(
    "profile",
    [seeded_profile(), measured_profile(POSITIONS, np.sin(POSITIONS)), FadedIn(seeded_profile(), -24.0, 15.0), level_track],
    ids=["seeded", "measured", "faded in", "level"],
)
def test_positions_of_several_wheels_are_taken_at_once(profile):
    wheels = POSITIONS[:2900].reshape(4, 725)
    together = profile(wheels)
    assert together.shape == (3, 4, 725)
    for wheel in range(4):
        np.testing.assert_array_equal(together[:, wheel], profile(wheels[wheel]))


def test_same_seed_same_profile_and_another_seed_another():
    first, again, other = (seeded_profile("german", seed)(POSITIONS) for seed in (7, 7, 8))
    assert first.tobytes() == again.tobytes()
    assert abs(np.corrcoef(first[0], other[0])[0, 1]) < 0.9


def test_a_spectrum_of_another_module_is_found_by_its_dotted_name(foreign_module):
    assert spectrum_named("foreign_spectra:white").meaning == "white"
    heights = seeded_profile("foreign_spectra:white", 1)(np.arange(0.0, 600.0, 0.5))[0]
    assert np.mean(heights**2) == pytest.approx(2e-9 * 197 * 2.0 * math.pi / 600.0, rel=1e-9)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("fra-7", "unknown spectrum 'fra-7'.*there are german, german-low, german-high, fra-1, .*fra-6"),
        ("no_such_module:white", "No module named 'no_such_module'"),
        ("foreign_spectra:black", "has no attribute 'black'"),
        (":white", "module:NAME"),
        ("foreign_spectra:number", "a Spectrum is needed, received int"),
        ("foreign_spectra:falling_below_zero", "≥ 0 and finite"),
    ],
)
def test_unknown_and_unusable_spectra_are_refused_by_name(foreign_module, name, words):
    with pytest.raises(InputError, match=words):
        seeded_profile(name)


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"roughness": -1e-7}, "A_v ≥ 0 m² rad/m is needed, received -1e-07"),
        ({"roughness": math.nan}, "A_v ≥ 0"),
        ({"seed": -1}, "seed: an integer ≥ 0"),
        ({"seed": 1.5}, "seed: an integer ≥ 0"),
        ({"shortest": 0.0}, "wavelengths: 0 < shortest"),
        ({"longest": 700.0}, "wavelengths: 0 < shortest"),
    ],
)
def test_settings_without_a_profile_are_refused(settings, words):
    with pytest.raises(InputError, match=words):
        seeded_profile(**settings)


def test_a_run_longer_than_the_period_is_refused():
    profile = seeded_profile(period=300.0)
    assert profile([-100.0, 200.0]).shape == (3, 2)
    with pytest.raises(InputError, match="the run is 301 m long and the generated profile repeats after 300 m"):
        profile([-100.0, 201.0])


def test_measured_heights_of_a_cubic_come_back_with_both_derivatives():
    cubic = np.polynomial.Polynomial([1e-3, -2e-4, 3e-6, 1e-7])
    x = np.array([-30.0, -12.0, 0.0, 5.0, 31.0, 60.0])
    inside = np.linspace(-30.0, 60.0, 91)
    found = measured_profile(x, cubic(x))(inside)
    for order in range(3):
        np.testing.assert_allclose(found[order], cubic.deriv(order)(inside) if order else cubic(inside), atol=1e-15)


def test_measured_derivatives_converge_to_those_of_a_wave():
    """Spline errors fall with the fourth, third and second power of the distance between the points."""
    wave, inside = 2.0 * math.pi / 12.0, np.linspace(20.0, 40.0, 777)
    exact = 1e-3 * np.stack([np.sin(wave * inside), wave * np.cos(wave * inside), -(wave**2) * np.sin(wave * inside)])
    errors = []
    for count in (121, 241):
        x = np.linspace(0.0, 60.0, count)
        errors.append(np.abs(measured_profile(x, 1e-3 * np.sin(wave * x))(inside) - exact).max(axis=1))
    np.testing.assert_allclose(np.log2(errors[0] / errors[1]), [4.0, 3.0, 2.0], atol=0.15)


def test_a_file_is_read_with_comments_and_any_separator(tmp_path):
    x = np.arange(-5.0, 6.0)
    for separator in (",", ";", " ", "\t"):
        path = tmp_path / "level.csv"
        path.write_text("# position, height\n" + "".join(f"{a}{separator}{1e-3 * a}\n" for a in x), encoding="utf-8")
        np.testing.assert_allclose(profile_from_file(path)([0.25]), [[2.5e-4], [1e-3], [0.0]], atol=1e-15)


def test_a_file_too_short_for_the_run_is_refused_by_name(tmp_path):
    path = tmp_path / "level.csv"
    path.write_text("".join(f"{x} 0\n" for x in range(11)), encoding="utf-8")
    assert profile_from_file(path)([0.0, 10.0]).shape == (3, 2)
    for run in ([-0.1, 5.0], [5.0, 10.1]):
        with pytest.raises(
            InputError, match=r"level\.csv: the profile is too short: it covers 0 to 10 m and the wheels run"
        ):
            profile_from_file(path)(run)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (None, "cannot be read"),
        ("height\nlow\n", "two columns of numbers"),
        ("1 2 3\n4 5 6\n", "two columns, position and height in m, are needed, received 3"),
        ("0 0\n1 0\n2 0\n", "four or more positions"),
        ("0 0\n1 0\n1 0\n2 0\n", "positions must ascend, received 1 m after 1 m"),
        ("0 0\n1 nan\n2 0\n3 0\n", "finite positions and heights"),
    ],
)
def test_files_that_hold_no_profile_are_refused_by_name(tmp_path, text, words):
    path = tmp_path / "level.csv"
    if text is not None:
        path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=rf"level\.csv: .*{words}|level\.csv: {words}"):
        profile_from_file(path)


def test_fade_in_wraps_any_profile():
    profile = seeded_profile("german", 1)
    faded = FadedIn(profile, -24.0, 15.0)(POSITIONS)
    assert not faded[:, POSITIONS <= -24.0].any()
    np.testing.assert_array_equal(faded[:, POSITIONS >= -9.0], profile(POSITIONS)[:, POSITIONS >= -9.0])


@pytest.mark.parametrize("length", [0.0, -1.0, math.nan])
def test_a_fade_in_of_no_length_is_refused(length):
    with pytest.raises(InputError, match="irregularity fade-in: a length above 0 m"):
        FadedIn(level_track, -24.0, length)


@pytest.mark.parametrize("first", ["x [m],z [m]", "# x [m], z [m]", "position height", "-1.0,0.0"])
def test_first_line_of_a_file_may_be_words(tmp_path, first):
    file = tmp_path / "profile.csv"
    file.write_text(first + "\n0,0\n1,0.001\n2,0.002\n3,0\n", encoding="utf-8")
    profile = profile_from_file(file)
    assert profile.spline.x[0] == (-1.0 if first == "-1.0,0.0" else 0.0)
    assert profile(2.0)[0] == pytest.approx(0.002)
