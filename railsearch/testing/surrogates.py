"""What a surrogate has to fulfil."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np

from railsearch.errors import RailsearchError, SurrogateError
from railsearch.interfaces import Surrogate
from railsearch.parameters import make_parameters
from railsearch.space import FloatArray
from railsearch.testing.requirement import require


def check_surrogate(plugin: Any, settings: Mapping[str, object] | None = None, interpolates: bool = True) -> None:
    """Check a surrogate class, made with `settings` of its parameters, on smooth functions of one to four variables.

    Shapes; many points predicted as one by one; gradient against central differences (1e-5 of the spread of the values);
    `add` equals `fit` (1e-6); if it interpolates, every value is met (1e-6); inputs are not altered; too few points and
    values that are not finite are errors of railsearch. Raises AssertionError with an explanation.
    """
    parameters = make_parameters(plugin.Parameters, dict(settings or {}), "surrogate")
    for dimension in (1, 2, 4):
        points, values = _smooth_data(dimension)
        queries = np.random.default_rng(7).random((15, dimension))
        model = plugin(dimension, parameters)
        _fit_unaltered(model, points, values)
        _check_predictions(model, queries, float(np.ptp(values)))
        if interpolates:
            error = np.max(np.abs(model.predict(points) - values)) / np.ptp(values)
            require(error < 1e-6, f"the surrogate misses values it was fitted to by {error:.1e} of their spread")
        grown = plugin(dimension, parameters)
        grown.fit(points[:-5], values[:-5])
        grown.add(points[-5:-1], values[-5:-1])
        grown.add(points[-1:], values[-1:])
        error = np.max(np.abs(grown.predict(queries) - model.predict(queries))) / np.ptp(values)
        require(error < 1e-6, f"points added one after another give predictions that differ from a fit by {error:.1e}")
        _check_refusals(partial(plugin, dimension, parameters), points, values)


def _smooth_data(dimension: int) -> tuple[FloatArray, FloatArray]:
    points = np.random.default_rng(dimension).random((40, dimension))
    return points, 100.0 + np.sin(3.0 * points).sum(axis=1) + points[:, 0] * points[:, -1]


def _fit_unaltered(model: Surrogate, points: FloatArray, values: FloatArray) -> None:
    before = points.copy(), values.copy()
    model.fit(points, values)
    require(np.array_equal(points, before[0]) and np.array_equal(values, before[1]), "fit altered its arguments")


def _check_predictions(model: Surrogate, queries: FloatArray, spread: float) -> None:
    predicted, gradient = model.predict(queries), model.gradient(queries)
    shapes = predicted.shape == (len(queries),) and gradient.shape == queries.shape
    require(shapes, f"predict must give (k,) and gradient (k, d), received {predicted.shape} and {gradient.shape}")
    single = np.concatenate([model.predict(query[None, :]) for query in queries])
    require(bool(np.allclose(single, predicted, rtol=1e-9)), "many points predicted at once differ from one by one")
    step = 1e-5
    for axis, offset in enumerate(step * np.eye(queries.shape[1])):
        slope = (model.predict(queries + offset) - model.predict(queries - offset)) / (2.0 * step)
        error = np.max(np.abs(slope - gradient[:, axis])) / spread
        require(error < 1e-5, f"the gradient differs from central differences by {error:.1e} of the spread of the values")


def _check_refusals(make: Callable[[], Surrogate], points: FloatArray, values: FloatArray) -> None:
    spoilt = values.copy()
    spoilt[3] = np.nan
    try:
        make().fit(points, spoilt)
    except RailsearchError:
        pass
    else:
        raise AssertionError("a value that is not a number was accepted; raise SurrogateError")
    try:
        make().fit(np.empty((0, points.shape[1])), np.empty(0))
    except SurrogateError:
        pass
    else:
        raise AssertionError("a fit to no points was accepted; raise SurrogateError")
