"""Scalarising functions: many objectives into one.

| symbol | meaning | shape | unit | source |
|---|---|---|---|---|
| f | objectives, minimised | (n, m) | each its own | |
| f^r | aspiration point, the values wished for | (m,) | of f | Wierzbicki 1980 |
| f^max | worst values | (m,) | of f | level-crossing study, Shang et al. 2023 |
| κ_i | weight 1/(f_i^max − f_i^r) | (m,) | 1/unit of f_i | Miettinen and Mäkelä 2002 |
| ρ | augmentation coefficient | scalar | - | Miettinen and Mäkelä 2002 |
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
    objectives, aspiration, worst = (np.asarray(values, dtype=float) for values in (objectives, aspiration, worst))
    _check(objectives, aspiration, worst, rho)
    achievements = (objectives - aspiration) / (worst - aspiration)
    scalars: FloatArray = achievements.max(axis=1) + rho * achievements.sum(axis=1)
    return scalars


def _check(objectives: FloatArray, aspiration: FloatArray, worst: FloatArray, rho: float) -> None:
    if objectives.ndim != 2 or not aspiration.shape == worst.shape == objectives.shape[1:]:
        raise InputError(
            "augmented_chebyshev: objectives (n, m), aspiration (m,) and worst (m,) are needed, received shapes "
            f"{objectives.shape}, {aspiration.shape} and {worst.shape}"
        )
    if not np.all(worst > aspiration):
        low = int(np.argmin(worst > aspiration))
        raise InputError(
            f"augmented_chebyshev: the worst value must lie above the aspiration, received {worst[low]:g} and "
            f"{aspiration[low]:g} for objective {low + 1}; raise the worst value or lower the aspiration"
        )
    if not rho >= 0.0:
        raise InputError(f"augmented_chebyshev: rho ≥ 0 is needed, received {rho!r}")
