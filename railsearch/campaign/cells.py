"""The parts of a campaign and the cells that they span.

A cell is one run: one problem searched by one strategy once. Its study is named `campaign/problem/strategy/repetition`.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from itertools import product

from railsearch.problem_factory import ProblemSettings


@dataclass(frozen=True, order=True)
class Cell:
    """One run of a campaign, by the labels of its problem and strategy; repetitions count from 1."""

    problem: str
    strategy: str
    repetition: int

    def study_name(self, campaign: str) -> str:
        """The name of the cell's study."""
        return f"{campaign}/{self.problem}/{self.strategy}/{self.repetition}"


@dataclass(frozen=True)
class CampaignProblem:
    """A problem of a campaign under a label.

    given: designs to evaluate first, by variable, each an amendment of the reference design; reference_point: objective
    values with their natural sign against which hypervolume is measured, by objective.
    """

    label: str
    settings: ProblemSettings
    given: tuple[Mapping[str, object], ...] = ()
    reference_point: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class CampaignStrategy:
    """A strategy of a campaign under a label, with all its settings."""

    label: str
    name: str
    settings: Mapping[str, object] = field(default_factory=dict)


@dataclass(frozen=True)
class Campaign:
    """Problems × strategies × repetitions on one budget of evaluations."""

    name: str
    budget: int
    repetitions: int
    seed: int
    problems: tuple[CampaignProblem, ...]
    strategies: tuple[CampaignStrategy, ...]
    batch_size: int = 1
    timeout: float | None = None

    def cells(self) -> Iterator[Cell]:
        """All cells, repetition by repetition, so that every comparison is balanced at any time."""
        repetitions = range(1, self.repetitions + 1)
        for repetition, problem, strategy in product(repetitions, self.problems, self.strategies):
            yield Cell(problem.label, strategy.label, repetition)
