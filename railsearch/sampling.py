"""Space-filling and random designs.

| symbol | meaning | shape | unit | source |
|---|---|---|---|---|
| n | number of points | scalar | - | |
| d | number of variables | scalar | - | |
| U | points of the unit cube | (n, d) | - | |
| l | level of a point in one coordinate, each of 0 … n − 1 taken once | (n, d) | - | Ye et al. 2000 |
| X | points of a random vector, F⁻¹(U) | (n, d) | the caller's | |

A symmetric design holds with every point u its mirror image 1 − u (Ye, Li and Sudjianto 2000).
"""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from railsearch.errors import InputError
from railsearch.space import FloatArray, Space

if TYPE_CHECKING:  # half a second of scipy that only those who have random vectors need
    from railsearch.distributions import RandomVector

RANK_TOLERANCE = 1e-6
"""Singular values of [U 1] below this fraction of the largest count as zero: such points determine no linear tail."""

FACE = 2.0**-53
"""How far points stay off the faces of the unit cube: the smallest step between two random numbers."""

REPAIR_ATTEMPTS = 1000
"""Random replacements tried before a design of full affine rank is given up."""


def symmetric_latin_hypercube(n_points: int, dimension: int, generator: np.random.Generator) -> FloatArray:
    """Draw a symmetric Latin hypercube U (n, d) on the unit cube: u_k = (l_k + 1/2)/n and u_{n−1−k} = 1 − u_k.

    An odd number of points has the centre of the cube as its own mirror image.
    Raises InputError for a negative number of points or a dimension below one.
    Source: Ye, Li and Sudjianto 2000.
    """
    _check_size(n_points, dimension)
    half = n_points // 2
    levels = np.full((n_points, dimension), half)
    lower = generator.permuted(np.tile(np.arange(half)[:, None], dimension), axis=0)
    first = np.where(generator.random((half, dimension)) < 0.5, lower, n_points - 1 - lower)
    levels[:half] = first
    levels[n_points - half :] = (n_points - 1 - first)[::-1]
    return (levels + 0.5) / max(n_points, 1)


def latin_hypercube(vector: "RandomVector", n_points: int, generator: np.random.Generator) -> FloatArray:
    """Draw a Latin hypercube X (n, d) of a random vector: of every input, one value in each of n equally likely intervals.

    X = F⁻¹((l + u)/n) with random permutations l and u uniform in (0, 1). Raises InputError for a negative number of points.
    Source: McKay, Beckman and Conover 1979.
    """
    _check_size(n_points, vector.dimension)
    levels = generator.permuted(np.tile(np.arange(n_points)[:, None], vector.dimension), axis=0)
    return vector.from_uniform(_inside_cube((levels + generator.random(levels.shape)) / max(n_points, 1)))


def sobol(vector: "RandomVector", n_points: int, generator: np.random.Generator) -> FloatArray:
    """Draw the first n points X (n, d) of a scrambled Sobol' sequence in the space of a random vector.

    They are balanced best if n is a power of two. Raises InputError for a negative number of points.
    Source: Sobol' 1967; Owen 1998.
    """
    return vector.from_uniform(_inside_cube(sobol_points(n_points, vector.dimension, generator)))


def sobol_points(n_points: int, dimension: int, generator: np.random.Generator) -> FloatArray:
    """Draw the first n points U (n, d) of a scrambled Sobol' sequence on the unit cube.

    Raises InputError for a negative number of points or a dimension below one. Source: Sobol' 1967; Owen 1998.
    """
    from scipy.stats.qmc import Sobol

    _check_size(n_points, dimension)
    sequence = Sobol(dimension, rng=generator)
    # A whole power of two is drawn because anything else makes scipy warn.
    points: FloatArray = sequence.random_base2(max(n_points - 1, 0).bit_length())[:n_points]
    return points


def random_points(vector: "RandomVector", n_points: int, generator: np.random.Generator) -> FloatArray:
    """Draw independent points X (n, d) of a random vector. Raises InputError for a negative number of points."""
    _check_size(n_points, vector.dimension)
    return vector.from_uniform(_inside_cube(generator.random((n_points, vector.dimension))))


def random_designs(space: Space, n_points: int, generator: np.random.Generator) -> FloatArray:
    """Draw designs (n, d) in native units, uniform over the box; every value of an integer is equally likely."""
    return designs_of_cells(space, generator.random((n_points, space.dimension)))


def designs_of_cells(space: Space, points: FloatArray) -> FloatArray:
    """Map points (n, d) of the unit cube to designs; every value of an integer has a cell of the same width."""
    margin = np.where(space.integer, 0.5, 0.0)
    return space.rounded(space.lower - margin + points * (space.upper - space.lower + 2.0 * margin))


def unseen_design(space: Space, seen: set[bytes], generator: np.random.Generator) -> FloatArray | None:
    """Draw a uniform design (d,) whose `space.key` is not in `seen`; None if every design of the space has been seen."""
    if space.size <= 2 * len(seen):
        unseen: list[FloatArray] = [design for design in _all_designs(space) if space.key(design) not in seen]
        return unseen[int(generator.integers(len(unseen)))] if unseen else None
    while True:
        design: FloatArray = random_designs(space, 1, generator)[0]
        if space.key(design) not in seen:
            return design


def affine_rank(points: FloatArray) -> int:
    """The rank of [U 1] for points U (n, d) of the unit cube: d + 1 if they determine every linear polynomial."""
    if len(points) == 0:
        return 0
    return int(np.linalg.matrix_rank(np.column_stack([points, np.ones(len(points))]), rtol=RANK_TOLERANCE))


def initial_design(
    space: Space,
    n_points: int,
    generator: np.random.Generator,
    known: FloatArray | None = None,
    avoided: FloatArray | None = None,
) -> FloatArray:
    """Make the designs (n, d), in native units, with which a search starts: a symmetric Latin hypercube, repaired.

    The points are rounded on the integers; those that coincide with one another, with `known` (k, d) or with `avoided`
    (j, d) are replaced by random unseen designs; and where k + n > d points allow it, others are replaced until the new
    and the known designs together have affine rank d + 1. If the space has fewer unseen designs than asked for, all
    of them are returned. Raises InputError for a negative number of points.
    Source: Regis and Shoemaker 2007, on the symmetric Latin hypercube of Ye et al. 2000.
    """
    nothing = np.empty((0, space.dimension))
    known, avoided = (nothing if designs is None else designs for designs in (known, avoided))
    seen = {space.key(design) for design in (*known, *avoided)}
    wished = space.from_unit(symmetric_latin_hypercube(n_points, space.dimension, generator))
    designs = _distinct(space, wished, seen, generator)
    return _of_full_rank(space, designs, known, seen, generator)


def _inside_cube(points: FloatArray) -> FloatArray:
    """Points off the faces of the cube, where unbounded inputs are infinite."""
    return np.clip(points, FACE, 1.0 - FACE)


def _check_size(n_points: int, dimension: int) -> None:
    if n_points < 0 or dimension < 1:
        raise InputError(f"design: n_points ≥ 0 and dimension ≥ 1 are needed, received {n_points} and {dimension}")


def _all_designs(space: Space) -> FloatArray:
    """Every design (size, d) of a space of integers."""
    levels = (space.upper - space.lower + 1.0).astype(int)
    return space.lower + np.stack(np.unravel_index(np.arange(int(space.size)), levels), axis=1)


def _distinct(space: Space, wished: FloatArray, seen: set[bytes], generator: np.random.Generator) -> FloatArray:
    """The wished designs, those already seen replaced by unseen ones as long as there are any; `seen` grows."""
    designs = []
    for design in wished:
        chosen = unseen_design(space, seen, generator) if space.key(design) in seen else design
        if chosen is None:
            break
        seen.add(space.key(chosen))
        designs.append(chosen)
    return np.array(designs).reshape(-1, space.dimension)


def _of_full_rank(
    space: Space, designs: FloatArray, known: FloatArray, seen: set[bytes], generator: np.random.Generator
) -> FloatArray:
    """Replace redundant designs by unseen ones until the rank is full, or as full as the number of points allows."""
    target = min(space.dimension + 1, len(designs) + len(known))
    rank = affine_rank(space.to_unit(np.vstack([known, designs])))
    for _ in range(REPAIR_ATTEMPTS):
        if rank == target or not len(designs):
            break
        replacement = unseen_design(space, seen, generator)
        if replacement is None:
            break
        trial = designs.copy()
        trial[_redundant(space.to_unit(known), space.to_unit(designs), rank)] = replacement
        trial_rank = affine_rank(space.to_unit(np.vstack([known, trial])))
        if trial_rank > rank:
            designs, rank = trial, trial_rank
            seen.add(space.key(replacement))
    return designs


def _redundant(known: FloatArray, points: FloatArray, rank: int) -> np.intp:
    """The index of a point without which the rank stays the same."""
    without: NDArray[np.bool_] = np.array(
        [affine_rank(np.vstack([known, np.delete(points, k, axis=0)])) == rank for k in range(len(points))]
    )
    return np.argmax(without)
