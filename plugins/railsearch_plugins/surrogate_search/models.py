"""One surrogate for each of several responses, kept up to date as evaluations come in."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from railsearch.errors import CapabilityError, SurrogateError
from railsearch.interfaces import SearchContext, Surrogate, UncertainSurrogate
from railsearch.space import FloatArray

MakeSurrogate = Callable[[], Surrogate]


class ResponseModels:
    """Surrogates of r responses over the same points of the unit cube.

    Points that come in are added to the fitted surrogates; where that cannot be done, all are fitted anew.
    """

    def __init__(self, make: MakeSurrogate) -> None:
        self._make = make
        self._size = 0
        self.surrogates: Sequence[Surrogate] = ()

    def refresh(self, points: FloatArray, values: FloatArray) -> bool:
        """Learn from points (n, d) with values (n, r), of which the first may be known; False if they determine no model."""
        if not (self.surrogates and self._added(points[self._size :], values[self._size :])):
            self.surrogates = self._fitted(points, values)
        self._size = len(points)
        return bool(self.surrogates)

    def predict(self, points: FloatArray) -> FloatArray:
        """Predicted values (k, r) at points (k, d)."""
        return np.column_stack([surrogate.predict(points) for surrogate in self.surrogates])

    def deviation(self, points: FloatArray) -> FloatArray:
        """Standard deviations (k, r) of the predictions at points (k, d). Raises CapabilityError where there are none."""
        return np.column_stack([uncertain(surrogate).deviation(points) for surrogate in self.surrogates])

    def _added(self, points: FloatArray, values: FloatArray) -> bool:
        try:
            for surrogate, column in zip(self.surrogates, values.T, strict=True):
                if len(points):
                    surrogate.add(points, column)
        except SurrogateError:
            return False
        return True

    def _fitted(self, points: FloatArray, values: FloatArray) -> Sequence[Surrogate]:
        surrogates = [self._make() for _ in values.T]
        try:
            for surrogate, column in zip(surrogates, values.T, strict=True):
                surrogate.fit(points, column)
        except SurrogateError:
            return ()
        return surrogates


def surrogate_maker(context: SearchContext, name: str, settings: Mapping[str, object] | None) -> MakeSurrogate:
    """What makes registered surrogates of that name. An unknown name or setting is refused here, by trying."""

    def make() -> Surrogate:
        return context.surrogate(name, settings or {})

    make()
    return make


def uncertain(surrogate: Surrogate) -> UncertainSurrogate:
    """The surrogate itself if it says how far it may be off. Raises CapabilityError if it does not."""
    if not (hasattr(surrogate, "deviation") and hasattr(surrogate, "deviation_gradient")):
        raise CapabilityError(
            "surrogate: expected improvement needs the standard deviation of the predictions, and "
            f"{type(surrogate).__name__} has none; choose a surrogate with `deviation`, such as kriging"
        )
    return surrogate  # type: ignore[return-value]
