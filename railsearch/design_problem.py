"""Design problems: pymoo `Problem`s whose variables and results have names and units."""

from __future__ import annotations

import copy
from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, ClassVar, cast

import numpy as np
from pymoo.core.problem import Problem
from pymoo.core.variable import Integer, Real

from railsearch.errors import InputError
from railsearch.interfaces import Evaluation, Host, Outcome, Quantity, Responses, Scalariser
from railsearch.space import FloatArray, Space

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from railsearch.distributions import RandomVector


class DesignProblem(Problem):  # type: ignore[misc]
    """A pymoo problem with a `Space`, named quantities and, if there is one, a reference design.

    A subclass calls `super().__init__` with its description and implements `simulate(design) -> Outcome`; one that has
    choices (objectives, parameters of a site) implements `sections` and `make` as well. Under plain
    pymoo, designs come as float vectors (GA, NSGA-II; integers are rounded here) or as dictionaries by name
    (MixedVariableGA); F, G and the metrics are handed back.

    sections: what a site file may set, {section: frozen parameters dataclass}; `make` receives them validated.
    distributions: those of the variables, for samples; without them a sample is uniform over the bounds. The bounds are
    the range of a search; a sample need only be physically possible and may lie beyond them, so `simulate` must either
    carry such a design out or raise an error that says why it cannot be.
    """

    available_objectives: ClassVar[Sequence[Quantity]] = ()

    def __init__(
        self,
        name: str,
        space: Space,
        objectives: Sequence[Quantity],
        metrics: Sequence[Quantity] = (),
        reference: FloatArray | None = None,
        worst: Mapping[str, float] | None = None,
        n_constraints: int = 0,
        distributions: RandomVector | None = None,
    ) -> None:
        super().__init__(
            n_var=space.dimension,
            n_obj=len(objectives),
            n_ieq_constr=n_constraints,
            xl=space.lower,
            xu=space.upper,
        )
        self.name = name
        self.space = space
        self.objectives = tuple(objectives)
        self.metrics = tuple(metrics)
        self.reference = None if reference is None else space.checked(reference)
        self.worst = dict(worst or {})
        self.distributions = distributions
        if distributions is not None and distributions.names != space.names:
            raise InputError(
                f"distributions: those of {', '.join(space.names)} are needed in this order, received "
                f"{', '.join(distributions.names)}"
            )
        self.vars = {
            variable.name: (Integer if variable.integer else Real)(bounds=(variable.lower, variable.upper))
            for variable in space.variables
        }

    @classmethod
    def sections(cls, host: Host) -> Mapping[str, object]:
        """The sections of this problem's site file: {name: parameters dataclass instance with the defaults}."""
        return {}

    @classmethod
    def make(cls, host: Host, objectives: Sequence[str], sections: Mapping[str, Any]) -> DesignProblem:
        """The problem with the named objectives (empty: its default ones) for the given sections of a site.

        As it stands it makes a problem without sections whose objectives cannot be chosen. Raises InputError.
        """
        made: DesignProblem = cast(Any, cls)()
        check_own_objectives(made, objectives)
        return made

    @property
    def label(self) -> str:
        """Name and objectives, for titles and records."""
        return f"{self.name} ({', '.join(objective.name for objective in self.objectives)})"

    @property
    def exact_objectives(self) -> Mapping[str, Callable[[FloatArray], FloatArray]]:
        """Objectives by name, (n,) from designs (n, d), that are known without a simulation; by default none."""
        return {}

    @property
    def responses(self) -> Responses:
        """What has to be simulated before the objectives are known: those of them that are not exact."""
        exact = {k: self.exact_objectives[q.name] for k, q in enumerate(self.objectives) if q.name in self.exact_objectives}
        expensive = [k for k in range(self.n_obj) if k not in exact]

        def objectives(designs: FloatArray, values: FloatArray) -> FloatArray:
            columns = dict(zip(expensive, values.T, strict=True)) | {k: known(designs) for k, known in exact.items()}
            return np.column_stack([columns[k] for k in range(self.n_obj)])

        return Responses(
            tuple(self.objectives[k] for k in expensive), lambda evaluation: evaluation.objectives[expensive], objectives
        )

    @abstractmethod
    def simulate(self, design: FloatArray) -> Outcome:
        """The expensive part: evaluate one design (d,). Any exception counts as a failed evaluation."""

    def warm_up(self) -> None:
        """Do what is done once per process (compilation), so that it counts in nobody's time."""

    @property
    def simulated(self) -> DesignProblem:
        """The problem whose objectives `simulate` returns."""
        return self

    def finish(self, design: FloatArray, outcome: Outcome) -> Outcome:
        """The free part, done where the record is kept: what is made of a simulated outcome."""
        return outcome

    def replay(self, evaluation: Evaluation) -> None:
        """Learn from a stored evaluation what `finish` would have learnt when it was made."""

    def figures(self, designs: Mapping[str, FloatArray]) -> Mapping[str, Figure]:
        """Pictures that compare labelled designs (reference and best), by name."""
        return {}

    def _evaluate(self, X: Any, out: dict[str, Any], *args: object, **kwargs: object) -> None:
        rows = [[row[name] for name in self.space.names] if isinstance(row, dict) else row for row in X]
        designs = [self.space.rounded(np.asarray(row, dtype=float)) for row in rows]
        outcomes = [self.finish(design, self.simulate(design)) for design in designs]
        out["F"] = np.array([outcome.objectives for outcome in outcomes])
        if self.n_ieq_constr:
            out["G"] = np.array([outcome.constraints for outcome in outcomes])
        for metric in self.metrics:
            out[metric.name] = np.array([outcome.metrics[metric.name] for outcome in outcomes])


def check_own_objectives(problem: DesignProblem, asked: Sequence[str]) -> None:
    """Raise InputError if other objectives are asked for than the problem's own; none are asked for in an empty list."""
    names = [objective.name for objective in problem.objectives]
    if asked and list(asked) != names:
        raise InputError(f"objectives: {problem.name} always has {', '.join(names)}, received {', '.join(asked)}")


class ScalarisedProblem(DesignProblem):
    """A multi-objective problem made single-objective; the raw objectives stay beside the scalar among the metrics.

    A scalariser that needs the objectives of the reference design gets them from the first outcome at that design,
    which the run therefore evaluates first; under plain pymoo it is simulated once before anything else.
    """

    def __init__(self, base: DesignProblem, scalariser_name: str, scalariser: Scalariser) -> None:
        known = {metric.name for metric in base.metrics}
        raw = tuple(objective for objective in base.objectives if objective.name not in known)
        scalar = Quantity(scalariser_name, meaning=f"{scalariser_name} of {', '.join(q.name for q in base.objectives)}")
        super().__init__(
            base.name,
            base.space,
            [scalar],
            base.metrics + raw,
            base.reference,
            base.worst,
            base.n_ieq_constr,
            base.distributions,
        )
        self.base = base
        self.scalariser = copy.copy(scalariser)

    @property
    def label(self) -> str:
        """Name, scalariser and the objectives behind it."""
        return f"{self.name} ({self.objectives[0].name} of {', '.join(q.name for q in self.base.objectives)})"

    def simulate(self, design: FloatArray) -> Outcome:
        """The base problem's outcome, its objectives also among the metrics."""
        outcome = self.base.simulate(design)
        raw = {q.name: float(value) for q, value in zip(self.base.objectives, outcome.objectives, strict=True)}
        return Outcome(outcome.objectives, {**outcome.metrics, **raw}, outcome.constraints)

    @property
    def responses(self) -> Responses:
        """Those of the base problem, scalarised."""
        base = self.base.responses

        def values(evaluation: Evaluation) -> FloatArray:
            return base.values(replace(evaluation, objectives=self._raw(evaluation)))

        def objectives(designs: FloatArray, values: FloatArray) -> FloatArray:
            return np.asarray(self.scalariser(base.objectives(designs, values)), dtype=float)[:, None]

        return Responses(base.quantities, values, objectives)

    def warm_up(self) -> None:
        """Warm the base problem up."""
        self.base.warm_up()

    @property
    def simulated(self) -> DesignProblem:
        """The base problem."""
        return self.base

    def finish(self, design: FloatArray, outcome: Outcome) -> Outcome:
        """Scalarise the raw objectives of an outcome."""
        self._prepare(design, outcome.objectives)
        scalar = np.asarray(self.scalariser(outcome.objectives[None, :]), dtype=float)
        return Outcome(scalar, outcome.metrics, outcome.constraints)

    def figures(self, designs: Mapping[str, FloatArray]) -> Mapping[str, Figure]:
        """The base problem's pictures."""
        return self.base.figures(designs)

    def replay(self, evaluation: Evaluation) -> None:
        """Prepare the scalariser from the stored raw objectives."""
        self._prepare(evaluation.design, self._raw(evaluation))

    def _raw(self, evaluation: Evaluation) -> FloatArray:
        return np.array([evaluation.metrics[quantity.name] for quantity in self.base.objectives])

    def _prepare(self, design: FloatArray, raw: FloatArray) -> None:
        if self.scalariser.ready:
            return
        if self.reference is None or not np.array_equal(design, self.reference):
            raise InputError(
                f"{self.objectives[0].name}: the objectives of the reference design are needed, and its evaluation failed "
                "or was not made first; give the scalariser its aspiration values"
            )
        self.scalariser.prepare(raw)

    def _evaluate(self, X: Any, out: dict[str, Any], *args: object, **kwargs: object) -> None:
        if not self.scalariser.ready and self.reference is not None:
            self.scalariser.prepare(self.simulate(self.reference).objectives)
        super()._evaluate(X, out, *args, **kwargs)
