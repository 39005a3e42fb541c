"""The tables of Optuna's relational storages, as far as the records of runs are in them.

They are used where making an object of every trial, parameter and attribute, as Optuna does, takes too long: a campaign has
hundreds of thousands. Where the schema is not the known one, Optuna's own ways take their place.
"""

from sqlalchemy import (
    Column,
    Connection,
    DateTime,
    Enum,
    Float,
    ForeignKey,
    Integer,
    MetaData,
    String,
    Table,
    Text,
    inspect,
    select,
)

KNOWN_SCHEMA = "v3.2.0.a"
CONSTRAINTS = "constraints"

_METADATA = MetaData()
_STATES = Enum("RUNNING", "COMPLETE", "PRUNED", "FAIL", "WAITING", name="trialstate")
_VALUE_TYPES = Enum("FINITE", "INF_POS", "INF_NEG", name="trialvaluetype")

SCHEMA = Table("alembic_version", _METADATA, Column("version_num", String))
STUDIES = Table("studies", _METADATA, Column("study_id", Integer, primary_key=True), Column("study_name", String))
STUDY_ATTRIBUTES = Table(
    "study_user_attributes",
    _METADATA,
    Column("study_user_attribute_id", Integer, primary_key=True),
    Column("study_id", Integer),
    Column("key", String),
    Column("value_json", Text),
)
TRIALS = Table(
    "trials",
    _METADATA,
    Column("trial_id", Integer, primary_key=True),
    Column("number", Integer),
    Column("study_id", Integer),
    Column("state", _STATES),
    Column("datetime_start", DateTime),
    Column("datetime_complete", DateTime),
)
PARAMETERS = Table(
    "trial_params",
    _METADATA,
    Column("param_id", Integer, primary_key=True),
    Column("trial_id", Integer, ForeignKey("trials.trial_id")),
    Column("param_name", String),
    Column("param_value", Float),
    Column("distribution_json", Text),
)
VALUES = Table(
    "trial_values",
    _METADATA,
    Column("trial_value_id", Integer, primary_key=True),
    Column("trial_id", Integer, ForeignKey("trials.trial_id")),
    Column("objective", Integer),
    Column("value", Float),
    Column("value_type", _VALUE_TYPES),
)


def _attributes(name: str) -> Table:
    return Table(
        f"trial_{name}_attributes",
        _METADATA,
        Column(f"trial_{name}_attribute_id", Integer, primary_key=True),
        Column("trial_id", Integer, ForeignKey("trials.trial_id")),
        Column("key", String),
        Column("value_json", Text),
    )


ATTRIBUTES = _attributes("user")
SYSTEM_ATTRIBUTES = _attributes("system")


def schema_of(connection: Connection) -> str | None:
    """The schema of Optuna's tables; None where there are none yet."""
    if not inspect(connection).has_table(SCHEMA.name):
        return None
    return connection.execute(select(SCHEMA.c.version_num)).scalar()
