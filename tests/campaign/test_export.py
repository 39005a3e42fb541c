import dataclasses
import json
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet
import pytest
from sample_campaigns import Searcher, campaign_of, record_of, results_of, synthetic_results

from railsearch.campaign.cells import Cell
from railsearch.campaign.export import results_table, write_csv, write_parquet
from railsearch.campaign.results import CampaignResults, CellRecord
from railsearch.design_problem import DesignProblem
from railsearch.errors import StorageError
from railsearch.interfaces import Outcome, Quantity
from railsearch.space import FloatArray, Space, Variable
from sample_problems import Sphere, TwoObjectives

NAN = np.nan


class Comfort(DesignProblem):
    """A maximised objective, and names that other problems and the table itself use for something else."""

    def __init__(self) -> None:
        variables = (
            Variable("stiffness", -5.0, 5.0, "kN/m"),
            Variable("origin", 0, 3, integer=True),
            Variable("rows", 0.0, 1.0),
        )
        super().__init__("comfort", Space(variables), [Quantity("comfort", "m/s²", maximised=True)], n_constraints=1)

    def simulate(self, design: FloatArray) -> Outcome:
        return Outcome(-design[:1], constraints=np.zeros(1))


def column(table: pa.Table, name: str) -> list:
    return table.column(name).to_pylist()


def of_comfort(objectives: list[float], **changes: object) -> CampaignResults:
    """One cell of the maximised problem; objectives as they are minimised."""
    problem = Comfort()
    designs = np.tile([1.5, 2.0, 0.5], (len(objectives), 1))
    reasons = ["SimulationError: diverged" if np.isnan(value) else "" for value in objectives]
    record = dataclasses.replace(record_of(problem, objectives, reasons, designs), **changes)
    return CampaignResults(campaign_of({"c": problem}, ["s"], 1, 9), {"c": problem}, {Cell("c", "s", 1): record})


def without_evaluations(problem: DesignProblem) -> CellRecord:
    nothing = np.empty(0)
    return CellRecord(
        {}, np.empty((0, 4)), np.empty((0, 1)), np.empty((0, 0)), {}, [], nothing.astype(int), [], nothing, nothing
    )


@pytest.fixture(scope="module")
def results() -> CampaignResults:
    problems = {"ball": Sphere(), "two": TwoObjectives(constrained=True)}
    return synthetic_results(problems, {"near": Searcher(0.9, 0.2), "far": Searcher(0.1)}, repetitions=3, budget=25)


def test_there_is_a_row_for_every_evaluation_in_the_order_of_the_campaign(results: CampaignResults) -> None:
    table = results_table(results)
    rows = zip(*(column(table, name) for name in ("problem", "strategy", "repetition", "evaluation")), strict=True)
    expected = [(p, s, r, e) for p in ("ball", "two") for s in ("near", "far") for r in (1, 2, 3) for e in range(1, 26)]
    assert list(rows) == expected
    assert set(column(table, "campaign")) == {"sample"}


def test_rows_hold_what_the_records_hold(results: CampaignResults) -> None:
    table = results_table(results).to_pandas()
    for cell, record in results.records.items():
        own = table[
            (table.problem == cell.problem) & (table.strategy == cell.strategy) & (table.repetition == cell.repetition)
        ]
        names = list(results.problems[cell.problem].space.names)
        np.testing.assert_array_equal(own[names].to_numpy(float), record.designs)
        objectives = [quantity.name for quantity in results.problems[cell.problem].objectives]
        np.testing.assert_array_equal(own[objectives].to_numpy(float), record.objectives)
        np.testing.assert_array_equal(own.feasible, record.feasible)
        np.testing.assert_array_equal(own.origin, record.origins)
        np.testing.assert_array_equal(own.duration, record.durations)
        np.testing.assert_array_equal(own.overhead, record.overheads)
        np.testing.assert_array_equal(own.trajectory, record.trajectories)


def test_columns_have_types_and_units(results: CampaignResults) -> None:
    schema = results_table(results).schema
    types = {"stiffness": pa.float64(), "count": pa.int64(), "evaluation": pa.int64(), "feasible": pa.bool_()}
    assert {name: schema.field(name).type for name in types} == types
    units = {"stiffness": "MN/m", "distance": "m²", "best_so_far": "m²", "right": "N·m", "duration": "s", "count": ""}
    assert {name: schema.field(name).metadata[b"unit"].decode() for name in units} == units
    assert schema.field("distance").metadata[b"meaning"] == b"squared distance"
    assert len(schema.names) == len(set(schema.names))


def test_what_a_problem_lacks_is_null(results: CampaignResults) -> None:
    table = results_table(results)
    two = np.array(column(table, "problem")) == "two"
    for name, there in (("left", two), ("constraint 1", two), ("comfort", two), ("distance", ~two)):
        assert all(value is None for value in np.array(column(table, name), dtype=object)[~there])
    assert table.column("stiffness").null_count == 0


def test_a_maximised_quantity_has_its_natural_sign() -> None:
    results = of_comfort([-2.0, -5.0, -3.0], metrics={"grip": np.array([1.0, -1.0, 0.0])})
    table = results_table(results)
    assert column(table, "comfort") == [2.0, 5.0, 3.0]
    assert column(table, "best_so_far") == [2.0, 5.0, 5.0]
    assert column(table, "grip") == [1.0, -1.0, 0.0]


def test_an_objective_that_is_a_metric_as_well_has_one_column() -> None:
    table = results_table(of_comfort([-2.0, NAN], metrics={"comfort": np.array([-2.0, -8.0])}))
    assert column(table, "comfort") == [2.0, None]


def test_a_failed_evaluation_has_a_reason_and_no_values() -> None:
    table = results_table(of_comfort([NAN, -5.0, NAN]))
    assert column(table, "reason") == ["SimulationError: diverged", None, "SimulationError: diverged"]
    assert column(table, "comfort") == [None, 5.0, None]
    assert column(table, "feasible") == [False, True, False]
    assert column(table, "best_so_far") == [None, 5.0, 5.0]


def test_an_infeasible_design_is_no_best_one() -> None:
    table = results_table(of_comfort([-1.0, -9.0, -2.0], constraints=np.array([[0.0], [0.5], [-1.0]])))
    assert column(table, "comfort") == [1.0, 9.0, 2.0]
    assert column(table, "constraint 1") == [0.0, 0.5, -1.0]
    assert column(table, "feasible") == [True, False, True]
    assert column(table, "best_so_far") == [1.0, 1.0, 2.0]


def test_hypervolume_so_far_is_the_share_of_the_box_to_the_reference_point() -> None:
    """Between (0, 0) and (5, 5): 1 × 5 of 25, with its mirror image 9, with (1, 1) 4 × 4 + 2."""
    problem = TwoObjectives()
    campaign = campaign_of({"two": problem}, ["s"], 1, 4, {"two": {"left": 5.0, "right": 5.0}})
    record = record_of(problem, [[0.0, 4.0], [4.0, 0.0], [1.0, 1.0], [2.0, 2.0]])
    table = results_table(CampaignResults(campaign, {"two": problem}, {Cell("two", "s", 1): record}))
    assert column(table, "hypervolume_so_far") == pytest.approx([5 / 25, 9 / 25, 18 / 25, 18 / 25])
    assert column(table, "best_so_far") == [None] * 4
    box = json.loads(table.schema.metadata[b"hypervolume_boxes"])["two"]
    assert box["ideal"] == {"left": 0.0, "right": 0.0}
    assert box["reference"] == {"left": 5.0, "right": 5.0}


def test_a_name_with_two_meanings_is_told_apart_by_kind_and_unit() -> None:
    problems = {"ball": Sphere(), "two": TwoObjectives(), "c": Comfort()}
    campaign = campaign_of(problems, ["s"], 1, 2)
    records = {
        Cell("ball", "s", 1): record_of(problems["ball"], [1.0, 2.0]),
        Cell("two", "s", 1): record_of(problems["two"], [[1.0, 2.0]], metrics={"comfort": np.array([-4.0])}),
        Cell("c", "s", 1): record_of(problems["c"], [-7.0], designs=np.array([[3.0, 2.0, 0.5]])),
    }
    table = results_table(CampaignResults(campaign, problems, records))
    assert column(table, "variable stiffness [kN/m]") == [None, None, None, 3.0]
    assert column(table, "variable stiffness [MN/m]")[3] is None
    assert column(table, "variable origin") == [None, None, None, 2]
    assert column(table, "origin") == ["given", "random", "given", "given"]
    assert column(table, "comfort") == [None, None, 4.0, 7.0]
    assert table.schema.field("variable origin").type == pa.int64()
    assert column(table, "rows")[3] == 0.5, "an integer of one problem that is real in another is real"


def test_incomplete_campaigns_have_the_rows_that_there_are() -> None:
    problem = Sphere()
    campaign = campaign_of({"p": problem}, ["a", "b"], 3, 10)
    records = {Cell("p", "b", 3): record_of(problem, [4.0, 1.0]), Cell("p", "a", 2): without_evaluations(problem)}
    table = results_table(CampaignResults(campaign, {"p": problem}, records))
    assert column(table, "repetition") == [3, 3]
    nothing = results_table(CampaignResults(campaign, {"p": problem}, {}))
    assert nothing.num_rows == 0
    assert {"strategy", "evaluation", "best_so_far", "overhead"} <= set(nothing.column_names)


def test_parquet_gives_the_table_back(results: CampaignResults, tmp_path: Path) -> None:
    write_parquet(results, tmp_path / "new" / "results.parquet")
    table = pyarrow.parquet.read_table(tmp_path / "new" / "results.parquet")
    assert table.equals(results_table(results), check_metadata=True)
    assert table.schema.metadata[b"format"] == b"railsearch results 1"


def test_csv_gives_the_values_back_and_shows_units(results: CampaignResults, tmp_path: Path) -> None:
    path = tmp_path / "results.csv"
    write_csv(results, path)
    missing = pyarrow.csv.ConvertOptions(strings_can_be_null=True, quoted_strings_can_be_null=False)
    read, table = pyarrow.csv.read_csv(path, convert_options=missing), results_table(results)
    assert {"stiffness [MN/m]", "distance [m²]", "duration [s]", "count"} <= set(read.column_names)
    for place, field in enumerate(table.schema):
        assert read.column(place).cast(field.type).to_pylist() == column(table, field.name), field.name


def test_files_are_the_same_for_the_same_results(tmp_path: Path) -> None:
    for name in ("once", "again"):
        results = results_of(Sphere(), {"a": [1.0, 2.0], "b": [3.0, 0.5]})
        write_parquet(results, tmp_path / f"{name}.parquet")
        write_csv(results, tmp_path / f"{name}.csv")
    for suffix in ("parquet", "csv"):
        assert (tmp_path / f"once.{suffix}").read_bytes() == (tmp_path / f"again.{suffix}").read_bytes()


@pytest.mark.parametrize("write", [write_parquet, write_csv])
def test_a_place_that_cannot_be_written_is_named(write: object, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(StorageError, match="file"):
        write(results_of(Sphere(), {"a": [1.0]}), tmp_path / "file" / "results")
