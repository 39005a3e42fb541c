import numpy as np
import pytest
from railsearch_peers.cells import CellResult, joined, read_cells, unequal_starts, write_cells
from railsearch_peers.scores import ranking, score, scored, standings
from railsearch_peers.tables import medians_table, ranking_table, standings_table

from railsearch.errors import InputError


def cell(problem: str, strategy: str, repetition: int, *best: float, start: str = "s", ended: str = "") -> CellResult:
    return CellResult(problem, strategy, repetition, 7, start, 0.002, ended, best)


# Random search ends at medians 20, 12 and 10 on `a` (best known 0), at 6, 5 and 4 on `b` (best known 2).
CELLS = [
    *(cell("a", "random", k, 20.0, 12.0, value) for k, value in enumerate((8.0, 10.0, 13.0), 1)),
    *(cell("b", "random", k, 6.0, 5.0, 4.0) for k in (1, 2, 3)),
    *(cell("a", "pysot-dycors", k, 10.0, 6.0, value) for k, value in enumerate((4.0, 5.0, 6.0), 1)),
    *(cell("b", "pysot-dycors", k, 4.0, 3.5, 3.0) for k in (1, 2, 3)),
    *(cell("a", "other", k, 10.0, 3.0, value) for k, value in enumerate((2.0, 2.5, 8.0), 1)),
    *(cell("b", "other", k, 5.0, 3.5, 2.5) for k in (1, 2, 3)),
    cell("a", "slow", 2, 5.0, 3.0, 1.0),
]
KNOWN = {"a": 0.0, "b": 2.0}


def test_the_score_is_0_at_the_best_known_1_like_random_search_and_2_at_most() -> None:
    best = np.array([[2.0, 2.0, 2.0], [6.0, 4.0, 3.0], [10.0, 6.0, 4.0], [np.inf, 7.0, 2.5]])
    expected = [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0], [2.0, 2.0, 2.0], [2.0, 2.0, 0.5]]
    assert np.allclose(score(best, 2.0, np.array([6.0, 4.0, 3.0])), expected, rtol=1e-15, atol=0.0)


def test_a_floor_as_good_as_the_best_known_value_is_refused() -> None:
    with pytest.raises(InputError, match="random search must be worse"):
        score(np.array([1.0, 1.0, 1.0]), 1.0, np.array([3.0, 2.0, 1.0]))


def test_scores_use_the_median_of_random_search_on_each_problem() -> None:
    scores = scored(CELLS, KNOWN)
    assert np.allclose(scores["a", "pysot-dycors", 1], [0.5, 0.5, 0.4], rtol=1e-15)
    assert np.allclose(scores["b", "other", 3], [0.75, 0.5, 0.25], rtol=1e-15)
    assert np.allclose(scores["a", "random", 2], [1.0, 1.0, 1.0], rtol=1e-15)


def test_a_problem_without_random_search_has_no_scores() -> None:
    without = [one for one in CELLS if (one.problem, one.strategy) != ("b", "random")]
    assert {problem for problem, _, _ in scored(without, KNOWN)} == {"a"}


def test_standings_are_worked_by_hand() -> None:
    found = {standing.strategy: standing for standing in standings(CELLS, KNOWN)}
    other = found["other"]
    # a: 0.5, 0.25 and 0.2, 0.25, 0.8; b: 0.75, 0.5, 0.25; the reference: 0.5, 0.5 and 0.4, 0.5, 0.6; 0.5, 0.5, 0.5.
    assert (other.runs, other.problems) == (6, 2)
    assert np.allclose(other.mean, [0.625, 0.375, (0.2 + 0.25 + 0.8 + 3 * 0.25) / 6.0], rtol=1e-14)
    assert np.allclose(other.ratio, [0.625 / 0.5, 0.375 / 0.5, 2.0 / 3.0], rtol=1e-14)
    assert np.allclose(other.wins, [0.25, 0.75, 5.0 / 6.0], rtol=1e-14)
    assert (found["slow"].runs, found["slow"].problems) == (1, 1)
    assert np.allclose(found["slow"].ratio, [0.5, 0.5, 0.2], rtol=1e-14)


def test_standings_come_in_the_order_of_the_ratio_at_the_full_budget() -> None:
    assert [standing.strategy for standing in standings(CELLS, KNOWN)] == ["slow", "other", "pysot-dycors", "random"]


def test_significance_is_that_of_the_rank_sum_and_signed_rank_tests_with_holm() -> None:
    cells = []
    for problem, k in ((p, k) for p in "abcdef" for k in range(6)):
        cells.append(cell(problem, "random", k, 9.0, 9.0, 9.0))
        cells.append(cell(problem, "pysot-dycors", k, 4.0, 4.0, 4.0 + 0.1 * k))
        cells.append(cell(problem, "better", k, 3.0, 3.0, 3.0 + 0.1 * k + 0.01 * "abcdef".index(problem)))
        cells.append(cell(problem, "same", k, 4.0, 4.0, 4.0 + 0.1 * k))
    found = {standing.strategy: standing for standing in standings(cells, dict.fromkeys("abcdef", 0.0))}
    assert found["better"].significant == (6, 0)
    assert found["random"].significant == (0, 6)
    assert found["same"].significant == (0, 0)
    # Six differences of one sign: p = 2/2⁶, times 3 (better and random are equal, same is 1).
    assert np.allclose(found["better"].p_value, 3.0 * 2.0 / 64.0, rtol=1e-12)
    assert np.allclose(found["same"].p_value, 1.0, rtol=1e-12)


def test_ranks_rest_on_the_repetitions_that_all_have() -> None:
    three = ranking(CELLS, ["pysot-dycors", "other", "random"])
    assert three is not None
    assert (three.problems, three.runs) == (("a", "b"), 6)
    # a: 1.5, 1.5, 3 and 2, 1, 3 and 2, 1, 3; b: 1, 2, 3 and 1.5, 1.5, 3 and 2, 1, 3.
    expected = [[1.25, 1.75, 3.0], [1.75, 1.25, 3.0], [2.0, 1.0, 3.0]]
    assert np.allclose([ranks.mean_ranks for ranks in three.ranks], expected, rtol=1e-14)
    four = ranking(CELLS, ["pysot-dycors", "other", "random", "slow"])
    assert four is not None
    assert (four.problems, four.runs) == (("a",), 1)
    assert ranking(CELLS, ["pysot-dycors", "absent"]) is None


def test_a_run_in_two_records_is_refused() -> None:
    assert len(joined([CELLS[:4], CELLS[4:]])) == len(CELLS)
    with pytest.raises(InputError, match="random on a, repetition 1, is in two of them"):
        joined([CELLS, CELLS[:1]])


def test_another_start_than_the_others_is_found() -> None:
    astray = cell("a", "astray", 1, 1.0, 1.0, 1.0, start="t")
    assert unequal_starts([*CELLS, astray]) == [astray]


def test_cells_are_read_as_they_were_written(tmp_path) -> None:
    cells = [cell("a", "x", 2, np.inf, 0.1 + 0.2, 1e-300), cell("a", "x", 1, 3.0, 2.0, 1.0, ended='E: "no, more"')]
    write_cells(tmp_path / "cells.csv", cells)
    assert read_cells(tmp_path / "cells.csv") == cells[::-1]


def test_tables_name_everybody_and_say_what_is_missing() -> None:
    beside = standings_table(standings(CELLS, KNOWN), CELLS)
    assert "| other | 6, 2 | 0.62 / 0.38 / 0.33 | 1.25 / 0.75 / 0.67 | 0.25 / 0.75 / 0.83 |" in beside
    assert "| pysot-dycors | 6, 2 | 0.50 / 0.50 / 0.50 | 1.00 / 1.00 / 1.00 | 0.50 / 0.50 / 0.50 |" in beside
    medians = medians_table(CELLS, KNOWN, 2)
    assert "| problem | best known | pysot-dycors | other | slow | random |" in medians
    assert "| b | 2 | 3 (3 … 3) | 2.5 (2.5 … 2.5) | - | 4 (4 … 4) |" in medians
    ranks = ranking(CELLS, ["pysot-dycors", "other", "random"])
    assert ranks is not None
    assert ranking_table(ranks).splitlines()[2] == "| other | 1.75 / 1.25 / 1.00 |"
