"""One surrogate for each of several responses, kept up to date as evaluations come in."""

from collections.abc import Callable, Mapping, Sequence
from typing import cast

import numpy as np

from railsearch.errors import SurrogateError
from railsearch.interfaces import SearchContext, Surrogate, UncertainSurrogate
from railsearch.space import FloatArray

MakeSurrogate = Callable[[], Surrogate]


class ResponseModels:
    """Surrogates of r responses over the same points of the unit cube, made by `makes`.

    Points that come in are added to the fitted surrogates; where that cannot be done, all are fitted anew.
    """

    def __init__(self, makes: Sequence[MakeSurrogate]) -> None:
        self._makes = makes
        self._size = 0
        self.surrogates: Sequence[Surrogate] | None = None

    def adopt(self, surrogates: Sequence[Surrogate], size: int) -> None:
        """Go on with surrogates that know the first `size` points."""
        self.surrogates, self._size = surrogates, size

    def refresh(self, points: FloatArray, values: FloatArray) -> bool:
        """Learn from points (n, d) with values (n, r), of which the first may be known; False if they determine no model."""
        if not self._added(points[self._size :], values[self._size :]):
            self.surrogates = fitted(self._makes, points, values)
        self._size = len(points)
        return self.surrogates is not None

    def predict(self, points: FloatArray) -> FloatArray:
        """Predicted values (k, r) at points (k, d)."""
        columns = [surrogate.predict(points) for surrogate in self.surrogates or ()]
        return np.array(columns).reshape(len(columns), len(points)).T

    def deviation(self, points: FloatArray) -> FloatArray:
        """Standard deviations (k, r) of the predictions at points (k, d), of surrogates that have them."""
        uncertain = cast(Sequence[UncertainSurrogate], self.surrogates or ())
        return np.column_stack([surrogate.deviation(points) for surrogate in uncertain])

    def _added(self, points: FloatArray, values: FloatArray) -> bool:
        if self.surrogates is None:
            return False
        try:
            for surrogate, column in zip(self.surrogates, values.T, strict=True):
                if len(points):
                    surrogate.add(points, column)
        except SurrogateError:
            return False
        return True


def fitted(makes: Sequence[MakeSurrogate], points: FloatArray, values: FloatArray) -> Sequence[Surrogate] | None:
    """New surrogates of points (n, d) with values (n, r); None if they do not determine one of them."""
    surrogates = [make() for make in makes]
    try:
        for surrogate, column in zip(surrogates, values.T, strict=True):
            surrogate.fit(points, column)
    except SurrogateError:
        return None
    return surrogates


def surrogate_maker(context: SearchContext, name: str, settings: Mapping[str, object] | None) -> MakeSurrogate:
    """What makes registered surrogates of that name. An unknown name or setting is refused here, by trying."""

    def make() -> Surrogate:
        return context.surrogate(name, settings or {})

    make()
    return make
