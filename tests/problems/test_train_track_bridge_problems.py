"""The problems on a train-track-bridge system: extremes over uncertain inputs, and designs of the track."""

import json
from dataclasses import asdict

import numpy as np
import pytest

import railsearch as package
from railsearch.errors import InputError
from railsearch_problems.train_track_bridge_inputs import UNCERTAIN_INPUTS

SHORT = {"vehicles": 1, "bridge_length": 6.0, "start_position": -5.0, "end_position": 8.0, "irregularity_fade": 2.0}
EXTREMES, DESIGNS = "train-track-bridge", "train-track-bridge-design"


def problem(name=EXTREMES, objectives=(), **sections):
    return package.problem(name, objectives=objectives, sections={"track": SHORT} | sections)


def test_variables_are_parameters_of_the_track_within_the_ranges_of_their_distributions():
    made = problem()
    assert made.space.names == made.distributions.names == tuple(UNCERTAIN_INPUTS)
    np.testing.assert_allclose(made.space.lower, made.distributions.ranges(0.01)[:, 0])
    np.testing.assert_allclose(made.space.upper, made.distributions.ranges(0.01)[:, 1])
    design = made.space.lower + 0.3 * (made.space.upper - made.space.lower)
    track, start = asdict(made.parameters(design)), asdict(made.track)
    assert {name: track[name] for name in made.space.names} == made.space.named(design)
    assert {name for name in track if track[name] != start[name]} == set(made.space.names)
    assert asdict(made.parameters(made.reference)) == start


@pytest.mark.parametrize(("extreme", "sign"), [("largest", -1.0), ("smallest", 1.0)])
def test_criteria_are_maximised_or_minimised(extreme, sign):
    made = problem(objectives=["U_d", "W_z"], search={"extreme": extreme})
    outcome, metrics = made.simulate(made.reference), made.model.simulate(made.track).metrics
    np.testing.assert_array_equal(outcome.objectives, [sign * metrics["U_d"], sign * metrics["W_z"]])
    known = {metric.name: metric.sign * outcome.metrics[metric.name] for metric in made.metrics}
    assert known == {name: metrics[name] for name in known}
    assert {"W_z", "U_r", "A_s", "U_d", "contact_force_min"} < set(known)
    wanted = {metric.name: metric.sign for metric in made.metrics}
    assert wanted["contact_force_min"] == -sign
    assert wanted["contact_force_max"] == wanted["W_z"] == sign


def test_uncertain_inputs_are_the_users():
    own = {
        "pad_stiffness": {"distribution": "normal", "mean": 5e8, "std": 5e7},
        "speed": {"distribution": "triangular", "lower": 30.0, "mode": 38.0, "upper": 45.0},
    }
    made = problem(
        track=SHORT | {"pad_stiffness": 5e8}, inputs={"distributions": own, "fixed": ["ballast_angle"], "level": 0.05}
    )
    assert set(made.space.names) == set(UNCERTAIN_INPUTS) - {"ballast_angle"} | {"speed"}
    pads = made.space.names.index("pad_stiffness")
    assert made.space.lower[pads] == pytest.approx(5e8 - 1.6448536 * 5e7, rel=1e-6)
    assert made.distributions.marginals["speed"].support == (30.0, 45.0)
    assert made.space.variables[-1].unit == "m/s"
    assert made.parameters(made.reference).ballast_angle == 25.0


FAULTS = [
    ({"inputs": {"distributions": {"pad_siffness": {}}}}, "'pad_siffness' is no number of the track; did you mean 'pad_"),
    ({"inputs": {"fixed": ["vehicle"]}}, "'vehicle' is no number of the track"),
    ({"inputs": {"distributions": {"sleeper_mass": {"distribution": "gauss"}}}}, "mass: distribution: unknown 'gauss'"),
    (
        {"inputs": {"distributions": {"sleeper_mass": {"distribution": "normal", "mean": 300.0, "std": 300.0}}}},
        r"inputs.distributions.sleeper_mass: normal.* leaves its physical range, 0 to inf, .* truncate = true under",
    ),
    ({"inputs": {"distributions": {"sleeper_mass": {"distribution": "uniform", "lower": 300.0, "upper": 400.0}}}},
     r"track.sleeper_mass: 272.5 is the reference of a variable whose range is 300 to 400"),
    ({"inputs": {"fixed": list(UNCERTAIN_INPUTS)}}, "one uncertain input or more is needed"),
    ({"inputs": {"fixed": ["speed"], "distributions": {"speed": {}}}}, "fixed: speed: also under inputs.distributions"),
    ({"track": SHORT | {"irregularity_spectrum": "none"}}, "irregularity_amplitude has no effect on this track"),
    ({"track": SHORT | {"ballast_stiffness": 1e8}}, "ballast_modulus has no effect on this track"),
    ({"inputs": {"level": 0.5}}, "level: allowed is > 0 and < 0.5"),
    ({"search": {"extreme": "both"}}, "extreme: allowed is 'largest' or 'smallest'"),
    ({"track": SHORT | {"speed": 300.0}}, "speed: the speed must stay below the critical speed"),
    ({"track": SHORT | {"speed": 200.0}}, "variables: at the upper bounds train-track-bridge.speed"),
]  # fmt: skip


@pytest.mark.parametrize(("sections", "message"), FAULTS, ids=[message[:30] for _, message in FAULTS])
def test_faults_are_named(sections, message):
    with pytest.raises(InputError, match=message):
        problem(**sections)


def test_a_distribution_can_be_cut_off():
    own = {"sleeper_mass": {"distribution": "normal", "mean": 300.0, "std": 100.0}}
    with pytest.warns(UserWarning, match="sleeper_mass.*cut off"):
        made = problem(inputs={"distributions": own, "truncate": True})
    assert made.distributions.marginals["sleeper_mass"].support[0] == 0.0


def test_what_is_cut_off_at_a_physical_range_is_still_searched_between_percentiles():
    own = {"bridge_damping": {"distribution": "normal", "mean": 0.02, "cov": 0.5}}
    with pytest.warns(UserWarning, match="bridge_damping.*cut off"):
        made = problem(inputs={"distributions": own, "truncate": True})
    place = made.space.names.index("bridge_damping")
    marginal = made.distributions.marginals["bridge_damping"]
    assert (made.space.lower[place], made.space.upper[place]) == pytest.approx(tuple(marginal.percentile([0.01, 0.99])))
    assert made.space.upper[place] < 0.05


def test_limits_are_constraints():
    free = problem(DESIGNS)
    assert free.n_ieq_constr == 0
    assert free.space.names == ("pad_stiffness", "ballast_depth", "sleeper_mass")
    metrics = free.simulate(free.reference).metrics
    limits = {"A_s": 0.5 * metrics["A_s"], "U_d": 2.0 * metrics["U_d"]}
    made = problem(DESIGNS, objectives=["U_r"], limits=limits)
    outcome = made.simulate(made.reference)
    np.testing.assert_allclose(outcome.constraints, [1.0, -0.5])
    np.testing.assert_array_equal(outcome.objectives, [metrics["U_r"]])


def test_design_outside_its_bounds_or_unsound_bounds_are_refused():
    with pytest.raises(InputError, match=r"track.ballast_depth: 0.7 is the reference .* range is 0.3 to 0.6"):
        problem(DESIGNS, track=SHORT | {"ballast_depth": 0.7})
    with pytest.raises(InputError, match=r"limits.U_r: allowed is > 0"):
        problem(DESIGNS, limits={"U_r": -1.0})


def test_stiffer_and_softer_pads_trade_rail_for_sleepers():
    """Soft pads let the rail down and spare the sleepers: the design problem has something to decide."""
    made = problem(DESIGNS)
    soft, stiff = (np.array([pad, 0.45, 272.5]) for pad in (1.5e8, 1.4e9))
    (soft_rail, soft_sleepers), (stiff_rail, stiff_sleepers) = (made.simulate(d).objectives for d in (soft, stiff))
    assert soft_rail > stiff_rail
    assert soft_sleepers < stiff_sleepers


def test_sampled_from_the_command_line(railsearch, tmp_path):
    """Every criterion is sampled, from the distributions, beyond the ranges of a search."""
    words = [word for name, value in SHORT.items() for word in ("--set", f"track.{name}={value}")]
    out = tmp_path / "samples.csv"
    answer = railsearch("sample", EXTREMES, "--n", 40, "--design", "lhs", "--seed", 2, "--out", out, *words, "--json")
    assert answer.code == 0, answer.err
    rows = {row["name"]: row for row in json.loads(answer.out)["quantities"]}
    assert all(rows[name]["values"] == 40 for name in ("W_z", "U_r", "A_s", "U_d"))
    from railsearch.samples import read_samples

    inputs = read_samples(out).inputs
    made = problem()
    levels = made.distributions.marginals["bridge_modulus"].cdf(inputs["bridge_modulus"])
    np.testing.assert_array_equal(np.sort(np.floor(40 * levels)), np.arange(40))
    assert levels.min() < 0.025 < 0.975 < levels.max()


def test_designs_are_drawn_beside_one_another():
    made = problem(DESIGNS)
    other = made.reference * [0.5, 1.0, 1.1]
    figures = made.figures({"reference": made.reference, "best": other})
    assert {"snapshot", "force", "histories", "envelopes"} == set(figures)
    words = {text.get_text() for text in figures["histories"].findobj() if hasattr(text, "get_text")}
    assert {"reference", "best"} <= words
