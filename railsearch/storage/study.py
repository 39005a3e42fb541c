"""The record of a run as an Optuna study.

One finished evaluation is one trial, written in one transaction when it is finished: a process killed at any moment leaves
whole evaluations and nothing else. There is one writer per study.
"""

import contextlib
import datetime
import json
import math
import threading
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import optuna
from optuna.distributions import BaseDistribution, FloatDistribution, IntDistribution
from optuna.study import StudyDirection
from optuna.trial import FrozenTrial, TrialState, create_trial
from sqlalchemy import Engine
from sqlalchemy.exc import IntegrityError, ProgrammingError

from railsearch.errors import StorageError
from railsearch.interfaces import Evaluation
from railsearch.space import Space
from railsearch.storage.access import Patience, readable, writable
from railsearch.storage.address import check_storage, is_file, without_password
from railsearch.storage.claims import Claims
from railsearch.storage.note import note_attributes
from railsearch.storage.tables import CONSTRAINTS
from railsearch.storage.writer import can_write, write_trials

IDENTITY = "railsearch"
OPENING_SECONDS = 5.0
COLLISIONS = 5
SHOWN = 60
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
    """The stored evaluations of one run.

    lock: lets one thread write at a time; claims: without which nothing is written, if they are given; engine: of the
    tables, if trials can be written straight into them.
    """

    def __init__(
        self,
        study: optuna.Study,
        space: Space,
        n_constraints: int,
        place: str,
        lock: threading.Lock,
        patience: Patience,
        claims: Claims | None = None,
        engine: Engine | None = None,
    ) -> None:
        self._study = study
        self._space = space
        self._n_constraints = n_constraints
        self._place = place
        self._lock = lock
        self._patience = patience
        self._claims = claims
        self._engine = engine
        self._distributions = _distributions(space)
        self._safe = 0

    def load(self) -> list[Evaluation]:
        """The evaluations in the order in which they were proposed; those under way when a run ended may be missing."""
        with readable(self._place), self._lock:
            trials = self._patience.insist(lambda: self._study.get_trials(deepcopy=False))
        finished = [trial for trial in trials if trial.state in (TrialState.COMPLETE, TrialState.FAIL)]
        if len(finished) != len(trials):
            raise StorageError(f"{self._place}: study '{self._study.study_name}' has trials that another program began")
        evaluations = [self._evaluation(trial, len(self._study.directions)) for trial in finished]
        numbers = {evaluation.number for evaluation in evaluations}
        if len(numbers) != len(evaluations):
            raise StorageError(f"{self._place}: study '{self._study.study_name}' has an evaluation twice: two wrote to it")
        self._safe = len(evaluations)
        return sorted(evaluations, key=lambda evaluation: evaluation.number)

    def remove(self) -> None:
        """Remove the study with its evaluations. Raises StorageError if it cannot be done."""
        with writable(self._place, f"{self._safe} evaluations are"), self._lock:
            optuna.delete_study(study_name=self._study.study_name, storage=self._study._storage)

    def append(self, *evaluations: Evaluation) -> None:
        """Store finished evaluations in one transaction, in the order given.

        Raises StorageError if they cannot be written, or if the study was claimed by another process.
        """
        trials = {evaluation.number: self._trial(evaluation) for evaluation in evaluations}
        attempts = 0

        def attempt() -> None:
            nonlocal attempts
            attempts += 1
            self._check_claim()
            # A broken connection leaves open whether the transaction before it was carried out.
            there = self._numbers() if attempts > 1 else set()
            self._add([trial for number, trial in trials.items() if number not in there])

        with writable(self._place, f"{self._safe} evaluations are"), self._lock:
            self._patience.insist(attempt)
        self._safe += len(trials)

    def _add(self, trials: Sequence[FrozenTrial]) -> None:
        if self._engine is None:
            self._study.add_trials(trials)
        else:
            write_trials(self._engine, self._study._study_id, trials)

    def _check_claim(self) -> None:
        if self._claims is not None and not self._claims.kept(self._study.study_name):
            raise StorageError(
                f"{self._place}: study '{self._study.study_name}' was taken over by another process while the connection "
                "was lost; that process goes on with it"
            )

    def _numbers(self) -> set[int]:
        """The numbers of the evaluations that are stored."""
        return {trial.user_attrs["evaluation"] - 1 for trial in self._study.get_trials(deepcopy=False)}

    def _trial(self, evaluation: Evaluation) -> FrozenTrial:
        now = datetime.datetime.now()
        constraints = [] if evaluation.failed else [float(value) for value in evaluation.constraints]
        trial = create_trial(
            state=TrialState.FAIL if evaluation.failed else TrialState.COMPLETE,
            values=None if evaluation.failed else [float(value) for value in evaluation.objectives],
            params=self._space.named(evaluation.design),
            distributions=self._distributions,
            user_attrs=_attributes(evaluation),
            system_attrs={CONSTRAINTS: constraints} if constraints else {},
        )
        trial.datetime_start = now - datetime.timedelta(seconds=evaluation.duration)
        trial.datetime_complete = now
        return trial

    def _evaluation(self, trial: FrozenTrial, n_objectives: int) -> Evaluation:
        attributes = trial.user_attrs
        constraints = trial.system_attrs.get(CONSTRAINTS, [math.nan] * self._n_constraints)
        return Evaluation(
            number=attributes["evaluation"] - 1,
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


class Storage:
    """An open storage: the runs in it, and this process's claims.

    patience: how long a server that does not answer is waited for. Raises StorageError if it cannot be opened.
    """

    def __init__(self, url: str, patience: Patience | None = None, claims: Claims | None = None) -> None:
        self._place = without_password(url)
        self._patience = patience or Patience()
        self._claims = claims
        self._lock = threading.Lock()
        with readable(self._place):
            backend = Patience(min(OPENING_SECONDS, self._patience.seconds)).insist(lambda: _backend(url))
            self._storage = optuna.storages.get_storage(backend)
            self._engine = backend.engine if can_write(backend.engine) else None

    def claim(self, name: str) -> bool:
        """Claim a study by name; False if another process has it. Without claims everything is free."""
        claims = self._claims
        with writable(self._place, "All finished evaluations are"):
            return claims is None or self._patience.insist(lambda: claims.take(name))

    def release(self, name: str) -> None:
        """Let a claimed study go."""
        if self._claims is not None:
            self._claims.release(name)

    def close(self) -> None:
        """Let go of all claims."""
        if self._claims is not None:
            self._claims.close()

    def run(self, description: StudyDescription, space: Space, create: bool = True) -> RunStorage:
        """The study of a run, made if need be and if `create`.

        Raises StorageError if the storage holds under that name no run or one with another identity.
        """
        with readable(self._place), self._lock:
            study, known = self._patience.insist(lambda: self._study(description, create))
            stored = study.user_attrs.get(IDENTITY)
        if stored is not None or (known and study.get_trials(deepcopy=False)):
            _check_identity(stored or {}, description, self._place)
        else:
            with writable(self._place, "No evaluations are"), self._lock:
                self._patience.insist(lambda: self._describe(study, description))
        return RunStorage(
            study,
            space,
            description.n_constraints,
            self._place,
            self._lock,
            self._patience,
            self._claims,
            self._engine,
        )

    def _study(self, description: StudyDescription, create: bool) -> tuple[optuna.Study, bool]:
        try:
            return optuna.load_study(study_name=description.name, storage=self._storage), True
        except KeyError:
            if not create:
                raise StorageError(f"{self._place} holds no study '{description.name}'") from None
        directions = [StudyDirection.MINIMIZE] * len(description.objective_names)
        return optuna.create_study(storage=self._storage, study_name=description.name, directions=directions), False

    def _describe(self, study: optuna.Study, description: StudyDescription) -> None:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
            study.set_metric_names(list(description.objective_names))
        number = self._storage.get_study_id_from_name(description.name)
        for key, value in note_attributes(description.note, self._storage.get_study_system_attrs(number)).items():
            self._storage.set_study_system_attr(number, key, value)
        study.set_user_attr(IDENTITY, plain(description.identity))


def _backend(url: str) -> optuna.storages.RDBStorage:
    """Optuna's storage at a URL; a server's connections are tried before they are used, as they may have broken.

    Processes that begin at the same time make the same tables: what one could not make, it finds at its next attempt.
    """
    kwargs = {} if is_file(url) else {"pool_pre_ping": True}
    for _ in range(COLLISIONS):
        with contextlib.suppress(IntegrityError, ProgrammingError):
            return optuna.storages.RDBStorage(url, engine_kwargs=kwargs)
    return optuna.storages.RDBStorage(url, engine_kwargs=kwargs)


def open_run(url: str, description: StudyDescription, space: Space, create: bool = True) -> RunStorage:
    """Open the study of a run at an Optuna storage URL, or make it if `create`.

    Raises StorageError if the storage cannot be opened, or holds under that name no run or one with another identity.
    """
    if not create:
        check_storage(url)
    return Storage(url).run(description, space, create)


def identity_differences(stored: Mapping[str, Any], wanted: Mapping[str, Any], prefix: str = "") -> list[str]:
    """What differs between two identities, as 'name: stored … , now …'."""
    rows = []
    for key in dict.fromkeys([*stored, *wanted]):
        old, new = stored.get(key), wanted.get(key)
        if isinstance(old, Mapping) and isinstance(new, Mapping):
            rows += identity_differences(old, new, f"{prefix}{key}.")
        elif isinstance(old, list) and isinstance(new, list) and _long(old, new):
            rows += _list_differences(old, new, f"{prefix}{key}")
        elif old != new:
            rows.append(f"{prefix}{key}: there {_short(old)}, here {_short(new)}")
    return rows


def _long(old: list[Any], new: list[Any]) -> bool:
    """Whether two different lists cannot be shown side by side."""
    return old != new and max(len(json.dumps(old)), len(json.dumps(new))) > SHOWN


def _list_differences(old: list[Any], new: list[Any], name: str) -> list[str]:
    """What differs between two long lists: their lengths, or the first entry that is another."""
    if len(old) != len(new):
        added = [entry for entry in new if entry not in old]
        shown = f", new is {_short(added[0])}" if added else ""
        return [f"{name}: there {len(old)} entries, here {len(new)}{shown}"]
    place = next(place for place, (one, other) in enumerate(zip(old, new, strict=True)) if one != other)
    return identity_differences({f"{name}[{place + 1}]": old[place]}, {f"{name}[{place + 1}]": new[place]})


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
    return text if len(text) <= SHOWN else text[: SHOWN - 3] + "…"
