"""A client without a peer, for tests: every algorithm behaves in one way of its own."""

import os
import signal
import time

import numpy as np
from serve import Run

DISTRIBUTIONS = ("numpy",)


def random(run: Run) -> None:
    """Random points for ever."""
    print("a peer may print what it likes")
    generator = np.random.default_rng(run.seed)
    while True:
        run.evaluate(generator.uniform(run.lower, run.upper))


def checking(run: Run) -> None:
    """Knows the start and is answered the value of the rounded point; fails if anything is not as it should be."""
    assert run.points.shape == (20, 4)
    assert run.budget == 30
    assert run.integer.tolist() == [False, False, True, True]
    for point, value in zip(run.points, run.values, strict=True):
        assert value == np.sum((point - 1.0) ** 2)
        assert run.evaluate(point + 1e-12) == value
    for k in range(9):
        point = run.lower + 0.41 + 0.93 * k * np.array([1.0, 0.9, 0.8, 0.7])
        rounded = np.where(run.integer, np.round(np.clip(point, run.lower, run.upper)), np.clip(point, run.lower, run.upper))
        assert run.evaluate(point) == np.sum((rounded - 1.0) ** 2)


def repeating(run: Run) -> None:
    """Asks for the same point for ever and insists on the same value."""
    while True:
        assert run.evaluate(np.zeros(run.dimension) + 0.25) == run.evaluate(np.zeros(run.dimension) + 0.25)


def crashing(run: Run) -> None:
    """Fails after the second answer."""
    run.evaluate(run.lower)
    run.evaluate(run.upper)
    raise ZeroDivisionError("no third question")


def stopping(run: Run) -> None:
    """Stops after the first answer."""
    run.evaluate(run.lower)


def hanging(run: Run) -> None:
    """Says nothing for longer than anybody should wait, then goes on."""
    run.evaluate(run.lower)
    time.sleep(20.0)
    random(run)


def dying(run: Run) -> None:
    """Kills itself."""
    run.evaluate(run.lower)
    os.kill(os.getpid(), signal.SIGKILL)


def astray(run: Run) -> None:
    """Asks for the value at no place at all."""
    run.evaluate(np.full(run.dimension, np.nan))


def failures(run: Run) -> None:
    """Asks where there is no value, and fails unless it is told the worst value so far."""
    assert run.evaluate([0.0, 0.0, -4.0, 0.0]) == run.values.max()
    random(run)


ALGORITHMS = {
    algorithm.__name__: algorithm
    for algorithm in (random, checking, repeating, crashing, stopping, hanging, dying, astray, failures)
}
