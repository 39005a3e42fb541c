"""How many of the selected terms the trend should have: optimal PC-Kriging.

| symbol | meaning | shape | source |
|---|---|---|---|
| p | number of terms, in the order in which they were selected, the constant first | scalar | |
| k | number of them in the trend | scalar | |
| θ | length scales | (d,) | |
| ε_k(θ) | mean square of the leave-one-out residuals with the first k terms | (p,) | Schöbi et al. 2015, section 3.3 |

Published is one estimate of θ for every k. Here ε_k(θ) of all k at once costs one factorisation (see
`leave_one_out_by_trend`), and θ moves little with k: so θ is estimated for k = 1, 4, 16, …, p, the least of all ε_k at
these θ gives k, and θ and k are improved in turn as long as ε falls.
"""

import itertools
from dataclasses import dataclass

import numpy as np

from railsearch.space import FloatArray

from ..gaussian_process.estimation import Hyperparameters, estimated, solved, subset
from ..gaussian_process.parameters import GaussianProcessParameters
from ..gaussian_process.system import Training, leave_one_out_by_trend
from ..gaussian_process.trend import Trend

RATIO = 4
"""From one number of terms for which length scales are estimated to the next."""

ROUNDS = 5
"""How often the length scales and the number of terms are improved in turn at most."""


@dataclass(frozen=True)
class _Choice:
    """A number of terms k, its error ε_k and the length scales at which it was found."""

    count: int
    error: float
    at: Hyperparameters


def best_trend(
    trend: Trend,
    points: FloatArray,
    values: FloatArray,
    parameters: GaussianProcessParameters,
    generator: np.random.Generator,
) -> tuple[int, Hyperparameters]:
    """The number of trend functions with the least leave-one-out error for points (n, d) and values (n,), and θ there.

    Source: Schöbi, Sudret & Wiart 2015, section 3.3.
    """
    spread = float(np.std(values))
    training = Training(points, trend.values(points), (values - np.mean(values)) / (spread if spread > 0.0 else 1.0))
    small = subset(training, generator)
    choices: list[_Choice] = []
    counts = _counts(training.trend.shape[1])
    for count in counts:
        # From several starts at both ends, so that nothing is worse than all terms or none for want of them.
        last = choices[-1].at if count not in (counts[0], counts[-1]) else None
        choices.append(_least_error(training, parameters, estimated(small.functions(count), parameters, generator, last)))
    return _improved(min(choices, key=lambda choice: choice.error), training, parameters, generator)


def _counts(p: int) -> list[int]:
    """1, 4, 16, … and p."""
    return [*itertools.takewhile(lambda count: count < p, (RATIO**k for k in itertools.count())), p]


def _least_error(training: Training, parameters: GaussianProcessParameters, at: Hyperparameters) -> _Choice:
    """The number of terms of least error at these length scales."""
    solution, _ = solved(training, parameters, at)
    errors = np.mean(leave_one_out_by_trend(solution) ** 2, axis=0)
    count = int(np.argmin(errors)) + 1
    return _Choice(count, float(errors[count - 1]), at)


def _improved(
    best: _Choice, training: Training, parameters: GaussianProcessParameters, generator: np.random.Generator
) -> tuple[int, Hyperparameters]:
    """Length scales and number of terms in turn, as long as the error falls."""
    for _ in range(ROUNDS):
        at = estimated(training.functions(best.count), parameters, generator, best.at)
        choice = _least_error(training, parameters, at)
        if choice.error >= best.error:
            break
        best = choice
    return best.count, best.at
