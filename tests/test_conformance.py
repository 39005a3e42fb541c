"""Every registered plugin passes the shipped suite; the suite finds what it is there to find."""

import itertools
from dataclasses import dataclass, replace

import numpy as np
import pytest
from matplotlib.figure import Figure

from railsearch.errors import CapabilityError, InputError
from railsearch.interfaces import Capabilities, Proposal, Quantity, Response, parameter
from railsearch.plugin_manager import load_plugins
from railsearch.run import MemoryRecord, RunSettings, make_strategy, run_search
from railsearch.sampling import random_designs
from railsearch.scalarise import augmented_chebyshev
from railsearch.testing import check_scalariser, check_strategy, check_surrogate, check_track_model
from railsearch_plugins.scalarisers.asf import AchievementScalarisingFunction
from railsearch_plugins.strategies.random import RandomSearch
from railsearch_plugins.surrogates.rbf import RadialBasisFunctionInterpolant
from registered_strategies import SMALL_SETTINGS, every_strategy, small_budget
from sample_problems import Sphere, TwoObjectives


def registered(kind):
    return pytest.mark.parametrize("plugin", [pytest.param(e.plugin, id=e.name) for e in load_plugins().entries(kind)])


@every_strategy
def test_strategy(entry):
    check_strategy(entry.plugin, SMALL_SETTINGS.get(entry.name), budget=small_budget(entry.name))


@every_strategy
def test_a_run_begins_with_the_given_designs_and_ends_with_the_budget(entry):
    budget = small_budget(entry.name)
    given = [np.zeros(4), np.array([1.5, -2.0, 3.0, 0.0])]
    settings = RunSettings(entry.name, budget, 5, SMALL_SETTINGS.get(entry.name, {}))
    result = run_search(load_plugins(), Sphere(), settings, given)
    assert [e.number for e in result.evaluations] == list(range(budget))
    assert [e.origin == "given" for e in result.evaluations] == [True] * 2 + [False] * (budget - 2)
    assert len({e.design.tobytes() for e in result.evaluations}) == budget


@every_strategy
def test_a_continued_run_is_the_run_that_was_not_interrupted(entry):
    settings = RunSettings(entry.name, small_budget(entry.name), 6, SMALL_SETTINGS.get(entry.name, {}))
    whole = run_search(load_plugins(), Sphere(), settings, [np.zeros(4)])
    record = MemoryRecord()
    record.evaluations = list(whole.evaluations[: settings.budget // 2])
    continued = run_search(load_plugins(), Sphere(), settings, [np.zeros(4)], record)
    assert continued.replayed == settings.budget // 2
    assert [e.design.tobytes() for e in continued.evaluations] == [e.design.tobytes() for e in whole.evaluations]


@every_strategy
def test_what_a_strategy_cannot_handle_is_refused_before_anything_is_evaluated(entry):
    capabilities = entry.plugin.capabilities
    demands = (
        (capabilities.multi_objective, TwoObjectives(), 1, "handles one objective"),
        (capabilities.integers, Sphere(), 1, "does not handle integer variables"),
        (capabilities.constraints, OneConstraint(), 1, "does not handle constraints"),
        (capabilities.batch, Sphere(), 3, "one design at a time"),
    )
    for capable, problem, batch_size, words in demands:
        settings = RunSettings(entry.name, 40, 1, batch_size=batch_size)
        if capable:
            make_strategy(load_plugins(), problem, settings)
        else:
            with pytest.raises(CapabilityError, match=words):
                make_strategy(load_plugins(), problem, settings)


class OneConstraint(Sphere):
    """A sphere with a constraint and one objective."""

    def __init__(self):
        super().__init__()
        self.n_ieq_constr = 1


@registered("surrogate")
def test_surrogate(plugin):
    check_surrogate(plugin)


THREE = ("f1", "f2", "f3")
IDEAL = {"ideal": dict.fromkeys(THREE, -2.0)}
LINEAR = {"preferences": {name: {"function": "linear", "best": -2.0, "worst": 12.0} for name in THREE}}
SCALARISER_SETTINGS = {
    "weighted-sum": IDEAL,
    "chebyshev": IDEAL,
    "lp": IDEAL,
    "preference-minmax": LINEAR,
    "imap": LINEAR | {"stakeholders": {"user": {}, "owner": {"weight": 2.0, "weights": {"f1": 3.0}}}},
}


@pytest.mark.parametrize("entry", load_plugins().entries("scalariser"), ids=lambda entry: entry.name)
def test_scalariser(entry):
    check_scalariser(entry.plugin, SCALARISER_SETTINGS.get(entry.name))


@registered("track-model")
def test_track_model(plugin):
    check_track_model(plugin)


@pytest.mark.parametrize("settings", [{"kernel": "thin-plate"}, {"kernel": "linear"}])
def test_rbf_kernels(settings):
    check_surrogate(RadialBasisFunctionInterpolant, settings)


def test_capped_rbf_regresses():
    check_surrogate(RadialBasisFunctionInterpolant, {"cap_above_median": True}, interpolates=False)


class Changed(RandomSearch):
    """Random search with something done to its proposals."""

    def __init__(self, context, parameters):
        super().__init__(context, parameters)
        self.context = context

    def ask(self):
        return [replace(proposal, design=self.change(proposal.design)) for proposal in super().ask()]


class OutOfBounds(Changed):
    def change(self, design):
        return design + 0.7 * (self.context.space.upper - self.context.space.lower)


class Fractional(Changed):
    def change(self, design):
        return np.where(self.context.space.integer, np.minimum(design + 0.25, self.context.space.upper), design)


class PlainList(Changed):
    def change(self, design):
        return design.tolist()


class WholeArray(Changed):
    def change(self, design):
        return np.round(design).astype(int)


class GloballyRandom(RandomSearch):
    def ask(self):
        np.random.random()  # noqa: NPY002 - the fault to be found
        return super().ask()


class SelfSeeded(Changed):
    count = itertools.count()

    def change(self, design):
        return random_designs(self.context.space, 1, np.random.default_rng(next(SelfSeeded.count)))[0]


class Fixed(Changed):
    def change(self, design):
        return self.context.space.lower.copy()


class Silent(RandomSearch):
    def ask(self):
        return []


class TooMany(RandomSearch):
    def ask(self):
        return [*super().ask(), *super().ask()]


class Unlabelled(RandomSearch):
    def ask(self):
        return [replace(proposal, origin="") for proposal in super().ask()]


class Counted(RandomSearch):
    def ask(self):
        return [Proposal(proposal.design, "random", -1) for proposal in super().ask()]


class Overwriting(RandomSearch):
    def tell(self, evaluations):
        evaluations[0].design[:] = 0.0


class Fixated(Changed):
    """Proposes a poor corner first and close to it ever after."""

    def change(self, design):
        space = self.context.space
        return space.from_unit(1.0 - 1e-3 * space.to_unit(design))


class Ending(RandomSearch):
    """Falls over when everything is the same."""

    def tell(self, evaluations):
        values = np.array([evaluation.objectives for evaluation in evaluations if not evaluation.failed])
        self.values = (
            np.vstack([getattr(self, "values", np.empty((0, values.shape[-1]))), values])
            if len(values)
            else np.empty((0, 1))
        )
        if len(self.values) > 5 and np.ptp(self.values) == 0.0:
            raise ZeroDivisionError("no spread")


class Trusting(RandomSearch):
    def tell(self, evaluations):
        if any(np.isnan(evaluation.objectives).any() for evaluation in evaluations):
            raise AssertionError("a failed evaluation was not survived")


@pytest.mark.parametrize(
    ("plugin", "explanation"),
    [
        (OutOfBounds, "outside the bounds"),
        (Fractional, "fractions in the integers"),
        (PlainList, "float vector"),
        (WholeArray, "float vector"),
        (GloballyRandom, "global generator"),
        (SelfSeeded, "same seed propose different designs"),
        (Fixed, "different seeds propose the same designs"),
        (Silent, "proposed nothing"),
        (TooMany, "2 designs were proposed, a batch is 1 at most"),
        (Unlabelled, "origin in a word"),
        (Counted, "trajectory must be an integer ≥ 0"),
        (Overwriting, "altered a design it was told"),
        (Trusting, "failed evaluation was not survived"),
        (Fixated, "no better than"),
    ],
)
def test_a_strategy_at_fault_is_found(plugin, explanation):
    with pytest.raises(AssertionError, match=explanation):
        check_strategy(plugin)


def test_an_error_says_in_which_trial():
    with pytest.raises(ZeroDivisionError) as caught:
        check_strategy(Ending)
    assert "a constant objective" in caught.value.__notes__[0]


def test_only_what_a_strategy_claims_is_asked_of_it():
    class OnlyReal(RandomSearch):
        capabilities = Capabilities()

        def __init__(self, context, parameters):
            super().__init__(context, parameters)
            assert not context.space.integer.any()
            assert (context.n_objectives, context.n_constraints, context.batch_size) == (1, 0, 1)

    check_strategy(OnlyReal)


class Biased(RadialBasisFunctionInterpolant):
    def predict(self, points):
        return super().predict(points) + 0.1


class WrongSlope(RadialBasisFunctionInterpolant):
    def gradient(self, points):
        return 1.001 * super().gradient(points)


class Forgetful(RadialBasisFunctionInterpolant):
    def add(self, points, values):
        super().add(points[:1], values[:1])


class Flat(RadialBasisFunctionInterpolant):
    def predict(self, points):
        return super().predict(points)[:, None]


class Sorting(RadialBasisFunctionInterpolant):
    def fit(self, points, values):
        points.sort(axis=0)
        super().fit(points, values)


class Lenient(RadialBasisFunctionInterpolant):
    def fit(self, points, values):
        super().fit(points, np.nan_to_num(values))


class Greedy(RadialBasisFunctionInterpolant):
    def fit(self, points, values):
        if len(points):
            super().fit(points, values)


class Crowded(RadialBasisFunctionInterpolant):
    def predict(self, points):
        return super().predict(points) + (len(points) > 1)


@pytest.mark.parametrize(
    ("plugin", "explanation"),
    [
        (Biased, "misses values"),
        (WrongSlope, "central differences"),
        (Forgetful, "added one after another"),
        (Flat, "predict must give"),
        (Sorting, "altered its arguments"),
        (Lenient, "not a number was accepted"),
        (Greedy, "fit to no points was accepted"),
        (Crowded, "differ from one by one"),
    ],
)
def test_a_surrogate_at_fault_is_found(plugin, explanation):
    with pytest.raises(AssertionError, match=explanation):
        check_surrogate(plugin)


class Unready(AchievementScalarisingFunction):
    def prepare(self, reference):
        """Forget it."""


class Sharing(AchievementScalarisingFunction):
    def prepare(self, reference):
        self._aspiration[:] = 0.8 * reference


class Backwards(AchievementScalarisingFunction):
    def __call__(self, objectives):
        return -super().__call__(objectives)


class Summed(AchievementScalarisingFunction):
    def __call__(self, objectives):
        return super().__call__(objectives).sum()


class Relative(AchievementScalarisingFunction):
    def __call__(self, objectives):
        return super().__call__(objectives) - super().__call__(objectives).mean()


class Divided(AchievementScalarisingFunction):
    def __call__(self, objectives):
        return augmented_chebyshev(objectives, np.zeros(3), np.ones(3), 0.0) / np.array(0.0)


class Unrecorded(AchievementScalarisingFunction):
    @property
    def values(self):
        return {"worst": np.ones(3)}


@dataclass(frozen=True)
class Demanding:
    rho: float = parameter(meaning="a value that has to be given")


class Undescribed(AchievementScalarisingFunction):
    Parameters = Demanding

    def __init__(self, parameters, objectives, worst):
        super().__init__(AchievementScalarisingFunction.Parameters(rho=parameters.rho), objectives, worst)


class Shifting(AchievementScalarisingFunction):
    def __call__(self, objectives):
        objectives -= 1.0
        return super().__call__(objectives)


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize(
    ("plugin", "explanation"),
    [
        (Unready, "not ready"),
        (Unrecorded, "not plain"),
        (Undescribed, "cannot be made without values"),
        (Sharing, "prepared the original too"),
        (Backwards, "does not get a lower scalar"),
        (Summed, "shape"),
        (Relative, "differ from row by row"),
        (Divided, "not finite"),
        (Shifting, "altered the objectives"),
    ],
)
def test_a_scalariser_at_fault_is_found(plugin, explanation):
    with pytest.raises(AssertionError, match=explanation):
        check_scalariser(plugin, {"rho": 0.05})


@dataclass(frozen=True)
class Speed:
    speed: float = parameter(1.0, unit="m/s", meaning="speed")


class Steady:
    """A track model without fault: the force of a passage is its speed."""

    Parameters = Speed
    metrics = (Quantity("F_max", "N"),)
    histories = (Quantity("force", "N"),)

    def warm_up(self):
        """Nothing to compile."""

    def check(self, parameters):
        """Everything is allowed."""

    def simulate(self, parameters, histories=False):
        return Response({"F_max": parameters.speed}, {"force": np.ones(3)} if histories else {})


class Unannounced(Steady):
    metrics = ()


class Diverging(Steady):
    def simulate(self, parameters, histories=False):
        return Response({"F_max": float("nan")})


class Talkative(Steady):
    def simulate(self, parameters, histories=False):
        return super().simulate(parameters, True)


class Silenced(Steady):
    def simulate(self, parameters, histories=False):
        return super().simulate(parameters, False)


class Dependent(Steady):
    def simulate(self, parameters, histories=False):
        return replace(super().simulate(parameters, histories), metrics={"F_max": 1.0 + histories})


class Drifting(Steady):
    count = itertools.count()

    def __init__(self):
        self.drift = float(next(Drifting.count))

    def simulate(self, parameters, histories=False):
        return replace(super().simulate(parameters, histories), metrics={"F_max": self.drift})


class Interfering(Steady):
    def simulate(self, parameters, histories=False):
        object.__setattr__(parameters, "speed", 2.0)
        return super().simulate(parameters, histories)


class Drawing(Steady):
    """A track model without fault that draws."""

    label = "what is seen"

    def figures(self, passages, names=()):
        for name in names:
            if name not in ("force", "speed"):
                raise InputError(name)
        return {name: self.figure() for name in names or ("force", "speed")}

    def figure(self):
        made = Figure()
        made.set_label(self.label)
        return made


class Captionless(Drawing):
    label = ""


class Empty(Drawing):
    def figures(self, passages, names=()):
        return {}


class DrawingAll(Drawing):
    def figures(self, passages, names=()):
        return super().figures(passages)


class DrawingAnything(Drawing):
    def figures(self, passages, names=()):
        return {name: self.figure() for name in names or ("force", "speed")}


def test_a_track_model_may_draw():
    check_track_model(Drawing)


@pytest.mark.parametrize(
    ("plugin", "explanation"),
    [
        (Captionless, "figure force has no label"),
        (Empty, "but there are none"),
        (DrawingAll, "other figures are returned than speed"),
        (DrawingAnything, "not refused with an InputError"),
        (Unannounced, "not the announced"),
        (Diverging, "not a finite float"),
        (Talkative, "without being asked"),
        (Silenced, "histories .* are not the announced"),
        (Dependent, "when histories are asked for"),
        (Drifting, "two passages"),
        (Interfering, "changed its parameters"),
    ],
)
def test_a_track_model_at_fault_is_found(plugin, explanation):
    check_track_model(Steady)
    with pytest.raises(AssertionError, match=explanation):
        check_track_model(plugin)
