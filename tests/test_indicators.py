import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from railsearch.indicators import non_dominated


def dominates(a: np.ndarray, b: np.ndarray) -> bool:
    return bool(np.all(a <= b) and np.any(a < b))


@given(hnp.arrays(float, st.tuples(st.integers(1, 12), st.integers(1, 3)), elements=st.integers(0, 4).map(float)))
def test_the_front_is_what_its_definition_says(objectives: np.ndarray) -> None:
    rows = non_dominated(objectives)
    members = objectives[rows]
    assert len(np.unique(members, axis=0)) == len(members)
    for row, vector in enumerate(objectives):
        beaten = any(dominates(other, vector) for other in objectives)
        first = not any(np.array_equal(vector, earlier) for earlier in objectives[:row])
        assert (row in rows) == (first and not beaten)
