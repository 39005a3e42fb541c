import multiprocessing
import time

import numpy as np
import pytest

from railsearch.errors import InputError
from railsearch.interfaces import Outcome
from railsearch.simulation import TimeLimited, simulator
from sample_problems import Sphere, Troubled


def design(count: int) -> np.ndarray:
    return np.array([0.0, 0.0, count, 0.0])


def test_the_process_gives_what_the_problem_gives() -> None:
    limited = simulator(Sphere(), timeout=30.0)
    try:
        outcome = limited.simulate(design(0))
    finally:
        limited.close()
    assert isinstance(outcome, Outcome)
    assert outcome.objectives == [4.0]
    assert outcome.metrics == {"norm": 0.0}


def test_hanging_and_dying_models_are_failures_and_the_next_design_works() -> None:
    limited = TimeLimited(Troubled(), timeout=0.5)
    try:
        start = time.perf_counter()
        assert limited.simulate(design(3)) == "time limit of 0.5 s exceeded"
        assert time.perf_counter() - start < 60.0
        assert isinstance(limited.simulate(design(0)), Outcome)
        assert limited.simulate(design(4)) == "the simulating process died (exit code 3)"
        assert limited.simulate(design(-4)) == "ZeroDivisionError: no ballast"
        assert isinstance(limited.simulate(design(1)), Outcome)
    finally:
        limited.close()


def test_a_process_that_died_while_waiting_is_replaced() -> None:
    limited = TimeLimited(Sphere(), timeout=5.0)
    try:
        assert isinstance(limited.simulate(design(0)), Outcome)
        (child,) = multiprocessing.active_children()
        child.kill()
        child.join()
        assert isinstance(limited.simulate(design(0)), Outcome)
    finally:
        limited.close()


def test_a_problem_that_cannot_travel_is_refused() -> None:
    class Local(Sphere):
        pass

    with pytest.raises(InputError, match="cannot travel"):
        TimeLimited(Local(), timeout=5.0).warm_up()
