"""A run as its folder and its record have it."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from railsearch.design_problem import DesignProblem
from railsearch.errors import InputError
from railsearch.interfaces import Evaluation
from railsearch.plugin_manager import Registry
from railsearch.result import RunCommand
from railsearch.run_directory import RunDirectory, recorded_url
from railsearch.run_identity import problem_of
from railsearch.storage import StudyDescription, open_run, storage_url
from railsearch.study_note import study_note


@dataclass(frozen=True)
class StoredRun:
    """A run that was begun, perhaps finished: its problem, how it was asked for, and its evaluations so far."""

    problem: DesignProblem
    command: RunCommand
    evaluations: tuple[Evaluation, ...]


def stored_run(registry: Registry, directory: RunDirectory, storage: str | None) -> StoredRun:
    """The run of a folder, read from its record. Raises InputError without one, StorageError if it cannot be read."""
    stored = stored_document(directory)
    identity = stored["identity"]
    problem = problem_of(registry, identity, "run.json")
    command = RunCommand(stored["command"], identity)
    record = open_run(record_url(directory, stored, storage), study_of(problem, command), problem.space, create=False)
    evaluations = record.load()
    for evaluation in evaluations:
        if not evaluation.failed:
            problem.replay(evaluation)
    return StoredRun(problem, command, tuple(evaluations))


def stored_document(directory: RunDirectory) -> dict[str, Any]:
    """What run.json says. Raises InputError if there is none."""
    stored = directory.stored()
    if stored is None:
        raise InputError(f"DIR: {directory.folder} holds no run (no run.json); give the --out of a `railsearch run`")
    return stored


def record_url(directory: RunDirectory, stored: Mapping[str, Any], storage: str | None) -> str:
    """Where the record is: at the storage that a command names, else where run.json says."""
    if storage is not None:
        return storage_url(storage)
    return recorded_url(stored["storage"], directory.embedded_url)


def study_of(problem: DesignProblem, command: RunCommand) -> StudyDescription:
    """The study that keeps the record of a run."""
    identity = command.identity
    name = f"{problem.label} / {identity['strategy']['name']} / seed {identity['seed']}"
    names = tuple(objective.name for objective in problem.objectives)
    return StudyDescription(name, identity, names, problem.n_ieq_constr, study_note(problem, command))
