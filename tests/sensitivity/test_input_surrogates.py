"""Registered surrogates on random inputs in their own units."""

import numpy as np
import pytest

from railsearch.distributions import random_vector
from railsearch.errors import InputError, PluginError
from railsearch.plugin_manager import load_plugins
from railsearch.sampling import latin_hypercube
from railsearch.sensitivity import ExactModel, extreme_surfaces, factors_on, input_space, input_surrogate

REGISTRY = load_plugins()
INPUTS = random_vector(
    {
        "modulus": {"distribution": "lognormal", "mean": 2.1e11, "std": 2.1e10},
        "depth": {"distribution": "uniform", "lower": 0.3, "upper": 0.6},
    }
)


def truth(points):
    return 1e11 / points[:, 0] + points[:, 1] ** 2


@pytest.mark.parametrize("name", ["pce", "kriging", "rbf"])
def test_slopes_and_extremes_in_the_inputs_own_units(name):
    points = latin_hypercube(INPUTS, 150, np.random.default_rng(0))
    surrogate = input_surrogate(REGISTRY, name, INPUTS)
    surrogate.fit(points, truth(points))
    inner = INPUTS.from_uniform(np.random.default_rng(1).uniform(0.1, 0.9, (20, 2)))
    np.testing.assert_allclose(surrogate.predict(inner), truth(inner), atol=5e-3)
    for k, step in enumerate((2e7, 2e-5)):
        moved = step * np.eye(2)[k]
        numeric = (surrogate.predict(inner + moved) - surrogate.predict(inner - moved)) / (2.0 * step)
        np.testing.assert_allclose(surrogate.gradient(inner)[:, k], numeric, rtol=1e-3, atol=1e-6 * np.abs(numeric).max())
    # Away from the corners, where there are no points: an interpolant may be off by half of the range there.
    factors = factors_on(input_space(INPUTS, 0.15, {"depth": (0.35, 0.55)}), 6)
    found = extreme_surfaces(surrogate, factors, np.random.default_rng(2)).importances()
    exact = extreme_surfaces(ExactModel(truth, factors.space), factors, np.random.default_rng(2)).importances()
    assert found == pytest.approx(exact, abs=0.02)


def test_settings_reach_the_surrogate_and_bad_ones_are_named():
    surrogate = input_surrogate(REGISTRY, "pce", INPUTS, {"degree": 1, "growth": False})
    points = latin_hypercube(INPUTS, 20, np.random.default_rng(0))
    surrogate.fit(points, truth(points))
    assert surrogate.expansion.indices.max() == 1
    with pytest.raises(InputError, match="degre"):
        input_surrogate(REGISTRY, "pce", INPUTS, {"degre": 1})
    with pytest.raises(PluginError, match="did you mean 'kriging'"):
        input_surrogate(REGISTRY, "krigging", INPUTS)
    with pytest.raises(InputError, match="depth"):
        input_surrogate(REGISTRY, "rbf", INPUTS).fit(np.array([[2e11, 0.7]]), np.zeros(1))
