"""The records of many runs in columns, read straight from the tables of Optuna's relational storages.

Optuna makes objects of every trial, parameter and attribute, which takes about half a millisecond per trial; a campaign has
hundreds of thousands. Here a few SELECTs fetch many studies at a time. Where the tables are not of the known schema,
Optuna's own reading takes their place.
"""

import json
import math
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import optuna
from numpy.typing import NDArray
from sqlalchemy import ColumnElement, Connection, Table, create_engine, func, select

from railsearch.errors import StorageError
from railsearch.space import FloatArray
from railsearch.storage.access import readable
from railsearch.storage.address import check_storage, without_password
from railsearch.storage.study import IDENTITY, OWN_ATTRIBUTES
from railsearch.storage.tables import (
    ATTRIBUTES,
    CONSTRAINTS,
    KNOWN_SCHEMA,
    PARAMETERS,
    STUDIES,
    STUDY_ATTRIBUTES,
    SYSTEM_ATTRIBUTES,
    TRIALS,
    VALUES,
    schema_of,
)

# Few enough that a writer to an SQLite file, who waits while it is read, waits for a fraction of a second.
TRIALS_AT_ONCE = 5_000
STUDIES_AT_ONCE = 500
FINISHED = {"COMPLETE", "FAIL"}
INFINITE = {"INF_POS": math.inf, "INF_NEG": -math.inf}


@dataclass(frozen=True)
class StudyColumns:
    """The n stored evaluations of one run in their order.

    variables: (n,) by name; objectives: (n,) by index, NaN where an evaluation failed; constraints: a list, or None where
    there is none; metrics: (n,) by name, NaN where there is none; reasons are empty for successful evaluations; durations
    and overheads in seconds.
    """

    name: str
    identity: Mapping[str, Any]
    variables: Mapping[str, FloatArray]
    objectives: Mapping[int, FloatArray]
    constraints: Sequence[Sequence[float] | None]
    metrics: Mapping[str, FloatArray]
    origins: Sequence[str]
    trajectories: NDArray[np.int64]
    reasons: Sequence[str]
    durations: FloatArray
    overheads: FloatArray


@dataclass(slots=True)
class _Entries:
    """What trials of a study have under one name: the trials by row, and their values."""

    rows: list[int] = field(default_factory=list)
    values: list[Any] = field(default_factory=list)


Part = defaultdict[Any, _Entries]


@dataclass(slots=True)
class _Gathered:
    """A study as it is read, a row per trial in any order; `constraints` has one name."""

    name: str
    identity: Mapping[str, Any]
    states: list[str] = field(default_factory=list)
    variables: Part = field(default_factory=lambda: defaultdict(_Entries))
    objectives: Part = field(default_factory=lambda: defaultdict(_Entries))
    constraints: Part = field(default_factory=lambda: defaultdict(_Entries))
    attributes: Part = field(default_factory=lambda: defaultdict(_Entries))


def read_studies(url: str, prefix: str) -> Iterator[StudyColumns]:
    """The runs whose study names begin with `prefix`, each with its evaluations in order.

    Studies that railsearch did not make are left out. Raises StorageError if the storage cannot be read, or if a study is
    not what one writer leaves: a trial unfinished, an evaluation there twice, an attribute missing.
    """
    place = without_password(url)
    with readable(place):
        check_storage(url)
        engine = create_engine(url)
        try:
            with engine.connect() as connection:
                schema = schema_of(connection)
                if schema == KNOWN_SCHEMA:
                    yield from (_columns(study, place) for study in _from_tables(connection, prefix))
        finally:
            engine.dispose()
        if schema not in (None, KNOWN_SCHEMA):
            yield from (_columns(study, place) for study in _from_optuna(url, prefix))


def _from_tables(connection: Connection, prefix: str) -> Iterator[_Gathered]:
    """The runs by SELECTs, many at a time, as long as the trials are not too many for the memory."""
    counted = (
        select(STUDIES.c.study_id, STUDIES.c.study_name, func.count(TRIALS.c.trial_id))
        .select_from(STUDIES.outerjoin(TRIALS, TRIALS.c.study_id == STUDIES.c.study_id))
        .where(STUDIES.c.study_name.startswith(prefix, autoescape=True))
        .group_by(STUDIES.c.study_id, STUDIES.c.study_name)
        .order_by(STUDIES.c.study_id)
    )
    # LIKE does not tell upper from lower case in every database.
    rows = [row for row in connection.execute(counted) if row[1].startswith(prefix)]
    for names in _batches(rows):
        yield from _batch(connection, names)


def _batches(rows: Iterable[tuple[int, str, int]]) -> Iterator[dict[int, str]]:
    """Studies {id: name} in batches, from rows of id, name and number of trials."""
    batch: dict[int, str] = {}
    trials = 0
    for study, name, count in rows:
        if batch and (trials + count > TRIALS_AT_ONCE or len(batch) == STUDIES_AT_ONCE):
            yield batch
            batch, trials = {}, 0
        batch[study] = name
        trials += count
    if batch:
        yield batch


def _batch(connection: Connection, names: Mapping[int, str]) -> Iterable[_Gathered]:
    identities = select(STUDY_ATTRIBUTES.c.study_id, STUDY_ATTRIBUTES.c.value_json)
    identities = identities.where(STUDY_ATTRIBUTES.c.key == IDENTITY, STUDY_ATTRIBUTES.c.study_id.in_(names))
    studies = {study: _Gathered(names[study], json.loads(identity)) for study, identity in connection.execute(identities)}
    # Trials come first: of those that are stored meanwhile, what the later SELECTs find is left out.
    places: dict[int, tuple[_Gathered, int]] = {}
    trials = select(TRIALS.c.trial_id, TRIALS.c.study_id, TRIALS.c.state).where(TRIALS.c.study_id.in_(studies))
    for trial, study, state in connection.execute(trials):
        places[trial] = (studies[study], len(studies[study].states))
        studies[study].states.append(state)
    _fill(connection, list(studies), places)
    for gathered in studies.values():
        for entries in (*gathered.attributes.values(), *gathered.constraints.values()):
            entries.values = json.loads(f"[{','.join(entries.values)}]")
        for entries in gathered.objectives.values():
            entries.values = [INFINITE.get(value, value) for value in entries.values]
    return studies.values()


def _fill(connection: Connection, studies: Sequence[int], places: Mapping[int, tuple[_Gathered, int]]) -> None:
    """Put what the trials of the studies have into its place."""

    def put(part: str, source: Table, key: str, value: str, *where: ColumnElement[bool]) -> None:
        joined = source.join(TRIALS, TRIALS.c.trial_id == source.c.trial_id)
        rows = select(source.c.trial_id, source.c[key], source.c[value]).select_from(joined)
        rows = rows.where(TRIALS.c.study_id.in_(studies), *where)
        for trial, name, entry in connection.execute(rows):
            if trial in places:
                study, row = places[trial]
                entries = getattr(study, part)[name]
                entries.rows.append(row)
                entries.values.append(entry)

    put("variables", PARAMETERS, "param_name", "param_value")
    put("objectives", VALUES, "objective", "value", VALUES.c.value.is_not(None))
    put("objectives", VALUES, "objective", "value_type", VALUES.c.value.is_(None))
    put("attributes", ATTRIBUTES, "key", "value_json")
    put("constraints", SYSTEM_ATTRIBUTES, "key", "value_json", SYSTEM_ATTRIBUTES.c.key == CONSTRAINTS)


def _from_optuna(url: str, prefix: str) -> Iterator[_Gathered]:
    """The runs as Optuna reads them."""
    storage = optuna.storages.get_storage(url)
    for name in optuna.get_all_study_names(storage):
        study = optuna.load_study(study_name=name, storage=storage) if name.startswith(prefix) else None
        if study is None or IDENTITY not in study.user_attrs:
            continue
        gathered = _Gathered(name, study.user_attrs[IDENTITY])
        for row, trial in enumerate(study.get_trials(deepcopy=False)):
            gathered.states.append(trial.state.name)
            constraints = {key: value for key, value in trial.system_attrs.items() if key == CONSTRAINTS}
            _put(gathered.variables, row, trial.params)
            _put(gathered.objectives, row, dict(enumerate(trial.values or ())))
            _put(gathered.attributes, row, trial.user_attrs)
            _put(gathered.constraints, row, constraints)
        yield gathered


def _put(part: Part, row: int, found: Mapping[Any, Any]) -> None:
    for name, value in found.items():
        part[name].rows.append(row)
        part[name].values.append(value)


def _columns(study: _Gathered, place: str) -> StudyColumns:
    """The study with its evaluations in order."""
    _check(study, place)
    n = len(study.states)
    numbers = study.attributes["evaluation"]
    positions = np.empty(n, dtype=np.intp)
    positions[np.array(numbers.rows, dtype=np.intp)[np.argsort(numbers.values)]] = np.arange(n)

    def floats(entries: _Entries) -> FloatArray:
        filled = np.full(n, np.nan)
        filled[positions[entries.rows]] = np.array(entries.values, dtype=float)
        return filled

    def values(entries: _Entries, missing: Any = None) -> list[Any]:
        filled = [missing] * n
        for position, value in zip(positions[entries.rows], entries.values, strict=True):
            filled[position] = value
        return filled

    return StudyColumns(
        name=study.name,
        identity=study.identity,
        variables={name: floats(entries) for name, entries in study.variables.items()},
        objectives={index: floats(entries) for index, entries in study.objectives.items()},
        constraints=values(study.constraints[CONSTRAINTS]),
        metrics={name: floats(entries) for name, entries in study.attributes.items() if name not in OWN_ATTRIBUTES},
        origins=values(study.attributes["origin"]),
        trajectories=np.array(values(study.attributes["trajectory"]), dtype=np.int64),
        reasons=values(study.attributes["reason"], ""),
        durations=floats(study.attributes["duration [s]"]),
        overheads=floats(study.attributes["overhead [s]"]),
    )


def _check(study: _Gathered, place: str) -> None:
    """Raise StorageError unless the study is what one writer leaves behind."""
    if not FINISHED.issuperset(study.states):
        raise StorageError(f"{place}: study '{study.name}' has trials that another program began")
    for name in OWN_ATTRIBUTES:
        if name != "reason" and len(study.attributes[name].rows) != len(study.states):
            raise StorageError(f"{place}: study '{study.name}' has trials without '{name}': another program wrote to it")
    if len(set(study.attributes["evaluation"].values)) != len(study.states):
        raise StorageError(f"{place}: study '{study.name}' has an evaluation twice: two wrote to it")
