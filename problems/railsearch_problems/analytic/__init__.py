"""Analytic problems whose optimum or front is known, for tests, comparisons and demonstrations.

`optimum` is the optimal design, `pareto_set()` and `pareto_front()`, as pymoo has them, give the optimal designs (n, d) and
their objectives (n, m); `front(n)` gives more or fewer points of the front.
"""

from collections.abc import Callable
from typing import Any

from railsearch.hookspecs import hookimpl
from railsearch_problems.analytic import one_objective, several_objectives


@hookimpl
def railsearch_problems(register: Callable[[str, Any], None]) -> None:
    """Register the analytic problems."""
    for problem in (*one_objective.PROBLEMS, *several_objectives.PROBLEMS):
        register(problem.function_name, problem)
