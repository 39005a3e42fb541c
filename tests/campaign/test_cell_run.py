"""A run that stands still between requests is the run that goes through."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from railsearch.campaign import cell_run
from railsearch.campaign.cell_run import Beginning, LiveRuns, Request, Step
from railsearch.interfaces import Evaluation
from railsearch.plugin_manager import Registry, load_plugins
from railsearch.problem_factory import ProblemSettings, given_designs, make_problem
from railsearch.run import RunSettings, run_search
from railsearch.run_identity import run_identity

BUDGET = 30


@pytest.fixture(scope="module")
def registry() -> Registry:
    return load_plugins()


@pytest.fixture(scope="module")
def whole(registry: Registry) -> tuple[dict[str, Any], list[Evaluation]]:
    """The identity of a run, and its evaluations when nothing interrupts it."""
    asked = ProblemSettings("ackley", sections={"function": {"dimension": 4, "integers": 2}})
    problem = make_problem(registry, asked)
    settings = RunSettings("lmsrs", BUDGET, 5, initial_seed=9)
    given = given_designs(problem)
    identity = run_identity(registry, asked, problem, settings, given)
    return identity, list(run_search(registry, problem, settings, given).evaluations)


def designs(evaluations: Sequence[Evaluation]) -> list[bytes]:
    return [evaluation.design.tobytes() for evaluation in evaluations]


def advanced(runs: LiveRuns, token: str, stored: list[Evaluation], beginning: Beginning | None = None) -> Step:
    step = runs.advance(Request(token, len(stored), beginning))
    if step.evaluation is not None:
        stored.append(step.evaluation)
    return step


def test_step_by_step_is_the_run_that_goes_through(registry: Registry, whole: tuple[Any, list[Evaluation]]) -> None:
    identity, expected = whole
    runs, stored = LiveRuns(registry), list[Evaluation]()
    step = advanced(runs, "a", stored, Beginning(identity, None, ()))
    assert step.versions["railsearch"]
    while not step.finished:
        step = advanced(runs, "a", stored)
    assert designs(stored) == designs(expected)
    assert np.array_equal([e.objectives for e in stored], [e.objectives for e in expected])
    assert advanced(runs, "a", stored).unknown


def test_a_run_goes_on_elsewhere_from_its_record(registry: Registry, whole: tuple[Any, list[Evaluation]]) -> None:
    identity, expected = whole
    stored: list[Evaluation] = []
    for place in range(5):
        runs = LiveRuns(registry)
        assert advanced(runs, "a", stored).unknown
        step = advanced(runs, "a", stored, Beginning(identity, None, tuple(stored)))
        for _ in range(place):
            step = advanced(runs, "a", stored)
        assert step.evaluation is not None
        runs.close()
    assert designs(stored) == designs(expected[: len(stored)])
    assert len(stored) == 5 + 1 + 2 + 3 + 4


def test_a_run_that_is_not_where_the_record_is_is_begun_again(
    registry: Registry, whole: tuple[Any, list[Evaluation]]
) -> None:
    """An answer that never arrived: the place is one evaluation ahead of the record."""
    identity, expected = whole
    runs, stored = LiveRuns(registry), list[Evaluation]()
    advanced(runs, "a", stored, Beginning(identity, None, ()))
    lost: list[Evaluation] = list(stored)
    advanced(runs, "a", lost)
    assert advanced(runs, "a", stored).unknown
    advanced(runs, "a", stored, Beginning(identity, None, tuple(stored)))
    assert designs(stored) == designs(expected[:2]) == designs(lost)


def test_runs_side_by_side_do_not_disturb_one_another(registry: Registry, whole: tuple[Any, list[Evaluation]]) -> None:
    identity, expected = whole
    runs, one, other = LiveRuns(registry), list[Evaluation](), list[Evaluation]()
    advanced(runs, "one", one, Beginning(identity, None, ()))
    advanced(runs, "other", other, Beginning({**identity, "seed": 6}, None, ()))
    for _ in range(BUDGET - 1):
        advanced(runs, "one", one)
        advanced(runs, "other", other)
    assert designs(one) == designs(expected)
    assert designs(other) != designs(expected)


def test_an_error_is_told_and_not_raised(registry: Registry, whole: tuple[Any, list[Evaluation]]) -> None:
    identity, expected = whole
    runs = LiveRuns(registry)
    strange = {**identity, "strategy": {"name": "nobody", "settings": {}}}
    assert "nobody" in runs.advance(Request("a", 0, Beginning(strange, None, ()))).error
    other = runs.advance(Request("b", 3, Beginning({**identity, "seed": 6, "initial_seed": 7}, None, tuple(expected[:3]))))
    assert "the record differs from this run at evaluation 2" in other.error


def test_a_run_that_nobody_asks_for_is_forgotten(
    registry: Registry, whole: tuple[Any, list[Evaluation]], monkeypatch: pytest.MonkeyPatch
) -> None:
    identity, _ = whole
    runs, stored = LiveRuns(registry), list[Evaluation]()
    advanced(runs, "a", stored, Beginning(identity, None, ()))
    monkeypatch.setattr(cell_run, "FORGOTTEN_AFTER", -1.0)
    assert advanced(runs, "a", stored).unknown
