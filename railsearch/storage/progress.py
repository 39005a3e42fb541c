"""How far the runs in a storage are, without reading them."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import optuna
from sqlalchemy import Connection, create_engine, func, select

from railsearch.storage.access import readable
from railsearch.storage.address import storage_exists, without_password
from railsearch.storage.study import IDENTITY
from railsearch.storage.tables import KNOWN_SCHEMA, STUDIES, STUDY_ATTRIBUTES, TRIALS, schema_of


@dataclass(frozen=True)
class StudyProgress:
    """What identifies the run of a study, None if that was never written, and its number of evaluations."""

    identity: Mapping[str, Any] | None
    evaluations: int


def read_progress(url: str, prefix: str) -> dict[str, StudyProgress]:
    """The progress of the studies whose names begin with `prefix`, by name; none where there is no storage yet.

    Raises StorageError if the storage cannot be read.
    """
    if not storage_exists(url):
        return {}
    with readable(without_password(url)):
        engine = create_engine(url)
        try:
            with engine.connect() as connection:
                schema = schema_of(connection)
                if schema == KNOWN_SCHEMA:
                    return _from_tables(connection, prefix)
        finally:
            engine.dispose()
        return {} if schema is None else _from_optuna(url, prefix)


def _from_tables(connection: Connection, prefix: str) -> dict[str, StudyProgress]:
    mine = STUDIES.c.study_name.startswith(prefix, autoescape=True)
    counted = (
        select(STUDIES.c.study_name, func.count(TRIALS.c.trial_id))
        .select_from(STUDIES.outerjoin(TRIALS, TRIALS.c.study_id == STUDIES.c.study_id))
        .where(mine)
        .group_by(STUDIES.c.study_name)
    )
    identified = (
        select(STUDIES.c.study_name, STUDY_ATTRIBUTES.c.value_json)
        .select_from(STUDIES.join(STUDY_ATTRIBUTES, STUDY_ATTRIBUTES.c.study_id == STUDIES.c.study_id))
        .where(mine, STUDY_ATTRIBUTES.c.key == IDENTITY)
    )
    identities = {name: json.loads(text) for name, text in connection.execute(identified)}
    counts = connection.execute(counted)
    return {name: StudyProgress(identities.get(name), count) for name, count in counts if name.startswith(prefix)}


def _from_optuna(url: str, prefix: str) -> dict[str, StudyProgress]:
    storage = optuna.storages.get_storage(url)
    studies = [study for study in storage.get_all_studies() if study.study_name.startswith(prefix)]
    return {
        study.study_name: StudyProgress(study.user_attrs.get(IDENTITY), storage.get_n_trials(study._study_id))
        for study in studies
    }
