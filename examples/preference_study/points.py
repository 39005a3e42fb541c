"""The designs that surrogates are fitted to, as a table of text."""

import numpy as np

from railsearch.run_directory import write_whole

DIGITS = 12


def write_points(path, problem, evaluations):
    """Write designs with their objectives, a row each."""
    names = [*problem.space.names, *(quantity.name for quantity in problem.objectives)]
    rows = [
        [*evaluation.design, *(evaluation.metrics[quantity.name] for quantity in problem.objectives)]
        for evaluation in evaluations
        if not evaluation.failed
    ]
    lines = [",".join(names), *(",".join(f"{value:.{DIGITS}g}" for value in row) for row in rows)]
    write_whole(path, ("\n".join(lines) + "\n").encode("utf-8"))


def read_points(path):
    """The columns (n,) of such a table by name."""
    table = np.genfromtxt(path, delimiter=",", names=True)
    return {name: np.atleast_1d(table[name]) for name in table.dtype.names}
