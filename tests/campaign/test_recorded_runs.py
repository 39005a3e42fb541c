"""Runs that were made elsewhere are taken over from the table of results."""

import dataclasses
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet
import pytest
from campaign_runs import Trial
from sample_campaigns import Searcher, campaign_of, record_of, synthetic_results

from railsearch.campaign.cells import Cell
from railsearch.campaign.coordinator import Coordinator
from railsearch.campaign.export import write_parquet
from railsearch.campaign.identity import campaign_identity
from railsearch.campaign.problems import make_problems
from railsearch.campaign.reading import cell_record, read_campaign
from railsearch.campaign.recorded_runs import RecordedRuns
from railsearch.campaign.results import CampaignResults, CellRecord
from railsearch.campaign.tasks import cell_tasks
from railsearch.design_problem import DesignProblem
from railsearch.interfaces import Evaluation, Outcome, Quantity
from railsearch.plugin_manager import load_plugins
from railsearch.space import FloatArray, Space, Variable
from railsearch.storage import Storage, StudyDescription, open_run
from railsearch.storage.reader import read_studies
from sample_problems import Sphere, TwoObjectives

Cli = Callable[..., Any]
NAN = np.nan


class Ride(DesignProblem):
    """A maximised objective, a maximised metric, and names that others use for something else."""

    def __init__(self) -> None:
        variables = (Variable("stiffness", -5.0, 5.0, "kN/m"), Variable("origin", 0, 3, integer=True))
        objectives = [Quantity("comfort", "m/s²", maximised=True)]
        super().__init__("ride", Space(variables), objectives, [Quantity("speed", "m/s", maximised=True)], n_constraints=1)

    def simulate(self, design: FloatArray) -> Outcome:
        return Outcome(-design[:1], constraints=np.zeros(1))


@pytest.fixture(scope="module")
def results() -> CampaignResults:
    """Synthetic searches that fail now and then, and one of a problem whose quantities are maximised."""
    problems = {"ball": Sphere(), "two": TwoObjectives(constrained=True), "ride": Ride()}
    made = synthetic_results(
        {name: problems[name] for name in ("ball", "two")}, {"near": Searcher(0.9, 0.3)}, repetitions=2, budget=12
    )
    ride = dataclasses.replace(
        record_of(problems["ride"], [2.5, NAN, -1.5], ["", "SimulationError: diverged", ""], np.array([[1.5, 2.0]] * 3)),
        metrics={"speed": np.array([-3.0, NAN, 4.0]), "unforeseen": np.array([7.0, NAN, NAN])},
        constraints=np.array([[0.5], [NAN], [-0.5]]),
        trajectories=np.array([0, 0, 1]),
    )
    campaign = campaign_of(problems, ["near"], 2, 12)
    return CampaignResults(campaign, problems, {**made.records, Cell("ride", "near", 1): ride})


def stored_again(folder: Path, problem: DesignProblem, evaluations: list[Evaluation]) -> CellRecord:
    """The record that a storage has after these evaluations were put into it."""
    url = f"sqlite:///{folder / 'again.db'}"
    names = tuple(objective.name for objective in problem.objectives)
    run = open_run(url, StudyDescription("again/run", {}, names, problem.n_ieq_constr, ""), problem.space)
    for evaluation in evaluations:
        run.append(evaluation)
    (study,) = read_studies(url, "again/")
    return cell_record(problem, study)


def test_every_record_comes_back_to_the_last_bit(results: CampaignResults, tmp_path: Path) -> None:
    write_parquet(results, tmp_path / "results.parquet", {"campaign": "sample"})
    runs = RecordedRuns(tmp_path / "results.parquet")
    assert runs.lengths == {cell: len(record.objectives) for cell, record in results.records.items()}
    for place, (cell, record) in enumerate(results.records.items()):
        problem, folder = results.problems[cell.problem], tmp_path / str(place)
        folder.mkdir()
        again = stored_again(folder, problem, runs.evaluations(cell, problem))
        for field in dataclasses.fields(CellRecord):
            if field.name not in ("identity", "metrics"):
                np.testing.assert_array_equal(getattr(again, field.name), getattr(record, field.name), field.name)
        for name, values in record.metrics.items():
            np.testing.assert_array_equal(again.metrics[name], values, name)


def written(trial: Trial, path: Path) -> Path:
    """The table of a trial's campaign, carried out."""
    trial.carry_out()
    registry, campaign = load_plugins(), trial.campaign()
    identity = campaign_identity(registry, campaign, make_problems(registry, campaign))
    write_parquet(read_campaign(registry, trial.url, campaign), path, identity)
    return path


@pytest.mark.usefixtures("sample_plugin")
def test_a_campaign_made_in_parts_is_put_together_without_an_evaluation(railsearch: Cli, tmp_path: Path) -> None:
    whole, folder = Trial(tmp_path / "whole"), tmp_path / "put-together"
    takes = []
    for name in whole.strategies:
        part = Trial(whole.folder, strategies=(name,))
        takes += ["--take", written(part, tmp_path / f"{name}.parquet")]
    made, found = len(whole.calls), whole.found()
    words = ("campaign", whole.file(), "--out", folder, *takes)
    dry = railsearch(*words, "--dry-run")
    assert "taking over: 4 complete runs with 100 evaluations" in dry.err
    assert "4 cells of 25 evaluations, 4 complete" in dry.out
    answer = railsearch(*words, "--workers", 2)
    assert answer.code == 0, answer.err
    assert len(whole.calls) == made + 1, "nothing is evaluated but what the dry run times"
    assert whole.found(f"sqlite:///{folder / 'study.db'}") == found
    assert len(found) == 4
    assert railsearch(*words).err.startswith("taking over: 0 complete runs")


@pytest.mark.usefixtures("sample_plugin")
def test_incomplete_runs_are_made_here(railsearch: Cli, tmp_path: Path) -> None:
    trial = Trial(tmp_path / "trial", strategies=("random",), budget=10)
    path = written(trial, tmp_path / "part.parquet")
    found = trial.found()
    table = pyarrow.parquet.read_table(path)
    pyarrow.parquet.write_table(table.slice(0, 13), path)
    before = len(trial.calls)
    answer = railsearch("campaign", trial.file(), "--out", tmp_path / "out", "--take", path)
    assert answer.code == 0, answer.err
    assert "taking over: 1 complete runs with 10 evaluations" in answer.err
    assert len(trial.calls) == before + 10
    assert trial.found(f"sqlite:///{tmp_path / 'out' / 'study.db'}") == found


@pytest.mark.usefixtures("sample_plugin")
@pytest.mark.parametrize("same", [True, False])
def test_a_run_that_has_begun_here_is_completed_only_by_what_it_began(tmp_path: Path, same: bool) -> None:
    trial = Trial(tmp_path, strategies=("random",), repetitions=1, budget=10)
    registry, campaign = load_plugins(), trial.campaign()
    problems = make_problems(registry, campaign)
    path = written(trial, tmp_path / "part.parquet")
    (task,) = cell_tasks(registry, campaign, problems, campaign.cells(), "")
    known = RecordedRuns(path).evaluations(task.cell, problems[task.cell.problem])
    url = f"sqlite:///{tmp_path / 'begun.db'}"
    begun = open_run(url, task.description, task.space)
    for evaluation in known[:4]:
        begun.append(evaluation)
    other = [dataclasses.replace(known[0], objectives=known[0].objectives + 1.0), *known[1:]]
    before, handed = len(trial.calls), known if same else other
    with closing(Storage(url)) as storage:
        Coordinator(storage, [task], made=lambda task: handed).carry_out(trial.places())
    assert len(trial.calls) == before + (0 if same else 6)
    assert trial.found(url) == trial.found()


def test_what_is_no_table_of_this_campaign_is_refused(
    railsearch: Cli, results: CampaignResults, sample_plugin: None, tmp_path: Path
) -> None:
    trial = Trial(tmp_path / "trial", strategies=("random",), budget=5)
    path = written(trial, tmp_path / "part.parquet")
    write_parquet(results, tmp_path / "unnamed.parquet")
    (tmp_path / "text.parquet").write_text("no table")
    other = dataclasses.replace(trial, budget=6)
    for name, file, words in (
        ("part", other, f"{path} holds another campaign than the file describes:\n- budget: there 5, here 6"),
        ("unnamed", trial, "is not a table of results that says of which campaign it is; give the results.parquet"),
        ("text", trial, "text.parquet: is not a parquet table"),
        ("absent", trial, "absent.parquet: cannot be read: No such file or directory"),
    ):
        out = tmp_path / "out"
        answer = railsearch("campaign", file.file(), "--out", out, "--take", tmp_path / f"{name}.parquet")
        assert answer.code == 2
        assert words in answer.err
        assert not out.exists(), "a refusal leaves nothing behind"
