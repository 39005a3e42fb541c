"""Reading many runs at once gives, to the last bit, what Optuna gives trial by trial."""

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import optuna
import pytest
from optuna.trial import TrialState

from postgresql_server import Server, postgresql
from railsearch.errors import StorageError
from railsearch.interfaces import Evaluation
from railsearch.space import Space, Variable
from railsearch.storage import Storage, StudyDescription
from railsearch.storage import reader as reader_module
from railsearch.storage.reader import StudyColumns, read_studies
from railsearch.storage.study import OWN_ATTRIBUTES

SPACES = (
    Space((Variable("Steifigkeit ü", -5.0, 1e6, "MN/m"), Variable("n", -3, 12, integer=True))),
    Space(tuple(Variable(f"x{k}", -1.0, 1.0, integer=k > 9) for k in range(12))),
    Space((Variable("räder", 0, 9, integer=True),)),
)


@pytest.fixture(scope="module")
def server() -> Iterator[Server]:
    with postgresql() as running:
        yield running


@pytest.fixture(params=["sqlite", pytest.param("postgresql", marks=[pytest.mark.system])])
def url(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[str]:
    if request.param == "sqlite":
        yield f"sqlite:///{tmp_path / 'study.db'}"
    else:
        with request.getfixturevalue("server").database(tmp_path.name) as made:
            yield made


def evaluation(space: Space, number: int, m: int, k: int, generator: np.random.Generator) -> Evaluation:
    """A random evaluation: some fail, some have an infinite objective or no number for a metric."""
    failed = generator.random() < 0.2
    objectives = generator.standard_normal(m) * 10.0 ** generator.integers(-300, 300, m)
    objectives[0] = {1: math.inf, 2: -math.inf, 3: -0.0}.get(number % 5, objectives[0])
    metrics = {"F_max [kN]": generator.standard_normal(), "größte": generator.random(), "sometimes": math.nan}
    kept = {name: value for name, value in metrics.items() if generator.random() < 0.7}
    return Evaluation(
        number=number,
        design=space.from_unit(generator.random(space.dimension)),
        objectives=np.full(m, math.nan) if failed else objectives,
        constraints=np.full(k, math.nan) if failed else generator.standard_normal(k),
        metrics={} if failed else kept,
        origin=str(generator.choice(["given", "Störung", 'a "quoted" one'])),
        trajectory=int(generator.integers(9)),
        reason='ValueError: "kein Schotter", \\ [1]' if failed else "",
        duration=float(generator.random()),
        overhead=float(generator.random() * 1e-5),
    )


def write_run(storage: Storage, name: str, n: int, seed: int) -> None:
    """A run of n evaluations that were stored in another order than that in which they were proposed."""
    generator = np.random.default_rng(seed)
    space, m, k = SPACES[seed % 3], 1 + seed % 2, seed % 4
    identity = {"seed": seed, "given": [{"ä": 1.5}], "nested": {"list": [1, 2.5, None]}}
    names = tuple(f"f{index}" for index in range(m))
    record = storage.run(StudyDescription(name, identity, names, k, "# note"), space)
    for number in generator.permutation(n):
        record.append(evaluation(space, int(number), m, k, generator))


def write_campaign(url: str, sizes: tuple[int, ...] = (6, 0, 8, 1, 3)) -> list[str]:
    storage = Storage(url)
    names = [f"Übung_1/sphäre/dycors %/{number}" for number in range(1, len(sizes) + 1)]
    for seed, (name, size) in enumerate(zip(names, sizes, strict=True)):
        write_run(storage, name, size, seed)
    return names


def trials_in_order(url: str, name: str) -> list[optuna.trial.FrozenTrial]:
    trials = optuna.load_study(study_name=name, storage=url).get_trials()
    return sorted(trials, key=lambda trial: trial.user_attrs["evaluation"])


def bits(values: object) -> bytes:
    return np.array(values, dtype=float).tobytes()


def assert_as_optuna_reads(url: str, study: StudyColumns) -> None:
    trials = trials_in_order(url, study.name)
    assert study.identity == optuna.load_study(study_name=study.name, storage=url).user_attrs["railsearch"]
    assert [bool(reason) for reason in study.reasons] == [trial.state == TrialState.FAIL for trial in trials]
    assert set(study.variables) == {name for trial in trials for name in trial.params}
    for name, column in study.variables.items():
        assert column.tobytes() == bits([trial.params[name] for trial in trials])
    assert sorted(study.objectives) == list(range(max((len(trial.values or ()) for trial in trials), default=0)))
    for index, column in study.objectives.items():
        assert column.tobytes() == bits([trial.values[index] if trial.values else math.nan for trial in trials])
    assert study.constraints == [trial.system_attrs.get("constraints") for trial in trials]
    assert set(study.metrics) == {name for trial in trials for name in trial.user_attrs} - set(OWN_ATTRIBUTES)
    for name, column in study.metrics.items():
        assert column.tobytes() == bits([trial.user_attrs.get(name) for trial in trials])
    assert study.origins == [trial.user_attrs["origin"] for trial in trials]
    assert study.trajectories.tolist() == [trial.user_attrs["trajectory"] for trial in trials]
    assert study.reasons == [trial.user_attrs.get("reason", "") for trial in trials]
    assert study.durations.tobytes() == bits([trial.user_attrs["duration [s]"] for trial in trials])
    assert study.overheads.tobytes() == bits([trial.user_attrs["overhead [s]"] for trial in trials])


def test_every_study_is_read_as_optuna_reads_it(url: str) -> None:
    names = write_campaign(url)
    studies = list(read_studies(url, "Übung_1/"))
    assert [study.name for study in studies] == names
    assert [len(study.origins) for study in studies] == [6, 0, 8, 1, 3]
    for study in studies:
        assert_as_optuna_reads(url, study)
    objectives = np.concatenate([column for study in studies for column in study.objectives.values()])
    assert {math.inf, -math.inf} <= set(objectives), "the samples have both infinities"
    assert np.isnan(objectives).any(), "and failures"


def test_only_studies_of_runs_under_the_prefix_are_read(url: str) -> None:
    (name,) = write_campaign(url, (3,))
    storage = Storage(url)
    for beside in ("Übung_10/a/b/1", "ÜBUNG_1/a/b/1", "Übungx1/a/b/1", "Übung_1"):
        write_run(storage, beside, 2, 5)
    stranger = optuna.create_study(storage=url, study_name="Übung_1/of/somebody/1")
    stranger.set_user_attr("else", {"seed": 1})
    stranger.ask({"x": optuna.distributions.FloatDistribution(0.0, 1.0)})
    assert [study.name for study in read_studies(url, "Übung_1/")] == [name]
    assert [len(study.origins) for study in read_studies(url, "Übung_1/")] == [3]


def test_batches_of_any_size_give_the_same(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    url = f"sqlite:///{tmp_path / 'study.db'}"
    names = write_campaign(url)
    for trials, studies in ((7, 500), (1, 500), (5_000, 2)):
        monkeypatch.setattr(reader_module, "TRIALS_AT_ONCE", trials)
        monkeypatch.setattr(reader_module, "STUDIES_AT_ONCE", studies)
        found = list(read_studies(url, "Übung_1/"))
        assert [study.name for study in found] == names
        for study in found:
            assert_as_optuna_reads(url, study)


def test_batches_are_as_large_as_allowed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reader_module, "TRIALS_AT_ONCE", 10)
    monkeypatch.setattr(reader_module, "STUDIES_AT_ONCE", 3)
    rows = [(study, str(study), count) for study, count in enumerate([4, 6, 1, 0, 0, 0, 25, 2])]
    batches = [list(batch) for batch in reader_module._batches(rows)]
    assert batches == [[0, 1], [2, 3, 4], [5], [6], [7]]


def test_tables_of_another_schema_are_read_by_optuna(url: str, monkeypatch: pytest.MonkeyPatch) -> None:
    names = write_campaign(url)
    write_run(Storage(url), "Übung_10/a/b/1", 1, 5)
    optuna.create_study(storage=url, study_name="Übung_1/of/somebody/1")
    with monkeypatch.context() as patched:
        patched.setattr(reader_module, "KNOWN_SCHEMA", "v9.9.9.a")
        studies = list(read_studies(url, "Übung_1/"))
    assert [study.name for study in studies] == names
    for study in studies:
        assert_as_optuna_reads(url, study)


def test_the_known_schema_is_read_without_optuna(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What the dependency pinned here makes is the known schema: no silent falling back to the slow way."""
    url = f"sqlite:///{tmp_path / 'study.db'}"
    write_campaign(url, (3,))
    monkeypatch.setattr(optuna.storages, "get_storage", lambda url: pytest.fail("the slow way"))
    assert len(list(read_studies(url, "Übung_1/"))) == 1


def test_evaluations_stored_while_it_is_read_are_left_out(url: str, monkeypatch: pytest.MonkeyPatch) -> None:
    write_campaign(url, (4,))
    fill = reader_module._fill

    def late(*arguments: object) -> None:
        generator = np.random.default_rng(1)
        description = StudyDescription(name, identity, ("f0",), 0, "")
        Storage(url).run(description, SPACES[0]).append(evaluation(SPACES[0], 4, 1, 0, generator))
        fill(*arguments)  # type: ignore[arg-type]

    (before,) = read_studies(url, "Übung_1/")
    name, identity = before.name, before.identity
    monkeypatch.setattr(reader_module, "_fill", late)
    (during,) = read_studies(url, "Übung_1/")
    monkeypatch.setattr(reader_module, "_fill", fill)
    (after,) = read_studies(url, "Übung_1/")
    assert [len(study.origins) for study in (before, during, after)] == [4, 4, 5]
    assert during.durations.tobytes() == before.durations.tobytes()


def test_a_trial_that_another_program_began_is_refused(url: str) -> None:
    (name,) = write_campaign(url, (3,))
    optuna.load_study(study_name=name, storage=url).ask()
    with pytest.raises(StorageError, match=f"'{name}' has trials that another program began"):
        list(read_studies(url, "Übung_1/"))


@pytest.mark.parametrize(
    ("attributes", "message"),
    [
        ({"evaluation": 3}, "has an evaluation twice"),
        ({"evaluation": 4, "origin": None}, "has trials without 'origin'"),
        ({"evaluation": None}, "has trials without 'evaluation'"),
    ],
)
def test_a_study_that_two_wrote_is_refused(tmp_path: Path, attributes: dict[str, object], message: str) -> None:
    url = f"sqlite:///{tmp_path / 'study.db'}"
    (name,) = write_campaign(url, (3,))
    own = {"evaluation": 4, "origin": "x", "trajectory": 0, "duration [s]": 0.0, "overhead [s]": 0.0}
    kept = {key: value for key, value in {**own, **attributes}.items() if value is not None}
    optuna.load_study(study_name=name, storage=url).add_trial(optuna.create_trial(value=1.0, user_attrs=kept))
    with pytest.raises(StorageError, match=message):
        list(read_studies(url, "Übung_1/"))


def test_a_storage_without_tables_has_no_studies(url: str) -> None:
    if url.startswith("sqlite"):
        Path(url.removeprefix("sqlite:///")).touch()
    assert list(read_studies(url, "Übung_1/")) == []


def test_a_storage_that_cannot_be_read_is_a_clear_error(tmp_path: Path) -> None:
    with pytest.raises(StorageError, match="there is no record"):
        list(read_studies(f"sqlite:///{tmp_path / 'absent.db'}", "a/"))
    (tmp_path / "text.db").write_text("no database " * 100)
    with pytest.raises(StorageError, match=r"cannot be opened: .*not a database"):
        list(read_studies(f"sqlite:///{tmp_path / 'text.db'}", "a/"))
    assert not (tmp_path / "absent.db").exists()
