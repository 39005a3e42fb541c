"""What the benchmarks share: seconds, their spread, and a yardstick for the noise of the machine."""

import statistics
import time
from collections.abc import Callable

import numpy as np


def seconds(work: Callable[[], object]) -> float:
    """How long a piece of work takes."""
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def both_seconds(work: Callable[[], object]) -> tuple[float, float]:
    """How long a piece of work takes, and how much of this process's processor time."""
    processor = time.process_time()
    return seconds(work), time.process_time() - processor


def yardstick() -> None:
    """A fixed piece of arithmetic whose spread over the repeats is the noise of the machine."""
    x = np.linspace(0.0, 1.0, 1000)
    for _ in range(20000):
        x = x * 0.5 + 0.25


def spread(values: list[float]) -> str:
    """Median and range in words."""
    return f"median {statistics.median(values):.4g} ({min(values):.4g} to {max(values):.4g})"
