"""The record of a run as an Optuna study. The only module that touches Optuna's studies and storages.

One finished evaluation is one trial, written in one transaction when it is finished: a process killed at any moment leaves
whole evaluations and nothing else. There is one writer per study.
"""

import datetime
import json
import math
import os
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
import optuna
from optuna.distributions import BaseDistribution, FloatDistribution, IntDistribution
from optuna.study import StudyDirection
from optuna.trial import FrozenTrial, TrialState, create_trial
from sqlalchemy.engine import make_url
from sqlalchemy.exc import ArgumentError, SQLAlchemyError

from railsearch.errors import InputError, StorageError
from railsearch.interfaces import Evaluation
from railsearch.space import Space

IDENTITY = "railsearch"
OWN_ATTRIBUTES = ("evaluation", "origin", "trajectory", "reason", "duration [s]", "overhead [s]")


@dataclass(frozen=True)
class StudyDescription:
    """What makes a study: its name, what identifies the run, the objectives' names, how many constraints, a note."""

    name: str
    identity: Mapping[str, Any]
    objective_names: tuple[str, ...]
    n_constraints: int
    note: str


class RunStorage:
    """The stored evaluations of one run."""

    def __init__(self, study: optuna.Study, space: Space, n_constraints: int, place: str) -> None:
        self._study = study
        self._space = space
        self._n_constraints = n_constraints
        self._place = place
        self._distributions = _distributions(space)

    def load(self) -> list[Evaluation]:
        """The evaluations in the order in which they were made."""
        with _readable(self._place):
            trials = self._study.get_trials(deepcopy=False)
        finished = [trial for trial in trials if trial.state in (TrialState.COMPLETE, TrialState.FAIL)]
        if len(finished) != len(trials):
            raise StorageError(f"{self._place}: study '{self._study.study_name}' has trials that another program began")
        return [self._evaluation(trial, len(self._study.directions)) for trial in finished]

    def append(self, evaluation: Evaluation) -> None:
        """Store one finished evaluation in one transaction. Raises StorageError if it cannot be written."""
        now = datetime.datetime.now()
        constraints = [] if evaluation.failed else [float(value) for value in evaluation.constraints]
        trial = create_trial(
            state=TrialState.FAIL if evaluation.failed else TrialState.COMPLETE,
            values=None if evaluation.failed else [float(value) for value in evaluation.objectives],
            params=self._space.named(evaluation.design),
            distributions=self._distributions,
            user_attrs=_attributes(evaluation),
            system_attrs={"constraints": constraints} if constraints else {},
        )
        trial.datetime_start = now - datetime.timedelta(seconds=evaluation.duration)
        trial.datetime_complete = now
        with _writable(self._place, evaluation.number):
            self._study.add_trial(trial)

    def _evaluation(self, trial: FrozenTrial, n_objectives: int) -> Evaluation:
        attributes = trial.user_attrs
        constraints = trial.system_attrs.get("constraints", [math.nan] * self._n_constraints)
        return Evaluation(
            number=trial.number,
            design=np.array([trial.params[name] for name in self._space.names], dtype=float),
            objectives=np.array(trial.values or [math.nan] * n_objectives, dtype=float),
            constraints=np.array(constraints, dtype=float),
            metrics={key: _number(value) for key, value in attributes.items() if key not in OWN_ATTRIBUTES},
            origin=attributes["origin"],
            trajectory=attributes["trajectory"],
            reason=attributes.get("reason", ""),
            duration=attributes["duration [s]"],
            overhead=attributes["overhead [s]"],
        )


def storage_url(url: str) -> str:
    """An Optuna storage URL with the path of an SQLite file made absolute. Raises InputError if it is none."""
    try:
        parsed = make_url(url)
    except ArgumentError:
        raise InputError(
            f"--storage: an URL such as sqlite:///FILE or postgresql://USER@HOST/NAME is needed, received {url!r}"
        ) from None
    if parsed.drivername.startswith("sqlite") and parsed.database:
        parsed = parsed.set(database=os.path.abspath(parsed.database))
    return parsed.render_as_string(hide_password=False)


def without_password(url: str) -> str:
    """A storage URL that can be shown; what is no URL stays as it is."""
    try:
        return make_url(url).render_as_string(hide_password=True)
    except ArgumentError:
        return url


def open_run(url: str, description: StudyDescription, space: Space, create: bool = True) -> RunStorage:
    """Open the study of a run at an Optuna storage URL, or make it if `create`.

    Raises StorageError if the storage cannot be opened, or holds under that name no run or one with another identity.
    """
    shown = without_password(url)
    if not create:
        check_storage(url)
    with _readable(shown):
        storage = optuna.storages.get_storage(url)
        known = description.name in optuna.get_all_study_names(storage)
        if known:
            study = optuna.load_study(study_name=description.name, storage=storage)
        elif not create:
            raise StorageError(f"{shown} holds no study '{description.name}'")
        else:
            directions = [StudyDirection.MINIMIZE] * len(description.objective_names)
            study = optuna.create_study(storage=storage, study_name=description.name, directions=directions)
        stored = study.user_attrs.get(IDENTITY)
    if stored is not None or (known and study.get_trials(deepcopy=False)):
        _check_identity(stored or {}, description, shown)
    else:
        with _writable(shown, 0):
            _describe(study, description)
    return RunStorage(study, space, description.n_constraints, shown)


def check_storage(url: str) -> None:
    """Raise StorageError if the storage is an SQLite file that does not exist: opening it would make one."""
    parsed = make_url(url)
    if parsed.drivername.startswith("sqlite") and parsed.database and not os.path.exists(parsed.database):
        raise StorageError(
            f"there is no record at {without_password(url)}: bring the file back, or name its place with --storage"
        )


def identity_differences(stored: Mapping[str, Any], wanted: Mapping[str, Any], prefix: str = "") -> list[str]:
    """What differs between two identities, as 'name: stored … , now …'."""
    rows = []
    for key in dict.fromkeys([*stored, *wanted]):
        old, new = stored.get(key), wanted.get(key)
        if isinstance(old, Mapping) and isinstance(new, Mapping):
            rows += identity_differences(old, new, f"{prefix}{key}.")
        elif old != new:
            rows.append(f"{prefix}{key}: there {_short(old)}, here {_short(new)}")
    return rows


def plain(identity: Mapping[str, Any]) -> dict[str, Any]:
    """An identity as it comes back from a storage: lists for tuples, plain numbers."""
    document: dict[str, Any] = json.loads(json.dumps(identity))
    return document


def _check_identity(stored: Mapping[str, Any], description: StudyDescription, place: str) -> None:
    differences = identity_differences(stored, plain(description.identity))
    if differences:
        shown = "; ".join(differences[:3]) + (f"; and {len(differences) - 3} more" if len(differences) > 3 else "")
        raise StorageError(
            f"{place} holds another run under the name '{description.name}' ({shown}). Nothing was changed: "
            "use another folder or storage for this run, or repeat the command that made that one"
        )


def _describe(study: optuna.Study, description: StudyDescription) -> None:
    from optuna_dashboard import save_note

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
        study.set_metric_names(list(description.objective_names))
    save_note(study, description.note)
    study.set_user_attr(IDENTITY, plain(description.identity))


def _distributions(space: Space) -> dict[str, BaseDistribution]:
    return {
        variable.name: IntDistribution(int(variable.lower), int(variable.upper))
        if variable.integer
        else FloatDistribution(variable.lower, variable.upper)
        for variable in space.variables
    }


def _attributes(evaluation: Evaluation) -> dict[str, Any]:
    own: dict[str, Any] = {
        "evaluation": evaluation.number + 1,
        "origin": evaluation.origin,
        "trajectory": evaluation.trajectory,
        "duration [s]": evaluation.duration,
        "overhead [s]": evaluation.overhead,
    }
    if evaluation.failed:
        own["reason"] = evaluation.reason
    return {key: float(value) if math.isfinite(value) else None for key, value in evaluation.metrics.items()} | own


def _number(value: float | None) -> float:
    return math.nan if value is None else float(value)


def _short(value: object) -> str:
    text = json.dumps(value, ensure_ascii=False)
    return text if len(text) <= 60 else text[:57] + "…"


@contextmanager
def _readable(place: str) -> Iterator[None]:
    try:
        yield
    except (SQLAlchemyError, optuna.exceptions.OptunaError, OSError, ImportError, ValueError) as error:
        raise StorageError(
            f"the storage {place} cannot be opened: {_cause(error)}. Check the URL, the rights and the space there"
        ) from error


@contextmanager
def _writable(place: str, stored: int) -> Iterator[None]:
    try:
        yield
    except (SQLAlchemyError, optuna.exceptions.OptunaError, OSError) as error:
        raise StorageError(
            f"the storage {place} cannot be written: {_cause(error)}. {stored} evaluations are safe in it; "
            "make space or restore the connection, then repeat the same command to go on"
        ) from error


def _cause(error: BaseException) -> str:
    deepest = error
    while deepest.__cause__ is not None:
        deepest = deepest.__cause__
    return f"{deepest}".split("\n")[0]
