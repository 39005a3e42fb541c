"""Design problem B: what its designs are, against an independent implementation, and what sites may ask for."""

import json
import pickle
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.optimize import minimize

import railsearch
from command_line import Answer
from railsearch.errors import InputError

NAME = "level-crossing-preference"
STUDY = [11, 0, 89.0, 50.0, 50.0, 53]
# Everything unequal, so that a reversed order, a strip on the wrong side or a side that is no mirror image would be seen.
UNEQUAL = np.array([13.0, 4, 900.0, 300.0, 60.0, 31])
REFERENCE = Path(__file__).parents[1] / "reference" / "level_crossing.json"


@pytest.fixture(scope="module")
def problem() -> Any:
    return railsearch.problem(NAME)


def sleepers(problem: Any, design: np.ndarray) -> Any:
    """Sleepers of a design as they were laid: distances from the crossing outwards, by side."""
    histories = problem.model.simulate(problem.parameters(design), histories=True).histories
    position = histories["sleeper_position"]
    return 100.0 - position[position < 100.0][::-1], position[position > 100.0] - 106.0


def test_an_independent_implementation_has_the_same_values(problem: Any) -> None:
    runs = json.loads(REFERENCE.read_text(encoding="utf-8"))["runs"]
    (run,) = [r for r in runs if r["problem"] == "B" and r["reading"] == "per rail seat" and r["time_step"] == 1e-3]
    assert run["design"] == STUDY
    outcome = problem.simulate(np.array(STUDY))
    expected = [run["metrics"]["E_adjacent"], run["metrics"]["A_max"], 9207.0]
    np.testing.assert_allclose(outcome.objectives, expected, rtol=1e-6)
    assert outcome.metrics["E_rms"] == pytest.approx(run["metrics"]["E_rms"], rel=1e-6)
    assert outcome.metrics["F_max"] == pytest.approx(run["metrics"]["F_max"], rel=1e-6)


def test_energy_is_compared_between_neighbours_only(problem: Any) -> None:
    histories = problem.model.simulate(problem.parameters(UNEQUAL), histories=True).histories
    energy = histories["sleeper_energy"][histories["sleeper_position"] < 100.0][-20:]
    largest = max(abs(float(a) - float(b)) for a, b in zip(energy[1:], energy[:-1], strict=True))
    assert problem.simulate(UNEQUAL).objectives[0] == largest
    assert largest < np.ptp(energy)


def test_the_acceleration_is_measured_from_12_m_before_to_the_second_interface(problem: Any) -> None:
    histories = problem.model.simulate(problem.parameters(UNEQUAL), histories=True).histories
    x = histories["wheel_position"]
    inside = histories["carbody_acceleration"][(x >= 88.0 - 1e-9) & (x <= 106.0 + 1e-9)]
    assert problem.simulate(UNEQUAL).objectives[1] == np.ptp(inside)
    assert x.size == 3291 + 1


@pytest.mark.parametrize(("xs", "bays"), [(10, 10), (11, 9), (12, 8), (13, 7), (14, 7)])
def test_whole_spacings_fill_the_five_metres(problem: Any, xs: int, bays: int) -> None:
    spacing = 0.05 * xs
    expected = [*(spacing * np.arange(1, bays + 1)), bays * spacing + 0.6, bays * spacing + 1.2]
    for side in sleepers(problem, np.array([xs, *UNEQUAL[1:]])):
        np.testing.assert_allclose(side[: bays + 2], expected, atol=1e-9)


def test_pads_and_strengthened_sleepers_are_mirrored_and_the_strip_is_not(problem: Any) -> None:
    from railsearch_plugins.track_models.level_crossing.assembly import assemble_track, pad_values

    parameters = problem.parameters(UNEQUAL)
    laid = assemble_track(parameters).sleepers
    before = int(np.sum(laid.position < 100.0))
    for pads, masses in (
        (laid.pad_stiffness[:before][::-1], laid.mass[:before][::-1]),
        (laid.pad_stiffness[before:], laid.mass[before:]),
    ):
        assert pads[:5].tolist() == [60e6, 300e6, 900e6, 78e6, 78e6]
        assert masses[:6].tolist() == [150.0] * 4 + [125.5] * 2
    stiffness, damping = pad_values(parameters, laid)
    np.testing.assert_allclose(damping, stiffness * 120e3 / 1120e6)
    assert parameters.zone.type_2_strip_length == 1.55
    strip, none = problem.simulate(UNEQUAL), problem.simulate(np.array([*UNEQUAL[:5], 0]))
    assert strip.objectives[0] != none.objectives[0]


def test_the_reference_design_is_no_measure(problem: Any) -> None:
    assert problem.reference.tolist() == [12, 0, 78, 78, 78, 0]
    near, _ = sleepers(problem, problem.reference)
    np.testing.assert_allclose(np.diff(near), 0.6, atol=1e-9)
    zone = problem.track.zone
    assert set(zone.pad_stiffness) == {problem.track.railpad.stiffness}


def test_the_reference_design_is_the_zone_of_the_site() -> None:
    zone = {"pad_stiffness": [3e8, 2e8, 1e8], "sleeper_distances": [0.7] * 7, "type_2_strip_length": 0.15}
    site = {"track": {"zone": zone | {"strengthened_sleepers": 2}}}
    assert railsearch.problem(NAME, sections=site).reference.tolist() == [14, 2, 300, 200, 100, 3]


def test_the_cost_is_known_without_a_simulation(problem: Any) -> None:
    designs = np.array([STUDY, UNEQUAL, problem.reference])
    assert problem.construction_cost(designs).tolist() == [9207.0, 2767.7 + 11 * 400.0 + 4 * 600.0, 9000.0]
    assert list(problem.exact_objectives) == ["C_cap"]
    assert problem.exact_objectives["C_cap"](designs).tolist() == problem.construction_cost(designs).tolist()
    simulated = [problem.simulate(design).metrics["C_cap"] for design in designs]
    assert simulated == problem.construction_cost(designs).tolist()


@pytest.mark.parametrize("names", [("C_cap",), ("A_max", "E_max")])
def test_any_choice_of_objectives(names: tuple[str, ...]) -> None:
    problem = railsearch.problem(NAME, objectives=names)
    outcome = problem.simulate(UNEQUAL)
    assert outcome.objectives.tolist() == [outcome.metrics[name] for name in names]
    assert set(outcome.metrics) == {"E_max", "A_max", "C_cap", "E_rms", "F_max"}


def test_plain_pymoo_and_another_process(problem: Any) -> None:
    result = minimize(problem, NSGA2(pop_size=3), ("n_eval", 3), seed=1, save_history=True)
    individual = result.history[0].pop[0]
    there = pickle.loads(pickle.dumps(problem))
    assert np.array_equal(individual.F, there.simulate(problem.space.rounded(individual.X)).objectives)


@pytest.mark.parametrize(
    ("sections", "message"),
    [
        (
            {"variables": {"xs": {"lower": 9}}},
            r"cost.spacings: there are costs for 10, 11, 12, 13, 14 \(0.05 m\), received 9",
        ),
        ({"variables": {"xn": {"upper": 16}}}, "cost.sleepers: 15 sleepers are laid, received 16 strengthened ones"),
        ({"variables": {"xl": {"upper": 121}}}, "at the upper bounds .* must fit in the crossing of 6 m"),
        ({"variables": {"xr1": {"lower": -1.0}}}, "xr1.lower: allowed is > 0, received -1.0 MN/m"),
        ({"cost": {"spacing_costs": [1.0]}}, "cost: spacing_costs: one cost for each of the 5 spacings"),
        ({"layout": {"stretch": 4.5}}, r"one distance for all whole bays of the 4.5 m .*received \(0.6"),
        ({"track": {"zone": {"sleeper_distances": [0.6] * 7}}}, "for instance 8 of 0.6 m in 5 m"),
        ({"track": {"zone": {"sleeper_distances": [0.6] * 7 + [0.55]}}}, "one distance for all"),
        ({"track": {"zone": {"sleeper_distances": []}}}, "one distance for all"),
        ({"track": {"zone": {"type_2_strip_length": 0.12}}}, "whole multiples of 0.05 m in this problem"),
        ({"track": {"zone": {"pad_stiffness": [78e6]}}}, "three pads, the last adjacent to the crossing, received 1"),
    ],
)
def test_sites_that_are_not_allowed(sections: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        railsearch.problem(NAME, sections=sections)


def test_a_stretch_shorter_than_a_spacing() -> None:
    site = {"layout": {"stretch": 0.65}, "track": {"zone": {"sleeper_distances": [0.6]}}}
    with pytest.raises(InputError, match=r"variables.xs.upper is 0.7 m, received 0.65 m; lengthen the stretch"):
        railsearch.problem(NAME, sections=site)


def test_another_stretch_and_other_prices() -> None:
    site = {
        "layout": {"stretch": 2.5},
        "track": {"zone": {"sleeper_distances": [0.6] * 4}},
        "variables": {"xs": {"lower": 11, "upper": 13}},
        "cost": {"spacings": [11, 12, 13], "spacing_costs": [3.0, 2.0, 1.0], "sleeper": 0.0, "strengthened_sleeper": 1.0},
    }
    problem: Any = railsearch.problem(NAME, sections=site)
    assert problem.simulate(np.array([11, 5, 78, 78, 78, 0])).metrics["C_cap"] == 8.0
    assert problem.parameters(np.array([13, 5, 78, 78, 78, 0])).zone.sleeper_distances == (0.65,) * 3


def test_the_command_line_describes_makes_a_site_and_evaluates(railsearch: Callable[..., Answer], tmp_path: Path) -> None:
    described = railsearch("describe", NAME)
    assert described.code == 0
    assert all(word in described.out for word in ("E_max", "A_max", "C_cap", "cost.spacing_costs", "layout.stretch"))
    site = tmp_path / "site.toml"
    assert railsearch("init", NAME, "--out", site).code == 0
    values = [
        word
        for name, value in zip(("xs", "xn", "xr1", "xr2", "xr3", "xl"), STUDY, strict=True)
        for word in ("--set", f"{name}={value:g}")
    ]
    answers = [railsearch("evaluate", NAME, *values, "--json", *extra) for extra in ((), ("--parameters", site))]
    assert [answer.code for answer in answers] == [0, 0]
    documents = [json.loads(answer.out) for answer in answers]
    assert documents[0] == documents[1]
    assert documents[0]["objectives"]["C_cap"] == 9207.0


def test_a_search_runs_and_draws(railsearch: Callable[..., Answer], tmp_path: Path) -> None:
    words = ("run", NAME, "--strategy", "random", "--objectives", "A_max", "--budget", 3, "--seed", 1)
    answer = railsearch(*words, "--out", tmp_path / "run", "--json")
    assert answer.code == 0, answer.err
    assert json.loads(answer.out)["failed"] == 0
    drawn = {path.stem for path in (tmp_path / "run" / "figures").glob("*.png")}
    assert drawn == {"history", "energy", "acceleration", "zone"}


def test_the_pictures_say_what_the_numbers_say(problem: Any) -> None:
    figures = problem.figures({"reference": problem.reference, "best": UNEQUAL})
    assert list(figures) == ["energy", "acceleration", "zone"]
    for name, metric, unit, decimals in (("energy", "E_max", "N·m", 4), ("acceleration", "A_max", "m/s²", 3)):
        _, ranges = figures[name].axes
        for bar, design, label in zip(ranges.patches, (problem.reference, UNEQUAL), ranges.get_xticklabels(), strict=True):
            expected = problem.simulate(design).metrics[metric]
            assert bar.get_height() == pytest.approx(expected, rel=1e-9)
            assert f"{metric}\n{expected:.{decimals}f} {unit}" in label.get_text()


def test_the_marked_sleepers_are_the_neighbours_that_differ_most(problem: Any) -> None:
    (curves, _) = problem.figures({"best": UNEQUAL})["energy"].axes
    marked = sorted(float(line.get_xdata()[0]) for line in curves.lines if line.get_marker() in "^v")
    near, _ = sleepers(problem, UNEQUAL)
    ranks = [int(np.argmin(np.abs(near + place))) for place in marked]
    assert ranks[0] - ranks[1] == 1


def test_speed_and_windows_of_the_site_are_used(problem: Any) -> None:
    slower = {"track": {"passage": {"speed": 30.0}}}
    changed = railsearch.problem(NAME, sections=slower)
    assert changed.track == replace(problem.track, passage=replace(problem.track.passage, speed=30.0))  # type: ignore[attr-defined]
