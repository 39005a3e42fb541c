"""Optuna 5: its samplers TPE, CMA-ES and GP, one trial at a time, the start as trials that are finished already."""

import optuna
from optuna.distributions import BaseDistribution, FloatDistribution, IntDistribution
from serve import Run

DISTRIBUTIONS = ("optuna", "cmaes", "torch", "numpy", "scipy")
PRELOADED = ("cmaes", "torch", "scipy.optimize", "scipy.stats")


def _distributions(run: Run) -> dict[str, BaseDistribution]:
    return {
        f"x{k}": IntDistribution(int(lower), int(upper)) if integer else FloatDistribution(lower, upper)
        for k, (lower, upper, integer) in enumerate(zip(run.lower.tolist(), run.upper.tolist(), run.integer, strict=True))
    }


def _parameters(run: Run, point: list[float]) -> dict[str, float | int]:
    return {f"x{k}": int(x) if integer else x for k, (x, integer) in enumerate(zip(point, run.integer, strict=True))}


def _search(run: Run, sampler: optuna.samplers.BaseSampler) -> None:
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    study = optuna.create_study(sampler=sampler)
    distributions = _distributions(run)
    for point, value in zip(run.points.tolist(), run.values.tolist(), strict=True):
        parameters = _parameters(run, point)
        study.add_trial(optuna.trial.create_trial(params=parameters, distributions=distributions, value=value))
    while True:
        trial = study.ask(distributions)
        study.tell(trial, run.evaluate(list(trial.params.values())))


def tpe(run: Run) -> None:
    """Tree-structured Parzen estimator with Optuna's defaults."""
    _search(run, optuna.samplers.TPESampler(seed=run.seed))


def cma(run: Run) -> None:
    """CMA-ES from the best point of the start, with margins where there are integers."""
    start = _parameters(run, run.best_point.tolist())
    _search(run, optuna.samplers.CmaEsSampler(x0=start, seed=run.seed, with_margin=bool(run.integer.any())))


def gp(run: Run) -> None:
    """Gaussian process, told that values have no noise."""
    _search(run, optuna.samplers.GPSampler(seed=run.seed, deterministic_objective=True))


ALGORITHMS = {"tpe": tpe, "cma": cma, "gp": gp}
