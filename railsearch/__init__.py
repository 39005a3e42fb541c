"""railsearch: search for better railway transition zones on a budget of expensive simulations."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from railsearch.design_problem import DesignProblem

__all__ = ["problem"]


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

    settings = ProblemSettings(name, tuple(objectives), sections or {}, scalariser, scalariser_settings or {})
    return make_problem(load_plugins(), settings)
