"""Functions whose extreme surfaces are known."""

import numpy as np

from railsearch.space import Space, Variable


class Differentiable:
    """A vectorised function with its derivatives, as a surrogate has them; remembers how often it was asked."""

    def __init__(self, function, slopes):
        self.function = function
        self.slopes = slopes
        self.asked = 0

    def predict(self, points):
        self.asked += len(points)
        return self.function(points)

    def gradient(self, points):
        return self.slopes(points)


def box(*bounds):
    return Space(tuple(Variable(f"x{k + 1}", low, high) for k, (low, high) in enumerate(bounds)))


def linear(coefficients, constant=0.0):
    c = np.asarray(coefficients, dtype=float)
    return Differentiable(lambda x: constant + x @ c, lambda x: np.tile(c, (len(x), 1)))


def waves(frequency=9.0, depth=1.0, slant=0.3):
    """Σ depth cos(frequency x_i) + slant x_i: separable, with many local optima in [−π, π]."""
    return Differentiable(
        lambda x: (depth * np.cos(frequency * x) + slant * x).sum(axis=1),
        lambda x: -depth * frequency * np.sin(frequency * x) + slant,
    )


def wave_extremes(low, high, frequency=9.0, depth=1.0, slant=0.3):
    """Least and largest value of one term, by a fine grid polished at its ends."""
    x = np.linspace(low, high, 2_000_001)
    values = depth * np.cos(frequency * x) + slant * x
    return values.min(), values.max()
