"""Latin hypercubes, their symmetry, and initial designs that determine a linear polynomial."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from railsearch.distributions import random_vector
from railsearch.errors import InputError
from railsearch.sampling import (
    affine_rank,
    initial_design,
    latin_hypercube,
    random_designs,
    random_points,
    sobol,
    symmetric_latin_hypercube,
    unseen_design,
)
from railsearch.space import Space, Variable

INPUTS = random_vector(
    {
        "modulus": {"distribution": "lognormal", "mean": 2.1e11, "cov": 0.1},
        "load": {"distribution": "gumbel-max", "mean": 5e4, "std": 7.5e3},
        "depth": {"distribution": "uniform", "lower": 0.3, "upper": 0.6},
    }
)
DESIGNS = {"latin-hypercube": latin_hypercube, "sobol": sobol, "random": random_points}
SIZES = st.tuples(st.integers(1, 25), st.integers(1, 8), st.integers(0, 2**32))


@st.composite
def spaces(draw):
    """Spaces of one to six variables, some of them integers of two to six values."""
    kinds = draw(st.lists(st.integers(0, 5), min_size=1, max_size=6))
    return Space(
        tuple(
            Variable(f"x{k}", -1.0, -1.0 + levels, integer=True) if levels else Variable(f"x{k}", -3.0, 7.5)
            for k, levels in enumerate(kinds)
        )
    )


@given(SIZES)
def test_symmetric_latin_hypercube_is_latin_and_its_own_mirror_image(size):
    n, d, seed = size
    points = symmetric_latin_hypercube(n, d, np.random.default_rng(seed))
    assert np.array_equal(np.sort(np.floor(points * n), axis=0), np.tile(np.arange(n)[:, None], d))
    np.testing.assert_allclose(points + points[::-1], 1.0, atol=1e-12)


def test_symmetric_latin_hypercube_takes_every_level_equally_often_in_a_given_place():
    generator = np.random.default_rng(0)
    first = np.array([symmetric_latin_hypercube(6, 1, generator)[0, 0] for _ in range(3000)])
    counts = np.bincount((first * 6).astype(int), minlength=6)
    expected = 3000 / 6
    assert np.sum((counts - expected) ** 2 / expected) < 20.5  # chi-squared with 5 degrees of freedom at 0.1 %


@given(SIZES)
def test_same_seed_same_points(size):
    n, d, seed = size
    first, second = (symmetric_latin_hypercube(n, d, np.random.default_rng(seed)) for _ in range(2))
    assert first.tobytes() == second.tobytes()


def test_random_designs_take_every_integer_equally_often():
    space = Space((Variable("k", 0, 4, integer=True),))
    counts = np.bincount(random_designs(space, 5000, np.random.default_rng(1))[:, 0].astype(int), minlength=5)
    assert np.sum((counts - 1000) ** 2 / 1000) < 18.5  # chi-squared with 4 degrees of freedom at 0.1 %


@settings(deadline=None)
@example(Space((Variable("k", -1, 0, integer=True),)), 0, 2, 0, 1)
@given(spaces(), st.integers(0, 30), st.integers(0, 4), st.integers(0, 4), st.integers(0, 2**32))
def test_initial_design_is_distinct_allowed_and_of_full_rank(space, n, n_known, n_avoided, seed):
    generator = np.random.default_rng(seed)
    known, avoided = random_designs(space, n_known, generator), random_designs(space, n_avoided, generator)
    designs = initial_design(space, n, generator, known, avoided)
    taken = {space.key(design) for design in (*known, *avoided)}
    keys = [space.key(space.checked(design)) for design in designs]
    assert len(set(keys)) == len(keys)
    assert not taken & set(keys)
    assert len(designs) == min(n, space.size - len(taken))
    if n > space.dimension and len(designs) == n < space.size - len(taken):
        assert affine_rank(space.to_unit(np.vstack([known, designs]))) == space.dimension + 1


def test_as_few_points_as_d_plus_one_have_full_rank_though_a_symmetric_design_has_not():
    space = Space(tuple(Variable(f"x{k}", 0.0, 1.0) for k in range(7)))
    for seed in range(20):
        assert affine_rank(symmetric_latin_hypercube(8, 7, np.random.default_rng(seed))) < 8
        assert affine_rank(initial_design(space, 8, np.random.default_rng(seed))) == 8


def test_initial_design_of_a_space_with_fewer_designs_returns_all_of_them():
    space = Space((Variable("a", 0, 2, integer=True), Variable("b", 0, 1, integer=True)))
    designs = initial_design(space, 20, np.random.default_rng(0))
    assert sorted(map(tuple, designs)) == [(a, b) for a in range(3) for b in range(2)]


def test_unseen_design_finds_the_last_one_and_then_none():
    space = Space((Variable("a", -1, 2, integer=True), Variable("b", 5, 6, integer=True)))
    generator, seen = np.random.default_rng(0), set()
    for _ in range(8):
        seen.add(space.key(unseen_design(space, seen, generator)))
    assert len(seen) == 8
    assert unseen_design(space, seen, generator) is None


@pytest.mark.parametrize("size", [(-1, 2), (3, 0)])
def test_impossible_sizes_are_refused(size):
    with pytest.raises(InputError, match="n_points ≥ 0 and dimension ≥ 1"):
        symmetric_latin_hypercube(*size, np.random.default_rng(0))


@given(st.integers(0, 40), st.integers(0, 2**32))
def test_latin_hypercube_of_a_vector_has_one_value_in_each_equally_likely_interval(n, seed):
    points = latin_hypercube(INPUTS, n, np.random.default_rng(seed))
    assert points.shape == (n, 3)
    levels = np.floor(INPUTS.cdf(points) * n + 1e-9)
    assert np.array_equal(np.sort(levels, axis=0), np.tile(np.arange(n)[:, None], 3))


def test_latin_hypercube_is_uniform_inside_its_intervals_and_its_columns_are_shuffled_apart():
    points = INPUTS.cdf(latin_hypercube(INPUTS, 4000, np.random.default_rng(3)))
    inside = np.histogram((points * 4000) % 1.0, bins=10, range=(0.0, 1.0))[0]
    assert np.sum((inside - 1200.0) ** 2 / 1200.0) < 27.9  # chi-squared with 9 degrees of freedom at 0.1 %
    # Ranks of independent columns correlate with a deviation of 1/√n, 0.016.
    assert np.abs(np.corrcoef(points.T) - np.eye(3)).max() < 0.07


@pytest.mark.parametrize("n", [0, 1, 2, 64, 100, 300])
def test_sobol_points_are_those_of_the_sequence_in_probability(n):
    points = sobol(INPUTS, n, np.random.default_rng(5))
    assert points.shape == (n, 3)
    whole = INPUTS.cdf(sobol(INPUTS, 512, np.random.default_rng(5)))
    np.testing.assert_allclose(INPUTS.cdf(points), whole[:n], atol=1e-9)
    if n == 64:  # a (t, m, s)-net: every half of 64 points has one value in each of 64 intervals of every coordinate
        assert np.array_equal(np.sort(np.floor(INPUTS.cdf(points) * n), axis=0), np.tile(np.arange(n)[:, None], 3))


def test_means_by_latin_hypercube_and_sobol_are_closer_than_by_random_points():
    def error(design):
        draws = [np.mean(design(INPUTS, 256, np.random.default_rng(seed)), axis=0) for seed in range(20)]
        return np.sqrt(np.mean((np.array(draws) / INPUTS.mean - 1.0) ** 2, axis=0))

    # 256 points: σ/√n at random; a stratified variable alone converges faster than 1/n.
    random = error(random_points)
    np.testing.assert_allclose(random, INPUTS.std / INPUTS.mean / 16.0, rtol=0.5)
    assert (error(latin_hypercube) < 0.2 * random).all()
    assert (error(sobol) < 0.2 * random).all()


@pytest.mark.parametrize("design", DESIGNS.values(), ids=DESIGNS)
def test_designs_of_a_vector_follow_the_generator_alone_and_are_finite(design):
    first, second = (design(INPUTS, 33, np.random.default_rng(9)) for _ in range(2))
    assert first.tobytes() == second.tobytes()
    assert first.tobytes() != design(INPUTS, 33, np.random.default_rng(10)).tobytes()
    assert np.isfinite(first).all()
    with pytest.raises(InputError, match="n_points ≥ 0"):
        design(INPUTS, -1, np.random.default_rng(0))


class Corner:
    """A generator that draws the smallest number there is, every time."""

    @staticmethod
    def random(shape):
        return np.zeros(shape)


def test_unbounded_inputs_stay_finite_on_the_faces_of_the_cube():
    assert np.isfinite(random_points(INPUTS, 2, Corner())).all()
