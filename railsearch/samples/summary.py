"""What a sample shows of each objective and metric: extremes and quantiles.

The quantile at level p of n sorted values is interpolated linearly at place p (n − 1) (Hyndman & Fan 1996, definition 7).
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from railsearch.design_problem import DesignProblem
from railsearch.interfaces import Evaluation
from railsearch.result import quantities
from railsearch.samples.table import natural_values

LEVELS = (1, 50, 90, 99)
"""Quantiles in per cent."""


def summary(problem: DesignProblem, evaluations: Sequence[Evaluation]) -> list[dict[str, Any]]:
    """Name, unit, meaning, number of values, minimum, quantiles and maximum of every objective and metric.

    Failed samples do not count, nor do values that are not finite; a quantity without any value has nulls.
    """
    succeeded = [evaluation for evaluation in evaluations if not evaluation.failed]
    rows = []
    for quantity in quantities(problem):
        values = natural_values(problem, succeeded, quantity.name)
        values = values[np.isfinite(values)]
        numbers = np.quantile(values, [0.0, *(level / 100.0 for level in LEVELS), 1.0]).tolist() if values.size else None
        keys = ["minimum", *(f"q{level}" for level in LEVELS), "maximum"]
        shown = dict(zip(keys, numbers, strict=True)) if numbers else dict.fromkeys(keys)
        rows.append(
            {"name": quantity.name, "unit": quantity.unit, "meaning": quantity.meaning, "values": values.size} | shown
        )
    return rows
