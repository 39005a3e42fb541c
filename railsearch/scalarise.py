"""Scalarising functions: many objectives into one.

| symbol | meaning | shape | unit | source |
|---|---|---|---|---|
| f | objectives, minimised | (n, m) | each its own | |
| f^r | aspiration point, the values wished for | (m,) | of f | Wierzbicki 1980 |
| f^max | worst values | (m,) | of f | level-crossing study, Shang et al. 2023 |
| κ_i | weight 1/(f_i^max − f_i^r) | (m,) | 1/unit of f_i | Miettinen and Mäkelä 2002 |
| ρ | augmentation coefficient | scalar | - | Miettinen and Mäkelä 2002 |
| z* | ideal point, the least values of each objective alone | (m,) | of f | Yu 1973 |
| z^nad | nadir point, the worst values on the front | (m,) | of f | Miettinen 1999 |
| δ | deviations from the ideal point | (n, m) | - or of f | Zeleny 1973 |
| w | weights of the objectives, ≥ 0, one of them > 0 | (m,) | - or 1/unit of f | |
| p | order of the distance, 1 ≤ p ≤ ∞ | scalar | - | Yu 1973 |
"""

import numpy as np
from numpy.typing import NDArray

from railsearch.errors import InputError

FloatArray = NDArray[np.float64]


def augmented_chebyshev(objectives: FloatArray, aspiration: FloatArray, worst: FloatArray, rho: float) -> FloatArray:
    """The achievement g = max_i κ_i (f_i − f_i^r) + ρ Σ_i κ_i (f_i − f_i^r) with κ_i = 1/(f_i^max − f_i^r).

    g is 0 at the aspiration point and 1 + ρ m at the worst values. With ρ > 0 every minimiser is Pareto optimal.

    objectives: f (n, m); aspiration: f^r (m,); worst: f^max (m,), each above the aspiration; rho: ρ ≥ 0.
    Raises InputError for shapes that do not fit, a worst value not above its aspiration, and a negative ρ.
    Source: Wierzbicki 1980; Miettinen and Mäkelä 2002.
    """
    _check_points("augmented_chebyshev", objectives, ("aspiration", aspiration), ("worst", worst))
    if not rho >= 0.0:
        raise InputError(f"augmented_chebyshev: rho ≥ 0 is needed, received {rho!r}")
    achievements = _relative(objectives, aspiration, worst)
    scalars: FloatArray = achievements.max(axis=1) + rho * achievements.sum(axis=1)
    return scalars


def deviations(objectives: FloatArray, ideal: FloatArray, nadir: FloatArray) -> FloatArray:
    """The deviations δ_i = (f_i − z_i*)/(z_i^nad − z_i*) (n, m): 0 at the ideal point, 1 at the nadir point.

    objectives: f (n, m); ideal: z* (m,); nadir: z^nad (m,), each above the ideal value.
    Raises InputError for shapes that do not fit and a nadir value not above its ideal value.
    Source: Yu 1973; Zeleny 1973.
    """
    _check_points("deviations", objectives, ("ideal", ideal), ("nadir", nadir))
    return _relative(objectives, ideal, nadir)


def weighted_sum(values: FloatArray, weights: FloatArray) -> FloatArray:
    """The weighted sum g = Σ_i w_i v_i (n,). With all w_i > 0 every minimiser is Pareto optimal, else weakly so.

    It finds no design in a dent of the front, whatever the weights.
    values: deviations δ or objectives f (n, m); weights: w (m,). Raises InputError for weights that are not allowed.
    Source: Zadeh 1963; Miettinen 1999, section 3.1.
    """
    _check_weights("weighted_sum", values, weights)
    scalars: FloatArray = values @ np.asarray(weights, dtype=float)
    return scalars


def chebyshev(values: FloatArray, weights: FloatArray) -> FloatArray:
    """The weighted Chebyshev distance g = max_i w_i δ_i (n,). Every minimiser is weakly Pareto optimal.

    Every Pareto-optimal design that is worse than the ideal in each objective minimises it for some weights.
    values: deviations δ (n, m); weights: w (m,). Raises InputError for weights that are not allowed.
    Source: Bowman 1976; Miettinen 1999, section 3.4.
    """
    _check_weights("chebyshev", values, weights)
    scalars: FloatArray = (values * weights).max(axis=1)
    return scalars


def lp_distance(values: FloatArray, weights: FloatArray, p: float) -> FloatArray:
    """The weighted L_p distance g = (Σ_i (w_i δ_i)^p)^(1/p) (n,), the global criterion; max_i w_i δ_i for p = ∞.

    p = 1 is the weighted sum, p = ∞ the Chebyshev distance. A design better than the ideal value counts with negative sign:
    sgn(s) |s|^(1/p) with s = Σ_i sgn(δ_i) |w_i δ_i|^p, so that g increases with every δ_i everywhere.
    With p < ∞ and all w_i > 0 every minimiser is Pareto optimal, else weakly so.

    values: deviations δ (n, m); weights: w (m,); p: 1 ≤ p ≤ ∞. Raises InputError for weights and orders not allowed.
    Source: Yu 1973; Zeleny 1973; weights inside the power after Steuer 1986.
    """
    if not p >= 1.0:
        raise InputError(f"lp_distance: an order 1 ≤ p ≤ ∞ is needed, received {p!r}")
    if np.isinf(p):
        return chebyshev(values, weights)
    _check_weights("lp_distance", values, weights)
    weighted = values * weights
    largest = np.abs(weighted).max(axis=1, keepdims=True)
    shares = weighted / np.where(largest > 0.0, largest, 1.0)
    total = np.sum(np.sign(shares) * np.abs(shares) ** p, axis=1)
    scalars: FloatArray = largest[:, 0] * np.sign(total) * np.abs(total) ** (1.0 / p)
    return scalars


def _relative(objectives: FloatArray, zero: FloatArray, one: FloatArray) -> FloatArray:
    """The objectives (n, m) in units of the distance from the point `zero` (m,) to the point `one` (m,)."""
    scaled: FloatArray = (np.asarray(objectives, dtype=float) - zero) / (np.asarray(one, dtype=float) - zero)
    return scaled


def _check_points(
    function: str, objectives: FloatArray, better: tuple[str, FloatArray], worse: tuple[str, FloatArray]
) -> None:
    """Raise InputError unless two named points (m,) fit objectives (n, m), the second one above the first."""
    (low_name, low), (high_name, high) = better, worse
    if np.ndim(objectives) != 2 or not np.shape(low) == np.shape(high) == np.shape(objectives)[1:]:
        raise InputError(
            f"{function}: objectives (n, m), {low_name} (m,) and {high_name} (m,) are needed, received shapes "
            f"{np.shape(objectives)}, {np.shape(low)} and {np.shape(high)}"
        )
    above = np.greater(high, low)
    if not np.all(above):
        row = int(np.argmin(above))
        raise InputError(
            f"{function}: the {high_name} value must lie above the {low_name}, received {high[row]:g} and {low[row]:g} for "
            f"objective {row + 1}; raise the {high_name} value or lower the {low_name}"
        )


def _check_weights(function: str, values: FloatArray, weights: FloatArray) -> None:
    if np.ndim(values) != 2 or np.shape(weights) != np.shape(values)[1:]:
        raise InputError(
            f"{function}: values (n, m) and weights (m,) are needed, received shapes {np.shape(values)} and "
            f"{np.shape(weights)}"
        )
    if not (np.all(np.isfinite(weights)) and np.all(np.greater_equal(weights, 0.0)) and np.any(weights)):
        raise InputError(f"{function}: weights ≥ 0 are needed, one of them above 0, received {np.asarray(weights).tolist()}")
