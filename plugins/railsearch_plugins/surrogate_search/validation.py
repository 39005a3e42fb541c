"""How far surrogates are off on data that they have not seen, and which of several to take.

| symbol | meaning | shape | unit | source |
|---|---|---|---|---|
| y | values of a response | (n,) | of the response | |
| ŷ | predictions at the same points | (n,) | of the response | |
| e | mean absolute error relative to the mean absolute value, mean|ŷ − y| / mean|y| | scalar | % | |
| Q² | predictivity coefficient, 1 − Σ(ŷ − y)²/Σ(y − mean y)² | scalar | - | Marrel et al. 2008 |
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from railsearch.interfaces import Surrogate
from railsearch.space import FloatArray

from .models import MakeSurrogate, fitted


@dataclass(frozen=True)
class Split:
    """Rows for training, validation and test."""

    training: NDArray[np.intp]
    validation: NDArray[np.intp]
    test: NDArray[np.intp]


@dataclass(frozen=True)
class Chosen:
    """The surrogate of a response that was best in validation, with its errors e in % and its Q² on the test set."""

    name: str
    surrogate: Surrogate
    validation_error: float
    test_error: float
    predictivity: float


def split_rows(n: int, validation: float, test: float, generator: np.random.Generator) -> Split:
    """Shuffle n rows and divide them; `validation` and `test` are parts of the whole, the rest is for training."""
    order = generator.permutation(n)
    n_test, n_validation = round(test * n), round(validation * n)
    n_training = n - n_test - n_validation
    return Split(order[:n_training], order[n_training : n - n_test], order[n - n_test :])


def relative_error(predicted: FloatArray, values: FloatArray) -> float:
    """The mean absolute error e in % of predictions (n,) of values (n,); NaN without any, or if all are zero."""
    size = float(np.abs(values).sum())
    return 100.0 * float(np.abs(predicted - values).sum()) / size if size > 0.0 else np.nan


def predictivity(predicted: FloatArray, values: FloatArray) -> float:
    """The coefficient Q² of predictions (n,) of values (n,): 1 if exact, 0 if no better than their mean, NaN if constant."""
    spread = float(np.sum((values - values.mean()) ** 2)) if len(values) else 0.0
    return 1.0 - float(np.sum((predicted - values) ** 2)) / spread if spread > 0.0 else np.nan


def chosen_surrogate(
    makes: Mapping[str, MakeSurrogate], points: FloatArray, values: FloatArray, split: Split
) -> Chosen | None:
    """Fit every surrogate to the training rows of points (n, d) with values (n,), take the one of least validation error.

    Without validation rows the first one is taken. None if the training rows determine none of them.
    """
    candidates = []
    for name, make in makes.items():
        surrogates = fitted([make], points[split.training], values[split.training, None])
        if surrogates:
            validation, test = (surrogates[0].predict(points[rows]) for rows in (split.validation, split.test))
            errors = relative_error(validation, values[split.validation]), relative_error(test, values[split.test])
            candidates.append(Chosen(name, surrogates[0], *errors, predictivity(test, values[split.test])))
    return min(candidates, key=lambda chosen: np.nan_to_num(chosen.validation_error, nan=np.inf), default=None)
