"""Sobol' indices of a model over its random inputs, to stand beside importances near extremes.

| symbol | meaning | shape | unit |
|---|---|---|---|
| X, Y | random inputs, output g(X) | (d,), scalar | |
| S_i | first-order index Var E[Y | X_i] / Var Y | (d,) | - |
| T_i | total index E Var[Y | X_j, j ≠ i] / Var Y | (d,) | - |
| n | base sample; n (d + 2) evaluations are made | scalar | - |

Estimated by SALib (Herman & Usher 2017): Saltelli et al. 2010 for S, Jansen 1999 for T, on scrambled Sobol' points.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from railsearch.distributions import RandomVector
from railsearch.errors import InputError, SimulationError
from railsearch.sampling import FACE
from railsearch.space import FloatArray

from .curves import plain
from .models import Function

CONFIDENCE = 0.95


@dataclass(frozen=True)
class SobolIndices:
    """Indices of the inputs `names`, each (d,), with the half widths of their 95 % confidence intervals.

    evaluations: how many were made; dropped: blocks of d + 2 of them in which one failed.
    """

    names: tuple[str, ...]
    first: FloatArray
    first_half_width: FloatArray
    total: FloatArray
    total_half_width: FloatArray
    evaluations: int
    dropped: int

    def document(self) -> dict[str, Any]:
        """All of it in plain types, ready for JSON."""
        columns = ("first", "first_half_width", "total", "total_half_width")
        return {
            "inputs": list(self.names),
            **{column: plain(getattr(self, column)) for column in columns},
            "confidence": CONFIDENCE,
            "evaluations": self.evaluations,
            "dropped_blocks": self.dropped,
        }


def sobol_indices(function: Function, inputs: RandomVector, base: int, generator: np.random.Generator) -> SobolIndices:
    """Estimate S and T of a vectorised function from n (d + 2) evaluations; blocks with a failed one are left out.

    function: values (k,) at points (k, d), NaN where it failed; base: n, a power of two. Raises InputError for another n,
    an output that does not vary, and SimulationError if fewer than two blocks are whole.
    """
    from SALib.analyze import sobol as analysis
    from SALib.sample import sobol as design

    if base < 2 or base & (base - 1):
        raise InputError(f"base sample: a power of two from 2 is needed for Sobol' points, received {base}")
    problem = unit_problem(inputs.names)
    unit = design.sample(problem, base, calc_second_order=False, seed=generator)
    values = np.asarray(function(inputs.from_uniform(np.clip(unit, FACE, 1.0 - FACE))), dtype=float)
    blocks = whole_blocks(values, base)
    found = analysis.analyze(
        problem, blocks.ravel(), calc_second_order=False, conf_level=CONFIDENCE, seed=int(generator.integers(2**31))
    )
    first, first_half, total, total_half = (
        np.asarray(found[key], dtype=float) for key in ("S1", "S1_conf", "ST", "ST_conf")
    )
    return SobolIndices(inputs.names, first, first_half, total, total_half, len(values), base - len(blocks))


def unit_problem(names: tuple[str, ...]) -> dict[str, Any]:
    """The unit cube as SALib describes a problem."""
    return {"num_vars": len(names), "names": list(names), "bounds": [[0.0, 1.0]] * len(names)}


def whole_blocks(values: FloatArray, count: int) -> FloatArray:
    """The blocks (m, k) without failures among `count` of values.

    Raises SimulationError if fewer than two are left, InputError if nothing varies in them.
    """
    blocks = values.reshape(count, -1)
    blocks = blocks[np.isfinite(blocks).all(axis=1)]
    if len(blocks) < 2:
        raise SimulationError(
            f"{int((~np.isfinite(values)).sum())} of {len(values)} evaluations failed: fewer than two of {count} blocks are "
            "whole"
        )
    if not np.ptp(blocks) > 0.0:
        raise InputError(f"the output is {blocks[0, 0]:g} at every point: nothing has an influence on it")
    return blocks
