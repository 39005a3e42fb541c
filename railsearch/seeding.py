"""Randomness handed in: every generator of a run is spawned from recorded seeds."""

import hashlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np

from railsearch.errors import InputError


@dataclass(frozen=True)
class RunGenerators:
    """The independent random streams of one run."""

    initial: np.random.Generator
    strategy: np.random.Generator
    unseen: np.random.Generator


def checked_seed(seed: int | None, field: str = "seed") -> int:
    """The seed itself, or a drawn one for None, to be recorded. Raises InputError for anything but an integer ≥ 0."""
    if seed is None:
        return int(np.random.SeedSequence().generate_state(1)[0])
    if isinstance(seed, bool) or not isinstance(seed, (int, np.integer)) or seed < 0:
        raise InputError(f"{field}: an integer ≥ 0 is needed, received {seed!r}")
    return int(seed)


def run_generators(seed: int, initial_seed: int | None = None) -> RunGenerators:
    """Spawn the streams of a run. `initial` serves initial designs alone; runs of one initial seed share it."""
    streams = np.random.SeedSequence(seed).spawn(3)
    if initial_seed is not None:
        streams[0] = np.random.SeedSequence(initial_seed).spawn(1)[0]
    initial, strategy, unseen = map(np.random.default_rng, streams)
    return RunGenerators(initial, strategy, unseen)


@dataclass(frozen=True)
class CellSeeds:
    """The seeds of one run of a campaign; `initial_seed` is the same for all strategies."""

    seed: int
    initial_seed: int


def cell_seeds(campaign_seed: int, problem: str, strategy: str, repetition: int) -> CellSeeds:
    """The seeds of a cell, a pure function of the campaign's seed, the labels and the repetition: no order matters."""
    return CellSeeds(
        _derived(campaign_seed, "strategy", problem, strategy, repetition),
        _derived(campaign_seed, "initial", problem, repetition),
    )


def _derived(seed: int, *words: str | int) -> int:
    """A number below 2⁵³ (exact in any JSON reader) from the SHA-256 hash of a seed and words."""
    text = "\x1f".join(map(str, (seed, *words)))
    return int.from_bytes(hashlib.sha256(text.encode()).digest()[:8], "big") >> 11


class LentGlobalGenerator:
    """numpy's global generator, lent to a library that draws from it without asking for one.

    Inside `lent` it has a state that follows from the seed and from what was drawn inside before, and so have generators
    that are made there without a seed; outside, nothing changes.
    """

    def __init__(self, seed: int) -> None:
        self._state = np.random.RandomState(seed).get_state()
        self._seeds = np.random.SeedSequence(seed)
        self._made = np.random.default_rng

    @contextmanager
    def lent(self) -> Iterator[None]:
        """The global generator in the state that belongs to the library."""
        before, made = np.random.get_state(), np.random.default_rng  # noqa: NPY002
        np.random.set_state(self._state)  # noqa: NPY002
        np.random.default_rng = self._generator
        try:
            yield
        finally:
            self._state = np.random.get_state()  # noqa: NPY002
            np.random.set_state(before)  # noqa: NPY002
            np.random.default_rng = made

    def _generator(self, seed: Any = None) -> np.random.Generator:
        return self._made(self._seeds.spawn(1)[0] if seed is None else seed)
