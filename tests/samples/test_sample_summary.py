import numpy as np
from uncertain_problem import Uncertain

from railsearch.interfaces import Evaluation
from railsearch.samples import summary


def evaluation(number: int, load: float, reason: str = "", gap: float = 1.0) -> Evaluation:
    values = np.array([load, load])
    return Evaluation(number, np.ones(3), values, np.zeros(1), {"gap": gap}, "lhs", reason=reason)


def test_metrics_of_a_failed_sample_and_values_that_are_not_finite_do_not_count() -> None:
    made = [evaluation(0, 1.0), evaluation(1, 3.0, gap=np.inf), evaluation(2, np.nan, "lost after its simulation", gap=9.0)]
    comfort, load, gap = summary(Uncertain(), made)
    assert (comfort["minimum"], comfort["maximum"], comfort["q50"]) == (-3.0, -1.0, -2.0)
    assert load["values"] == 2
    assert (gap["values"], gap["maximum"]) == (1, 1.0)


def test_a_quantity_without_values_has_nulls() -> None:
    rows = summary(Uncertain(), [evaluation(0, 1.0, gap=np.nan)])
    assert rows[2]["values"] == 0
    assert {rows[2][key] for key in ("minimum", "q1", "q50", "q90", "q99", "maximum")} == {None}
