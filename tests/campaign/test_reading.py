"""What is read of a campaign is what its runs made."""

import types
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from railsearch.campaign.cells import Campaign, CampaignProblem, CampaignStrategy, Cell
from railsearch.campaign.identity import cell_identity, cell_settings
from railsearch.campaign.problems import make_problems
from railsearch.campaign.reading import cell_record, read_campaign
from railsearch.campaign.results import CampaignResults, CellRecord
from railsearch.design_problem import DesignProblem
from railsearch.errors import StorageError
from railsearch.hookspecs import hookimpl
from railsearch.interfaces import Evaluation
from railsearch.plugin_manager import Registry, load_plugins
from railsearch.problem_factory import ProblemSettings, given_designs
from railsearch.run import run_search
from railsearch.storage import Storage, StudyDescription
from railsearch.storage.reader import StudyColumns, read_studies
from sample_problems import Sphere, TwoObjectives

CAMPAIGN = Campaign(
    name="trial",
    budget=7,
    repetitions=2,
    seed=3,
    problems=(
        CampaignProblem("bounded", ProblemSettings("bounded")),
        CampaignProblem("scalar", ProblemSettings("bounded", scalariser="asf")),
        CampaignProblem("often", ProblemSettings("failing")),
        CampaignProblem("always", ProblemSettings("broken")),
    ),
    strategies=(CampaignStrategy("random", "random"),),
)
LEFT_OUT = Cell("often", "random", 2)


class Bounded(TwoObjectives):
    """Two objectives and a constraint; fails below a length."""

    def __init__(self) -> None:
        super().__init__(constrained=True)

    def simulate(self, design: np.ndarray) -> Any:
        if design[1] < -2.0:
            raise ZeroDivisionError("no ballast")
        return super().simulate(design)


class Failing(Sphere):
    """Fails at every second design."""

    def simulate(self, design: np.ndarray) -> Any:
        if design[0] < 0.0:
            raise ValueError("too soft")
        return super().simulate(design)


class Broken(TwoObjectives):
    """Always fails."""

    def simulate(self, design: np.ndarray) -> Any:
        raise ValueError("broken")


@pytest.fixture
def registry(install: Callable[..., None]) -> Registry:
    @hookimpl
    def railsearch_problems(register: Callable[[str, Any], None]) -> None:
        register("bounded", Bounded)
        register("failing", Failing)
        register("broken", Broken)

    samples = types.ModuleType("samples")
    vars(samples)["railsearch_problems"] = railsearch_problems
    install(samples=lambda: samples)
    return load_plugins()


def recorded(registry: Registry, url: str) -> Iterator[tuple[Cell, DesignProblem, list[Evaluation]]]:
    """Run and record all cells of the campaign but one, and begin a study of that."""
    storage, problems = Storage(url), make_problems(registry, CAMPAIGN)
    for cell in CAMPAIGN.cells():
        problem = problems[cell.problem]
        names = tuple(objective.name for objective in problem.objectives)
        identity = cell_identity(registry, CAMPAIGN, cell, problem)
        record = storage.run(
            StudyDescription(cell.study_name("trial"), identity, names, problem.n_ieq_constr, ""), problem.space
        )
        if cell != LEFT_OUT:
            run = run_search(registry, problem, cell_settings(CAMPAIGN, cell), given_designs(problem), record)
            yield cell, problem, list(run.evaluations)


def assert_same(record: CellRecord, problem: DesignProblem, made: list[Evaluation]) -> None:
    for column, name in ((record.designs, "design"), (record.objectives, "objectives"), (record.constraints, "constraints")):
        assert column.tobytes() == np.array([getattr(evaluation, name) for evaluation in made]).tobytes()
        assert column.shape == (len(made), len(getattr(made[0], name)))
    assert set(record.metrics) >= {quantity.name for quantity in problem.metrics}
    for name, values in record.metrics.items():
        assert values.tobytes() == np.array([evaluation.metrics.get(name, np.nan) for evaluation in made]).tobytes()
    assert list(record.origins) == [evaluation.origin for evaluation in made]
    assert list(record.trajectories) == [evaluation.trajectory for evaluation in made]
    assert list(record.reasons) == [evaluation.reason for evaluation in made]
    assert list(record.durations) == [evaluation.duration for evaluation in made]
    assert list(record.overheads) == [evaluation.overhead for evaluation in made]
    assert record.failed.tolist() == [evaluation.failed for evaluation in made]
    assert record.feasible.tolist() == [evaluation.feasible for evaluation in made]


def test_every_record_is_what_its_run_made(registry: Registry, tmp_path: Path) -> None:
    url = f"sqlite:///{tmp_path / 'study.db'}"
    made = list(recorded(registry, url))
    results = read_campaign(registry, url, CAMPAIGN)
    assert isinstance(results, CampaignResults)
    assert set(results.records) == {cell for cell, *_ in made} == set(CAMPAIGN.cells()) - {LEFT_OUT}
    assert {label: problem.label for label, problem in results.problems.items()} == {
        cell.problem: problem.label for cell, problem, _ in made
    }
    for cell, problem, evaluations in made:
        assert_same(results.records[cell], problem, evaluations)
        assert results.records[cell].identity == cell_identity(registry, CAMPAIGN, cell, problem)
    failed = [record.failed for record in results.records.values()]
    assert any(0 < rows.sum() < len(rows) for rows in failed), "the samples have failures"


def test_cells_that_the_campaign_does_not_have_are_left_out(registry: Registry, tmp_path: Path) -> None:
    url = f"sqlite:///{tmp_path / 'study.db'}"
    assert len(list(recorded(registry, url))) == 7
    fewer = Campaign("trial", 7, 1, 3, CAMPAIGN.problems[:1], CAMPAIGN.strategies)
    assert set(read_campaign(registry, url, fewer).records) == {Cell("bounded", "random", 1)}


def test_a_study_of_another_problem_is_refused(registry: Registry, tmp_path: Path) -> None:
    url = f"sqlite:///{tmp_path / 'study.db'}"
    next(recorded(registry, url))
    study: StudyColumns = next(iter(read_studies(url, "trial/")))
    other = load_plugins().get("problem", "sphere")()
    with pytest.raises(StorageError, match=r"'trial/bounded/random/1' has no x1, .*not a record of sphere \(f\)"):
        cell_record(other, study)
