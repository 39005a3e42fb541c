"""What the inner problems ask: a surrogate, or the true model with gradients by finite differences.

| symbol | meaning | shape | unit |
|---|---|---|---|
| x | point in the factors' own units | (d,) | SI |
| u | point of the unit box, u = (x − x^l)/(x^u − x^l) | (d,) | - |
| g | output of the model | scalar | of the output |
| h | step of a finite difference, as a fraction of the range | scalar | - |
"""

from collections import Counter
from collections.abc import Callable

import numpy as np

from railsearch.design_problem import DesignProblem
from railsearch.errors import InputError, SurrogateError
from railsearch.interfaces import Outcome, Quantity
from railsearch.projected_gradient import SmoothFunction, value_and_gradient
from railsearch.result import quantities
from railsearch.simulation import Simulators, simulators
from railsearch.space import FloatArray, Space

Function = Callable[[FloatArray], FloatArray]
"""Values (k,) at points (k, d) in the factors' own units, NaN where an evaluation failed."""

STEP = 1e-6
"""h: large beside the rounding of a simulation, small beside what curves the output."""


class ExactModel:
    """The true model as something that can be searched: its values, and gradients by finite differences into the box.

    ∂g/∂x_i ≈ (g(x + h_i) − g(x))/h_i with h_i towards the centre of the range; 0 where one of both failed.
    function: vectorised; space: bounds of the factors; step: h. `evaluations` and `failures` count the true ones.
    Raises InputError for a step not between 0 and a half.
    """

    def __init__(self, function: Function, space: Space, step: float = STEP) -> None:
        if not 0.0 < step < 0.5:
            raise InputError(f"step: a fraction of the range between 0 and 0.5 is needed, received {step!r}")
        self._function = function
        self._space = space
        self._steps = step * (space.upper - space.lower)
        self.evaluations = 0
        self.failures = 0

    def predict(self, points: FloatArray) -> FloatArray:
        """True values (k,) at points (k, d), NaN where the evaluation failed."""
        values = np.array(self._function(points), dtype=float)
        if values.shape != (len(points),):
            raise InputError(
                f"model: one value for each of {len(points)} points is needed, received shape {values.shape}; "
                "it must take points (k, d) and return values (k,)"
            )
        failed = ~np.isfinite(values)
        values[failed] = np.nan
        self.evaluations += len(values)
        self.failures += int(failed.sum())
        return values

    def gradient(self, points: FloatArray) -> FloatArray:
        """Differences (k, d) at points (k, d)."""
        return self.predict_with_gradient(points)[1]

    def predict_with_gradient(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Values (k,) and differences (k, d) from d + 1 evaluations of each point."""
        inwards = np.where(2.0 * points > self._space.lower + self._space.upper, -self._steps, self._steps)
        moved = points[:, None, :] + inwards[:, None, :] * np.eye(self._space.dimension)
        asked = np.concatenate([points, moved.reshape(-1, self._space.dimension)])
        answers = self.predict(asked)
        values, others = answers[: len(points)], answers[len(points) :].reshape(points.shape)
        differences = (others - values[:, None]) / inwards
        return values, np.where(np.isfinite(differences), differences, 0.0)


class ProblemFunction:
    """A quantity of a design problem as a vectorised function; a failed evaluation is NaN and its reason is counted.

    name: an objective or metric, which has its natural sign; simulating: what carries the evaluations out, by default this
    process; the caller closes it. Constraints are not looked at. Raises InputError for an unknown quantity.
    """

    def __init__(self, problem: DesignProblem, name: str, simulating: Simulators | None = None) -> None:
        self._problem = problem
        self.quantity = quantity_of(problem, name)
        self._simulators = simulating or simulators(problem)
        self.reasons: Counter[str] = Counter()

    def __call__(self, points: FloatArray) -> FloatArray:
        """Values (k,) at designs (k, d)."""
        values = np.full(len(points), np.nan)
        for place, simulated in self._simulators.simulate(list(points)):
            if isinstance(simulated.outcome, Outcome):
                values[place] = natural_value(self._problem, self.quantity, points[place], simulated.outcome)
            else:
                self.reasons[simulated.outcome] += 1
        return values


def quantity_of(problem: DesignProblem, name: str) -> Quantity:
    """The objective or metric of that name. Raises InputError if there is none."""
    known = {quantity.name: quantity for quantity in quantities(problem)}
    if name not in known:
        raise InputError(f"unknown quantity '{name}' of {problem.name}; there are {', '.join(known)}")
    return known[name]


def natural_value(problem: DesignProblem, quantity: Quantity, design: FloatArray, outcome: Outcome) -> float:
    """The value of a quantity with its natural sign in a simulated outcome of a design (d,)."""
    finished = problem.finish(design, outcome)
    names = [objective.name for objective in problem.objectives]
    if quantity.name in names:
        return quantity.sign * float(finished.objectives[names.index(quantity.name)])
    return quantity.sign * float(finished.metrics[quantity.name])


class BoxModel:
    """A surrogate or the true model on the unit box of the factors; `asked` counts the points.

    Raises SurrogateError where a surrogate predicts something that is not finite.
    """

    def __init__(self, model: SmoothFunction, space: Space) -> None:
        self._space = space
        self._evaluate = value_and_gradient(model)
        self._model = model
        self.asked = 0

    @property
    def exact(self) -> bool:
        """Whether this is the true model."""
        return isinstance(self._model, ExactModel)

    def predict(self, points: FloatArray) -> FloatArray:
        """g (k,) at points u (k, d)."""
        self.asked += len(points)
        native = self._space.from_unit(points)
        return self._checked(native, np.asarray(self._model.predict(native), dtype=float))

    def predict_with_gradient(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """g (k,) and ∂g/∂u (k, d) at points u (k, d)."""
        self.asked += len(points)
        native = self._space.from_unit(points)
        values, slopes = self._evaluate(native)
        slopes = slopes * (self._space.upper - self._space.lower)
        self._checked(native, slopes)
        return self._checked(native, values), slopes

    def _checked(self, native: FloatArray, numbers: FloatArray) -> FloatArray:
        if self.exact or np.isfinite(numbers).all():
            return numbers
        rows = np.isfinite(numbers.reshape(len(native), -1)).all(axis=1)
        point = native[int(np.argmin(rows))]
        words = ", ".join(f"{name} = {value:g}" for name, value in zip(self._space.names, point, strict=True))
        raise SurrogateError(
            f"the surrogate predicts a value or slope that is not finite at {words}; narrow the ranges to those of the "
            "samples, or fit it afresh"
        )
