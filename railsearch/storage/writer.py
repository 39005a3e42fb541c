"""Finished trials straight into the tables of Optuna's relational storages: one transaction, a handful of statements.

Optuna writes a trial of ten parameters in some fifty statements. What is stored is the same.
"""

import datetime
import json
from collections.abc import Iterable
from itertools import chain

from optuna.distributions import distribution_to_json
from optuna.trial import FrozenTrial
from sqlalchemy import Connection, Engine, func, insert, select

from railsearch.storage.tables import (
    ATTRIBUTES,
    KNOWN_SCHEMA,
    PARAMETERS,
    SYSTEM_ATTRIBUTES,
    TRIALS,
    VALUES,
    schema_of,
)

Row = dict[str, object]
TABLES = (PARAMETERS, VALUES, ATTRIBUTES, SYSTEM_ATTRIBUTES)


def can_write(engine: Engine) -> bool:
    """Whether the tables are of the known schema."""
    with engine.connect() as connection:
        return schema_of(connection) == KNOWN_SCHEMA


def write_trials(engine: Engine, study_id: int, trials: Iterable[FrozenTrial]) -> None:
    """Add finished trials with finite values to a study that has one writer, in one transaction."""
    with engine.begin() as connection:
        rows = [_rows(connection, study_id, trial) for trial in trials]
        for table, *parts in zip(TABLES, *rows, strict=True):
            if together := list(chain.from_iterable(parts)):
                connection.execute(insert(table), together)


def _rows(connection: Connection, study_id: int, trial: FrozenTrial) -> tuple[list[Row], ...]:
    """Add a trial; what belongs to it in the other tables."""
    number = select(func.count()).select_from(TRIALS).where(TRIALS.c.study_id == study_id).scalar_subquery()
    times = {"datetime_start": _utc(trial.datetime_start), "datetime_complete": _utc(trial.datetime_complete)}
    row = insert(TRIALS).values(number=number, study_id=study_id, state=trial.state.name, **times)
    (made,) = connection.execute(row).inserted_primary_key or (None,)
    parameters: list[Row] = [
        {
            "trial_id": made,
            "param_name": name,
            "param_value": trial.distributions[name].to_internal_repr(value),
            "distribution_json": distribution_to_json(trial.distributions[name]),
        }
        for name, value in trial.params.items()
    ]
    values: list[Row] = [
        {"trial_id": made, "objective": objective, "value": value, "value_type": "FINITE"}
        for objective, value in enumerate(trial.values or ())
    ]
    own = [_attribute(made, key, value) for key, value in trial.user_attrs.items()]
    systems = [_attribute(made, key, value) for key, value in trial.system_attrs.items()]
    return parameters, values, own, systems


def _attribute(trial: int | None, key: str, value: object) -> Row:
    return {"trial_id": trial, "key": key, "value_json": json.dumps(value)}


def _utc(time: datetime.datetime | None) -> datetime.datetime | None:
    """A local time as Optuna stores it."""
    return None if time is None else time.astimezone(datetime.UTC).replace(tzinfo=None)
