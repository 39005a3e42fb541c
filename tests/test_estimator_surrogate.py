"""Scikit-learn regressors as surrogates by the dotted name of their class."""

import numpy as np
import pytest
from sklearn.ensemble import BaggingRegressor, RandomForestRegressor
from sklearn.tree import DecisionTreeRegressor

from railsearch.errors import CapabilityError, InputError, PluginError, SurrogateError
from railsearch.estimator_surrogate import estimator_surrogate
from railsearch.interfaces import lacking, require_methods
from railsearch.plugin_manager import load_plugins
from railsearch.testing import MIXED, REAL, Trial, run_trial
from railsearch.testing.surrogates import check_made_surrogate
from railsearch_plugins.strategies.lmsrs import LocalMetricSearch

FOREST = "sklearn.ensemble.RandomForestRegressor"
PROCESS = "sklearn.gaussian_process.GaussianProcessRegressor"
NEIGHBOURS = "sklearn.neighbors.KNeighborsRegressor"


def sample(n=40, dimension=3):
    points = np.random.default_rng(0).random((n, dimension))
    return points, np.sin(3.0 * points).sum(axis=1)


@pytest.mark.parametrize(
    ("name", "settings"),
    [
        (NEIGHBOURS, {"n_neighbors": 3}),
        (FOREST, {"n_estimators": 5}),
        (PROCESS, {"alpha": 1e-6, "optimizer": None}),
        ("railsearch_plugins.gaussian_process.estimator.KrigingRegressor", {"starts": 1}),
    ],
)
def test_the_conformance_suite_holds(name, settings):
    check_made_surrogate(lambda dimension: estimator_surrogate(name, dimension, settings), interpolates=False)


def test_it_is_the_regressor_with_its_settings_and_a_fixed_seed():
    points, values = sample()
    surrogate = load_plugins().surrogate(FOREST, 3, {"n_estimators": 7, "max_depth": 2})
    surrogate.fit(points, values)
    twin = RandomForestRegressor(n_estimators=7, max_depth=2, random_state=0).fit(points, values)
    np.testing.assert_array_equal(surrogate.predict(points), twin.predict(points))
    other = load_plugins().surrogate(FOREST, 3, {"n_estimators": 7, "max_depth": 2, "random_state": 1})
    other.fit(points, values)
    assert np.any(other.predict(points) != twin.predict(points))


class Bagged(BaggingRegressor):
    """Trees in a bag, which can be made without arguments."""

    def __init__(self, estimator=None, n_estimators=5, random_state=None):
        super().__init__(estimator or DecisionTreeRegressor(), n_estimators=n_estimators, random_state=random_state)


def test_nested_regressors_are_seeded_too():
    settings = {"estimator__max_depth": 2, "n_estimators": 5}
    name = f"{__name__}.Bagged"
    points, values = sample()
    predictions = []
    for _ in range(2):
        surrogate = estimator_surrogate(name, 3, settings)
        surrogate.fit(points, values)
        predictions.append(surrogate.predict(points))
    np.testing.assert_array_equal(*predictions)


def test_deviation_is_there_where_predict_gives_one():
    points, values = sample()
    surrogate = estimator_surrogate(PROCESS, 3, {})
    surrogate.fit(points, values)
    assert lacking(surrogate, ["gradient", "deviation", "deviation_gradient"]) == ["gradient", "deviation_gradient"]
    twin = surrogate._regressor.predict(points[:5] + 0.01, return_std=True)[1]
    np.testing.assert_array_equal(surrogate.deviation(points[:5] + 0.01), twin)


def test_what_a_regressor_lacks_is_a_clear_error():
    points, values = sample()
    surrogate = estimator_surrogate(NEIGHBOURS, 3, {})
    surrogate.fit(points, values)
    for method, words in (("gradient", "no gradient"), ("deviation", "no standard deviation")):
        with pytest.raises(SurrogateError, match=f"surrogate {NEIGHBOURS} has {words}; take one that has"):
            getattr(surrogate, method)(points)
    with pytest.raises(SurrogateError, match="no gradient of the standard deviation"):
        surrogate.deviation_gradient(points)
    with pytest.raises(CapabilityError, match="has no gradient and no deviation, which a test needs: take another"):
        require_methods(surrogate, "neighbours", ["gradient", "deviation"], "a test", "take another")


class Unrelated:
    """Nothing of a regressor."""


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("sklearn.ensembl.RandomForestRegressor", r"sklearn\.ensembl cannot be imported \(ModuleNotFoundError.*correct the"),
        (
            "sklearn.ensemble.RandomForestRegresor",
            r"sklearn\.ensemble has no RandomForestRegresor; did you mean 'sklearn\.ensemble\.RandomForestRegressor'\?",
        ),
        ("sklearn.ensemble.RandomForestClassifier", "RandomForestClassifier' is not a regressor; a class of scikit-learn's"),
        ("sklearn.ensemble.VotingRegressor", "cannot be made without arguments .*estimators"),
        ("math.sqrt", "'math.sqrt' is not a regressor"),
        (f"{__name__}.Unrelated", "is not a regressor"),
        (".", r"surrogate '\.'.* cannot be imported"),
        ("rbf", None),
    ],
)
def test_names_that_lead_nowhere(name, message):
    if message is None:
        assert load_plugins().surrogate(name, 3, {})
        return
    with pytest.raises(PluginError, match=message):
        load_plugins().surrogate(name, 3, {})


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"trees": 5}, r"surrogate .*RandomForestRegressor: unknown setting 'trees'; allowed are bootstrap, .*n_estimators"),
        ({"n_estimators": -5}, "its settings do not work with 20 points: The 'n_estimators' parameter .* must be an int"),
        ({"n_estimators": "many"}, "its settings do not work with 20 points: The 'n_estimators' parameter"),
    ],
)
def test_settings_are_checked_before_a_search_begins(settings, message):
    with pytest.raises(InputError, match=message):
        load_plugins().surrogate(FOREST, 3, settings)


def test_what_a_regressor_finds_out_when_it_predicts_is_found_before_a_search_begins():
    with pytest.raises(InputError, match="its settings do not work with 22 points: Expected n_neighbors <= n_samples_fit"):
        load_plugins().surrogate("sklearn.neighbors.KNeighborsRegressor", 10, {"n_neighbors": 23})
    assert load_plugins().surrogate("sklearn.neighbors.KNeighborsRegressor", 10, {"n_neighbors": 22})


def test_bad_data_are_refused():
    points, values = sample()
    surrogate = estimator_surrogate(NEIGHBOURS, 3, {})
    with pytest.raises(SurrogateError, match="not fitted"):
        surrogate.predict(points)
    with pytest.raises(SurrogateError, match="not fitted"):
        surrogate.add(points, values)
    with pytest.raises(SurrogateError, match=r"received shapes \(40, 2\) and \(40,\)"):
        surrogate.fit(points[:, :2], values)
    surrogate.fit(points[:3], values[:3])
    with pytest.raises(SurrogateError, match=r"cannot predict from 3 points: .*n_neighbors"):
        surrogate.predict(points)


def test_a_search_goes_with_any_regressor_where_no_gradient_is_needed():
    settings = {"surrogate": NEIGHBOURS, "surrogate_settings": {"n_neighbors": 2}}
    assert len(run_trial(LocalMetricSearch, Trial(REAL, budget=30), settings)) == 30
    assert len(run_trial(LocalMetricSearch, Trial(MIXED, budget=30), {**settings, "tree_search": False})) == 30


def test_a_tree_search_without_a_gradient_is_refused_at_the_door():
    message = "KNeighborsRegressor has no gradient, which the tree search needs: set tree_search = false, or take"
    with pytest.raises(CapabilityError, match=message):
        run_trial(LocalMetricSearch, Trial(MIXED, budget=30), {"surrogate": NEIGHBOURS})


def test_kriging_carries_a_search_with_integers():
    assert len(run_trial(LocalMetricSearch, Trial(MIXED, budget=30), {"surrogate": "kriging"})) == 30
