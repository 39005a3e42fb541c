"""What a strategy has to fulfil."""

import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from railsearch.interfaces import Capabilities, Evaluation
from railsearch.sampling import random_designs
from railsearch.testing.requirement import require
from railsearch.testing.trials import (
    MIXED,
    ONE_INTEGER,
    ONE_REAL,
    REAL,
    TINY,
    MakeSurrogate,
    Trial,
    bowls,
    played_trial,
    registered_surrogates,
)

Play = Callable[[Trial], tuple[list[Evaluation], list[bytes]]]


def check_strategy(
    plugin: Any,
    settings: Mapping[str, object] | None = None,
    surrogate: MakeSurrogate | None = None,
    budget: int = 30,
) -> None:
    """Check a strategy class, made with `settings` of its parameters, in the trials that its capabilities allow.

    - Same seed, same proposals to the last bit; another seed, others; nothing depends on or touches global randomness.
    - Float vectors inside the bounds, whole integers, batches no larger than asked for, budgets from one evaluation on.
    - Failed evaluations (all, the first ones, 5 % and 50 % at random), repeated ones and ones that were not asked for are
      survived; what was told is not altered.
    - Spaces of one variable, spaces with fewer designs than the budget, constant objectives and objectives of any
      magnitude are searched.
    - With one objective, the best design is better than the median of random ones.

    surrogate: makes a surrogate from its name, dimension and settings, by default one of the registered ones; budget:
    evaluations of a trial, less for a strategy that is slow by its nature, but enough that it gets past its start. Raises
    AssertionError with an explanation; every error has a note that says in which trial.
    """
    play = partial(played_trial, plugin, settings=settings or {}, surrogate=surrogate or registered_surrogates())
    capabilities: Capabilities = plugin.capabilities
    main, *others = _bases(capabilities, budget)
    for base in (main, *others):
        _check_reproducible(play, base)
    for trial in itertools.chain(_mishaps(main, capabilities), _odd_problems(main, capabilities)):
        _check_played(play, trial)
    for base in others:
        _check_played(play, _everything_at_once(base, capabilities))


def _bases(capabilities: Capabilities, budget: int) -> Iterator[Trial]:
    """Undisturbed trials: the first in the richest space with one objective, then the other spaces and counts."""
    spaces = [MIXED, REAL] if capabilities.integers else [REAL]
    objectives = [1, 2] if capabilities.multi_objective else [1]
    constraints = [0, 1] if capabilities.constraints else [0]
    for space, n_objectives, n_constraints in itertools.product(spaces, objectives, constraints):
        name = f"{n_objectives} objectives, {n_constraints} constraints"
        yield Trial(space, n_objectives, n_constraints, budget, name=name)


def _mishaps(base: Trial, capabilities: Capabilities) -> Iterator[Trial]:
    """The trial with other budgets, batches, failures, and evaluations that were not asked for."""
    for budget, given in itertools.product((1, 2, 7), (0, 1)):
        yield replace(base, budget=budget, given=given, name=f"a budget of {budget}, {given} given")
    yield replace(base, fails=lambda number: True, name="every evaluation fails")
    yield replace(base, fails=lambda number: number < 2 * base.budget // 3, name="the first two thirds fail")
    yield replace(base, fails=_at_random(0.05), name="5 % fail")
    yield replace(base, fails=_at_random(0.5), name="50 % fail")
    yield replace(base, repeats=True, name="everything is told twice")
    yield replace(base, strangers=True, given=3, name="every fifth answer is of another design")
    if capabilities.batch:
        for size in (3, base.budget - 4):
            yield replace(base, batch_size=size, given=2, name=f"batches of {size}")
        yield _everything_at_once(base, capabilities)


def _odd_problems(base: Trial, capabilities: Capabilities) -> Iterator[Trial]:
    yield replace(base, space=ONE_REAL, name="one variable")
    yield replace(base, scale=0.0, name="a constant objective")
    yield replace(base, scale=1e12, name="a large objective")
    yield replace(base, scale=1e-12, name="a small objective")
    if capabilities.integers:
        yield replace(base, space=ONE_INTEGER, name="one integer, fewer designs than the budget")
        yield replace(base, space=TINY, given=1, name="fewer designs than the budget")
        yield replace(base, space=TINY, fails=_at_random(0.5), name="fewer designs than the budget, half of them fail")


def _everything_at_once(base: Trial, capabilities: Capabilities) -> Trial:
    return replace(
        base,
        batch_size=7 if capabilities.batch else 1,
        strangers=True,
        repeats=True,
        fails=lambda number: number % 4 == 0,
        name=f"everything at once, {base.name}",
    )


def _at_random(share: float) -> Callable[[int], bool]:
    """Whether the evaluation of a number fails, drawn once and for all."""
    return lambda number: bool(np.random.default_rng([7, number]).random() < share)


def _check_reproducible(play: Play, trial: Trial) -> None:
    before = _global_state()
    evaluations, first = play(trial)
    require(_global_state() == before, "the strategy draws from numpy's global generator; use context.generator")
    _, second = play(trial)
    require(first == second, "two runs from the same seed propose different designs; use context.generator only")
    _, other = play(replace(trial, seed=trial.seed + 1))
    require(first != other, "runs from different seeds propose the same designs")
    _check_best(evaluations, trial)


def _check_played(play: Play, trial: Trial) -> None:
    evaluations, _ = play(trial)
    require(
        len(evaluations) == trial.length, f"{len(evaluations)} evaluations were made in “{trial.name}”, not {trial.length}"
    )
    _check_best(evaluations, trial)


def _check_best(evaluations: Sequence[Evaluation], trial: Trial) -> None:
    """With one objective and 5 successes or more, the best one is better than the median of random designs."""
    successes = [float(evaluation.objectives[0]) for evaluation in evaluations if not evaluation.failed]
    if trial.n_objectives > 1 or trial.scale == 0.0 or len(successes) < 5:
        return
    drawn = random_designs(trial.space, 200, np.random.default_rng(trial.seed + 3000))
    median = float(np.median([bowls(trial, design)[0] for design in drawn]))
    require(
        min(successes) < median,
        f"in “{trial.name}” the best of {len(successes)} successes is {min(successes):g}, no better than {median:g}, the "
        "median of random designs",
    )


def _global_state() -> bytes:
    state: Any = np.random.get_state()  # noqa: NPY002 - what must not change
    return bytes(state[1].tobytes()) + str(state[2:]).encode()
