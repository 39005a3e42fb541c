"""The file of a sample, and the journal beside it in which evaluations are kept until the file is whole."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from railsearch.design_problem import DesignProblem
from railsearch.errors import InputError, StorageError
from railsearch.interfaces import Evaluation
from railsearch.plugin_manager import Registry
from railsearch.problem_factory import ProblemSettings
from railsearch.result import plugins_used, problem_document, versions
from railsearch.run_directory import make_folder
from railsearch.run_identity import problem_identity
from railsearch.samples.experiment import Experiment, ExperimentDesign, input_distributions
from railsearch.samples.file_table import FileTable, read_table
from railsearch.samples.journal import Journal
from railsearch.samples.table import check_suffix, evaluations_in, write_samples
from railsearch.storage import identity_differences, plain

JOURNAL = ".journal"
IDENTIFYING = ("problem", "objectives", "sections")
DIFFERENCES_SHOWN = 3


def experiment_identity(
    registry: Registry, asked: ProblemSettings, problem: DesignProblem, experiment: Experiment
) -> dict[str, Any]:
    """What identifies a sample of `problem`, which `asked` made; every default is spelt out."""
    known = problem_identity(registry, asked, problem, ())
    marginals = input_distributions(problem).marginals
    distributions = {name: str(marginal) for name, marginal in marginals.items()}
    return plain({key: known[key] for key in IDENTIFYING} | {"distributions": distributions} | asdict(experiment))


def sample_file_document(
    registry: Registry, problem: DesignProblem, command: str, identity: Mapping[str, Any]
) -> dict[str, Any]:
    """What a file says about its samples: the command, what identifies them, the problem, versions and plugins."""
    return plain(
        {
            "command": command,
            "identity": identity,
            "problem": problem_document(problem),
            "versions": versions(),
            "plugins": plugins_used(registry, identity),
        }
    )


class SampleFile:
    """A record of a run of samples (see `railsearch.run.Record`) that ends as one whole file, Parquet or CSV by its name.

    Raises InputError for a name that ends otherwise.
    """

    def __init__(self, path: Path, problem: DesignProblem) -> None:
        check_suffix(path)
        self.path = path
        self._problem = problem
        self._journal = Journal(path.with_name(path.name + JOURNAL))

    def stored(self) -> dict[str, Any] | None:
        """The document of the command that began these samples, None in a new place. Raises StorageError."""
        self._journal.read()
        whole = self._whole()
        return self._journal.head or (None if whole is None else _document(whole))

    @contextmanager
    def claimed(self, document: Mapping[str, Any]) -> Iterator[Mapping[str, Any]]:
        """Hold the file for the samples that `document` describes; gives the document of the command that began them.

        Raises StorageError if the file cannot be written, holds something else, or is in use by another process.
        """
        make_folder(self.path.parent)
        with self._journal.claimed():
            whole = self._whole()
            begun = [_document(whole)] if whole is not None else []
            begun += [self._journal.head] if self._journal.head is not None else []
            for earlier in begun:
                check_same_samples(self.path, earlier, document)
            same = next((earlier for earlier in begun if earlier["identity"] == document["identity"]), None)
            if same is None:
                self._journal.begin(document)
            yield same or document

    def load(self) -> list[Evaluation]:
        """The evaluations so far, those of the file and those of the journal."""
        whole = self._whole()
        found = {} if whole is None else {e.number: e for e in evaluations_in(whole.table, whole.about, self._problem)}
        found |= {entry["number"]: _evaluation(entry) for entry in self._journal.entries}
        return list(found.values())

    def append(self, evaluation: Evaluation) -> None:
        """Keep one more. Raises StorageError if it cannot be written."""
        self._journal.append(_entry(evaluation))

    def finish(self, evaluations: Sequence[Evaluation], document: Mapping[str, Any]) -> bool:
        """Write the file, unless it is whole already; whether it was written. Raises StorageError."""
        if self._journal.head is None:
            return False
        write_samples(self.path, self._problem, evaluations, document)
        self._journal.remove()
        return True

    def _whole(self) -> FileTable | None:
        if not self.path.exists():
            return None
        try:
            found = read_table(self.path)
        except InputError as error:
            raise StorageError(f"{error}. Nothing was changed: use another --out") from None
        if not found.about:
            raise StorageError(f"{self.path} holds something else than samples. Nothing was changed: use another --out")
        return found


def check_same_samples(path: Path, begun: Mapping[str, Any], document: Mapping[str, Any]) -> None:
    """Raise StorageError unless a file that was begun can become what `document` describes, with reason and remedy.

    It can if only the number of samples is larger and the design is one that can be extended.
    """
    old, new = dict(begun["identity"]), dict(document["identity"])
    there, here = old.pop("number"), new.pop("number")
    differences = identity_differences(old, new)
    if differences:
        shown, more = differences[:DIFFERENCES_SHOWN], len(differences) - DIFFERENCES_SHOWN
        others = f"; and {more} more" if more > 0 else ""
        raise StorageError(
            f"{path} holds another sample ({'; '.join(shown)}{others}). Nothing was changed: use another --out, or continue "
            f"that sample with: {begun['command']}"
        )
    if here < there:
        raise StorageError(
            f"{path} holds a sample of {there}, more than {here}. Nothing was changed: use another --out, or ask for {there}"
        )
    if here > there and old["design"] == ExperimentDesign.LHS:
        raise StorageError(
            f"{path} holds a Latin hypercube of {there}, which is no part of one of {here}: each has one sample in each of "
            "as many intervals as it has samples. Nothing was changed: use another --out, or a design that can grow, "
            f"{' or '.join(design for design in ExperimentDesign if design.extensible)}"
        )


def _document(whole: FileTable) -> dict[str, Any]:
    return {key: value for key, value in whole.about.items() if key != "columns"}


def _entry(evaluation: Evaluation) -> dict[str, Any]:
    return {
        "number": evaluation.number,
        "design": evaluation.design.tolist(),
        "objectives": evaluation.objectives.tolist(),
        "constraints": evaluation.constraints.tolist(),
        "metrics": dict(evaluation.metrics),
        "origin": evaluation.origin,
        "reason": evaluation.reason,
        "duration": evaluation.duration,
    }


def _evaluation(entry: Mapping[str, Any]) -> Evaluation:
    arrays = {name: np.array(entry[name], dtype=float) for name in ("design", "objectives", "constraints")}
    return Evaluation(
        number=entry["number"],
        design=arrays["design"],
        objectives=arrays["objectives"],
        constraints=arrays["constraints"],
        metrics=entry["metrics"],
        origin=entry["origin"],
        reason=entry["reason"],
        duration=entry["duration"],
    )
