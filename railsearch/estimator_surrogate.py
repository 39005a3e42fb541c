"""Any scikit-learn regressor as a surrogate, by the dotted name of its class."""

import difflib
import importlib
import inspect
import warnings
from collections.abc import Mapping
from typing import Any

import numpy as np

from railsearch.errors import InputError, PluginError, SurrogateError
from railsearch.interfaces import NoParameters
from railsearch.space import FloatArray

SEED = 0
"""What a regressor's `random_state` is set to where it is not given, so that runs can be repeated."""

FEWEST_TRIAL_POINTS = 20
"""A regressor is tried out on so many points before a search begins, or 2(d + 1): as many as most searches begin with."""


class EstimatorSurrogate:
    """A scikit-learn regressor. It has no gradient; it has a deviation if its `predict` takes `return_std`.

    Made by `estimator_surrogate`, which finds the class and checks the settings.
    """

    Parameters: type = NoParameters

    def __init__(self, name: str, dimension: int, regressor: Any) -> None:
        self._name = name
        self._dimension = dimension
        self._regressor = regressor
        self._points = np.empty((0, dimension))
        self._values = np.empty(0)

    @property
    def lacks(self) -> tuple[str, ...]:
        """The methods that this regressor cannot serve."""
        uncertain = "return_std" in inspect.signature(self._regressor.predict).parameters
        return ("gradient", "deviation_gradient") if uncertain else ("gradient", "deviation", "deviation_gradient")

    def fit(self, points: FloatArray, values: FloatArray) -> None:
        """Fit to points (n, d) of the unit cube with values (n,).

        Raises SurrogateError for points of the wrong shape, none, values that are not finite, or what the regressor refuses.
        """
        points, values = np.array(points, dtype=float), np.array(values, dtype=float)
        if not len(points) or points.shape != (len(points), self._dimension) or values.shape != (len(points),):
            raise SurrogateError(
                f"{self._name}: one or more points (n, {self._dimension}) and values (n,) are needed, received shapes "
                f"{points.shape} and {values.shape}"
            )
        if not (np.isfinite(points).all() and np.isfinite(values).all()):
            raise SurrogateError(f"{self._name}: finite points and values are needed; leave failed evaluations out")
        try:
            self._regressor.fit(points, values)
        except (ValueError, ArithmeticError, np.linalg.LinAlgError) as error:
            raise SurrogateError(f"{self._name} cannot be fitted to {len(points)} points: {error}") from error
        self._points, self._values = points, values

    def add(self, points: FloatArray, values: FloatArray) -> None:
        """Fit afresh with points (k, d) and values (k,) added. Raises SurrogateError as `fit`."""
        self._check_fitted()
        self.fit(np.concatenate([self._points, points]), np.concatenate([self._values, values]))

    def predict(self, points: FloatArray) -> FloatArray:
        """Predicted values (k,) at points (k, d)."""
        return self._predicted(points)[0]

    def gradient(self, points: FloatArray) -> FloatArray:
        """Raises SurrogateError: a regressor has none."""
        raise self._without("gradient")

    def deviation(self, points: FloatArray) -> FloatArray:
        """Standard deviations (k,) at points (k, d). Raises SurrogateError if the regressor gives none."""
        if "deviation" in self.lacks:
            raise self._without("standard deviation")
        return self._predicted(points, return_std=True)[1]

    def deviation_gradient(self, points: FloatArray) -> FloatArray:
        """Raises SurrogateError: a regressor has none."""
        raise self._without("gradient of the standard deviation")

    def _predicted(self, points: FloatArray, return_std: bool = False) -> list[FloatArray]:
        self._check_fitted()
        points = np.atleast_2d(points)
        try:
            found = self._regressor.predict(points, return_std=True) if return_std else (self._regressor.predict(points),)
        except (ValueError, ArithmeticError, np.linalg.LinAlgError) as error:
            raise SurrogateError(f"{self._name} cannot predict from {len(self._points)} points: {error}") from error
        return [np.asarray(array, dtype=float).reshape(len(points)) for array in found]

    def _check_fitted(self) -> None:
        if not len(self._points):
            raise SurrogateError(f"{self._name}: the regressor is not fitted; call fit with the first points")

    def _without(self, what: str) -> SurrogateError:
        return SurrogateError(f"surrogate {self._name} has no {what}; take one that has, for instance kriging")


def estimator_surrogate(name: str, dimension: int, settings: Mapping[str, object]) -> EstimatorSurrogate:
    """A surrogate from the regressor class of a dotted name, for instance `sklearn.ensemble.RandomForestRegressor`.

    Raises PluginError if there is no such class or it is not a regressor, InputError for settings it does not know or
    refuses.
    """
    regressor = _made(name)
    _configure(regressor, name, settings)
    _try_out(regressor, name, dimension)
    return EstimatorSurrogate(name, dimension, regressor)


def _made(name: str) -> Any:
    """An instance of the class of that name with its default settings."""
    module_name, _, class_name = name.rpartition(".")
    try:
        module = importlib.import_module(module_name)
    except Exception as error:
        raise PluginError(
            f"surrogate '{name}': {module_name} cannot be imported ({type(error).__name__}: {error}); correct the dotted "
            "name, or install the distribution that has it"
        ) from error
    if not hasattr(module, class_name):
        close = difflib.get_close_matches(class_name, dir(module), n=1)
        hint = f"; did you mean '{module_name}.{close[0]}'?" if close else "; give module and class of a regressor"
        raise PluginError(f"surrogate '{name}': {module_name} has no {class_name}{hint}")
    return _regressor(name, getattr(module, class_name))


def _regressor(name: str, plugin: Any) -> Any:
    from sklearn.base import is_regressor

    remedy = "a class of scikit-learn's conventions (fit, predict, get_params) whose instances are regressors is needed"
    if not (inspect.isclass(plugin) and all(hasattr(plugin, method) for method in ("fit", "predict", "get_params"))):
        raise PluginError(f"surrogate '{name}' is not a regressor; {remedy}")
    try:
        made = plugin()
    except TypeError as error:
        raise PluginError(
            f"surrogate '{name}' cannot be made without arguments ({error}); wrap it in a class that can, or register a "
            "surrogate of your own"
        ) from error
    if not is_regressor(made):
        raise PluginError(f"surrogate '{name}' is not a regressor; {remedy}")
    return made


def _configure(regressor: Any, name: str, settings: Mapping[str, object]) -> None:
    """Set what is given, and every `random_state` that is not."""
    known = regressor.get_params()
    unknown = [setting for setting in settings if setting not in known]
    if unknown:
        allowed = ", ".join(sorted(known)) or "none"
        raise InputError(f"surrogate {name}: unknown setting '{unknown[0]}'; allowed are {allowed}")
    regressor.set_params(**settings)
    seeds = {key: SEED for key, value in regressor.get_params().items() if key.endswith("random_state") and value is None}
    regressor.set_params(**seeds)


def _try_out(regressor: Any, name: str, dimension: int) -> None:
    """Fit a copy to a few points and predict: a regressor checks its settings no earlier."""
    from sklearn.base import clone

    points = np.random.default_rng(SEED).random((max(FEWEST_TRIAL_POINTS, 2 * (dimension + 1)), dimension))
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            clone(regressor).fit(points, points.sum(axis=1)).predict(points)
    except Exception as error:
        raise InputError(f"surrogate {name}: its settings do not work with {len(points)} points: {error}") from error
