"""Importances over refits."""

import json

import numpy as np
import pytest
from functions import Differentiable, box

from railsearch.errors import InputError, SurrogateError
from railsearch.sensitivity import bootstrap_importances, factors_on, importances_over_designs

SPACE = box((0.0, 1.0), (0.0, 1.0))
FACTORS = factors_on(SPACE, 5)
COEFFICIENTS = np.array([2.0, 1.0])


def least_squares(points, values):
    found = np.linalg.lstsq(np.column_stack([points, np.ones(len(points))]), values, rcond=None)[0]
    return Differentiable(lambda x: x @ found[:2] + found[2], lambda x: np.tile(found[:2], (len(x), 1)))


def samples(seed, noise=0.0, n=40):
    generator = np.random.default_rng(seed)
    points = generator.random((n, 2))
    return points, points @ COEFFICIENTS + noise * generator.standard_normal(n)


def test_without_noise_all_refits_agree_with_the_truth():
    spread = bootstrap_importances(*samples(0), 6, least_squares, FACTORS, np.random.default_rng(1))
    np.testing.assert_allclose(spread.importances, np.tile([0.8, 0.2], (6, 1)), atol=1e-9)
    assert spread.failures == {}


def test_the_interval_widens_with_the_noise_and_holds_the_truth():
    """σ of a slope from n points with noise s on the unit interval is s √(12/n); I moves by 4·0.2·0.8·δ/2 or so."""
    widths = []
    for noise in (0.02, 0.2):
        spread = bootstrap_importances(*samples(3, noise, 200), 40, least_squares, FACTORS, np.random.default_rng(1))
        low, high = spread.interval(0.9)
        assert low[0] < 0.8 < high[0]
        widths.append(high[0] - low[0])
    assert 5.0 < widths[1] / widths[0] < 20.0, "in proportion to the noise"


def test_each_refit_learns_distinct_points_of_the_design():
    points, values = samples(0, n=500)
    sizes = []

    def remembering(some, their_values):
        assert len(np.unique(some, axis=0)) == len(some)
        np.testing.assert_allclose(their_values, some @ COEFFICIENTS)
        sizes.append(len(some))
        return least_squares(some, their_values)

    bootstrap_importances(points, values, 5, remembering, FACTORS, np.random.default_rng(2))
    assert np.mean(sizes) == pytest.approx(500 * (1.0 - np.exp(-1.0)), rel=0.05)
    assert len(set(sizes)) > 1


def test_failed_refits_are_left_out_and_named():
    calls = []

    def second_fails(points, values):
        calls.append(len(points))
        if len(calls) == 2:
            raise np.linalg.LinAlgError("singular")
        return least_squares(points, values)

    told = []
    spread = importances_over_designs(
        [samples(seed) for seed in range(3)],
        second_fails,
        FACTORS,
        np.random.default_rng(0),
        progress=lambda done, total: told.append((done, total)),
    )
    assert spread.failures == {2: "LinAlgError: singular"}
    assert spread.importances.shape == (2, 2)
    assert told == [(1, 3), (2, 3), (3, 3)]
    document = json.loads(json.dumps(spread.document(), allow_nan=False))
    assert document["failures"] == {"2": "LinAlgError: singular"}
    assert document["factors"][0]["median"] == pytest.approx(0.8)


def test_missing_values_are_left_out():
    points, values = samples(0)
    values[::4] = np.nan
    spread = bootstrap_importances(points, values, 2, least_squares, FACTORS, np.random.default_rng(1))
    np.testing.assert_allclose(spread.importances[:, 0], 0.8, atol=1e-9)


def test_the_same_seed_gives_the_same_bits():
    first, second = (
        bootstrap_importances(*samples(0, 0.1), 3, least_squares, FACTORS, np.random.default_rng(7)) for _ in range(2)
    )
    assert first.importances.tobytes() == second.importances.tobytes()


def test_bad_input_is_named():
    points, values = samples(0)
    generator = np.random.default_rng(0)
    for arguments, message in (
        ((points, values, 0, least_squares, FACTORS, generator), "refits"),
        ((points[:, :1], values, 2, least_squares, FACTORS, generator), r"points \(n, 2\) in the order x1, x2"),
        ((points, np.full(40, np.nan), 2, least_squares, FACTORS, generator), "none of 40"),
    ):
        with pytest.raises(InputError, match=message):
            bootstrap_importances(*arguments)
    with pytest.raises(SurrogateError, match="none of 1 refits succeeded; the first one failed with ZeroDivisionError"):
        importances_over_designs([(points, values)], lambda p, v: 1 / 0, FACTORS, generator)
    with pytest.raises(InputError, match="level"):
        bootstrap_importances(points, values, 1, least_squares, FACTORS, generator).interval(1.0)
