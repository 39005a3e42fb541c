"""SMAC3 2.4, begun with the start: its facade for numeric black boxes, a Gaussian process with expected improvement, and the
one for hyperparameters, a random forest with expected improvement of the logarithm, which needs a tenth of the time.
"""

import tempfile
from pathlib import Path

from ConfigSpace import Configuration, ConfigurationSpace, Float, Integer
from serve import Run
from smac import BlackBoxFacade, HyperparameterOptimizationFacade, Scenario
from smac.facade import AbstractFacade
from smac.initial_design import AbstractInitialDesign

DISTRIBUTIONS = ("smac", "ConfigSpace", "scikit-learn", "numpy", "scipy")
ENDLESS = 1_000_000


class StartDesign(AbstractInitialDesign):
    """The start, handed over as additional configurations, and nothing else."""

    def _select_configurations(self) -> list[Configuration]:
        return []


def _space(run: Run) -> ConfigurationSpace:
    space = ConfigurationSpace(seed=run.seed)
    for k, (lower, upper, integer) in enumerate(zip(run.lower.tolist(), run.upper.tolist(), run.integer, strict=True)):
        space.add(Integer(f"x{k}", (int(lower), int(upper))) if integer else Float(f"x{k}", (lower, upper)))
    return space


def _parameters(run: Run, point: list[float]) -> dict[str, float | int]:
    return {f"x{k}": int(x) if integer else x for k, (x, integer) in enumerate(zip(point, run.integer, strict=True))}


def _search(facade: type[AbstractFacade], run: Run) -> None:
    """Search without noise, one evaluation at a time; no end."""
    space = _space(run)
    start = [Configuration(space, values=_parameters(run, point)) for point in run.points.tolist()]

    def value(config: Configuration, seed: int = 0) -> float:
        return run.evaluate([config[f"x{k}"] for k in range(run.dimension)])

    with tempfile.TemporaryDirectory() as folder:
        scenario = Scenario(space, output_directory=Path(folder), deterministic=True, n_trials=ENDLESS, seed=run.seed)
        design = StartDesign(scenario, n_configs=0, additional_configs=start)
        facade(scenario, value, initial_design=design, logging_level=False, overwrite=True).optimize()


def black_box(run: Run) -> None:
    """Gaussian process."""
    _search(BlackBoxFacade, run)


def random_forest(run: Run) -> None:
    """Random forest."""
    _search(HyperparameterOptimizationFacade, run)


ALGORITHMS = {"black-box": black_box, "random-forest": random_forest}
