"""What a surrogate has to fulfil."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, cast

import numpy as np
from threadpoolctl import threadpool_limits

from railsearch.errors import RailsearchError, SurrogateError
from railsearch.interfaces import Surrogate, UncertainSurrogate, lacking
from railsearch.parameters import make_parameters
from railsearch.space import FloatArray
from railsearch.testing.requirement import require

Function = Callable[[FloatArray], FloatArray]


def check_surrogate(plugin: Any, settings: Mapping[str, object] | None = None, interpolates: bool | None = None) -> None:
    """Check a surrogate class, made with `settings` of its parameters; see `check_made_surrogate`.

    interpolates: None for what the class says itself.
    """
    parameters = make_parameters(plugin.Parameters, dict(settings or {}), "surrogate")
    said = bool(getattr(plugin, "interpolates", True))
    check_made_surrogate(lambda dimension: plugin(dimension, parameters), said if interpolates is None else interpolates)


def check_made_surrogate(make: Callable[[int], Surrogate], interpolates: bool = True) -> None:
    """Check surrogates made by `make(dimension)` on smooth functions of one to four variables.

    Shapes; many points predicted as one by one; two fits alike; `add` equals `fit` (1e-6 of the spread of the values, or the
    surrogate's `add_tolerance`); if it interpolates, every value is met (1e-6); inputs are not altered; too few points and
    values that are not finite are errors of railsearch. Gradients, where there are any, agree with differences (1e-5 of the
    spread). Deviations, where there are any, are finite, not negative and, if it interpolates, below 1e-3 of the spread at
    the points and larger between them. A method that the surrogate lacks raises SurrogateError. Raises AssertionError with
    an explanation.
    """
    with threadpool_limits(1):
        for dimension in (1, 2, 4):
            _check_in(dimension, partial(make, dimension), interpolates)


def _check_in(dimension: int, make: Callable[[], Surrogate], interpolates: bool) -> None:
    points, values = _smooth_data(dimension, 40)
    queries = np.random.default_rng(7).random((15, dimension))
    model = make()
    _fit_unaltered(model, points, values)
    _check_predictions(model, queries)
    _check_gradient(model, "gradient", model.predict, queries, float(np.ptp(values)))
    if interpolates:
        error = np.max(np.abs(model.predict(points) - values)) / np.ptp(values)
        require(error < 1e-6, f"the surrogate misses values it was fitted to by {error:.1e} of their spread")
    _check_repeated_fit(make(), model, points, values, queries)
    _check_additions(make(), model, points, values, queries)
    _check_deviation(make(), *_smooth_data(dimension, 8 + 3 * dimension), queries, interpolates)
    _check_refusals(make, points, values)


def _smooth_data(dimension: int, count: int) -> tuple[FloatArray, FloatArray]:
    points = np.random.default_rng(dimension).random((count, dimension))
    return points, 100.0 + np.sin(3.0 * points).sum(axis=1) + points[:, 0] * points[:, -1]


def _fit_unaltered(model: Surrogate, points: FloatArray, values: FloatArray) -> None:
    before = points.copy(), values.copy()
    model.fit(points, values)
    require(np.array_equal(points, before[0]) and np.array_equal(values, before[1]), "fit altered its arguments")


def _check_predictions(model: Surrogate, queries: FloatArray) -> None:
    predicted = model.predict(queries)
    require(predicted.shape == (len(queries),), f"predict must give (k,), received {predicted.shape}")
    single = np.concatenate([model.predict(query[None, :]) for query in queries])
    require(bool(np.allclose(single, predicted, rtol=1e-9)), "many points predicted at once differ from one by one")


def _check_gradient(model: Surrogate, method: str, function: Function, queries: FloatArray, spread: float) -> None:
    """The method `gradient` or `deviation_gradient` against differences of what it is the gradient of."""
    if lacking(model, [method]):
        _check_lack(model, method, queries)
        return
    gradient = getattr(model, method)(queries)
    require(gradient.shape == queries.shape, f"{method} must give (k, d), received {gradient.shape}")
    error = np.max(np.minimum(*(np.abs(slopes - gradient) for slopes in _differences(function, queries)))) / spread
    require(error < 1e-5, f"the {method} differs from central differences by {error:.1e} of the spread of the values")


def _differences(function: Function, queries: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Slopes (k, d) by a short central difference, and by a long one of fourth order for what is evaluated with noise."""

    def central(step: float) -> FloatArray:
        offsets = step * np.eye(queries.shape[1])
        return np.column_stack([function(queries + h) - function(queries - h) for h in offsets]) / (2.0 * step)

    return central(1e-5), (4.0 * central(1e-3) - central(2e-3)) / 3.0


def _check_repeated_fit(
    other: Surrogate, model: Surrogate, points: FloatArray, values: FloatArray, queries: FloatArray
) -> None:
    other.fit(points, values)
    require(bool(np.array_equal(other.predict(queries), model.predict(queries))), "two fits to the same points differ")


def _check_additions(
    grown: Surrogate, model: Surrogate, points: FloatArray, values: FloatArray, queries: FloatArray
) -> None:
    grown.fit(points[:-5], values[:-5])
    grown.add(points[-5:-1], values[-5:-1])
    grown.add(points[-1:], values[-1:])
    error = np.max(np.abs(grown.predict(queries) - model.predict(queries))) / np.ptp(values)
    tolerance = float(getattr(model, "add_tolerance", 1e-6))
    require(error < tolerance, f"points added one after another give predictions that differ from a fit by {error:.1e}")


def _check_deviation(
    model: Surrogate, points: FloatArray, values: FloatArray, queries: FloatArray, interpolates: bool
) -> None:
    """On few points, between which there is something to be uncertain of."""
    model.fit(points, values)
    if lacking(model, ["deviation"]):
        _check_lack(model, "deviation", queries)
        return
    uncertain, spread = cast(UncertainSurrogate, model), float(np.ptp(values))
    deviations, at_points = uncertain.deviation(queries), uncertain.deviation(points)
    require(deviations.shape == (len(queries),), f"deviation must give (k,), received {deviations.shape}")
    sound = np.isfinite(deviations).all() and np.all(deviations >= 0.0)
    require(bool(sound), "deviations must be finite and not negative")
    if interpolates:
        largest = float(np.max(at_points))
        require(largest < 1e-3 * spread, f"the deviation at the points themselves is {largest / spread:.1e} of the spread")
        require(bool(np.max(deviations) > largest), "the deviation between the points is no larger than at them")
    _check_gradient(model, "deviation_gradient", uncertain.deviation, queries, spread)


def _check_lack(model: Surrogate, method: str, queries: FloatArray) -> None:
    """A method that is there although it cannot be carried out says so."""
    if not hasattr(model, method):
        return
    try:
        getattr(model, method)(queries)
    except SurrogateError:
        return
    raise AssertionError(f"{method} is among what the surrogate lacks, but raises no SurrogateError")


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
