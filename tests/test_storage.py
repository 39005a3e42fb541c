from pathlib import Path

import numpy as np
import optuna
import optuna_dashboard
import pytest
from optuna.trial import TrialState

from railsearch.errors import StorageError
from railsearch.interfaces import Evaluation
from railsearch.storage import RunStorage, StudyDescription, identity_differences, open_run
from railsearch.storage.note import note_attributes
from sample_problems import MIXED, TwoObjectives

IDENTITY = {"problem": "two", "seed": 1, "strategy": {"name": "random", "settings": {"a": (1.0, 2.0)}}}


def description(identity: dict[str, object] | None = None, n_constraints: int = 1) -> StudyDescription:
    return StudyDescription("two / random / seed 1", identity or IDENTITY, ("left", "right"), n_constraints, "# note")


def opened(folder: Path, identity: dict[str, object] | None = None) -> RunStorage:
    return open_run(f"sqlite:///{folder / 'study.db'}", description(identity), MIXED)


def evaluations() -> list[Evaluation]:
    generator = np.random.default_rng(3)
    made = []
    for number in range(6):
        design = MIXED.from_unit(generator.random(4))
        outcome = TwoObjectives(constrained=True).simulate(design)
        failed = number == 2
        made.append(
            Evaluation(
                number,
                design,
                np.full(2, np.nan) if failed else outcome.objectives,
                np.full(1, np.nan) if failed else outcome.constraints,
                {}
                if failed
                else {name: float(value) for name, value in outcome.metrics.items()} | {"unknown": float("nan")},
                "initial",
                number // 4,
                "ZeroDivisionError: no ballast" if failed else "",
                generator.random(),
                generator.random(),
            )
        )
    return made


def assert_same(one: Evaluation, other: Evaluation) -> None:
    assert one.design.tobytes() == other.design.tobytes()
    assert np.array_equal(one.objectives, other.objectives, equal_nan=True)
    assert np.array_equal(one.constraints, other.constraints, equal_nan=True)
    assert repr(dict(sorted(one.metrics.items()))) == repr(dict(sorted(other.metrics.items())))
    assert repr(one).split("origin=")[1] == repr(other).split("origin=")[1]


def test_what_is_stored_comes_back_to_the_last_bit(tmp_path: Path) -> None:
    record = opened(tmp_path)
    made = evaluations()
    for evaluation in made:
        record.append(evaluation)
    for one, other in zip(made, opened(tmp_path).load(), strict=True):
        assert_same(one, other)


def test_the_study_tells_the_dashboard_what_it_needs(tmp_path: Path) -> None:
    record = opened(tmp_path)
    for evaluation in evaluations():
        record.append(evaluation)
    study = optuna.load_study(study_name="two / random / seed 1", storage=f"sqlite:///{tmp_path / 'study.db'}")
    assert study.metric_names == ["left", "right"]
    assert optuna_dashboard.get_note(study) == "# note"
    states = [trial.state for trial in study.trials]
    assert [state == TrialState.FAIL for state in states] == [number == 2 for number in range(6)]
    assert study.trials[2].user_attrs["reason"] == "ZeroDivisionError: no ballast"
    first = study.trials[0]
    assert set(first.params) == set(MIXED.names)
    assert isinstance(first.params["count"], int)
    assert {"left", "right", "comfort", "origin", "trajectory", "duration [s]"} <= set(first.user_attrs)
    assert list(first.constraints.values()) == first.system_attrs["constraints"] == evaluations()[0].constraints.tolist()


@pytest.mark.parametrize("length", [0, 1, 2045, 2046, 5000])
@pytest.mark.parametrize("earlier", ["", "y" * 4091])
def test_a_note_is_kept_as_the_dashboard_keeps_one(length: int, earlier: str) -> None:
    storage = optuna.storages.InMemoryStorage()
    study = optuna.create_study(storage=storage)
    (number,) = (kept._study_id for kept in storage.get_all_studies())
    optuna_dashboard.save_note(study, earlier)
    ours = dict(storage.get_study_system_attrs(number))
    ours |= note_attributes("x" * length, ours)
    optuna_dashboard.save_note(study, "x" * length)
    assert ours == storage.get_study_system_attrs(number)


@pytest.mark.parametrize(
    ("change", "words"),
    [({"seed": 2}, "seed: there 1, here 2"), ({"problem": "one"}, "problem: there"), ({"budget": 3}, "budget: there null")],
)
def test_a_record_of_another_run_is_refused_and_left_alone(tmp_path: Path, change: dict[str, object], words: str) -> None:
    opened(tmp_path).append(evaluations()[0])
    with pytest.raises(StorageError, match=words):
        opened(tmp_path, {**IDENTITY, **change})
    assert len(opened(tmp_path).load()) == 1


def test_a_study_begun_by_another_program_is_refused(tmp_path: Path) -> None:
    record = opened(tmp_path)
    study = optuna.load_study(study_name="two / random / seed 1", storage=f"sqlite:///{tmp_path / 'study.db'}")
    study.ask()
    with pytest.raises(StorageError, match="another program"):
        record.load()


@pytest.mark.parametrize("url", ["sqlite:////no/such/folder/study.db", "nonsense", "postgresql+nodriver://host/name"])
def test_a_storage_that_cannot_be_opened_is_a_clear_error(url: str) -> None:
    with pytest.raises(StorageError, match="cannot be opened"):
        open_run(url, description(), MIXED)


def test_what_differs_in_a_long_list_is_found() -> None:
    reference = {f"x{k}": 1120.0 for k in range(8)}
    longer = identity_differences({"given": [reference]}, {"given": [reference, {**reference, "x1": 100.0}]})
    assert longer[0].startswith('given: there 1 entries, here 2, new is {"x0": 1120.0, "x1": 100.0')
    assert identity_differences({"given": [reference]}, {"given": [{**reference, "x7": 5.0}]}) == [
        "given[1].x7: there 1120.0, here 5.0"
    ]
    numbers = [float(k) for k in range(99)]
    assert identity_differences({"level": numbers}, {"level": [*numbers[:50], -1.0, *numbers[51:]]}) == [
        "level[51]: there 50.0, here -1.0"
    ]
    assert identity_differences({"short": [1]}, {"short": [2, 3]}) == ["short: there [1], here [2, 3]"]
    assert identity_differences({"given": [reference]}, {"given": [dict(reference)]}) == []
