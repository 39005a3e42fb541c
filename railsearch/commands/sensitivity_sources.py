"""Where the samples of a sensitivity analysis come from: a problem that is evaluated, or a table of the user's own."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from railsearch.commands.options import Asked, messages
from railsearch.commands.sampling import sampled_into
from railsearch.distributions import RandomVector
from railsearch.errors import InputError
from railsearch.plugin_manager import Registry
from railsearch.result import quantities
from railsearch.samples import Experiment, ExperimentDesign, MeasureDesign, input_distributions, read_samples
from railsearch.seeding import checked_seed
from railsearch.sensitivity.fitting import check_number
from railsearch.sensitivity.variance_based import check_base
from railsearch.sensitivity_study import CriterionStudy, ModelSamples, StudyData, confirm, own_data, problem_data
from railsearch.simulation import Simulators

SAMPLES = "samples.parquet"


@dataclass(frozen=True)
class Collected:
    """Samples, those for measures on the model if they were asked for, and the seed of everything random."""

    data: StudyData
    model: ModelSamples | None
    seed: int


class Source(Protocol):
    """What is known before anything is evaluated, and what is done then."""

    @property
    def inputs(self) -> RandomVector:
        """The random inputs."""

    @property
    def outputs(self) -> Sequence[str]:
        """Names of all outputs."""

    @property
    def default(self) -> tuple[str, ...]:
        """The outputs that are analysed if none is named."""

    def collected(self) -> Collected:
        """The samples, evaluated as far as that has not been done."""

    def confirmed(self, studies: list[CriterionStudy]) -> list[CriterionStudy]:
        """The studies with what the model says of their extremes, where there is one to ask."""


@dataclass(frozen=True)
class OwnSource:
    """A table of the user's own with its distributions: there is no model to ask."""

    data: StudyData
    seed: int | None

    @property
    def inputs(self) -> RandomVector:
        """Those with a distribution."""
        return self.data.inputs

    @property
    def outputs(self) -> Sequence[str]:
        """All other columns of numbers."""
        return tuple(self.data.outputs)

    @property
    def default(self) -> tuple[str, ...]:
        """All outputs."""
        return self.data.default

    def collected(self) -> Collected:
        """What the table has."""
        return Collected(self.data, None, checked_seed(self.seed))

    def confirmed(self, studies: list[CriterionStudy]) -> list[CriterionStudy]:
        """The studies as they are."""
        return studies


@dataclass(frozen=True)
class ProblemSource:
    """A problem, whose samples are evaluated into a folder, or read from `file`.

    wanted: design, number and seed of the samples; on_model: blocks and trajectories for measures on the problem itself, 0
    for none; confirming: whether it is asked for its values at the extremes. Raises InputError for too few samples, and
    blocks that are no power of two.
    """

    registry: Registry
    asked: Asked
    folder: Path
    file: Path | None
    wanted: tuple[ExperimentDesign, int, int | None]
    on_model: int
    confirming: bool
    simulating: Callable[[], Simulators]

    def __post_init__(self) -> None:
        if self.file is None:
            check_number(self.wanted[1], self.asked.problem.space.dimension)
        if self.on_model:
            check_base(self.on_model)

    @property
    def inputs(self) -> RandomVector:
        """The problem's variables."""
        return input_distributions(self.asked.problem)

    @property
    def outputs(self) -> Sequence[str]:
        """Its objectives and metrics."""
        return tuple(quantity.name for quantity in quantities(self.asked.problem))

    @property
    def default(self) -> tuple[str, ...]:
        """Its objectives."""
        return tuple(objective.name for objective in self.asked.problem.objectives)

    def collected(self) -> Collected:
        """The samples, and those of the measures."""
        file, (design, number, seed) = self.file, self.wanted
        if file is None:
            file = self.folder / SAMPLES
            seed = self._sampled(file, (design, number, seed)).seed
        data = problem_data(self.asked.problem, file)
        return Collected(data, self._model_samples(seed) if self.on_model else None, checked_seed(seed))

    def confirmed(self, studies: list[CriterionStudy]) -> list[CriterionStudy]:
        """With the problem's values at the extremes, unless that is not wanted."""
        if not self.confirming:
            return studies
        messages.print("confirming the extremes by the problem itself")
        return confirm(studies, self.asked.problem, self.simulating())

    def _model_samples(self, seed: int | None) -> ModelSamples:
        """The problem in blocks and along as many trajectories."""
        samples, names = {}, self.asked.problem.space.names
        for design in MeasureDesign:
            file = self.folder / f"{design}-{self.on_model}.parquet"
            self._sampled(file, (design, design.number(self.on_model, len(names)), seed))
            samples[design] = read_samples(file, names)
        return ModelSamples(samples[MeasureDesign.SALTELLI], samples[MeasureDesign.MORRIS])

    def _sampled(self, file: Path, wanted: tuple[ExperimentDesign | MeasureDesign, int, int | None]) -> Experiment:
        return sampled_into(file, self.registry, self.asked, wanted, self.simulating())[0]


def own_source(data: Path | None, distributions: Path | None, on_model: int, seed: int | None) -> OwnSource:
    """A user's table; says what it takes as outputs. Raises InputError as `own_data`, and for measures on a model."""
    if data is None or distributions is None:
        raise InputError("a problem is needed, or --data with --distributions; `railsearch list problem` has the problems")
    if on_model:
        raise InputError("--on-model: data of your own have no model that could be evaluated; leave it out")
    found = own_data(data, distributions)
    outputs = ", ".join(found.outputs) or "none"
    messages.print(f"inputs: {', '.join(found.inputs.names)}; outputs, because they have no distribution: {outputs}")
    return OwnSource(found, seed)
