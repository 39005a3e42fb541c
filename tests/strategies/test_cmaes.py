"""CMA-ES is invariant where it has to be, learns the shape of the objective, handles integers and starts afresh."""

from dataclasses import replace

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from railsearch.space import Space, Variable
from railsearch.testing import MIXED, REAL, Trial, run_trial
from railsearch_plugins.strategies.cmaes import CovarianceMatrixAdaptation, ranked_values

SQUARE = Space(tuple(Variable(name, -5.0, 5.0) for name in "abc"))
HALF = Space(tuple(Variable(f"x{k}", -10.0, 10.0, integer=k > 1) for k in range(4)))


def ellipsoid(design):
    """Condition number 10⁴ along directions that are no axes; minimum 0 at 1."""
    rotation = np.linalg.qr(np.random.default_rng(0).normal(size=(len(design), len(design))))[0]
    return np.array([np.sum(np.logspace(0.0, 4.0, len(design)) * (rotation @ (design - 1.0)) ** 2)])


def designs(evaluations):
    return [evaluation.design.tobytes() for evaluation in evaluations]


def test_only_the_order_of_the_objective_counts():
    trial = Trial(REAL, budget=80)
    plain = run_trial(CovarianceMatrixAdaptation, trial, objective=lambda x: np.array([REAL.to_unit(x).sum()]))
    cubed = run_trial(CovarianceMatrixAdaptation, trial, objective=lambda x: np.array([5e6 * REAL.to_unit(x).sum() ** 3]))
    assert designs(plain) == designs(cubed)


def test_units_do_not_matter():
    stretched = Space(tuple(Variable(v.name, 1e3 * v.lower, 1e3 * v.upper) for v in SQUARE.variables))
    plain = run_trial(CovarianceMatrixAdaptation, Trial(SQUARE, budget=60), objective=ellipsoid)
    scaled = run_trial(CovarianceMatrixAdaptation, Trial(stretched, budget=60), objective=lambda x: ellipsoid(x / 1e3))
    np.testing.assert_allclose([e.design / 1e3 for e in scaled], [e.design for e in plain], rtol=1e-6)


def test_an_ill_conditioned_rotated_ellipsoid_is_solved():
    evaluations = run_trial(CovarianceMatrixAdaptation, Trial(SQUARE, budget=900), objective=ellipsoid)
    assert min(e.objectives[0] for e in evaluations) < 1e-8


def test_integers_are_found_and_go_on_being_varied():
    def objective(design):
        return np.array([np.sum((design - [1.5, -2.5, 7.0, -4.0]) ** 2)])

    evaluations = run_trial(CovarianceMatrixAdaptation, Trial(HALF, budget=400), objective=objective)
    assert min(e.objectives[0] for e in evaluations) < 1e-3
    late = {tuple(e.design[2:]) for e in evaluations[-60:] if e.trajectory == evaluations[-1].trajectory}
    assert len(late) > 3


def test_the_search_starts_at_the_best_of_the_initial_design():
    evaluations = run_trial(CovarianceMatrixAdaptation, Trial(SQUARE, budget=14, given=3), {"sigma_start": 0.01})
    initial = [e for e in evaluations if e.origin in ("given", "initial")]
    assert [e.origin for e in evaluations] == ["given"] * 3 + ["initial"] * 4 + ["sample"] * 7
    start = min(initial, key=lambda e: e.objectives[0]).design
    distances = [np.abs(SQUARE.to_unit(e.design) - SQUARE.to_unit(start)).max() for e in evaluations[7:]]
    assert 0.0 < max(distances) < 0.05


def test_a_search_that_has_shrunk_starts_afresh_with_twice_the_population():
    sizes = []

    class Counting(CovarianceMatrixAdaptation):
        def ask(self):
            proposals = super().ask()
            sizes.append((proposals[0].trajectory, proposals[0].origin, len(proposals)))
            return proposals

    trial = Trial(SQUARE, budget=600, batch_size=1000)
    evaluations = run_trial(Counting, trial, {"smallest_step": 0.01, "population_size": 8, "initial_size": 5})
    assert sizes[0] == (0, "initial", 5)
    assert {(trajectory, size) for trajectory, origin, size in sizes if origin == "sample"} >= {(0, 8), (1, 16), (2, 32)}
    assert evaluations[-1].trajectory >= 2


def test_failed_and_infeasible_designs_are_left_behind():
    def failing(design):
        return np.array([np.nan if design[0] < 0.0 else design[0] + np.sum(design[1:] ** 2)])

    class Failing(CovarianceMatrixAdaptation):
        def tell(self, evaluations):
            super().tell([replace(e, reason="x < 0") if np.isnan(e.objectives).any() else e for e in evaluations])

    evaluations = run_trial(Failing, Trial(SQUARE, budget=300), objective=failing)
    assert min(e.objectives[0] for e in evaluations if e.objectives[0] >= 0.0) < 0.05

    def pulled(design):
        return np.array([np.sum((REAL.to_unit(design) - [1.0, 0.5, 0.5]) ** 2)])

    constrained = run_trial(CovarianceMatrixAdaptation, Trial(REAL, 1, 1, budget=300), objective=pulled)
    assert 0.89 < REAL.to_unit(min((e for e in constrained if e.feasible), key=lambda e: e.objectives[0]).design)[0] <= 0.9


def test_no_design_is_proposed_twice():
    evaluations = run_trial(CovarianceMatrixAdaptation, Trial(MIXED, budget=200))
    assert len(set(designs(evaluations))) == 200


@given(
    arrays(float, 6, elements=st.sampled_from([-1e12, -3.0, 0.0, 1e-12, 2e-12, 5.0, 1e12])),
    arrays(float, (6, 2), elements=st.sampled_from([-1.0, 0.0, 0.5, 2.0])),
)
def test_values_order_designs_by_feasibility_then_objective_or_violation(objective, constraints):
    values = ranked_values(objective, constraints)
    violation = np.maximum(constraints, 0.0).sum(axis=1)
    for i in range(6):
        for j in range(6):
            if violation[i] == violation[j] == 0.0 and objective[i] < objective[j]:
                assert values[i] < values[j]
            if violation[i] < violation[j]:
                assert values[i] < values[j]
