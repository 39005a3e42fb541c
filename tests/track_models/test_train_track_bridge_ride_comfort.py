"""Sperling's index: the filter against its transfer function, closed forms, and accelerations of an independent code."""

from pathlib import Path

import numpy as np
import pytest
from scipy.signal import lsim

from railsearch.errors import InputError
from railsearch_plugins.track_models.train_track_bridge.ride_comfort import comfort_filtered, ride_comfort_index

REFERENCE = Path(__file__).parents[1] / "reference" / "ttb" / "carbody_acceleration.npz"
STEP = 1e-3


def transfer_function(s):
    return 0.59 * (0.0063 * s**2 + 0.2200 * s) / (1.4836e-4 * s**3 + 0.0070 * s**2 + 0.2488 * s + 1.0)


def steady_gain(frequency, step):
    """Gain and phase of the filter from its answer to a cosine, when all else has died out (the slowest pole is 4.5/s)."""
    time = step * np.arange(round(12.0 / step))
    answer = comfort_filtered(np.cos(2.0 * np.pi * frequency * time), step)
    settled = time >= 8.0
    basis = np.exp(2j * np.pi * frequency * time[settled])
    columns = np.column_stack([basis.real, -basis.imag])
    (real, imaginary), *_ = np.linalg.lstsq(columns, answer[settled], rcond=None)
    return real + 1j * imaginary


@pytest.mark.parametrize("frequency", [0.3, 1.0, 3.0, 5.4, 8.0, 15.0, 30.0])
def test_filter_has_the_printed_frequency_response(frequency):
    expected = transfer_function(2j * np.pi * frequency)
    # First-order hold damps by sinc²(f dt), at most 3e-3 of the gain at 30 Hz and 1 ms.
    hold = np.sinc(frequency * STEP) ** 2
    assert abs(steady_gain(frequency, STEP) / expected / hold - 1.0) < 1e-3


def test_gain_is_met_to_a_thousandth_where_carbodies_move():
    for frequency in (0.5, 1.0, 2.0, 5.0, 10.0):
        assert abs(steady_gain(frequency, STEP)) == pytest.approx(abs(transfer_function(2j * np.pi * frequency)), rel=1e-3)


def test_error_of_the_gain_falls_with_the_square_of_the_step():
    expected = transfer_function(2j * np.pi * 8.0)
    coarse, fine = (abs(steady_gain(8.0, step) / expected - 1.0) for step in (4e-3, 2e-3))
    assert np.log2(coarse / fine) == pytest.approx(2.0, abs=0.05)


def test_a_constant_acceleration_is_not_felt_after_its_onset():
    answer = comfort_filtered(np.ones(round(20.0 / STEP)), STEP)
    assert np.abs(answer).max() > 0.3
    assert abs(answer[-1]) < 1e-10


def test_a_ramp_settles_at_the_slope_of_the_transfer_function():
    # H(s)/s² → H′(0)/s: the answer to a ramp of slope c ends at c · 0.59 · 0.2200.
    time = 0.01 * np.arange(2001)
    assert comfort_filtered(3.0 * time, 0.01)[-1] == pytest.approx(3.0 * 0.59 * 0.2200, rel=1e-9)


def test_answer_to_a_piecewise_linear_acceleration_is_exact():
    generator = np.random.default_rng(2)
    values = np.concatenate([[0.0], generator.normal(size=400)])
    system = ([0.59 * 0.0063, 0.59 * 0.2200, 0.0], [1.4836e-4, 0.0070, 0.2488, 1.0])
    _, expected, _ = lsim(system, values, 0.01 * np.arange(values.size))
    np.testing.assert_allclose(comfort_filtered(values, 0.01), expected, atol=1e-12)


def test_index_of_a_cosine_is_known_in_closed_form():
    time = STEP * np.arange(round(200.0 / STEP))
    gain = abs(transfer_function(2j * np.pi * 2.0))
    index = ride_comfort_index(0.3 * np.cos(4.0 * np.pi * time), STEP)
    assert index == pytest.approx((100.0 * 0.3 * gain / np.sqrt(2.0)) ** 0.3, rel=1e-3)


def test_index_grows_with_the_power_three_tenths_and_takes_vehicles_one_by_one():
    values = np.random.default_rng(1).normal(size=(3, 500))
    index = ride_comfort_index(values, STEP)
    assert index.shape == (3,)
    np.testing.assert_allclose(ride_comfort_index(10.0 * values, STEP), 10.0**0.3 * index, rtol=1e-12)
    assert ride_comfort_index(values[1], STEP) == index[1]
    assert ride_comfort_index(np.zeros(10), STEP) == 0.0


@pytest.mark.parametrize(("case", "published"), [("c01_smooth", 0.660), ("c02_irr", 1.666), ("c05_irr_1veh_200", 1.939)])
def test_index_of_reference_runs(case, published):
    """Carbody accelerations computed by TTB-2D (Cantero 2022); the index over the whole run, to 0.1 %."""
    with np.load(REFERENCE) as data:
        index = ride_comfort_index(data[case].astype(float), float(data[f"{case}_time_step"])).max()
    assert index == pytest.approx(published, rel=1e-3)


@pytest.mark.parametrize("values", [[], 1.0, [0.0, np.nan], [np.inf]])
def test_accelerations_that_are_none_are_refused(values):
    with pytest.raises(InputError, match="acceleration: one or more finite samples"):
        comfort_filtered(values, STEP)


@pytest.mark.parametrize("step", [0.0, -1e-3, np.nan, np.inf])
def test_time_steps_that_are_none_are_refused(step):
    with pytest.raises(InputError, match="time_step: above 0 s"):
        ride_comfort_index([0.0, 1.0], step)
