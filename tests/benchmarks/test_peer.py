import dataclasses
from collections.abc import Callable

import numpy as np
import pytest
from railsearch_peers import conversation
from railsearch_peers.peer import ENDED

from railsearch.design_problem import DesignProblem
from railsearch.errors import CapabilityError, InputError, PluginError
from railsearch.interfaces import Capabilities, Evaluation, NoParameters
from railsearch.plugin_manager import Entry, Provenance, Registry
from railsearch.run import MemoryRecord, RunSettings, run_search
from railsearch.space import Space
from sample_problems import Sphere, Troubled

Settings = Callable[..., dict[str, object]]
BUDGET, START = 30, 20


def searched(
    registry: Registry, strategy: str, settings: dict[str, object], problem: DesignProblem | None = None, **other: object
) -> list[Evaluation]:
    problem = problem or Sphere()
    run = RunSettings(strategy, BUDGET, 3, settings, initial_seed=8)
    return list(run_search(registry, problem, run, [problem.reference], **other).evaluations)


def designs(evaluations: list[Evaluation]) -> np.ndarray:
    return np.array([evaluation.design for evaluation in evaluations])


def test_the_peer_knows_the_start_and_gets_the_values_of_rounded_points_inside_the_bounds(
    registry: Registry, fake_peer: Callable[[], int], settings: Settings
) -> None:
    evaluations = searched(registry, "peer", settings("checking"))
    origins = [evaluation.origin for evaluation in evaluations]
    assert origins == ["given"] + ["initial"] * 19 + ["peer"] * 9 + [f"{ENDED}it stopped by itself"]


def test_every_participant_begins_with_the_same_designs_as_dycors(
    registry: Registry, fake_peer: Callable[[], int], settings: Settings
) -> None:
    dycors = designs(searched(registry, "dycors", {}))
    peer = designs(searched(registry, "peer", settings("random")))
    random = designs(searched(registry, "started", {"strategy": "random"}))
    assert np.array_equal(peer[:START], dycors[:START])
    assert np.array_equal(random[:START], dycors[:START])
    assert len(np.unique(np.vstack([peer[START:], random[START:], dycors[START:]]), axis=0)) == 3 * (BUDGET - START)


def test_dycors_behind_the_shared_start_is_dycors(registry: Registry) -> None:
    own = searched(registry, "dycors", {})
    started = searched(registry, "started", {"strategy": "dycors"})
    assert np.array_equal(designs(started), designs(own))
    assert [e.origin for e in started] == [e.origin for e in own]


def test_the_same_seed_gives_the_same_run_and_one_process_serves_both(
    registry: Registry, fake_peer: Callable[[], int], settings: Settings
) -> None:
    first, second = (searched(registry, "peer", settings("random")) for _ in range(2))
    assert len(first) == BUDGET
    assert np.array_equal(designs(first), designs(second))
    assert fake_peer() == 1
    assert len(conversation.idle("fake_client")) == 1


def test_a_stopped_run_goes_on_from_its_record(registry: Registry, fake_peer: Callable[[], int], settings: Settings) -> None:
    whole = searched(registry, "peer", settings("random"))
    record = MemoryRecord()
    record.evaluations = whole[:25]
    assert np.array_equal(designs(searched(registry, "peer", settings("random"), record=record)), designs(whole))


@pytest.mark.parametrize(
    ("algorithm", "asked", "reason"),
    [
        ("crashing", 2, "ZeroDivisionError: no third question"),
        ("stopping", 1, "it stopped by itself"),
        ("dying", 1, "it died (exit code -9)"),
        ("hanging", 1, "it was silent for 0.5 s"),
        ("astray", 0, "it asked for the value at [nan, nan, nan, nan]"),
        ("unheard", 0, "KeyError: 'unheard'"),
    ],
)
def test_a_peer_that_ends_is_recorded_with_its_reason_and_nothing_is_lost(
    registry: Registry, fake_peer: Callable[[], int], settings: Settings, algorithm: str, asked: int, reason: str
) -> None:
    searched(registry, "peer", settings("random"))
    waiting = conversation.idle("fake_client")
    evaluations = searched(registry, "peer", settings(algorithm, patience=0.5 if algorithm == "hanging" else 60.0))
    assert [e.origin for e in evaluations[START:]] == ["peer"] * asked + [ENDED + reason] * (BUDGET - START - asked)
    assert not waiting


def test_a_peer_that_cannot_be_imported_is_recorded_with_its_reason(
    registry: Registry, fake_peer: Callable[[], int], settings: Settings
) -> None:
    evaluations = searched(registry, "peer", settings("random") | {"peer": "missing_client"})
    reason = f"{ENDED}ModuleNotFoundError: No module named 'missing_client'"
    assert [e.origin for e in evaluations[START:]] == [reason] * (BUDGET - START)


def test_a_repeated_question_is_answered_from_memory_and_costs_nothing(
    registry: Registry, fake_peer: Callable[[], int], settings: Settings
) -> None:
    evaluations = searched(registry, "peer", settings("repeating"))
    assert [e.origin for e in evaluations[START:]] == ["peer"] + ["unseen"] * (BUDGET - START - 1)


def test_a_failed_evaluation_is_as_bad_as_the_worst_so_far(
    registry: Registry, fake_peer: Callable[[], int], settings: Settings
) -> None:
    evaluations = searched(registry, "peer", settings("failures"), problem=OnlyRaising())
    assert evaluations[START].failed
    assert {e.origin for e in evaluations[START:]} == {"peer"}


def test_another_version_of_the_peer_is_refused(
    registry: Registry, fake_peer: Callable[[], int], settings: Settings
) -> None:
    with pytest.raises(PluginError, match=r"numpy 0\.1 is asked for, its environment has"):
        searched(registry, "peer", settings("random") | {"version": "0.1"})


def test_a_peer_without_an_environment_is_refused_with_the_command_that_builds_it(registry: Registry) -> None:
    with pytest.raises(PluginError, match=r"environments\.py peers build no-such-peer"):
        searched(registry, "peer", {"peer": "no-such-peer"})


def test_a_strategy_behind_the_start_must_suit_the_problem(registry: Registry) -> None:
    class RealOnly:
        Parameters = NoParameters
        capabilities = Capabilities()
        ask = tell = None

    entry = Entry("strategy", "real-only", RealOnly, Provenance("", "", ""))
    widened = Registry({(e.kind, e.name): e for e in [*registry.entries(), entry]}, [])
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("railsearch_peers.shared_start._registry", lambda: widened)
        with pytest.raises(CapabilityError, match="real-only cannot handle integer"):
            searched(registry, "started", {"strategy": "real-only"})
    with pytest.raises(InputError, match="unknown parameter 'sgima'"):
        searched(registry, "started", {"strategy": "random", "settings": {"sgima": 1.0}})


def test_a_space_that_is_exhausted_ends_the_search(
    registry: Registry, fake_peer: Callable[[], int], settings: Settings
) -> None:
    evaluations = searched(registry, "peer", settings("random"), problem=Few())
    assert len(evaluations) == 25
    assert len(conversation.idle("fake_client")) == 1


class OnlyRaising(Troubled):
    """Fails where count is −4 alone."""

    def simulate(self, design: np.ndarray) -> object:
        return super().simulate(design) if design[2] == -4 else Sphere.simulate(self, design)


class Few(Sphere):
    """25 designs."""

    def __init__(self) -> None:
        super().__init__()
        space = Space(tuple(dataclasses.replace(v, lower=-2.0, upper=2.0) for v in self.space.variables[2:]))
        DesignProblem.__init__(self, "few", space, self.objectives, reference=np.zeros(2))
