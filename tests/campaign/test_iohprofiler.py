import dataclasses
import json
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from iohinspector import DataManager
from iohinspector.metrics import aggregate_running_time
from sample_campaigns import Searcher, campaign_of, record_of, results_of, synthetic_results

from railsearch.campaign.cells import Cell
from railsearch.campaign.export import write_iohprofiler
from railsearch.campaign.export.recorded import recorded_cells
from railsearch.campaign.results import CampaignResults, CellRecord
from railsearch.errors import InputError, StorageError
from railsearch.statistics import best_so_far, expected_running_time, runlengths
from sample_problems import Sphere, TwoObjectives

NAN = np.nan
BUDGET = 30


@pytest.fixture(scope="module")
def results() -> CampaignResults:
    problems = {"ball": Sphere(), "far ball": Sphere(), "two": TwoObjectives(constrained=True)}
    return synthetic_results(problems, {"near": Searcher(0.9, 0.2), "Far away": Searcher(0.1)}, 4, BUDGET)


@pytest.fixture(scope="module")
def read(results: CampaignResults, tmp_path_factory: pytest.TempPathFactory) -> DataManager:
    folder = tmp_path_factory.mktemp("export") / "ioh"
    write_iohprofiler(results, folder)
    return loaded(folder)


def loaded(folder: Path) -> DataManager:
    manager = DataManager()
    manager.add_folder(str(folder))
    return manager


def of_run(table: pl.DataFrame, cell: Cell) -> pl.DataFrame:
    return table.filter(
        (pl.col("algorithm_name") == cell.strategy)
        & (pl.col("function_name") == cell.problem)
        & (pl.col("instance") == cell.repetition)
    )


def minimised(record: CellRecord) -> np.ndarray:
    return np.where(record.feasible[:, None], record.objectives, np.inf)


def of_sphere(records: dict[Cell, CellRecord], strategies: list[str], repetitions: int = 1) -> CampaignResults:
    problem = Sphere()
    return CampaignResults(campaign_of({"p": problem}, strategies, repetitions, 9), {"p": problem}, records)


def test_every_run_is_found_with_its_best_value(results: CampaignResults, read: DataManager) -> None:
    assert read.n_runs == len(results.records) == 24
    for cell, record in results.records.items():
        run = of_run(read.overview, cell)
        assert run["best_y"].to_list() == [minimised(record)[:, 0].min()]
        assert run["evals"].to_list() == [BUDGET]
        assert run["dimension"].to_list() == [4]
        assert (run["suite"].item(), run["budget"].item(), run["campaign_seed"].item()) == ("sample", BUDGET, 7)


def test_every_evaluation_is_found_digit_by_digit(results: CampaignResults, read: DataManager) -> None:
    data = read.load(monotonic=False, include_meta_data=True)
    for cell, record in results.records.items():
        run = of_run(data, cell)
        assert run["evaluations"].to_list() == list(range(1, BUDGET + 1))
        columns = ["raw_y", "F2"][: record.objectives.shape[1]]
        np.testing.assert_array_equal(run.select(columns).to_numpy(), minimised(record))


def test_runlengths_and_expected_running_times_agree(results: CampaignResults, read: DataManager) -> None:
    data = read.load(monotonic=True, include_meta_data=True)
    for problem in ("ball", "far ball"):
        records = {cell: record for cell, record in results.records.items() if cell.problem == problem}
        finals = [minimised(record).min() for record in records.values()]
        own = data.filter(pl.col("function_name") == problem)
        theirs = aggregate_running_time(
            own, f_min=min(finals), f_max=60.0, scale_f_log=False, eval_max=BUDGET, return_as_pandas=False
        )
        for strategy in ("near", "Far away"):
            curves = best_so_far([minimised(record)[:, 0] for cell, record in records.items() if cell.strategy == strategy])
            times = theirs.filter(pl.col("algorithm_name") == strategy).sort("raw_y")
            lengths = runlengths(curves, times["raw_y"].to_numpy())
            np.testing.assert_allclose(expected_running_time(lengths, BUDGET), times["ERT"].to_numpy())
            np.testing.assert_array_equal(np.isfinite(lengths).sum(axis=0), times["success_count"].to_numpy())
            assert len(set(lengths[np.isfinite(lengths)])) > 5


def test_the_best_point_is_a_design_of_the_run(results: CampaignResults, read: DataManager) -> None:
    points = {}
    for data_set in read.data_sets:
        for run in data_set.scenarios[0].runs:
            points[Cell(data_set.function.name, data_set.algorithm.name, run.instance)] = run.best
    for cell, record in results.records.items():
        row = points[cell].evals - 1
        np.testing.assert_array_equal(points[cell].x, record.designs[row])
        assert points[cell].y == record.objectives[row, 0]
        assert record.feasible[row]


def test_functions_are_numbered_as_the_campaign_lists_its_problems(read: DataManager) -> None:
    functions = {(function.id, function.name, function.maximization) for function in read.functions}
    assert functions == {(1, "ball", False), (2, "far ball", False), (3, "two", False)}


def test_failed_and_infeasible_evaluations_are_infinite_and_count(tmp_path: Path) -> None:
    problem = Sphere()
    first = record_of(problem, [NAN, 5.0, NAN, 4.0], ["lost", "", "lost", ""])
    never = record_of(problem, [NAN, NAN], ["lost", "lost"])
    results = of_sphere({Cell("p", "s", 1): first, Cell("p", "s", 2): never, Cell("p", "s", 4): first}, ["s"], 4)
    write_iohprofiler(results, tmp_path / "ioh")
    read = loaded(tmp_path / "ioh")
    assert read.overview["best_y"].to_list() == [4.0, None, 4.0]
    assert read.overview["instance"].to_list() == [1, 2, 4]
    assert read.overview["evals"].to_list() == [4, 2, 4]
    data = read.load(monotonic=False)
    assert data["raw_y"].to_list() == [np.inf, 5.0, np.inf, 4.0, np.inf, np.inf, np.inf, 5.0, np.inf, 4.0]
    assert data["run_id"].to_list() == [1] * 4 + [2] * 2 + [3] * 4


def test_a_broken_constraint_is_no_success(tmp_path: Path) -> None:
    problem = TwoObjectives(constrained=True)
    record = dataclasses.replace(record_of(problem, [[1.0, 2.0], [0.5, 0.5]]), constraints=np.array([[0.0], [0.1]]))
    campaign = campaign_of({"two": problem}, ["s"], 1, 2)
    write_iohprofiler(CampaignResults(campaign, {"two": problem}, {Cell("two", "s", 1): record}), tmp_path / "ioh")
    data = loaded(tmp_path / "ioh").load(monotonic=False)
    assert data.select("raw_y", "F2").rows() == [(1.0, 2.0), (np.inf, np.inf)]


def test_labels_that_make_bad_file_names_stay_apart_and_inside_the_folder(tmp_path: Path) -> None:
    labels = ["a b", "a_b", "a?b", "..", "ä", ".dat"]
    records = {Cell("p", label, 1): record_of(Sphere(), [float(row)]) for row, label in enumerate(labels)}
    write_iohprofiler(of_sphere(records, labels), tmp_path / "ioh")
    assert [path.name for path in tmp_path.iterdir()] == ["ioh"]
    overview = loaded(tmp_path / "ioh").overview
    assert dict(overview.select("algorithm_name", "best_y").rows()) == {label: row for row, label in enumerate(labels)}


def test_metadata_are_strict_json(results: CampaignResults, tmp_path: Path) -> None:
    write_iohprofiler(results, tmp_path / "ioh")

    def refuse(constant: str) -> None:
        raise AssertionError(constant)

    for path in (tmp_path / "ioh").rglob("*.json"):
        document = json.loads(path.read_text(encoding="utf-8"), parse_constant=refuse)
        assert document["attributes"] == ["evaluations", "raw_y", *["F2"] * (document["function_name"] == "two")]


def test_a_later_export_takes_the_place_of_an_earlier_one(tmp_path: Path) -> None:
    folder = tmp_path / "ioh"
    write_iohprofiler(results_of(Sphere(), {"old": [1.0], "both": [1.0]}), folder)
    write_iohprofiler(results_of(Sphere(), {"both": [2.0]}), folder)
    assert loaded(folder).overview["algorithm_name"].to_list() == ["both"]
    assert [path.name for path in tmp_path.iterdir()] == ["ioh"]
    assert "objective" in (folder / "README.md").read_text(encoding="utf-8")


def test_a_folder_with_something_else_is_left_alone(tmp_path: Path) -> None:
    results = results_of(Sphere(), {"a": [1.0]})
    (tmp_path / "thesis").mkdir()
    (tmp_path / "thesis" / "README.md").write_text("# My thesis")
    with pytest.raises(InputError, match="thesis"):
        write_iohprofiler(results, tmp_path / "thesis")
    with pytest.raises(InputError, match=r"README\.md"):
        write_iohprofiler(results, tmp_path / "thesis" / "README.md")
    assert [path.name for path in (tmp_path / "thesis").iterdir()] == ["README.md"]
    with pytest.raises(StorageError):
        write_iohprofiler(results, tmp_path / "thesis" / "README.md" / "ioh")


def test_a_write_that_fails_leaves_the_earlier_export(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "ioh"
    write_iohprofiler(results_of(Sphere(), {"a": [1.0]}), folder)
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.fsync", full)
    with pytest.raises(StorageError, match="No space left"):
        write_iohprofiler(results_of(Sphere(), {"a": [2.0], "b": [3.0]}), folder)
    assert {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} == before
    assert [path.name for path in tmp_path.iterdir()] == ["ioh"]


def test_a_run_without_an_evaluation_is_no_run(tmp_path: Path) -> None:
    record = record_of(Sphere(), [3.0, 2.0])
    begun = dataclasses.replace(
        record,
        **{name: getattr(record, name)[:0] for name in ("designs", "objectives", "constraints", "origins", "reasons")},
    )
    write_iohprofiler(of_sphere({Cell("p", "s", 1): begun, Cell("p", "s", 2): record}, ["s"], 2), tmp_path / "ioh")
    overview = loaded(tmp_path / "ioh").overview
    assert overview.select("instance", "run_id", "best_y").rows() == [(2, 1, 2.0)]


def test_a_campaign_without_an_evaluation_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no evaluation"):
        write_iohprofiler(of_sphere({}, ["s"]), tmp_path / "ioh")
    assert recorded_cells(of_sphere({}, ["s"])) == []
