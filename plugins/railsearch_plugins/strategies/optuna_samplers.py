"""Strategies `optuna-tpe`, `optuna-gp`, `optuna-cma`, `optuna-nsgaii` and `optuna-random`: samplers of Optuna."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from railsearch.hookspecs import Register, hookimpl
from railsearch.interfaces import Capabilities, NoParameters, parameter
from railsearch.space import FloatArray
from railsearch.wording import install_remedy
from railsearch_plugins.optuna_study import OptunaStrategy

if TYPE_CHECKING:
    from optuna.samplers import BaseSampler
    from optuna.study import Study
    from optuna.trial import Trial

UNUSED = "(unused)"
"""A second variable for CMA-ES, which knows no covariance of a single one."""


@dataclass(frozen=True)
class TreeParzenParameters:
    """What can be set of TPE."""

    startup: int = parameter(10, meaning="random designs before the first model", source="Optuna 5.0", minimum=1)
    candidates: int = parameter(24, meaning="designs drawn to choose a proposal from", source="Optuna 5.0", minimum=1)


@dataclass(frozen=True)
class GaussianProcessParameters:
    """What can be set of the Gaussian process search."""

    startup: int = parameter(10, meaning="random designs before the first model", source="Optuna 5.0", minimum=1)
    deterministic: bool = parameter(
        False, meaning="fix the noise of the objective at nearly nothing instead of estimating it", source="Optuna 5.0"
    )


@dataclass(frozen=True)
class CovarianceParameters:
    """What can be set of CMA-ES."""

    population_size: int | None = parameter(
        None, meaning="designs per generation; if not given, 4 + 3 ln d", source="Hansen 2016", minimum=5
    )
    sigma_start: float | None = parameter(
        None,
        meaning="step size at the start; if not given, a sixth of the range",
        unit="of the range",
        source="Optuna 5.0",
        above=0.0,
        maximum=1.0,
    )


@dataclass(frozen=True)
class GeneticParameters:
    """What can be set of NSGA-II."""

    population_size: int | None = parameter(
        None,
        meaning="designs per generation; if not given, a tenth of the budget, but 10 to 100",
        source="own choice: Optuna's 50 leave four generations of a budget of 200",
        minimum=2,
    )
    crossover_probability: float = parameter(
        0.9, meaning="probability that a child has two parents", source="Optuna 5.0", minimum=0.0, maximum=1.0
    )
    swapping_probability: float = parameter(
        0.5, meaning="probability that a variable comes from the other parent", source="Optuna 5.0", minimum=0.0, maximum=1.0
    )


class TreeParzenEstimator(OptunaStrategy[TreeParzenParameters]):
    """TPE of Optuna: proposes where the better designs are dense and the worse ones are not (Watanabe 2023)."""

    Parameters = TreeParzenParameters
    capabilities = Capabilities(multi_objective=True, integers=True, constraints=True, batch=True)
    ranks_failures = True

    def _sampler(self, seed: int) -> "BaseSampler":
        from optuna.samplers import TPESampler

        return TPESampler(seed=seed, n_startup_trials=self._parameters.startup, n_ei_candidates=self._parameters.candidates)


class GaussianProcessSearch(OptunaStrategy[GaussianProcessParameters]):
    """Gaussian process search of Optuna with expected (hypervolume) improvement; needs PyTorch."""

    Parameters = GaussianProcessParameters
    capabilities = Capabilities(multi_objective=True, integers=True, constraints=True, batch=True)
    requires = ("torch", install_remedy("gp"))

    def _sampler(self, seed: int) -> "BaseSampler":
        from optuna.samplers import GPSampler

        return GPSampler(
            seed=seed,
            n_startup_trials=self._parameters.startup,
            deterministic_objective=self._parameters.deterministic,
            warn_independent_sampling=False,
        )


class CovarianceMatrixAdaptation(OptunaStrategy[CovarianceParameters]):
    """CMA-ES of Optuna from the best given design, with margin where there are integers (Hamano et al. 2022)."""

    Parameters = CovarianceParameters
    capabilities = Capabilities(integers=True, batch=True)
    repeats_count = True

    def _sampler(self, seed: int) -> "BaseSampler":
        from optuna.distributions import FloatDistribution
        from optuna.samplers import CmaEsSampler

        if len(self._distributions) == 1:
            self._distributions[UNUSED] = FloatDistribution(0.0, 1.0)
        successes = [evaluation for evaluation in self._told.values() if not evaluation.failed]
        best = min(successes, key=lambda evaluation: float(evaluation.objectives[0]), default=None)
        return CmaEsSampler(
            x0=None if best is None else self._params(best.design),
            sigma0=self._parameters.sigma_start,
            seed=seed,
            popsize=self._parameters.population_size,
            with_margin=bool(self._context.space.integer.any()),
            warn_independent_sampling=False,
        )

    def _params(self, design: FloatArray) -> dict[str, Any]:
        return super()._params(design) | ({UNUSED: 0.5} if UNUSED in self._distributions else {})


class NonDominatedSortingGeneticAlgorithm(OptunaStrategy[GeneticParameters]):
    """NSGA-II of Optuna: uniform crossover, mutation by drawing anew (Deb et al. 2002)."""

    Parameters = GeneticParameters
    capabilities = Capabilities(multi_objective=True, integers=True, constraints=True, batch=True)
    ranks_failures = True
    repeats_count = True

    def _sampler(self, seed: int) -> "BaseSampler":
        from optuna.samplers import NSGAIISampler

        return NSGAIISampler(
            population_size=self._parameters.population_size or int(np.clip(self._context.budget // 10, 10, 100)),
            crossover_prob=self._parameters.crossover_probability,
            swapping_prob=self._parameters.swapping_probability,
            seed=seed,
        )

    def _member(self, study: "Study", design: FloatArray) -> "Trial | None":
        """A trial at the design; the sampler gives a generation only to trials that it has drawn, or when it is asked."""
        from optuna.samplers import NSGAIISampler

        study.enqueue_trial(self._params(design))
        trial = study.ask(self._distributions)
        assert isinstance(study.sampler, NSGAIISampler), "the sampler is the one made here"
        study.sampler.get_trial_generation(study, study.get_trials(deepcopy=False)[trial.number])
        return trial


class RandomSampling(OptunaStrategy[NoParameters]):
    """Random search of Optuna."""

    Parameters = NoParameters
    capabilities = Capabilities(multi_objective=True, integers=True, constraints=True, batch=True)

    def _sampler(self, seed: int) -> "BaseSampler":
        from optuna.samplers import RandomSampler

        return RandomSampler(seed=seed)


@hookimpl
def railsearch_strategies(register: Register) -> None:
    """Register `optuna-tpe`, `optuna-gp`, `optuna-cma`, `optuna-nsgaii` and `optuna-random`."""
    register("optuna-tpe", TreeParzenEstimator)
    register("optuna-gp", GaussianProcessSearch)
    register("optuna-cma", CovarianceMatrixAdaptation)
    register("optuna-nsgaii", NonDominatedSortingGeneticAlgorithm)
    register("optuna-random", RandomSampling)
