"""Measures of sets of objective vectors.

| symbol | meaning | shape | unit | source |
|---|---|---|---|---|
| n, m | objective vectors, objectives | scalars | - | |
| F | objective vectors, minimised | (n, m) | of the objectives | |
| r | reference point: vectors not below it in every objective do not count | (m,) | of the objectives | |
| HV | hypervolume between F and r | scalar | product of those of the objectives | Zitzler et al. 2003 |
| Z | reference front | (q, m) | of the objectives | |
| IGD+ | modified inverted generational distance | scalar | of the objectives | Ishibuchi et al. 2015 |
| N | runs | scalar | - | |
| α(z) | empirical attainment: fraction of runs with an f ≤ z | scalar | - | Fonseca et al. 2011 |

Dominance, volumes, distances and attainment surfaces themselves are computed by moocore.
"""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from railsearch.errors import InputError
from railsearch.space import FloatArray


def non_dominated(objectives: FloatArray) -> NDArray[np.intp]:
    """Rows of `objectives` (n, m), to be minimised, that no other row dominates; of equal rows the first.

    a dominates b if a_i ≤ b_i for all i and a_i < b_i for one (Deb 2001, section 2.4).
    """
    import moocore

    unique, first = np.unique(objectives, axis=0, return_index=True)
    return np.sort(first[moocore.is_nondominated(unique)]) if len(unique) else first


def hypervolume(objectives: FloatArray, reference_point: FloatArray) -> float:
    """The volume that objective vectors F (n, m) dominate below a reference point r (m,); 0 if none lies below it.

    HV = λ(∪_i [f_i, r]), λ the volume of a set in R^m.
    Raises InputError for NaN, for an infinite reference point, and for shapes that do not agree.
    Source: Zitzler et al. 2003; Fonseca et al. 2006.
    """
    import moocore

    _check_shapes(objectives, "reference_point", np.atleast_2d(reference_point))
    _check_numbers("objectives", ~np.isnan(objectives))
    below = objectives[np.all(objectives < reference_point, axis=1)]
    return float(moocore.hypervolume(below, ref=reference_point)) if len(below) else 0.0


def hypervolume_curve(objectives: FloatArray, reference_point: FloatArray) -> FloatArray:
    """The hypervolumes (n,) of the first 1, 2, …, n objective vectors of F (n, m); rows with NaN do not count.

    Only the front is kept on the way, and the volume is computed when the front changes.
    Raises InputError for an infinite reference point, and for shapes that do not agree.
    """
    _check_shapes(objectives, "reference_point", np.atleast_2d(reference_point))
    volumes = np.zeros(len(objectives))
    front = np.empty((0, objectives.shape[1]))
    for number in np.flatnonzero(np.all(objectives < reference_point, axis=1)):
        vector = objectives[number]
        if not np.all(front <= vector, axis=1).any():
            front = np.vstack([front[np.any(front < vector, axis=1)], vector])
            volumes[number:] = hypervolume(front, reference_point)
    return volumes


def igd_plus(objectives: FloatArray, reference_front: FloatArray) -> float:
    """How far objective vectors F (n, m) are from covering a reference front Z (q, m); +∞ for an empty F.

    IGD+ = (1/q) Σ_z min_f ‖max(f − z, 0)‖, so that only being worse than z counts as distance.
    Raises InputError for an empty reference front, for values that are not finite, and for shapes that do not agree.
    Source: Ishibuchi et al. 2015.
    """
    import moocore

    _check_shapes(objectives, "reference_front", reference_front)
    _check_numbers("objectives", np.isfinite(objectives))
    return float(moocore.igd_plus(objectives, ref=reference_front)) if len(objectives) else math.inf


def attainment_surface(fronts: Sequence[FloatArray], fractions: Sequence[float] = (0.25, 0.5, 0.75)) -> list[FloatArray]:
    """For each fraction the corners (p_i, 2), by first objective, of the region that so many runs attain at the least.

    fronts: objective vectors (n_i, 2) of N runs; a run with none attains nothing. A corner z is a minimal vector with
    α(z) ≥ fraction; a fraction that too few runs could reach has no corners.
    Raises InputError without a run, for fractions outside (0, 1], values that are not finite, other than two objectives.
    Source: Fonseca et al. 2011.
    """
    _check_fronts(fronts)
    if not all(0.0 < fraction <= 1.0 for fraction in fractions):
        raise InputError(f"fractions: numbers above 0 and up to 1 are needed, received {list(fractions)}")
    found = [front for front in fronts if len(front)]
    runs = [math.ceil(round(fraction * len(fronts), 9)) for fraction in fractions]
    return [_attained_by(found, count) if count <= len(found) else np.empty((0, 2)) for count in runs]


def _attained_by(fronts: Sequence[FloatArray], count: int) -> FloatArray:
    """The corners (p, 2) of what `count` runs or more attain; the percentile lies half a run lower, clear of rounding."""
    import moocore

    runs = np.repeat(np.arange(len(fronts)), [len(front) for front in fronts])
    surface = moocore.eaf(np.vstack(fronts), runs, percentiles=[100.0 * (count - 0.5) / len(fronts)])
    corners: FloatArray = surface[np.argsort(surface[:, 0], kind="stable"), :2]
    return corners


def _check_fronts(fronts: Sequence[FloatArray]) -> None:
    if not fronts:
        raise InputError("fronts: one run or more is needed, received none")
    for front in fronts:
        if np.ndim(front) != 2 or np.shape(front)[1] != 2:
            raise InputError(f"fronts: two objectives are needed, received an array of shape {np.shape(front)}")
        _check_numbers("fronts", np.isfinite(front))


def _check_shapes(objectives: FloatArray, name: str, other: FloatArray) -> None:
    if np.ndim(objectives) != 2 or np.ndim(other) != 2 or len(other) == 0 or objectives.shape[1] != other.shape[1]:
        raise InputError(
            f"objectives and {name}: the same number of objectives in both is needed, received shapes "
            f"{np.shape(objectives)} and {np.shape(other)}"
        )
    _check_numbers(name, np.isfinite(other))


def _check_numbers(name: str, allowed: NDArray[np.bool_]) -> None:
    if not allowed.all():
        rows = np.flatnonzero(~allowed.all(axis=1))
        raise InputError(f"{name}: numbers are needed, received NaN or an infinite value in row {rows[0] + 1}")
