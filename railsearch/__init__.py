"""railsearch: search for better railway transition zones on a budget of expensive simulations."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from railsearch.errors import InputError, PluginError

if TYPE_CHECKING:
    from pymoo.core.algorithm import Algorithm

    from railsearch.design_problem import DesignProblem
    from railsearch.pymoo_algorithm import StrategyAlgorithm
    from railsearch.pymoo_generations import PymooStrategy
    from railsearch.space import FloatArray

__all__ = ["algorithm", "problem", "pymoo_strategy"]


def problem(
    name: str,
    objectives: Sequence[str] = (),
    sections: Mapping[str, Any] | None = None,
    scalariser: str | None = None,
    scalariser_settings: Mapping[str, object] | None = None,
) -> "DesignProblem":
    """A registered problem as a pymoo `Problem`, ready for `pymoo.optimize.minimize`.

    objectives: names, empty for the problem's default ones; sections: what a site file would set, as nested dictionaries;
    scalariser: name of a scalariser that makes one objective of many. Raises PluginError for an unknown name and InputError
    for a value that is not allowed.
    """
    from railsearch.plugin_manager import load_plugins
    from railsearch.problem_factory import ProblemSettings, make_problem

    if isinstance(objectives, str):
        raise InputError(f"objectives: a list of names is needed, received {objectives!r}")
    settings = ProblemSettings(name, tuple(objectives), sections or {}, scalariser, scalariser_settings or {})
    return make_problem(load_plugins(), settings)


def algorithm(
    strategy: "str | type[Any]",
    budget: int,
    settings: Mapping[str, object] | None = None,
    given: "Sequence[FloatArray]" = (),
) -> "StrategyAlgorithm":
    """A strategy as a pymoo `Algorithm`, for `pymoo.optimize.minimize(problem, algorithm, seed=…)`.

    It works on any pymoo problem with bounds and ends exactly at the budget. strategy: the name of a registered one, or a
    class; settings: those of the strategy that differ from its defaults; given: designs (d,) to evaluate first. Raises
    PluginError for an unknown name, and for a class that is not a strategy.
    """
    from railsearch.plugin_manager import load_plugins
    from railsearch.pymoo_algorithm import StrategyAlgorithm

    if not isinstance(strategy, str | type):
        raise PluginError(
            f"strategy: the name of one, or a class, is needed, received {strategy!r}; `railsearch.pymoo_strategy` makes a "
            "class of a pymoo algorithm"
        )
    registry, name = load_plugins(), strategy if isinstance(strategy, str) else strategy.__name__
    if not isinstance(strategy, str):
        registry = registry.extended("strategy", name, strategy)
    registry.entry("strategy", name)
    return StrategyAlgorithm(registry, name, budget, settings, given)


def pymoo_strategy(
    algorithm: "Algorithm", multi_objective: bool | None = None, constraints: bool = True
) -> "type[PymooStrategy]":
    """A strategy class that searches with copies of a pymoo `Algorithm` instance, to be registered under a name.

    In a plugin: `register("my-nsga2", railsearch.pymoo_strategy(NSGA2(pop_size=40)))`; in a program of one's own:
    `railsearch.algorithm(railsearch.pymoo_strategy(NSGA2(pop_size=40)), budget=200)`. The budget takes the place of the
    algorithm's termination, the run's seed that of its own; integers are rounded; given designs take the place of the first
    members of its first population. multi_objective: whether it handles several objectives; by default, whether pymoo keeps
    it among its multi-objective algorithms; constraints: whether it handles constraints (MOEA/D of pymoo does not). Raises
    InputError for anything but an instance that has not been used.
    """
    from railsearch.pymoo_generations import strategy_from_algorithm

    return strategy_from_algorithm(algorithm, multi_objective, constraints)
