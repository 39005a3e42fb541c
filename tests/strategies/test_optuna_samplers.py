"""The samplers propose what Optuna itself proposes, and are told what a run evaluates."""

import importlib.util
import warnings

import numpy as np
import optuna
import pytest
from optuna.trial import TrialState

from railsearch.errors import PluginError
from railsearch.plugin_manager import load_plugins
from railsearch.run import RunSettings, make_strategy
from railsearch.seeding import run_generators
from railsearch.space import Space, Variable
from railsearch.testing import MIXED, REAL, Trial, run_trial
from railsearch_plugins.strategies.optuna_samplers import (
    CovarianceMatrixAdaptation,
    GaussianProcessSearch,
    NonDominatedSortingGeneticAlgorithm,
    RandomSampling,
    TreeParzenEstimator,
)
from sample_problems import Sphere

EVERY = [
    (RandomSampling, lambda seed: optuna.samplers.RandomSampler(seed=seed)),
    (TreeParzenEstimator, lambda seed: optuna.samplers.TPESampler(seed=seed)),
    (CovarianceMatrixAdaptation, lambda seed: optuna.samplers.CmaEsSampler(seed=seed)),
    (NonDominatedSortingGeneticAlgorithm, lambda seed: optuna.samplers.NSGAIISampler(population_size=10, seed=seed)),
]


def bowl(space, n_objectives=1):
    return lambda design: np.array([np.sum((space.to_unit(design) - c) ** 2) for c in (0.2, 0.7)[:n_objectives]])


def kept(plugin):
    """The strategy class, and the list that will hold what was made of it."""
    made = []

    class Kept(plugin):
        def __init__(self, context, parameters):
            super().__init__(context, parameters)
            made.append(self)

    return Kept, made


def optuna_designs(make, space, n_objectives, n_trials, seed):
    """What Optuna's own loop evaluates."""
    study = optuna.create_study(directions=["minimize"] * n_objectives, sampler=make(seed))

    def objective(trial):
        design = np.array([trial.suggest_float(v.name, v.lower, v.upper) for v in space.variables])
        return tuple(bowl(space, n_objectives)(design).tolist())

    optuna.logging.set_verbosity(optuna.logging.ERROR)
    study.optimize(objective, n_trials)
    return [list(trial.params.values()) for trial in study.trials]


@pytest.mark.parametrize(("plugin", "make"), EVERY, ids=lambda value: getattr(value, "__name__", ""))
def test_the_designs_are_those_of_optunas_own_loop(plugin, make):
    seed = int(run_generators(4).strategy.integers(2**32))
    for n_objectives in (1, 2) if plugin.capabilities.multi_objective else (1,):
        ours = run_trial(plugin, Trial(REAL, n_objectives, budget=45, seed=4), objective=bowl(REAL, n_objectives))
        theirs = list(dict.fromkeys(map(tuple, optuna_designs(make, REAL, n_objectives, 60, seed))))
        np.testing.assert_array_equal([e.design for e in ours], theirs[:45])


@pytest.mark.parametrize("plugin", [plugin for plugin, _ in EVERY])
def test_what_fails_and_what_was_not_asked_for_is_told(plugin):
    plugin, made = kept(plugin)
    trial = Trial(MIXED, budget=25, given=4, strangers=True, fails=lambda number: number in (2, 6, 14))
    evaluations = run_trial(plugin, trial)
    told = {tuple(t.params[name] for name in MIXED.names): t for t in made[0]._study.trials if t.state != TrialState.RUNNING}
    for evaluation in evaluations:
        stored = told[tuple(evaluation.design)]
        if not evaluation.failed:
            assert stored.values == evaluation.objectives.tolist()
        elif plugin.ranks_failures:
            assert stored.constraints["failed"] == 1.0
            assert stored.value == max(e.objectives[0] for e in evaluations[: max(evaluation.number, 4)] if not e.failed)
        else:
            assert stored.state == TrialState.FAIL
        assert all(isinstance(stored.params[name], int) for name in ("k", "flag"))


def test_nothing_is_known_of_failures_before_the_first_success():
    plugin, made = kept(TreeParzenEstimator)
    run_trial(plugin, Trial(MIXED, budget=8, fails=lambda number: number < 4 or number == 6))
    states = [trial.state for trial in made[0]._study.trials]
    assert states == [TrialState.FAIL] * 4 + [TrialState.COMPLETE] * 4


def test_given_designs_are_members_of_the_first_generation():
    plugin, made = kept(NonDominatedSortingGeneticAlgorithm)
    evaluations = run_trial(plugin, Trial(MIXED, budget=30, given=4), {"population_size": 10})
    study = made[0]._study
    first = {tuple(t.params[name] for name in MIXED.names) for t in study.sampler.get_population(study, 0)}
    assert first == {tuple(e.design) for e in evaluations[:10]}


def test_cma_starts_at_the_best_given_design():
    trial = Trial(REAL, budget=12, given=5)
    evaluations = run_trial(CovarianceMatrixAdaptation, trial, {"sigma_start": 0.01})
    start = REAL.to_unit(min(evaluations[:5], key=lambda e: e.objectives[0]).design)
    assert np.abs([REAL.to_unit(e.design) - start for e in evaluations[5:]]).max() < 0.06


def test_cma_with_margin_finds_integers_and_goes_on_varying_them():
    space = Space(tuple(Variable(f"x{k}", -10.0, 10.0, integer=k > 1) for k in range(4)))
    optimum = np.array([1.5, -2.5, 7.0, -4.0])
    trial = Trial(space, budget=400)
    evaluations = run_trial(CovarianceMatrixAdaptation, trial, objective=lambda x: np.array([np.sum((x - optimum) ** 2)]))
    best = min(evaluations, key=lambda e: e.objectives[0])
    np.testing.assert_array_equal(best.design[2:], optimum[2:])
    assert best.objectives[0] < 0.05
    assert len({tuple(e.design[2:]) for e in evaluations[-60:]}) > 3


@pytest.mark.parametrize("plugin", [TreeParzenEstimator, NonDominatedSortingGeneticAlgorithm])
def test_constraints_are_respected_in_the_end(plugin):
    # the trial's constraint is u₁ ≤ 0.9; the objective pulls to u₁ = 1
    trial = Trial(REAL, 1, 1, budget=150)
    evaluations = run_trial(plugin, trial, objective=lambda x: np.array([np.sum((REAL.to_unit(x) - [1.0, 0.5, 0.5]) ** 2)]))
    feasible = [e for e in evaluations if e.feasible]
    assert 0.8 < REAL.to_unit(min(feasible, key=lambda e: e.objectives[0]).design)[0] <= 0.9
    assert np.mean([e.feasible for e in evaluations[-50:]]) > 0.6


@pytest.mark.parametrize("plugin", [plugin for plugin, _ in EVERY])
def test_no_design_is_proposed_twice_and_none_is_left_out(plugin):
    space = Space((Variable("a", 0, 4, integer=True), Variable("b", 0, 4, integer=True)))
    evaluations = run_trial(plugin, Trial(space, budget=25, batch_size=3))
    assert len({e.design.tobytes() for e in evaluations}) == 25


def test_optuna_is_quiet_and_left_as_it_was(capfd):
    optuna.logging.set_verbosity(optuna.logging.DEBUG)
    try:
        with warnings.catch_warnings(action="error"):
            run_trial(CovarianceMatrixAdaptation, Trial(MIXED, budget=15, fails=lambda number: number % 3 == 0))
        assert optuna.logging.get_verbosity() == optuna.logging.DEBUG
    finally:
        optuna.logging.set_verbosity(optuna.logging.WARNING)
    assert capfd.readouterr() == ("", "")


def test_without_torch_the_gaussian_process_says_what_to_install(monkeypatch):
    find = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == "torch" else find(name))
    with pytest.raises(PluginError, match=r"torch, which is not installed: `\.venv/bin/pip install '\.\[gp\]'`"):
        make_strategy(load_plugins(), Sphere(), RunSettings("optuna-gp", 20, 1))


@pytest.mark.torch
def test_the_gaussian_process_solves_a_bowl_in_few_evaluations():
    evaluations = run_trial(GaussianProcessSearch, Trial(REAL, budget=22), {"startup": 6}, objective=bowl(REAL))
    assert min(e.objectives[0] for e in evaluations) < 1e-3
