"""Sperling's ride comfort index of vertical carbody accelerations.

symbol  meaning                                              shape     unit
a       vertical acceleration of a carbody                   (..., t)  m/s²
dt      time step                                            scalar    s
H(s)    weighting filter, gain of a felt acceleration        -         -
a_w     a filtered with H from rest                          (..., t)  m/s²
W_z     (root mean square of a_w in cm/s²)^0.3               (...)     -

W_z 1 is just noticeable, 2 clearly noticeable, 3 strong (Garg & Dukkipati 1984, Dynamics of Railway
Vehicle Systems).
"""

from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.signal import cont2discrete, lfilter

from railsearch.errors import InputError

FloatArray = NDArray[np.float64]

NUMERATOR = (0.59 * 0.0063, 0.59 * 0.2200, 0.0)
DENOMINATOR = (1.4836e-4, 0.0070, 0.2488, 1.0)
"""H(s) = 0.59 (0.0063 s² + 0.2200 s)/(1.4836e-4 s³ + 0.0070 s² + 0.2488 s + 1), s in rad/s (Shang et al. 2024)."""


def comfort_filtered(acceleration: ArrayLike, time_step: float) -> FloatArray:
    """The weighted acceleration a_w (..., t) in the unit of `acceleration` a (..., t), filtered with H from rest.

    The response is exact for an acceleration that is linear between its samples and zero one step before the first
    (first-order hold). `time_step` in s. Raises InputError for a time step that is not positive, no samples, or
    accelerations that are not finite.
    """
    if not 0.0 < time_step < np.inf:
        raise InputError(f"time_step: above 0 s is needed for the comfort filter, received {time_step:g}; give the step")
    values = np.asarray(acceleration, dtype=float)
    if values.ndim == 0 or values.shape[-1] == 0 or not np.isfinite(values).all():
        raise InputError(
            f"acceleration: one or more finite samples are needed for the comfort filter, received shape {values.shape}; "
            "see whether the simulation diverged"
        )
    numerator, denominator = _discrete(float(time_step))
    return np.asarray(lfilter(numerator, denominator, values, axis=-1))


def ride_comfort_index(acceleration: ArrayLike, time_step: float) -> FloatArray:
    """W_z (...) = (root mean square of a_w in cm/s²)^0.3 of accelerations a (..., t) in m/s² at a `time_step` in s.

    The largest over the vehicles counts. Raises InputError as `comfort_filtered`.
    Source: Shang et al. 2024; Garg & Dukkipati 1984.
    """
    weighted = comfort_filtered(acceleration, time_step)
    return np.asarray((100.0 * np.sqrt(np.mean(weighted**2, axis=-1))) ** 0.3)


@lru_cache(maxsize=16)
def _discrete(time_step: float) -> tuple[tuple[float, ...], tuple[float, ...]]:
    numerator, denominator, _ = cont2discrete((NUMERATOR, DENOMINATOR), time_step, method="foh")
    return tuple(numerator.ravel()), tuple(denominator)
