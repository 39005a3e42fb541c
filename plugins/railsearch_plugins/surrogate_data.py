"""What surrogates share: their data checked at the door, and errors as fractions of a variance."""

import numpy as np

from railsearch.errors import SurrogateError
from railsearch.space import FloatArray


def checked_data(name: str, dimension: int, points: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Copies of points (n, d) and values (n,) of the surrogate called `name`.

    Raises SurrogateError for other shapes and for what is not finite.
    """
    points, values = np.array(points, dtype=float), np.array(values, dtype=float)
    if points.ndim != 2 or points.shape[1] != dimension or values.shape != (len(points),):
        raise SurrogateError(
            f"{name}: points (n, {dimension}) and values (n,) are needed, received shapes {points.shape} and {values.shape}"
        )
    if not (np.isfinite(points).all() and np.isfinite(values).all()):
        raise SurrogateError(f"{name}: finite points and values are needed; leave failed evaluations out of the fit")
    return points, values


def relative_error(residuals: FloatArray, variance: float) -> float:
    """The mean square of residuals (n,) as a fraction of a variance; 0 of a constant."""
    return float(np.mean(residuals**2)) / variance if variance > 0.0 else 0.0
