"""Randomness handed in: every generator of a run is spawned from one recorded seed."""

from dataclasses import dataclass

import numpy as np

from railsearch.errors import InputError


@dataclass(frozen=True)
class RunGenerators:
    """The independent random streams of one run."""

    initial: np.random.Generator
    strategy: np.random.Generator
    unseen: np.random.Generator


def checked_seed(seed: int | None) -> int:
    """The seed itself, or a drawn one for None, to be recorded. Raises InputError for anything but an integer ≥ 0."""
    if seed is None:
        return int(np.random.SeedSequence().generate_state(1)[0])
    if isinstance(seed, bool) or not isinstance(seed, (int, np.integer)) or seed < 0:
        raise InputError(f"seed: an integer ≥ 0 is needed, received {seed!r}")
    return int(seed)


def run_generators(seed: int) -> RunGenerators:
    """Spawn the streams of a run. `initial` serves initial designs alone: strategies compared at one seed share them."""
    initial, strategy, unseen = np.random.SeedSequence(seed).spawn(3)
    return RunGenerators(np.random.default_rng(initial), np.random.default_rng(strategy), np.random.default_rng(unseen))
