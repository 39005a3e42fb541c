"""Sobol' indices of a model over its random inputs, to stand beside importances near extremes.

| symbol | meaning | shape | unit |
|---|---|---|---|
| X, Y | random inputs, output g(X) | (d,), scalar | |
| S_i | first-order index Var E[Y | X_i] / Var Y | (d,) | - |
| T_i | total index E Var[Y | X_j, j ≠ i] / Var Y | (d,) | - |
| n | base sample; n (d + 2) evaluations are made | scalar | - |

Estimated by SALib (Herman & Usher 2017): Saltelli et al. 2010 for S, Jansen 1999 for T, on scrambled Sobol' points. Those
of a polynomial chaos expansion follow from its coefficients (Sudret 2008).
"""

from dataclasses import dataclass
from typing import Any, Protocol

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

    evaluations: how many were made, 0 for closed form; dropped: blocks of d + 2 of them in which one failed.
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
            "closed_form": self.evaluations == 0,
            "evaluations": self.evaluations,
            "dropped_blocks": self.dropped,
        }


class Decomposition(Protocol):
    """An expansion that knows its indices."""

    @property
    def first_order_indices(self) -> FloatArray:
        """S (d,)."""

    @property
    def total_indices(self) -> FloatArray:
        """T (d,)."""


def closed_form_indices(names: tuple[str, ...], expansion: Decomposition) -> SobolIndices:
    """S and T of an expansion over orthonormal polynomials of its inputs: nothing is estimated, half widths are 0."""
    exact = np.zeros(len(names))
    return SobolIndices(names, expansion.first_order_indices, exact, expansion.total_indices, exact, 0, 0)


def sobol_indices(function: Function, inputs: RandomVector, base: int, generator: np.random.Generator) -> SobolIndices:
    """Estimate S and T of a vectorised function from n (d + 2) evaluations; blocks with a failed one are left out.

    function: values (k,) at points (k, d), NaN where it failed; base: n, a power of two. Raises InputError for another n,
    an output that does not vary, and SimulationError if fewer than two blocks are whole.
    """
    values = np.asarray(function(saltelli_points(inputs, base, generator)), dtype=float)
    return indices_of_blocks(inputs.names, values, generator)


def saltelli_points(inputs: RandomVector, base: int, generator: np.random.Generator) -> FloatArray:
    """The points (n (d + 2), d) at which a function must be known; n is `base`. Raises InputError unless a power of two."""
    from SALib.sample import sobol as design

    check_base(base)
    unit = design.sample(unit_problem(inputs.names), base, calc_second_order=False, seed=generator)
    return inputs.from_uniform(np.clip(unit, FACE, 1.0 - FACE))


def check_base(base: int) -> None:
    """Raise InputError unless n is a power of two."""
    if base < 2 or base & (base - 1):
        raise InputError(f"base sample: a power of two from 2 is needed for Sobol' points, received {base}")


def indices_of_blocks(names: tuple[str, ...], values: FloatArray, generator: np.random.Generator) -> SobolIndices:
    """S and T from values (n (d + 2),) at `saltelli_points`; generator: resamples them for the confidence intervals.

    Raises InputError and SimulationError as `sobol_indices`.
    """
    from SALib.analyze import sobol as analysis

    base = len(values) // (len(names) + 2)
    blocks = whole_blocks(values, base)
    found = analysis.analyze(
        unit_problem(names),
        blocks.ravel(),
        calc_second_order=False,
        conf_level=CONFIDENCE,
        seed=int(generator.integers(2**31)),
    )
    first, first_half, total, total_half = (
        np.asarray(found[key], dtype=float) for key in ("S1", "S1_conf", "ST", "ST_conf")
    )
    return SobolIndices(names, first, first_half, total, total_half, len(values), base - len(blocks))


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
