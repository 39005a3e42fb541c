"""Participants of the benchmark: whatever they are, they begin with the same designs.

The start of a repetition is what `dycors` begins with: the given designs, then a symmetric Latin hypercube,
max(20, 2(d + 1)) in all, drawn by the generator that all strategies of a repetition share.
"""

import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, cast

import numpy as np

from railsearch.errors import CapabilityError
from railsearch.hookspecs import Register, hookimpl
from railsearch.interfaces import Capabilities, Evaluation, Proposal, SearchContext, parameter
from railsearch.parameters import make_parameters
from railsearch.plugin_manager import Registry, load_plugins
from railsearch.sampling import initial_design
from railsearch.space import FloatArray

START_ORIGINS = ("given", "initial")
"""How designs come about that every participant evaluates."""


def start_size(dimension: int) -> int:
    """How many designs the start has: max(20, 2(d + 1))."""
    return max(20, 2 * (dimension + 1))


class Searcher(Protocol):
    """What goes on from the start: it is told all of that before it is asked."""

    def ask(self) -> Sequence[Proposal]:
        """Designs to evaluate next."""

    def tell(self, evaluations: Sequence[Evaluation]) -> None:
        """Receive evaluations."""


class SharedStart:
    """Proposes the start (origin `initial`), tells it to a searcher at once, and hands on between it and the run."""

    capabilities = Capabilities(integers=True)

    def __init__(self, context: SearchContext, searcher: Searcher) -> None:
        self._context = context
        self._searcher = searcher
        self._start: list[Evaluation] = []
        self._waiting: list[FloatArray] | None = None
        self._handed_over = False

    @property
    def minimum_budget(self) -> int:
        """The size of the start."""
        return start_size(self._context.space.dimension)

    def ask(self) -> Sequence[Proposal]:
        """The next design of the start, then what the searcher proposes."""
        if self._waiting is None:
            self._waiting = self._initial_designs()
        if self._waiting:
            return [Proposal(self._waiting.pop(0), "initial")]
        if not self._handed_over:
            self._handed_over = True
            self._searcher.tell(self._start)
        return self._searcher.ask()

    def tell(self, evaluations: Sequence[Evaluation]) -> None:
        """Keep the start together; hand everything else on."""
        if self._handed_over:
            self._searcher.tell(evaluations)
        else:
            self._start += evaluations

    def _initial_designs(self) -> list[FloatArray]:
        space = self._context.space
        given = np.array([evaluation.design for evaluation in self._start]).reshape(-1, space.dimension)
        missing = max(0, self.minimum_budget - len(given))
        return list(initial_design(space, missing, self._context.initial_generator, given, given))


@dataclass(frozen=True)
class StartedParameters:
    """Which strategy goes on from the start."""

    strategy: str = parameter("random", meaning="name of a registered strategy")
    settings: dict[str, object] | None = parameter(  # noqa: RUF009 - a field, not a value
        None, meaning="parameters of the strategy that differ from its defaults"
    )


class Started(SharedStart):
    """A strategy of ours that has no start of its own, or another one, put behind the shared start."""

    Parameters = StartedParameters

    def __init__(self, context: SearchContext, parameters: StartedParameters) -> None:
        super().__init__(context, _strategy(context, parameters.strategy, parameters.settings or {}))


def _strategy(context: SearchContext, name: str, settings: Mapping[str, object]) -> Searcher:
    plugin = _registry().get("strategy", name)
    if context.space.integer.any() and not plugin.capabilities.integers:
        raise CapabilityError(f"strategy {name} cannot handle integer variables, this problem has some")
    parameters: Any = make_parameters(plugin.Parameters, settings, f"strategy {name}")
    return cast(Searcher, plugin(context, parameters))


@functools.cache
def _registry() -> Registry:
    return load_plugins()


@hookimpl
def railsearch_strategies(register: Register) -> None:
    """Register `started`."""
    register("started", Started)
