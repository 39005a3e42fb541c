"""The uncertain inputs of the train-track-bridge system: their statistics as published."""

import numpy as np
import pytest

from railsearch_problems.train_track_bridge_inputs import UNCERTAIN_INPUTS, uncertain_inputs

# Name: mean and standard deviation of a normal or lognormal input.
PRINTED_MOMENTS = {
    "carbody_mass_factor": (1.0, 0.15),
    "primary_stiffness_factor": (1.0, 0.10),
    "secondary_stiffness_factor": (1.0, 0.10),
    "bridge_mass": (69000.0, 2760.0),
    "bridge_modulus": (35e9, 2.8e9),
    "bridge_damping": (0.02, 0.003),
    "bridge_inertia": (51.3, 2.565),
}
PRINTED_BOUNDS = {
    "pad_stiffness": (1e8, 1.5e9),
    "pad_damping": (1e4, 7e4),
    "sleeper_mass": (220.0, 325.0),
    "ballast_density": (1500.0, 2100.0),
    "ballast_modulus": (8e7, 1.6e8),
    "ballast_depth": (0.3, 0.6),
    "ballast_angle": (15.0, 35.0),
    "ballast_damping": (4e4, 2.8e5),
    "irregularity_amplitude": (4.032e-7, 10.80e-7),
}


def test_there_are_sixteen_of_the_printed_moments_and_bounds():
    vector = uncertain_inputs()
    assert set(vector.names) == PRINTED_MOMENTS.keys() | PRINTED_BOUNDS.keys()
    assert vector.dimension == 16 == len(UNCERTAIN_INPUTS)
    for name, moments in PRINTED_MOMENTS.items():
        marginal = vector.marginals[name]
        assert (marginal.mean, marginal.std) == pytest.approx(moments, rel=1e-12)
    for name, bounds in PRINTED_BOUNDS.items():
        marginal = vector.marginals[name]
        assert marginal.support == pytest.approx(bounds, rel=1e-12)
        assert marginal.std == pytest.approx((bounds[1] - bounds[0]) / np.sqrt(12.0), rel=1e-12)


def test_factors_are_skewed_and_the_bridge_is_not():
    vector = uncertain_inputs()
    median, mean = vector.percentiles(0.5)[0], vector.mean
    for name, low, centre in zip(vector.names, median, mean, strict=True):
        assert (low < centre * (1.0 - 1e-3)) == name.endswith("factor")


def test_published_thresholds_of_the_carbody_mass_lie_inside_its_range():
    """Safe ranges are published for carbodies below 27 500 kg and below 37 000 kg, of 32 000 kg in the mean."""
    low, high = 32000.0 * uncertain_inputs().ranges()[0]
    assert low < 27500.0 < 37000.0 < high
