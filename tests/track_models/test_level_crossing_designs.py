"""What must hold over designs of problem A, on a seeded sample (Shang et al. 2023, sections 4 and 5)."""

from dataclasses import replace

import numpy as np
import pytest
from crossings import design_a
from scipy.stats import spearmanr

from railsearch_plugins.track_models.level_crossing import LevelCrossing

LOWER = np.array([50, 50, 50, 0, 3, 3, 3, 0])
UPPER = np.array([1200, 1200, 1200, 20, 7, 7, 7, 120])


def sample(count, seed):
    generator = np.random.default_rng(seed)
    designs = generator.integers(LOWER, UPPER, (count, 8), endpoint=True).astype(float)
    designs[:, :3] = generator.uniform(LOWER[:3], UPPER[:3], (count, 3))
    return designs


@pytest.fixture(scope="module")
def designs():
    return sample(80, seed=7)


@pytest.fixture(scope="module")
def metrics(designs):
    model = LevelCrossing()
    rows = [model.simulate(design_a(design)).metrics for design in designs]
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


@pytest.fixture(scope="module")
def soft_and_stiff():
    """Metrics with soft and with stiff pads, all else equal, in the default window and the last 2 m before the crossing."""
    model, pairs = LevelCrossing(), []
    for design in sample(12, seed=11):
        for window in ("default", "last 2 m"):
            responses = []
            for pad in (100.0, 1100.0):
                parameters = design_a([pad, pad, pad, *design[3:]])
                if window == "last 2 m":
                    parameters = replace(parameters, windows=replace(parameters.windows, force_before=2.0, force_after=0.0))
                responses.append(model.simulate(parameters).metrics)
            pairs.append((window, *responses))
    return pairs


def test_soft_pads_lower_the_energy_in_every_design(soft_and_stiff):
    assert all(soft["E_rms"] < stiff["E_rms"] for _, soft, stiff in soft_and_stiff)


def test_stiff_pads_lower_the_force_next_to_the_crossing_in_every_design(soft_and_stiff):
    assert all(stiff["F_rms"] < soft["F_rms"] for window, soft, stiff in soft_and_stiff if window == "last 2 m")


def test_stiff_pads_raise_the_force_by_a_few_newtons_in_the_long_window(soft_and_stiff):
    rises = [stiff["F_rms"] - soft["F_rms"] for window, soft, stiff in soft_and_stiff if window == "default"]
    assert min(rises) > 0.0
    assert max(rises) < 100.0


def test_mean_levels_vary_ten_times_less_than_extremes(metrics):
    variation = {name: values.std() / values.mean() for name, values in metrics.items()}
    assert 10.0 * max(variation["F_rms"], variation["E_rms"]) <= min(variation["F_max"], variation["E_max"])


def test_a_short_distance_to_the_first_sleeper_lowers_the_force_range(designs, metrics):
    assert spearmanr(designs[:, 6], metrics["F_max"]).statistic >= 0.6


def test_force_and_energy_ranges_are_not_correlated_but_conflict(metrics):
    force, energy = metrics["F_max"], metrics["E_max"]
    assert abs(spearmanr(force, energy).statistic) < 0.3
    assert energy[np.argmin(force)] > 1.1 * energy.min()
    assert force[np.argmin(energy)] > 1.1 * force.min()


def test_published_optimum_lowers_the_force_range_and_raises_the_energy_range():
    reference, published = (
        LevelCrossing().simulate(design_a(design)).metrics
        for design in ([1120, 1120, 1120, 8, 6, 6, 4, 0], [214, 155, 50, 5, 6, 7, 3, 0])
    )
    assert published["F_max"] / reference["F_max"] == pytest.approx(1.0 - 0.365, abs=1e-3)
    assert published["E_max"] / reference["E_max"] == pytest.approx(1.0 + 0.075, abs=1e-3)
