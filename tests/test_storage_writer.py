"""Trials written straight into the tables are those that Optuna writes, to the last bit."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import optuna
import pytest

from postgresql_server import postgresql
from railsearch.interfaces import Evaluation
from railsearch.space import Space, Variable
from railsearch.storage import Storage, StudyDescription, open_run
from railsearch.storage import study as study_module
from sample_problems import MIXED

SPACE = Space((Variable("Steifigkeit ü", -5.0, 1e300, "MN/m"), Variable("tiny", 0.0, 5e-324), *MIXED.variables))
DESCRIPTION = StudyDescription("campaign/ü/x/1", {"problem": "two"}, ("left", "right"), 1, "# note")


@pytest.fixture(params=["sqlite", pytest.param("postgresql", marks=pytest.mark.system)])
def url(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[str]:
    if request.param == "sqlite":
        yield f"sqlite:///{tmp_path / 'study.db'}"
    else:
        with postgresql() as server:
            yield server.url


def evaluations() -> list[Evaluation]:
    generator = np.random.default_rng(5)
    made = []
    for number in range(12):
        failed = number % 5 == 3
        made.append(
            Evaluation(
                number,
                SPACE.from_unit(generator.random(SPACE.dimension)),
                np.full(2, np.nan) if failed else generator.normal(size=2) * 10.0 ** generator.integers(-300, 300),
                np.full(1, np.nan) if failed else generator.normal(size=1),
                {} if failed else {"comfort [m/s²]": generator.normal(), "none": float("nan")},
                "perturbation",
                number // 3,
                'ZeroDivisionError: "no" ballast\n%s' if failed else "",
                generator.random(),
                generator.random(),
            )
        )
    return made


def stored(url: str, name: str) -> list[tuple[object, ...]]:
    study = optuna.load_study(study_name=name, storage=url)
    return [
        (
            trial.number,
            trial.state,
            trial.values,
            {key: (type(value), repr(value)) for key, value in trial.params.items()},
            trial.distributions,
            {key: repr(value) for key, value in trial.user_attrs.items()},
            trial.system_attrs,
        )
        for trial in study.get_trials()
    ]


@pytest.mark.parametrize("together", [1, 5, 12])
def test_what_is_written_fast_is_what_optuna_writes(url: str, together: int, monkeypatch: pytest.MonkeyPatch) -> None:
    fast = Storage(url).run(DESCRIPTION, SPACE)
    monkeypatch.setattr(study_module, "can_write", lambda engine: False)
    slow_description = StudyDescription("slow", DESCRIPTION.identity, DESCRIPTION.objective_names, 1, "")
    slow = Storage(url).run(slow_description, SPACE)
    monkeypatch.setattr(study_module, "write_trials", None, raising=True)
    for evaluation in evaluations():
        slow.append(evaluation)
    monkeypatch.undo()
    for first in range(0, 12, together):
        fast.append(*evaluations()[first : first + together])
    assert stored(url, DESCRIPTION.name) == stored(url, "slow")
    assert [trial[0] for trial in stored(url, DESCRIPTION.name)] == list(range(12))


def test_times_are_those_of_the_evaluation(url: str) -> None:
    evaluation = evaluations()[0]
    open_run(url, DESCRIPTION, SPACE).append(evaluation)
    (trial,) = optuna.load_study(study_name=DESCRIPTION.name, storage=url).get_trials()
    assert trial.duration is not None
    assert trial.duration.total_seconds() == pytest.approx(evaluation.duration, abs=2e-6)
    now = optuna.trial.create_trial(value=0.0).datetime_complete
    assert now is not None
    assert trial.datetime_complete is not None
    assert abs((now - trial.datetime_complete).total_seconds()) < 60.0


def test_a_trial_is_written_whole_or_not_at_all(url: str) -> None:
    record = Storage(url).run(DESCRIPTION, SPACE)
    good, bad = evaluations()[:2]
    record.append(good)
    broken = Evaluation(**{**bad.__dict__, "origin": object()})
    with pytest.raises(TypeError):
        record.append(broken)
    with pytest.raises(TypeError):
        record.append(bad, broken)
    assert len(stored(url, DESCRIPTION.name)) == 1
    record.append(bad)
    assert [trial[0] for trial in stored(url, DESCRIPTION.name)] == [0, 1]
