"""The strategies are pymoo's own algorithms, design for design, and survive what a run does to them."""

from dataclasses import replace

import numpy as np
import pytest
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.algorithms.moo.nsga3 import NSGA3
from pymoo.algorithms.soo.nonconvex.de import DE
from pymoo.algorithms.soo.nonconvex.ga import GA
from pymoo.algorithms.soo.nonconvex.pso import PSO
from pymoo.core.problem import Problem
from pymoo.operators.crossover.sbx import SBX
from pymoo.operators.mutation.pm import PM
from pymoo.optimize import minimize
from pymoo.util.ref_dirs import get_reference_directions

from railsearch.errors import InputError
from railsearch.parameters import make_parameters
from railsearch.sampling import initial_design
from railsearch.seeding import run_generators
from railsearch.space import Space, Variable
from railsearch.testing import MIXED, REAL, Trial, run_trial
from railsearch_plugins.strategies.pymoo_algorithms import (
    DifferentialEvolution,
    GeneticAlgorithm,
    GeneticParameters,
    NonDominatedSortingGeneticAlgorithm,
    ParticleSwarm,
    ReferenceDirectionGeneticAlgorithm,
)

EVERY = pytest.mark.parametrize(
    ("plugin", "n_objectives"),
    [
        (GeneticAlgorithm, 1),
        (NonDominatedSortingGeneticAlgorithm, 2),
        (ReferenceDirectionGeneticAlgorithm, 2),
        (DifferentialEvolution, 1),
        (ParticleSwarm, 1),
    ],
)


def plain(plugin, first):
    """The algorithm as pymoo's own users would set it up, with a first population."""
    genetic = {"pop_size": 12, "sampling": first, "mutation": PM(eta=20)}
    if plugin is ReferenceDirectionGeneticAlgorithm:
        directions = get_reference_directions("das-dennis", 2, n_partitions=11)
        return NSGA3(directions, **genetic, crossover=SBX(prob=1.0, eta=30))
    if plugin is DifferentialEvolution:
        return DE(pop_size=12, sampling=first, variant="DE/best/1/bin", F=0.5, CR=0.9)
    if plugin is ParticleSwarm:
        return PSO(pop_size=12, sampling=first)
    kind = NSGA2 if plugin is NonDominatedSortingGeneticAlgorithm else GA
    return kind(**genetic, crossover=SBX(prob=0.9, eta=15))


def bowls(n_objectives):
    def objective(design):
        centres = 0.2 + 0.5 * np.arange(n_objectives)
        return np.array([np.sum((REAL.to_unit(design) - centre) ** 2) for centre in centres])

    return objective


class RecordedProblem(Problem):
    """The same problem under plain pymoo, with a list of every design evaluated."""

    def __init__(self, n_objectives):
        super().__init__(n_var=3, n_obj=n_objectives, n_ieq_constr=1, xl=REAL.lower, xu=REAL.upper)
        self.objective = bowls(n_objectives)
        self.designs = []

    def _evaluate(self, X, out, *args, **kwargs):
        self.designs += list(X)
        out["F"] = np.array([self.objective(x) for x in X])
        out["G"] = np.zeros((len(X), 1))


def undisturbed(plugin, n_objectives, budget=120, seed=4):
    trial = Trial(REAL, n_objectives, budget=budget, seed=seed)
    return run_trial(plugin, trial, {"population_size": 12}, objective=bowls(n_objectives))


@EVERY
def test_the_designs_are_those_of_plain_pymoo_from_the_same_seed_and_first_population(plugin, n_objectives):
    generators = run_generators(4)
    first = initial_design(REAL, 12, generators.initial)
    seed = int(generators.strategy.integers(2**32))
    problem = RecordedProblem(n_objectives)
    minimize(problem, plain(plugin, first), ("n_gen", 11), seed=seed)
    ours = [evaluation.design for evaluation in undisturbed(plugin, n_objectives)]
    theirs = list({design.tobytes(): design for design in problem.designs}.values())[: len(ours)]
    np.testing.assert_array_equal(ours, theirs)


def test_equal_violations_are_settled_by_the_seed():
    # pymoo's own comparison of NSGA-III draws from a generator without seed when both are equally infeasible
    trial = Trial(REAL, 2, budget=60, fails=lambda number: number % 3 > 0)
    runs = [run_trial(ReferenceDirectionGeneticAlgorithm, trial) for _ in range(3)]
    first, *others = [[e.design.tobytes() for e in run] for run in runs]
    assert all(other == first for other in others)


@pytest.mark.parametrize(("n_objectives", "size", "directions"), [(1, 10, 1), (2, 24, 24), (3, 20, 15), (5, 4, 5)])
def test_as_many_reference_directions_as_fit_the_population(n_objectives, size, directions):
    strategies = []

    class Kept(ReferenceDirectionGeneticAlgorithm):
        def __init__(self, context, parameters):
            super().__init__(context, parameters)
            strategies.append(self)

    run_trial(Kept, Trial(REAL, n_objectives, budget=2 * size), {"population_size": size})
    assert strategies[0]._generations.algorithm.ref_dirs.shape == (directions, n_objectives)


@EVERY
def test_designs_are_labelled_and_none_is_proposed_twice(plugin, n_objectives):
    evaluations = run_trial(plugin, Trial(MIXED, n_objectives, budget=120))
    assert [e.origin for e in evaluations] == ["initial"] * 12 + ["offspring"] * 108
    assert len({e.design.tobytes() for e in evaluations}) == 120


@EVERY
def test_the_population_is_a_tenth_of_the_budget_within_limits(plugin, n_objectives):
    for budget, size in ((30, 10), (240, 24)):
        evaluations = run_trial(plugin, Trial(REAL, n_objectives, budget=budget))
        assert sum(e.origin == "initial" for e in evaluations) == size


@EVERY
def test_batches_make_no_difference(plugin, n_objectives):
    runs = [run_trial(plugin, Trial(MIXED, n_objectives, budget=60, batch_size=size)) for size in (1, 4, 10)]
    first, *others = [[e.design.tobytes() for e in run] for run in runs]
    assert all(other == first for other in others)


@EVERY
def test_runs_side_by_side_share_nothing(plugin, n_objectives):
    alone = [e.design.tobytes() for e in undisturbed(plugin, n_objectives)]
    other = []

    class Interrupted(plugin):
        def ask(self):
            other.append(run_trial(plugin, Trial(MIXED, n_objectives, budget=25, seed=9)) if len(other) < 3 else None)
            return super().ask()

    assert [e.design.tobytes() for e in undisturbed(Interrupted, n_objectives)] == alone


@EVERY
def test_given_designs_join_the_first_population(plugin, n_objectives):
    strategies = []

    class Kept(plugin):
        def __init__(self, context, parameters):
            super().__init__(context, parameters)
            strategies.append(self)

    evaluations = run_trial(Kept, Trial(REAL, n_objectives, budget=13, given=3), {"population_size": 12})
    assert [e.origin for e in evaluations] == ["given"] * 3 + ["initial"] * 9 + ["offspring"]
    members = {tuple(x) for x in strategies[0]._generations.algorithm.pop.get("X")}
    assert members == {tuple(e.design) for e in evaluations[:12]}
    assert strategies[0]._generations.algorithm.evaluator.n_eval == 12


@EVERY
def test_failed_evaluations_are_infeasible_with_the_worst_values(plugin, n_objectives):
    strategies = []

    class Kept(plugin):
        def __init__(self, context, parameters):
            super().__init__(context, parameters)
            strategies.append(self)

    trial = Trial(REAL, n_objectives, budget=13, fails=lambda number: number in (2, 7))
    evaluations = run_trial(Kept, trial, {"population_size": 12})
    population = strategies[0]._generations.algorithm.pop
    by_design = {e.design.tobytes(): e for e in evaluations}
    worst = np.max([e.objectives for e in evaluations[:12] if not e.failed], axis=0)
    failed = [by_design[individual.X.tobytes()].failed for individual in population]
    assert sum(failed) == 2
    np.testing.assert_array_equal(~population.get("FEAS").ravel(), failed)
    np.testing.assert_array_equal(population[failed].get("F"), [worst, worst])


@EVERY
def test_failed_designs_die_out_of_the_population(plugin, n_objectives):
    strategies = []
    trial = Trial(REAL, n_objectives, budget=200)

    def objective(design):
        return np.full(n_objectives, np.nan) if design[0] < 0.0 else bowls(n_objectives)(design)

    class Failing(plugin):
        def __init__(self, context, parameters):
            super().__init__(context, parameters)
            strategies.append(self)

        def tell(self, evaluations):
            super().tell([replace(e, reason="x < 0") if np.isnan(e.objectives).any() else e for e in evaluations])

    evaluations = run_trial(Failing, trial, objective=objective)
    early, late = (np.mean([e.design[0] < 0.0 for e in part]) for part in (evaluations[:20], evaluations[-60:]))
    assert early > 0.25
    assert strategies[0]._generations.algorithm.pop.get("FEAS").all()
    if plugin is not ParticleSwarm:  # a swarm about a best design at the border goes on crossing it
        assert late < 0.5 * early


@EVERY
def test_constraints_are_respected_in_the_end(plugin, n_objectives):
    # the trial's constraint is u₁ ≤ 0.9; the objective pulls to u₁ = 1
    def objective(design):
        return np.array([np.sum((REAL.to_unit(design) - [1.0, 0.5, centre]) ** 2) for centre in range(n_objectives)])

    evaluations = run_trial(plugin, Trial(REAL, n_objectives, 1, budget=300), objective=objective)
    feasible = [e for e in evaluations if e.feasible]
    assert 0.85 < max(REAL.to_unit(e.design)[0] for e in feasible) <= 0.9
    assert np.mean([e.feasible for e in evaluations[-60:]]) > 0.4


@EVERY
def test_a_small_space_is_walked_through_to_its_last_design(plugin, n_objectives):
    space = Space((Variable("a", 0, 4, integer=True), Variable("b", 0, 4, integer=True)))
    evaluations = run_trial(plugin, Trial(space, n_objectives, budget=25))
    assert len({e.design.tobytes() for e in evaluations}) == 25


@EVERY
def test_an_evaluation_in_place_of_a_proposal_becomes_a_member(plugin, n_objectives):
    evaluations = run_trial(plugin, Trial(REAL, n_objectives, budget=60, strangers=True), {"population_size": 12})
    assert len({e.design.tobytes() for e in evaluations}) == 60
    assert [e.origin for e in evaluations[:12]] == [("unseen" if k % 5 == 4 else "initial") for k in range(12)]
    assert evaluations[12].origin == "offspring"


def test_bad_settings_are_refused():
    with pytest.raises(InputError, match=r"strategy ga\.population_size: allowed is ≥ 2, received 1"):
        make_parameters(GeneticParameters, {"population_size": 1}, "strategy ga")
