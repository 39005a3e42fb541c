"""Candidates: random perturbations of the incumbent.

| symbol | meaning | shape | unit | source |
|---|---|---|---|---|
| x* | incumbent, the best design of the trajectory | (d,) | native | |
| σ | standard deviation of a perturbation | scalar | of the range | Regis and Shoemaker 2007 |
| p(n) | probability with which a coordinate is perturbed | scalar | - | Regis and Shoemaker 2013 |
| p₀ | p at the first perturbation | scalar | - | Regis and Shoemaker 2013 |
| n, n₀, N | evaluations of the trajectory so far, its initial ones, those it may spend in all | scalars | - | |
"""

import math

import numpy as np
from numpy.typing import NDArray

from railsearch.space import FloatArray, Space


def perturbation_probability(n: int, n_initial: int, budget: int, p_initial: float) -> float:
    """The probability p(n) = p₀ [1 − ln(n − n₀ + 1)/ln(N − n₀)] with which a coordinate is perturbed.

    It falls from p₀ at n = n₀ to 0 at the last evaluation n = N − 1, and stays p₀ where N − n₀ ≤ 1.
    Source: Regis and Shoemaker 2013.
    """
    if budget - n_initial <= 1:
        return p_initial
    return p_initial * max(0.0, 1.0 - math.log(n - n_initial + 1) / math.log(budget - n_initial))


def perturbed(
    space: Space,
    incumbent: FloatArray,
    sigma: float | FloatArray,
    probability: float | FloatArray,
    count: int,
    generator: np.random.Generator,
) -> FloatArray:
    """Candidates (count, d), in native units, around the incumbent (d,): σ N(0, 1) on the chosen coordinates.

    Each coordinate is chosen with the given probability, one at least; σ and the probability are those of all candidates, or
    one for each (count,). Perturbations are fractions of the range, reflected
    at the bounds; a chosen integer moves by one step or more and is rounded.
    Source: Regis and Shoemaker 2013; integers: Müller 2016.
    """
    chosen = _chosen_coordinates(count, space.dimension, probability, generator)
    steps = np.reshape(sigma, (-1, 1)) * generator.standard_normal(chosen.shape)
    moved = space.from_unit(reflected(space.to_unit(incumbent) + steps))
    moved = np.where(space.integer & (moved == incumbent), _one_step(space, incumbent, steps), moved)
    return np.where(chosen, moved, incumbent)


def perturbed_reals(space: Space, incumbent: FloatArray, sigma: FloatArray, generator: np.random.Generator) -> FloatArray:
    """Candidates (count, d), in native units, that differ from the incumbent (d,) in all real variables and in no integer.

    Perturbations are σ N(0, 1), with one σ for each candidate (count,), in fractions of the range, reflected at the bounds.
    """
    steps = sigma[:, None] * generator.standard_normal((len(sigma), space.dimension))
    moved = space.from_unit(reflected(space.to_unit(incumbent) + steps))
    return np.where(space.integer, incumbent, moved)


def reflected(points: FloatArray) -> FloatArray:
    """Points brought into the unit cube by mirroring at its faces, as often as needed."""
    folded = np.mod(points, 2.0)
    return np.where(folded > 1.0, 2.0 - folded, folded)


def _chosen_coordinates(
    count: int, dimension: int, probability: float | FloatArray, generator: np.random.Generator
) -> NDArray[np.bool_]:
    """A mask (count, d) in which every row has one chosen coordinate at least."""
    chosen: NDArray[np.bool_] = generator.random((count, dimension)) < np.reshape(probability, (-1, 1))
    fallback = generator.integers(dimension, size=count)
    idle = ~chosen.any(axis=1)
    chosen[idle, fallback[idle]] = True
    return chosen


def _one_step(space: Space, incumbent: FloatArray, steps: FloatArray) -> FloatArray:
    """The incumbent moved by one step of the integers, in the direction of `steps` or off the bound."""
    ahead = incumbent + np.sign(steps)
    inside = (ahead >= space.lower) & (ahead <= space.upper)
    return np.where(inside, ahead, incumbent - np.sign(steps))
