"""Registered surrogates on random inputs in their own units.

| symbol | meaning | shape | unit |
|---|---|---|---|
| X | samples of the inputs | (n, d) | the inputs' own |
| U | (X − X_min)/(X_max − X_min) | (n, d) | - |
"""

from collections.abc import Mapping
from typing import Any, Protocol, cast

import numpy as np

from railsearch.distributions import RandomVector
from railsearch.interfaces import RandomInputSurrogate, Surrogate
from railsearch.parameters import make_parameters
from railsearch.plugin_manager import Registry
from railsearch.space import FloatArray


class InputSurrogate(Protocol):
    """What is fitted and searched here: points (k, d) in the inputs' own units, values (k,)."""

    def fit(self, points: FloatArray, values: FloatArray) -> None:
        """Fit to points with values."""

    def predict(self, points: FloatArray) -> FloatArray:
        """Values at points."""

    def gradient(self, points: FloatArray) -> FloatArray:
        """Derivatives (k, d) at points."""


class BoxSurrogate:
    """A surrogate of the unit cube on the box that the samples span.

    Not on F(x), in which a smooth function has infinite slopes where an unbounded input has its tails.
    """

    def __init__(self, surrogate: Surrogate, inputs: RandomVector) -> None:
        self._surrogate = surrogate
        self._inputs = inputs
        self._lower = np.zeros(inputs.dimension)
        self._width = np.ones(inputs.dimension)

    def fit(self, points: FloatArray, values: FloatArray) -> None:
        """Fit to points (n, d) with values (n,). Raises InputError for points that the inputs cannot have."""
        points = self._inputs.checked(points)
        self._lower = points.min(axis=0)
        self._width = np.maximum(np.ptp(points, axis=0), np.finfo(float).tiny)
        self._surrogate.fit(self._unit(points), values)

    def predict(self, points: FloatArray) -> FloatArray:
        """Predictions (k,) at points (k, d)."""
        return self._surrogate.predict(self._unit(points))

    def gradient(self, points: FloatArray) -> FloatArray:
        """Derivatives (k, d) of the prediction at points (k, d)."""
        return np.asarray(self._surrogate.gradient(self._unit(points)) / self._width)

    def _unit(self, points: FloatArray) -> FloatArray:
        return np.asarray((points - self._lower) / self._width)


def input_surrogate(
    registry: Registry, name: str, inputs: RandomVector, settings: Mapping[str, object] | None = None
) -> InputSurrogate:
    """A new surrogate of that name for points of random inputs: made for them if it can be, else on the box of the samples.

    settings: those that differ from the surrogate's defaults. Raises PluginError for an unknown name, InputError for
    settings that are not allowed.
    """
    chosen = dict(settings or {})
    registered = {entry.name: entry.plugin for entry in registry.entries("surrogate")}
    plugin: Any = registered.get(name)
    if hasattr(plugin, "for_inputs"):
        parameters = make_parameters(plugin.Parameters, chosen, f"surrogate {name}")
        return cast(RandomInputSurrogate, plugin).for_inputs(inputs, parameters)
    return BoxSurrogate(registry.surrogate(name, inputs.dimension, chosen), inputs)
