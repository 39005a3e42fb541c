"""Classical sensitivities against closed forms: Sobol' indices, elementary effects, one at a time."""

import json

import numpy as np
import pytest

from railsearch.distributions import random_vector
from railsearch.errors import InputError, SimulationError
from railsearch.sensitivity.factors import factors_on
from railsearch.sensitivity.screening import elementary_effects, one_at_a_time
from railsearch.sensitivity.variance_based import sobol_indices
from railsearch.space import Space, Variable

UNIFORM = random_vector({f"x{k}": {"distribution": "uniform", "lower": -np.pi, "upper": np.pi} for k in (1, 2, 3)})
BOX = Space((Variable("a", 0.0, 2.0, "m"), Variable("b", -1.0, 3.0, "N"), Variable("c", 10.0, 20.0)))


def ishigami(x):
    return np.sin(x[:, 0]) + 7.0 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])


def linear(x):
    return 5.0 + 2.0 * x[:, 0] - 3.0 * x[:, 1] + 0.0 * x[:, 2]


def test_indices_of_the_ishigami_function():
    """S = (0.3139, 0.4424, 0), T = (0.5576, 0.4424, 0.2437) (Ishigami & Homma 1990)."""
    found = sobol_indices(ishigami, UNIFORM, 4096, np.random.default_rng(1))
    np.testing.assert_allclose(found.first, [0.31390519, 0.44241114, 0.0], atol=0.02)
    np.testing.assert_allclose(found.total, [0.55758886, 0.44241114, 0.24368366], atol=0.02)
    assert found.evaluations == 4096 * 5
    assert np.all(np.abs(found.first - [0.31390519, 0.44241114, 0.0]) < 2.0 * found.first_half_width)


def test_indices_are_those_of_the_distributions():
    """Var of a sum is the sum of the variances, whatever their distributions are."""
    inputs = random_vector(
        {
            "n": {"distribution": "normal", "mean": 4.0, "std": 1.0},
            "g": {"distribution": "gumbel-max", "mean": 0.0, "std": 2.0},
            "l": {"distribution": "lognormal", "mean": 3.0, "std": 1.0},
        }
    )
    found = sobol_indices(lambda x: x.sum(axis=1), inputs, 4096, np.random.default_rng(2))
    np.testing.assert_allclose(found.first, [1 / 6, 4 / 6, 1 / 6], atol=0.02)
    np.testing.assert_allclose(found.total, found.first, atol=0.03)


def test_elementary_effects_of_a_linear_function_are_its_slopes_over_the_ranges():
    found = elementary_effects(linear, BOX, 10, np.random.default_rng(3))
    np.testing.assert_allclose(found.mean_absolute, [4.0, 12.0, 0.0], atol=1e-9)
    np.testing.assert_allclose(found.deviation, 0.0, atol=1e-9)
    assert found.evaluations == 40


def test_interactions_show_in_the_deviation():
    found = elementary_effects(lambda x: x[:, 0] * x[:, 1] + x[:, 2], BOX, 40, np.random.default_rng(4))
    assert found.deviation[0] > 0.2 * found.mean_absolute[0]
    assert found.deviation[2] == pytest.approx(0.0, abs=1e-9)


def test_one_at_a_time_shares_are_those_of_the_squared_ranges():
    factors = factors_on(BOX, 21)
    found = one_at_a_time(linear, factors)
    np.testing.assert_allclose(found.importances, [16.0 / 160.0, 144.0 / 160.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(found.curves[0], 5.0 + 2.0 * factors.grids[0] - 3.0)
    moved = one_at_a_time(lambda x: x[:, 0] * x[:, 1] + 0.0 * x[:, 2], factors, np.array([0.0, 0.0, 10.0]))
    np.testing.assert_array_equal(moved.importances, 0.0)


def failing(share, seed):
    generator = np.random.default_rng(seed)
    return lambda x: np.where(generator.random(len(x)) < share, np.nan, linear(x))


def test_failed_evaluations_are_left_out_and_counted():
    found = elementary_effects(failing(0.05, 1), BOX, 30, np.random.default_rng(5))
    assert 0 < found.dropped < 30
    np.testing.assert_allclose(found.mean_absolute, [4.0, 12.0, 0.0], atol=1e-9)
    few = sobol_indices(failing(0.02, 2), UNIFORM, 1024, np.random.default_rng(6))
    assert 0 < few.dropped < 200
    np.testing.assert_allclose(few.first, [4 / 13, 9 / 13, 0.0], atol=0.08)
    assert one_at_a_time(failing(0.2, 3), factors_on(BOX, 11)).document()["failures"] > 0
    with pytest.raises(SimulationError, match=r"of 8 blocks are whole"):
        sobol_indices(lambda x: np.full(len(x), np.nan), UNIFORM, 8, np.random.default_rng(7))


def test_same_seed_same_numbers_and_documents_are_plain():
    for made in (
        lambda: sobol_indices(ishigami, UNIFORM, 64, np.random.default_rng(8)),
        lambda: elementary_effects(linear, BOX, 4, np.random.default_rng(8)),
        lambda: one_at_a_time(linear, factors_on(BOX, 5)),
    ):
        assert json.dumps(made().document(), allow_nan=False) == json.dumps(made().document(), allow_nan=False)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda g: sobol_indices(linear, UNIFORM, 1000, g),
            "a power of two from 2 is needed .*, received 1000",
        ),
        (lambda g: sobol_indices(lambda x: np.ones(len(x)), UNIFORM, 8, g), "the output is 1 at every point"),
        (lambda g: elementary_effects(linear, BOX, 1, g), "two or more are needed, received 1"),
        (lambda g: one_at_a_time(linear, factors_on(BOX, 5), np.array([5.0, 0.0, 10.0])), "a.*5"),
    ],
)
def test_faults_are_named(call, message):
    with pytest.raises(InputError, match=message):
        call(np.random.default_rng(9))
