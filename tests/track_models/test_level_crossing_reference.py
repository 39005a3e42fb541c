"""The fast model against an independent implementation's results and against the refactorising twin."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import refactorising_twin
from crossings import BUMPS, design_a, design_b, short_crossing

from railsearch_plugins.track_models.level_crossing import LevelCrossing

REFERENCE = json.loads((Path(__file__).parents[1] / "reference" / "level_crossing.json").read_text(encoding="utf-8"))


def label(run):
    return f"{run['problem']}-{run['reading']}-{run['design']}-{run['time_step']}"


@pytest.fixture(scope="module", params=REFERENCE["runs"], ids=label)
def reference_and_response(request):
    run = request.param
    parameters = {"A": design_a, "B": design_b}[run["problem"]](
        run["design"], run["reading"], run["element_length"], run["time_step"]
    )
    return run, LevelCrossing().simulate(parameters, histories=True), parameters


def test_every_metric_to_a_millionth(reference_and_response):
    run, response, _ = reference_and_response
    assert set(response.metrics) == set(run["metrics"])
    for name, expected in run["metrics"].items():
        assert response.metrics[name] == pytest.approx(expected, rel=1e-6), name


def test_energy_of_every_sleeper_to_a_millionth(reference_and_response):
    run, response, _ = reference_and_response
    np.testing.assert_allclose(response.histories["sleeper_position"], run["sleeper_position"], atol=1e-9)
    np.testing.assert_allclose(response.histories["sleeper_energy"], run["sleeper_energy"], rtol=1e-6)


def test_histories_to_their_rounding(reference_and_response):
    run, response, parameters = reference_and_response
    history = run["history"]
    step = parameters.passage.speed * parameters.passage.time_step
    at = np.round(np.array(history["wheel_position"]) / step).astype(int)
    np.testing.assert_allclose(response.histories["wheel_position"][at], history["wheel_position"], atol=6e-6)
    np.testing.assert_allclose(response.histories["wheel_rail_force"][at], history["wheel_rail_force"], atol=6e-3)
    np.testing.assert_allclose(1e3 * response.histories["rail_displacement"][at], history["rail_displacement_mm"], atol=6e-7)
    np.testing.assert_allclose(response.histories["carbody_acceleration"][at], history["carbody_acceleration"], atol=6e-8)


@pytest.mark.parametrize(
    "parameters",
    [short_crossing(), replace(short_crossing(), irregularity=BUMPS)],
    ids=["level", "irregular"],
)
def test_one_factorisation_equals_refactorisation_at_every_step(parameters):
    # Elements of 0.2 m: with shorter ones the rounding of their stiffness, 12 EI/l³, is what differs.
    twin = refactorising_twin.run(parameters)
    fast = LevelCrossing().simulate(parameters, histories=True).histories
    np.testing.assert_allclose(fast["wheel_position"], twin.position, rtol=1e-13)
    np.testing.assert_allclose(fast["wheel_rail_force"], twin.force, rtol=0.0, atol=1e-7)
    np.testing.assert_allclose(fast["rail_displacement"], twin.rail, rtol=0.0, atol=1e-14)
    np.testing.assert_allclose(fast["carbody_acceleration"], twin.carbody_acceleration, rtol=0.0, atol=1e-10)
    np.testing.assert_allclose(fast["sleeper_energy"], twin.sleeper_energy, rtol=1e-10)
