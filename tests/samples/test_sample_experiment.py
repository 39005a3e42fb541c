import dataclasses

import numpy as np
import pytest
from uncertain_problem import DISTRIBUTIONS, SPACE, Uncertain

from railsearch.design_problem import DesignProblem, ScalarisedProblem
from railsearch.distributions import random_vector
from railsearch.errors import InputError
from railsearch.interfaces import Outcome, Quantity
from railsearch.plugin_manager import load_plugins
from railsearch.run import MemoryRecord, RunSettings, run_search
from railsearch.samples import Experiment, ExperimentDesign, designs_of, input_distributions
from railsearch.space import FloatArray, Space, Variable
from sample_problems import Sphere, TwoObjectives

EVERY_DESIGN = list(ExperimentDesign)


class Whole(DesignProblem):
    """An integer from −2 to 5 and a real variable from 1 to 3, without distributions."""

    def __init__(self) -> None:
        variables = (Variable("whole", -2, 5, integer=True), Variable("real", 1.0, 3.0))
        super().__init__("whole", Space(variables), [Quantity("y")])

    def simulate(self, design: FloatArray) -> Outcome:
        return Outcome(design[:1])


@pytest.mark.parametrize("design", EVERY_DESIGN)
def test_the_same_experiment_has_the_same_designs_and_another_seed_has_others(design: ExperimentDesign) -> None:
    experiment = Experiment(design, 33, 5)
    designs = designs_of(Uncertain(), experiment)
    np.testing.assert_array_equal(designs, designs_of(Uncertain(), experiment))
    assert not np.isin(designs[:, :2], designs_of(Uncertain(), dataclasses.replace(experiment, seed=6))[:, :2]).any()


@pytest.mark.parametrize("design", EVERY_DESIGN)
def test_without_distributions_designs_are_uniform_and_whole_numbers_equally_likely(design: ExperimentDesign) -> None:
    whole, real = designs_of(Whole(), Experiment(design, 4096, 1)).T
    numbers, counts = np.unique(whole, return_counts=True)
    np.testing.assert_array_equal(numbers, np.arange(-2, 6))
    # Eight equal cells of 512; five standard deviations of a binomial count.
    assert np.all(np.abs(counts - 512) < 5 * np.sqrt(4096 / 8 * 7 / 8))
    assert real.min() >= 1.0
    assert real.max() <= 3.0
    # The mean of 4096 uniform numbers over a width of 2.
    assert abs(real.mean() - 2.0) < 5 * (2.0 / np.sqrt(12.0)) / 64


def test_random_designs_are_those_of_a_random_search() -> None:
    record = MemoryRecord()
    run_search(load_plugins(), Sphere(), RunSettings("random", 40, 3), record=record)
    searched = np.array([evaluation.design for evaluation in record.evaluations])
    np.testing.assert_array_equal(designs_of(Sphere(), Experiment(ExperimentDesign.RANDOM, 40, 3)), searched)


@pytest.mark.parametrize("design", EVERY_DESIGN)
def test_samples_follow_the_distributions_beyond_the_bounds_of_the_search(design: ExperimentDesign) -> None:
    designs = designs_of(Uncertain(), Experiment(design, 2000, 2))
    vector = random_vector(DISTRIBUTIONS)
    assert (designs[:, 0] < SPACE.lower[0]).any()
    assert (designs[:, 0] > SPACE.upper[0]).any()
    assert (np.abs(designs[:, 1]) > SPACE.upper[1]).any()
    for k in (0, 1):
        levels = np.sort(vector.cdf(designs)[:, k])
        # Kolmogorov's distance: 1.95/√n is exceeded by chance once in a thousand times.
        assert np.max(np.abs(levels - (np.arange(2000) + 0.5) / 2000)) < 1.95 / np.sqrt(2000)
    numbers, counts = np.unique(designs[:, 2], return_counts=True)
    np.testing.assert_array_equal(numbers, [1.0, 2.0, 3.0])
    # The triangular distribution grows from 0.5: F(k + 1/2) − F(k − 1/2) = (2k − 1)/9.
    np.testing.assert_allclose(counts / 2000, np.array([1, 3, 5]) / 9, atol=0.05)


@pytest.mark.parametrize("design", [design for design in EVERY_DESIGN if design.extensible])
@pytest.mark.parametrize("problem", [Uncertain(), Sphere()])
def test_extensible_designs_begin_with_the_smaller_ones(design: ExperimentDesign, problem: DesignProblem) -> None:
    larger = designs_of(problem, Experiment(design, 301, 4))
    for number in (1, 2, 3, 8, 64, 129, 300):
        np.testing.assert_array_equal(designs_of(problem, Experiment(design, number, 4)), larger[:number])


def test_a_latin_hypercube_cannot_be_extended() -> None:
    assert not ExperimentDesign.LHS.extensible
    smaller, larger = (designs_of(Sphere(), Experiment(ExperimentDesign.LHS, number, 4)) for number in (20, 40))
    assert not np.isin(smaller[:, 0], larger[:, 0]).any()


def test_a_scalarised_problem_has_the_distributions_of_its_base() -> None:
    base = TwoObjectives()
    base.distributions = random_vector({name: {"distribution": "normal", "mean": 0, "std": 1} for name in base.space.names})
    scalarised = ScalarisedProblem(base, "sum", lambda values: values.sum(axis=1))
    assert input_distributions(scalarised) is base.distributions


def test_distributions_must_be_those_of_the_variables() -> None:
    class Mistaken(Whole):
        def __init__(self) -> None:
            vector = random_vector({name: {"distribution": "normal", "mean": 0.0, "std": 1.0} for name in ("real", "whole")})
            DesignProblem.__init__(self, "mistaken", Whole().space, [Quantity("y")], distributions=vector)

    with pytest.raises(InputError, match=r"distributions: those of whole, real .* in this order, received real, whole"):
        Mistaken()


def test_an_experiment_needs_a_design() -> None:
    with pytest.raises(InputError, match="number: an integer ≥ 1 is needed, received 0"):
        Experiment(ExperimentDesign.SOBOL, 0, 1)
