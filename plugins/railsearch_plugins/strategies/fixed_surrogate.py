"""Strategy `fixed-surrogate`: surrogates of the responses from one large design, searched by a genetic algorithm.

The one-shot path of the preference study (Shang, Binnekamp and Wolfert 2023). A space-filling design takes most of the
budget. Surrogates of every expensive response are fitted to a part of it, chosen on a second part, and their generalisation
error is found on a third: 64, 16 and 20 %. A GA (NSGA-II with several objectives) searches what they predict, exact
objectives and the scalariser being applied to the predictions. What is left of the budget confirms the best predicted
designs by true evaluations. The errors reported are those of surrogates that have learnt the first part only. Before the
search they learn the other two, and after every confirmation its outcome, unless that is switched off.
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from railsearch.errors import InputError
from railsearch.hookspecs import Register, hookimpl
from railsearch.interfaces import (
    Capabilities,
    Evaluation,
    Finding,
    Proposal,
    Quantity,
    Responses,
    SearchContext,
    parameter,
)
from railsearch.space import FloatArray
from railsearch_plugins.surrogate_search.evolution import Evolution, evolved
from railsearch_plugins.surrogate_search.front import Candidates, best_of, front_of, select_by_gain
from railsearch_plugins.surrogate_search.models import ResponseModels, surrogate_maker
from railsearch_plugins.surrogate_search.search import SurrogateSearch, default_initial_size
from railsearch_plugins.surrogate_search.validation import Chosen, Split, chosen_surrogate, split_rows

DESIGN_SHARE = 0.9
STUDY = "preference study, Shang et al. 2023"


@dataclass(frozen=True)
class FixedSurrogateParameters:
    """What can be set of the one-shot path."""

    design_size: int | None = parameter(
        None,
        meaning="designs of the space-filling design, the given ones included; if not given, nine tenths of the budget",
        source=f"{STUDY}: 2000",
        minimum=1,
    )
    surrogates: tuple[str, ...] = parameter(
        ("kriging", "rbf"),
        meaning="names of registered surrogates; for every response the one of least error in validation is taken",
        source=f"{STUDY}: Kriging",
    )
    surrogate_settings: dict[str, dict[str, object]] | None = parameter(  # noqa: RUF009 - a field, not a value
        None, meaning="parameters of surrogates that differ from their defaults, for instance {kriging = {trend = 'linear'}}"
    )
    validation: float = parameter(
        0.16, meaning="part of the design on which surrogates are chosen", source=STUDY, minimum=0.0, below=0.5
    )
    test: float = parameter(
        0.2, meaning="part of the design on which their errors are found", source=STUDY, minimum=0.0, below=0.5
    )
    starts: int = parameter(
        5,
        meaning="first searches on the surrogates, each from a part of the design of its own; they go on together",
        source="own choice: one search ends in one combination of the integers",
        minimum=1,
    )
    population_size: int = parameter(50, meaning="designs per generation of the search", source="own choice", minimum=2)
    generations: int = parameter(100, meaning="generations of the first search", source="own choice", minimum=1)
    further_generations: int = parameter(
        20, meaning="generations by which it goes on after a confirmation", source="own choice", minimum=1
    )
    learn_confirmations: bool = parameter(
        True, meaning="whether the surrogates learn the outcome of every confirmation", source="own choice"
    )
    minimum_distance: float = parameter(
        1e-3,
        meaning="nearer than this (unit cube) to an evaluated point nothing is confirmed, and nothing joins the surrogates",
        source="own choice: within it an interpolant stays well determined",
        minimum=1e-5,
        below=1.0,
    )

    def __post_init__(self) -> None:
        if not self.surrogates:
            raise InputError("surrogates: one or more names are needed, received an empty list")
        unused = [name for name in self.surrogate_settings or {} if name not in self.surrogates]
        if unused:
            raise InputError(
                f"surrogate_settings: {', '.join(unused)} not among the surrogates ({', '.join(self.surrogates)}); "
                "name it there too, or leave its settings out"
            )


class FixedSurrogateSearch(SurrogateSearch):
    """A space-filling design, surrogates of the responses behind the objectives, their errors, and confirmed optima."""

    Parameters = FixedSurrogateParameters
    capabilities = Capabilities(multi_objective=True, integers=True, batch=True)

    def __init__(self, context: SearchContext, parameters: FixedSurrogateParameters) -> None:
        self._parameters = parameters
        size = parameters.design_size or max(1, min(round(DESIGN_SHARE * context.budget), context.budget - 1))
        super().__init__(context, size, parameters.minimum_distance)
        settings = parameters.surrogate_settings or {}
        self._makes = {name: surrogate_maker(context, name, settings.get(name)) for name in parameters.surrogates}
        self._responses = context.responses or _objectives_themselves(context.n_objectives)
        self._models: ResponseModels | None = None
        self._learnt: list[Evaluation] = []
        self._population = np.empty((0, context.space.dimension))
        self.findings: list[Finding] = []

    @property
    def minimum_budget(self) -> int:
        """The size of the design and one confirmation."""
        return (self._parameters.design_size or default_initial_size(self._context.space.dimension)) + 1

    def _propose(self) -> list[Proposal]:
        """The best predicted designs; none if nothing could be fitted, or they lie too near to evaluated points."""
        if self._models is None:
            self._choose_surrogates()
        if not self._refreshed():
            return []
        space, record, count = self._context.space, self._record, self._context.batch_size
        designs = self._promising()
        values = self._predicted(designs)
        front = front_of(record.successes, values)
        order = np.argsort(front.scaled(values).sum(axis=1), kind="stable")
        chosen = select_by_gain(
            Candidates(space.to_unit(designs[order]), values[order]),
            front,
            space.to_unit(record.designs),
            itertools.repeat(1.0),
            count,
            self._parameters.minimum_distance,
            margin=0.1,
        )
        return [Proposal(designs[order[k]], "confirmation") for k in chosen]

    def _choose_surrogates(self) -> None:
        """Split the design, choose a surrogate for every response, and note its errors."""
        learnable, parameters = self._record.learnable, self._parameters
        split = split_rows(len(learnable), parameters.validation, parameters.test, self._context.generator)
        self._learnt = [learnable[row] for row in (*split.training, *split.validation, *split.test)]
        points, values = self._data(learnable)
        found = [chosen_surrogate(self._makes, points, column, split) for column in values.T] if learnable else []
        chosen = [one for one in found if one is not None]
        if len(chosen) < len(self._responses.quantities):
            self._models = ResponseModels([next(iter(self._makes.values()))] * len(self._responses.quantities))
            return
        self._models = ResponseModels([self._makes[one.name] for one in chosen])
        self._models.adopt([one.surrogate for one in chosen], len(split.training))
        for quantity, one in zip(self._responses.quantities, chosen, strict=True):
            self.findings += _errors(quantity, one, split)

    def _refreshed(self) -> bool:
        """Bring the surrogates up to date: with the whole design, then with confirmations too."""
        assert self._models is not None, "surrogates are chosen first"
        learnable = self._record.learnable
        if not learnable:
            return False
        if self._models.surrogates is None or self._parameters.learn_confirmations:
            self._learnt += learnable[len(self._learnt) :]
        return self._models.refresh(*self._data(self._learnt))

    def _data(self, evaluations: Sequence[Evaluation]) -> tuple[FloatArray, FloatArray]:
        """Points (n, d) of the unit cube and responses (n, r) of evaluations."""
        designs = np.array([evaluation.design for evaluation in evaluations]).reshape(-1, self._context.space.dimension)
        values = np.array([self._responses.values(evaluation) for evaluation in evaluations])
        return self._context.space.to_unit(designs), values.reshape(-1, len(self._responses.quantities))

    def _promising(self) -> FloatArray:
        """The last population (k, d) of a GA or NSGA-II on the surrogates, which goes on with every confirmation.

        The first time it is those of several, each begun with another part of the design.
        """
        parameters, best = self._parameters, [evaluation.design for evaluation in best_of(self._record.successes)]
        if len(self._population):
            self._population = self._evolved(np.vstack([*best, self._population]), parameters.further_generations)
        else:
            shuffled = self._context.generator.permutation(self._record.designs)
            parts = np.array_split(shuffled, min(parameters.starts, len(shuffled)))
            self._population = np.vstack([self._evolved(part, parameters.generations) for part in parts])
        return self._population

    def _evolved(self, first: FloatArray, generations: int) -> FloatArray:
        """The last population (k, d) of an evolution on the surrogates that begins with designs (j, d)."""
        evolution = Evolution(self._parameters.population_size, generations, self._parameters.minimum_distance)
        return evolved(self._context.space, self._predicted, np.unique(first, axis=0), evolution, self._context.generator)

    def _predicted(self, designs: FloatArray) -> FloatArray:
        """The objectives (k, m) that follow from designs (k, d) and what the surrogates predict for them."""
        assert self._models is not None, "surrogates are chosen first"
        return self._responses.objectives(designs, self._models.predict(self._context.space.to_unit(designs)))


def _objectives_themselves(n_objectives: int) -> Responses:
    """The objectives as responses, where nothing is known of what they are made of."""
    quantities = tuple(Quantity(f"objective {k + 1}") for k in range(n_objectives))
    return Responses(quantities, lambda evaluation: evaluation.objectives, lambda designs, values: values)


def _errors(quantity: Quantity, chosen: Chosen, split: Split) -> list[Finding]:
    """The errors of a response's surrogate, those that could be found."""
    made = f"{chosen.name} fitted to {len(split.training)} designs"
    findings = [
        Finding(
            f"{quantity.name}: error in validation",
            chosen.validation_error,
            "%",
            f"mean absolute error relative to the mean absolute value, {made}, on {len(split.validation)} others",
        ),
        Finding(
            f"{quantity.name}: generalisation error",
            chosen.test_error,
            "%",
            f"mean absolute error relative to the mean absolute value, {made}, on {len(split.test)} test designs",
        ),
        Finding(
            f"{quantity.name}: predictivity Q²",
            chosen.predictivity,
            "",
            f"1 for exact predictions, 0 for those no better than the mean, {made}, on {len(split.test)} test designs",
        ),
    ]
    return [finding for finding in findings if np.isfinite(finding.value)]


@hookimpl
def railsearch_strategies(register: Register) -> None:
    """Register `fixed-surrogate`."""
    register("fixed-surrogate", FixedSurrogateSearch)
