"""Processes of our own."""

import os
import subprocess
import sys
from multiprocessing.connection import Connection
from pathlib import Path

from numpy.random import random_sample

from railsearch.child_process import AnsweringEnd, start_child


def draw(connection: Connection) -> None:
    """Answer with a number from NumPy's own generator, which exists as soon as this module is loaded."""
    AnsweringEnd(connection).answer(random_sample())  # noqa: NPY002 - the very thing


def different_draws() -> int:
    """How many different numbers four processes draw."""
    children = [start_child(draw, [], daemon=True) for _ in range(4)]
    drawn = {child.receive() for child in children}
    for child in children:
        child.end()
    return len(drawn)


def test_processes_do_not_draw_the_same_from_a_generator_that_nobody_seeds() -> None:
    """In a fresh interpreter, in which nothing has started processes with other modules."""
    code = f"from {Path(__file__).stem} import different_draws; print(different_draws())"
    environment = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join([str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")]),
    }
    answer = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    assert answer.stdout == "4\n"
