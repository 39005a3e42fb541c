"""Any pymoo algorithm instance is a strategy: the same designs as under pymoo, within a budget, with what a run brings."""

import numpy as np
import pytest
from pymoo.algorithms.moo.moead import MOEAD
from pymoo.algorithms.moo.mopso_cd import MOPSO_CD
from pymoo.algorithms.moo.nsga2 import NSGA2, RankAndCrowdingSurvival
from pymoo.algorithms.moo.rvea import RVEA
from pymoo.algorithms.moo.sms import SMSEMOA
from pymoo.algorithms.soo.nonconvex.cmaes import CMAES
from pymoo.algorithms.soo.nonconvex.es import ES
from pymoo.algorithms.soo.nonconvex.ga import GA
from pymoo.algorithms.soo.nonconvex.nelder import NelderMead
from pymoo.algorithms.soo.nonconvex.pattern import PatternSearch
from pymoo.core.mixed import MixedVariableGA
from pymoo.core.problem import Problem
from pymoo.optimize import minimize
from pymoo.util.ref_dirs import get_reference_directions

import railsearch
from railsearch.errors import InputError, PluginError
from railsearch.plugin_manager import load_plugins
from railsearch.run import RunSettings, run_search
from railsearch.seeding import run_generators
from railsearch.testing import MIXED, REAL, Trial, check_strategy, run_trial
from sample_problems import Sphere, TwoObjectives

DIRECTIONS = get_reference_directions("das-dennis", 2, n_partitions=9)


def bowls(n_objectives):
    centres = 0.2 + 0.5 * np.arange(n_objectives)
    return lambda design: np.array([np.sum((REAL.to_unit(design) - centre) ** 2) for centre in centres])


class Recorded(Problem):
    """The bowls under plain pymoo, with a list of every design evaluated."""

    def __init__(self, n_objectives, n_constraints):
        super().__init__(n_var=3, n_obj=n_objectives, n_ieq_constr=n_constraints, xl=REAL.lower, xu=REAL.upper)
        self.designs = []

    def _evaluate(self, X, out, *args, **kwargs):
        self.designs += list(np.array(X))
        out["F"] = np.array([bowls(self.n_obj)(x) for x in X])
        out["G"] = np.zeros((len(X), self.n_ieq_constr))


@pytest.mark.parametrize(
    ("make", "n_objectives"),
    [
        (lambda: GA(pop_size=10), 1),
        (lambda: ES(pop_size=6, n_offsprings=12), 1),
        (CMAES, 1),
        (NelderMead, 1),
        (lambda: SMSEMOA(pop_size=10), 2),
        (lambda: RVEA(DIRECTIONS), 2),
        (lambda: MOEAD(DIRECTIONS, n_neighbors=4), 2),
    ],
)
def test_the_designs_are_those_of_plain_pymoo_from_the_same_seed(make, n_objectives):
    constrained = not isinstance(make(), MOEAD)
    plugin = railsearch.pymoo_strategy(make(), constraints=constrained)
    assert plugin.capabilities.multi_objective == (n_objectives == 2)
    ours = run_trial(plugin, Trial(REAL, n_objectives, budget=50, seed=4), objective=bowls(n_objectives))
    problem = Recorded(n_objectives, int(constrained))
    minimize(problem, make(), ("n_eval", 50), seed=int(run_generators(4).strategy.integers(2**32)))
    theirs = list({design.tobytes(): design for design in problem.designs}.values())
    compared = min(len(ours), len(theirs))
    assert compared > 35
    np.testing.assert_array_equal([e.design for e in ours[:compared]], theirs[:compared])


@pytest.mark.parametrize("algorithm", [NSGA2(pop_size=8), NelderMead(), CMAES()], ids=lambda a: type(a).__name__)
def test_an_algorithm_made_a_strategy_passes_the_conformance_suite(algorithm):
    check_strategy(railsearch.pymoo_strategy(algorithm))


def test_an_instance_is_searched_with_under_a_name_and_is_not_altered():
    algorithm = NSGA2(pop_size=8)
    registry = load_plugins().extended("strategy", "my-nsga2", railsearch.pymoo_strategy(algorithm))
    given = [np.array([1.5, 1.0, 0.0, 0.0])]
    runs = [run_search(registry, TwoObjectives(), RunSettings("my-nsga2", 30, 2), given) for _ in range(2)]
    first, second = [[e.design.tobytes() for e in run.evaluations] for run in runs]
    assert first == second
    assert [e.origin for e in runs[0].evaluations] == ["given"] + ["initial"] * 7 + ["offspring"] * 22
    assert algorithm.problem is None
    assert algorithm.pop is None
    with pytest.raises(PluginError, match="registered twice"):
        registry.extended("strategy", "my-nsga2", railsearch.pymoo_strategy(GA()))


def test_designs_that_are_dictionaries_are_understood():
    algorithm = MixedVariableGA(pop_size=8, survival=RankAndCrowdingSurvival())
    plugin = railsearch.pymoo_strategy(algorithm, multi_objective=True)
    evaluations = run_trial(plugin, Trial(MIXED, 2, budget=40, given=2, strangers=True))
    assert len({e.design.tobytes() for e in evaluations}) == 40


def test_a_local_search_that_has_converged_starts_again_elsewhere():
    algorithm = CMAES(tolx=1e-3)
    evaluations = run_trial(railsearch.pymoo_strategy(algorithm), Trial(REAL, budget=500), objective=bowls(1))
    assert evaluations[-1].trajectory > 0
    assert min(e.objectives[0] for e in evaluations) < 1e-4


def test_what_an_algorithm_draws_without_a_seed_follows_from_that_of_the_run():
    strategy = railsearch.pymoo_strategy(PatternSearch())
    first, second = (run_trial(strategy, Trial(REAL, budget=40, seed=3), objective=bowls(1)) for _ in range(2))
    np.testing.assert_array_equal(*([evaluation.design for evaluation in run] for run in (first, second)))
    assert np.random.default_rng(5).random() == np.random.Generator(np.random.PCG64(5)).random()


def test_what_cannot_be_made_a_strategy_is_refused():
    with pytest.raises(InputError, match="an instance of pymoo's Algorithm is needed"):
        railsearch.pymoo_strategy(NSGA2)
    used = GA(pop_size=5)
    used.setup(Recorded(1, 0))
    with pytest.raises(InputError, match="not been set up"):
        railsearch.pymoo_strategy(used)
    with pytest.raises(PluginError, match="outside ask and tell"):
        run_trial(railsearch.pymoo_strategy(MOPSO_CD(pop_size=5)), Trial(REAL, 2))
    with pytest.raises(PluginError, match="constraints=False"):
        run_trial(railsearch.pymoo_strategy(MOEAD(DIRECTIONS)), Trial(REAL, 2))


def test_one_objective_is_all_that_a_single_objective_algorithm_gets():
    registry = load_plugins().extended("strategy", "my-ga", railsearch.pymoo_strategy(GA(pop_size=5)))
    with pytest.raises(Exception, match="my-ga handles one objective"):
        run_search(registry, TwoObjectives(), RunSettings("my-ga", 30, 2))
    assert len(run_search(registry, Sphere(), RunSettings("my-ga", 30, 2)).evaluations) == 30


def test_a_failure_inside_an_algorithm_says_whose_it_is():
    class Fragile(GA):
        def _infill(self):
            raise ValueError("no parents left")

    strategy = railsearch.pymoo_strategy(Fragile(pop_size=10))
    with pytest.raises(PluginError, match="Fragile of pymoo cannot go on: ValueError: no parents left"):
        run_trial(strategy, Trial(REAL, budget=30))
