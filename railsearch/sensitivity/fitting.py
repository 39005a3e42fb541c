"""Surrogates of a sensitivity analysis: on random inputs in their own units, with errors from data they have not seen.

| symbol | meaning | shape | unit |
|---|---|---|---|
| X, y | samples of the inputs, values of an output | (n, d), (n,) | the caller's |
| ε_gen | mean squared error on samples that were held out, over the variance of y | scalar | - |
| ε_loo | leave-one-out error over the variance of y | scalar | - |
"""

import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from railsearch.distributions import RandomVector
from railsearch.errors import InputError
from railsearch.interfaces import require_methods
from railsearch.plugin_manager import Registry
from railsearch.projected_gradient import SmoothFunction
from railsearch.sensitivity.surrogates import input_surrogate
from railsearch.space import FloatArray

Fit = Callable[[FloatArray, FloatArray], SmoothFunction]
"""Makes a surrogate of samples (n, d) with values (n,)."""

HELD_OUT = 0.2
"""Share of the samples on which ε_gen is measured: 64 % and 16 % of them train and validate in Shang et al. 2024."""

FEWEST_SAMPLES = 10


@dataclass(frozen=True)
class SurrogateQuality:
    """How good a surrogate is, and what it costs.

    samples: how many it was fitted to; held_out: how many others ε_gen was measured on, with a fit to the rest of them;
    leave_one_out: None where the surrogate has none; terms: of an expansion, else None; seconds of the fit, and per value.
    """

    samples: int
    held_out: int
    generalisation: float
    leave_one_out: float | None
    terms: int | None
    fit_seconds: float
    value_seconds: float

    def document(self) -> dict[str, Any]:
        """Plain types, ready for JSON."""
        return asdict(self)


@dataclass(frozen=True)
class FittedSurrogate:
    """A surrogate, its quality, and what one that had not seen them predicted (k,) for `true` values (k,)."""

    model: SmoothFunction
    quality: SurrogateQuality
    true: FloatArray
    predicted: FloatArray


def surrogate_fit(registry: Registry, name: str, settings: Mapping[str, object], inputs: RandomVector) -> Fit:
    """What fits the surrogate of that name to samples of random inputs.

    Raises PluginError and InputError as `input_surrogate`, CapabilityError for one without a gradient.
    """
    made = registry.surrogate(name, inputs.dimension, settings)
    require_methods(made, name, ["gradient"], "the search for extremes", "choose pce, pck, kriging or rbf")

    def fit(points: FloatArray, values: FloatArray) -> SmoothFunction:
        surrogate = input_surrogate(registry, name, inputs, settings)
        surrogate.fit(points, values)
        return surrogate

    return fit


def fitted_surrogate(
    fit: Fit, points: FloatArray, values: FloatArray, generator: np.random.Generator, share: float = HELD_OUT
) -> FittedSurrogate:
    """Fit to all samples, and measure ε_gen on a random `share` of them with a fit to the others.

    Raises InputError as `tried_surrogate`, SurrogateError as the surrogate does.
    """
    tried = tried_surrogate(fit, points, values, generator, share)
    model, seconds = _timed(fit, points, values)
    quality = replace(
        tried.quality,
        samples=len(values),
        leave_one_out=_leave_one_out(model),
        terms=_terms(model),
        fit_seconds=seconds[0],
        value_seconds=seconds[1],
    )
    return FittedSurrogate(model, quality, tried.true, tried.predicted)


def tried_surrogate(
    fit: Fit, points: FloatArray, values: FloatArray, generator: np.random.Generator, share: float = HELD_OUT
) -> FittedSurrogate:
    """Fit to all samples but a random `share`, on which ε_gen is measured.

    Raises InputError for fewer than ten or d + 2 samples, an output that does not vary, and a share that is not inside
    (0, 1); SurrogateError as the surrogate does.
    """
    check_number(len(values), points.shape[1])
    if not np.ptp(values) > 0.0:
        raise InputError(f"the output is {values[0]:g} in all {len(values)} samples: there is nothing to explain")
    if not 0.0 < share < 1.0:
        raise InputError(f"held out: a share between 0 and 1 is needed, received {share:g}")
    order = generator.permutation(len(values))
    held, kept = np.split(order, [max(round(share * len(values)), 2)])
    model, seconds = _timed(fit, points[kept], values[kept])
    predicted = model.predict(points[held])
    error = float(np.mean((values[held] - predicted) ** 2) / np.var(values))
    quality = SurrogateQuality(len(kept), len(held), error, _leave_one_out(model), _terms(model), *seconds)
    return FittedSurrogate(model, quality, values[held], predicted)


def check_number(number: int, dimension: int) -> None:
    """Raise InputError for fewer than ten samples, or fewer than d + 2."""
    fewest = max(FEWEST_SAMPLES, dimension + 2)
    if number < fewest:
        raise InputError(
            f"samples: {fewest} or more are needed with {dimension} inputs, for a constant, a slope for each and an error, "
            f"received {number}; evaluate more of them"
        )


def _timed(fit: Fit, points: FloatArray, values: FloatArray) -> tuple[SmoothFunction, tuple[float, float]]:
    """A surrogate, and the seconds of its fit and of a value."""
    begin = time.perf_counter()
    model = fit(points, values)
    fitted = time.perf_counter()
    model.predict(points)
    return model, (fitted - begin, (time.perf_counter() - fitted) / len(values))


def _leave_one_out(model: Any) -> float | None:
    found = getattr(model, "loo_error", None)
    return None if found is None else float(found)


def _terms(model: Any) -> int | None:
    expansion = getattr(model, "expansion", None)
    return None if expansion is None else len(expansion.coefficients)
