"""Registered surrogates on random inputs in their own units.

| symbol | meaning | shape | unit |
|---|---|---|---|
| x | point of the random inputs | (d,) | the inputs' own |
| p | F(x), point of the unit cube | (d,) | - |
| f | probability densities dF/dx | (d,) | one over the inputs' own |
"""

from collections.abc import Mapping
from typing import Any, Protocol, cast

import numpy as np

from railsearch.distributions import RandomVector
from railsearch.interfaces import RandomInputSurrogate, Surrogate
from railsearch.parameters import make_parameters
from railsearch.plugin_manager import Registry
from railsearch.space import FloatArray


class FittedSurrogate(Protocol):
    """What is fitted and searched here: points (k, d) in the inputs' own units, values (k,)."""

    def fit(self, points: FloatArray, values: FloatArray) -> None:
        """Fit to points with values."""

    def predict(self, points: FloatArray) -> FloatArray:
        """Values at points."""

    def gradient(self, points: FloatArray) -> FloatArray:
        """Derivatives (k, d) at points."""


class CubeSurrogate:
    """A surrogate of the unit cube, given p = F(x): ĝ(x) = ŝ(F(x)), ∂ĝ/∂x = f(x) ∂ŝ/∂p."""

    def __init__(self, surrogate: Surrogate, inputs: RandomVector) -> None:
        self._surrogate = surrogate
        self._inputs = inputs

    def fit(self, points: FloatArray, values: FloatArray) -> None:
        """Fit to points (n, d) with values (n,). Raises InputError for points that the inputs cannot have."""
        self._surrogate.fit(self._inputs.cdf(self._inputs.checked(points)), values)

    def predict(self, points: FloatArray) -> FloatArray:
        """Predictions (k,) at points (k, d)."""
        return self._surrogate.predict(self._inputs.cdf(points))

    def gradient(self, points: FloatArray) -> FloatArray:
        """Derivatives (k, d) of the prediction at points (k, d)."""
        columns = zip(self._inputs.marginals.values(), points.T, strict=True)
        densities = np.stack([marginal.pdf(column) for marginal, column in columns], axis=1)
        return self._surrogate.gradient(self._inputs.cdf(points)) * densities


def input_surrogate(
    registry: Registry, name: str, inputs: RandomVector, settings: Mapping[str, object] | None = None
) -> FittedSurrogate:
    """A new surrogate of that name for points of random inputs: made for them if it can be, else on the cube of F(x).

    settings: those that differ from the surrogate's defaults. Raises PluginError for an unknown name, InputError for
    settings that are not allowed.
    """
    chosen = dict(settings or {})
    registered = {entry.name: entry.plugin for entry in registry.entries("surrogate")}
    plugin: Any = registered.get(name)
    if hasattr(plugin, "for_inputs"):
        parameters = make_parameters(plugin.Parameters, chosen, f"surrogate {name}")
        return cast(RandomInputSurrogate, plugin).for_inputs(inputs, parameters)
    return CubeSurrogate(registry.surrogate(name, inputs.dimension, chosen), inputs)
