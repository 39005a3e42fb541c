import multiprocessing
import time
from contextlib import closing
from multiprocessing.connection import Connection

import numpy as np
import pytest

from railsearch.errors import InputError
from railsearch.interfaces import Outcome
from railsearch.simulation import SeparateProcess, Simulators, simulators
from sample_problems import Sphere, Troubled


def design(count: int) -> np.ndarray:
    return np.array([0.0, 0.0, count, 0.0])


def test_the_process_gives_what_the_problem_gives() -> None:
    with closing(simulators(Sphere(), timeout=30.0)) as limited:
        ((_, simulated),) = limited.simulate([design(0)])
    outcome = simulated.outcome
    assert isinstance(outcome, Outcome)
    assert outcome.objectives == [4.0]
    assert outcome.metrics == {"norm": 0.0}


def test_hanging_and_dying_models_are_failures_and_the_next_design_works() -> None:
    limited = SeparateProcess(Troubled(), timeout=0.5)
    try:
        start = time.perf_counter()
        assert limited.simulate(design(3)).outcome == "time limit of 0.5 s exceeded"
        assert time.perf_counter() - start < 60.0
        assert isinstance(limited.simulate(design(0)).outcome, Outcome)
        assert limited.simulate(design(4)).outcome == "the simulating process died (exit code 3)"
        assert limited.simulate(design(-4)).outcome == "ZeroDivisionError: no ballast"
        assert isinstance(limited.simulate(design(1)).outcome, Outcome)
    finally:
        limited.close()


def test_a_process_that_died_while_waiting_is_replaced() -> None:
    limited = SeparateProcess(Sphere(), timeout=5.0)
    try:
        assert isinstance(limited.simulate(design(0)).outcome, Outcome)
        (child,) = multiprocessing.active_children()
        child.kill()
        child.join()
        assert isinstance(limited.simulate(design(0)).outcome, Outcome)
    finally:
        limited.close()


def test_a_problem_that_cannot_travel_is_refused() -> None:
    class Local(Sphere):
        pass

    with pytest.raises(InputError, match="cannot travel"):
        SeparateProcess(Local(), timeout=5.0).warm_up()


def test_what_is_under_way_is_stopped_when_the_simulators_are_closed() -> None:
    """One of three designs hangs without a limit: the others come, and closing does not wait for it."""
    side_by_side = Simulators([SeparateProcess(Troubled()) for _ in range(2)])
    side_by_side.warm_up()
    started = time.perf_counter()
    results = side_by_side.simulate([design(3), design(0), design(1)])
    assert {next(results)[0], next(results)[0]} == {1, 2}
    side_by_side.close()
    place, hanging = next(results)
    assert place == 0
    assert "died" in str(hanging.outcome)
    assert time.perf_counter() - started < 120.0
    assert not multiprocessing.active_children()


def test_a_daemonic_process_may_simulate_in_a_process_of_its_own() -> None:
    context = multiprocessing.get_context("spawn")
    mine, theirs = context.Pipe()
    worker = context.Process(target=_simulate_and_tell, args=(theirs,), daemon=True)
    worker.start()
    assert mine.poll(60.0)
    assert mine.recv() == 4.0
    worker.join()


def _simulate_and_tell(connection: Connection) -> None:
    with closing(simulators(Sphere(), timeout=30.0)) as limited:
        ((_, simulated),) = limited.simulate([design(0)])
    assert isinstance(simulated.outcome, Outcome)
    connection.send(simulated.outcome.objectives[0])


class Interrupted(Sphere):
    """Ctrl-C while compiled code runs comes back as another exception, with the interruption as its cause or context."""

    def __init__(self, chained: bool) -> None:
        super().__init__()
        self.chained = chained

    def simulate(self, design: np.ndarray) -> Outcome:
        try:
            raise KeyboardInterrupt
        except KeyboardInterrupt as interruption:
            if self.chained:
                raise SystemError("returned a result with an exception set") from interruption
            raise SystemError("returned a result with an exception set")  # noqa: B904 - the context alone


@pytest.mark.parametrize("chained", [True, False])
def test_an_interruption_is_no_failed_evaluation(chained: bool) -> None:
    with closing(simulators(Interrupted(chained))) as here, pytest.raises(KeyboardInterrupt):
        list(here.simulate([design(0)]))
