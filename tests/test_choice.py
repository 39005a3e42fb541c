"""Choosing afterwards: candidates, order, pseudo-weights, trade-offs; preference files on the command line; the page."""

import json
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import railsearch as railsearch_package
from command_line import Answer
from html_page import Page
from railsearch.campaign.definition import load_campaign
from railsearch.campaign.problems import make_problems
from railsearch.choice import choice_document, choose, high_trade_offs, pseudo_weights
from railsearch.commands.options import asked_problem
from railsearch.errors import InputError
from railsearch.interfaces import Evaluation
from railsearch.plugin_manager import Registry, load_plugins
from railsearch.preferences import Linear
from railsearch.result import flat_start, stated_preferences
from railsearch.run import RunSettings, run_search
from sample_problems import Sphere, TwoObjectives
from test_cli import refused, sample_problems

Cli = Callable[..., Answer]
ON_BOTH = {"left": Linear(0.0, 4.0), "right": Linear(0.0, 4.0)}
FILE = """
[preferences.left]
function = "linear"
unit = "N"
best = 0.0
worst = 4.0

[preferences.right]
function = "linear"
best = 0.0
worst = 4.0
"""


@pytest.fixture(scope="module")
def registry() -> Registry:
    return load_plugins()


def evaluated(number: int, design: list[float], constrained: bool = False) -> Evaluation:
    outcome = TwoObjectives(constrained).simulate(np.array(design))
    return Evaluation(number, np.array(design), outcome.objectives, outcome.constraints, outcome.metrics, "initial")


# Objectives (x², (x − 2)²) and one that is dominated: scores (100, 0), (75, 75), (0, 100), (50, 50).
LINE = [evaluated(0, [0, 0, 0, 0]), evaluated(1, [1, 0, 0, 0]), evaluated(2, [2, 0, 0, 0]), evaluated(3, [1, 0, 1, 0])]


def test_the_design_with_the_highest_lowest_score_comes_first(registry: Registry) -> None:
    choice = choose(registry, TwoObjectives(), LINE, "preference-minmax", {"preferences": ON_BOTH})
    assert [candidate.number for candidate in choice.candidates] == [1, 0, 2], "the dominated one is no candidate"
    assert choice.scalars.tolist() == [25.0, 100.0, 100.0]
    np.testing.assert_allclose(choice.scores, [[75.0, 75.0], [100.0, 0.0], [0.0, 100.0]])
    heavier = choose(registry, TwoObjectives(), LINE, "imap", {"preferences": ON_BOTH, "weights": {"right": 9.0}})
    assert [candidate.number for candidate in heavier.candidates] == [2, 1, 0]


def test_equal_scalars_are_ranked_by_the_mean_of_the_scores(registry: Registry) -> None:
    functions = {"left": Linear(0.0, 0.5), "right": Linear(0.0, 8.0)}
    choice = choose(registry, TwoObjectives(), LINE, "preference-minmax", {"preferences": functions})
    # Lowest scores 50, 0, 0; of the last two the one with 100 on the right is ahead of that with 87.5.
    assert [candidate.number for candidate in choice.candidates] == [0, 2, 1]


def test_infeasible_and_failed_designs_are_no_candidates(registry: Registry) -> None:
    failed = Evaluation(4, np.zeros(4), np.full(2, np.nan), np.full(1, np.nan), {}, "initial", reason="no")
    rows = [evaluated(number, [x, 0, 0, 0], constrained=True) for number, x in enumerate((0.0, 1.0, 2.0))]
    choice = choose(registry, TwoObjectives(True), [*rows, failed], "preference-minmax", {"preferences": ON_BOTH})
    assert [candidate.number for candidate in choice.candidates] == [1, 2]
    with pytest.raises(InputError, match="none of the 1 evaluations is feasible"):
        choose(registry, TwoObjectives(True), [failed], "preference-minmax", {"preferences": ON_BOTH})


def test_a_preference_may_be_on_a_metric(registry: Registry) -> None:
    """Comfort, to be maximised, is 1 plus the squares of the rest: the same for all candidates."""
    settings = {"preferences": {**ON_BOTH, "comfort": {"function": "linear", "unit": "m/s²", "best": 2.0, "worst": 0.0}}}
    choice = choose(registry, TwoObjectives(), LINE, "imap", settings)
    np.testing.assert_allclose(choice.scores[:, 2], 50.0)
    assert [candidate.number for candidate in choice.candidates] == [1, 0, 2]
    with pytest.raises(
        InputError, match=r"unknown objective 'speed'; objectives and metrics of this run are left, right, comf"
    ):
        choose(registry, TwoObjectives(), LINE, "imap", {"preferences": {**ON_BOTH, "speed": Linear(0.0, 1.0)}})


def test_a_metric_without_a_value_is_named(registry: Registry) -> None:
    lacking = Evaluation(0, LINE[0].design, LINE[0].objectives, np.empty(0), {}, "initial")
    with pytest.raises(InputError, match=r"preferences\.comfort: evaluation 1 has no value of comfort"):
        choose(registry, TwoObjectives(), [lacking], "imap", {"preferences": {**ON_BOTH, "comfort": Linear(2.0, 0.0)}})


def test_a_scalariser_without_preferences_cannot_choose(registry: Registry) -> None:
    with pytest.raises(InputError, match="asf goes by no preference functions"):
        choose(registry, TwoObjectives(), LINE, "asf", {})


def test_one_objective_leaves_no_choice(registry: Registry) -> None:
    settings = {"preferences": {"distance": Linear(0.0, 1.0)}}
    with pytest.raises(InputError, match="this run has one objective, distance"):
        choose(registry, Sphere(), [], "preference-minmax", settings)


def test_pseudo_weights_add_up_to_one_and_tell_what_a_design_serves() -> None:
    front = np.array([[0.0, 4.0], [1.0, 1.0], [4.0, 0.0]])
    np.testing.assert_allclose(pseudo_weights(front), [[1.0, 0.0], [0.5, 0.5], [0.0, 1.0]])
    assert pseudo_weights(front[:1]).shape == (0, 2)


def test_a_knee_is_a_high_trade_off_and_a_few_designs_have_none() -> None:
    x = np.linspace(0.0, 1.0, 31)
    front = np.column_stack([1e3 * x, np.where(x < 0.3, 1.0 - 3.0 * x, 0.1 - (x - 0.3) / 7.0)])
    assert high_trade_offs(front) == [9]
    assert high_trade_offs(front[:2]) == []
    assert high_trade_offs(np.ones((5, 2))) == []


def test_the_nearest_pseudo_weights_are_those_of_the_weights(registry: Registry) -> None:
    for weights, number in (({"left": 9.0}, 0), ({"right": 9.0}, 2), ({}, 1)):
        choice = choose(registry, TwoObjectives(), LINE, "imap", {"preferences": ON_BOTH, "weights": weights})
        assert choice.nearest is not None
        assert choice.candidates[choice.nearest].number == number


def test_the_document_is_plain_and_cut(registry: Registry) -> None:
    choice = choose(registry, TwoObjectives(), LINE, "preference-minmax", {"preferences": ON_BOTH})
    document = json.loads(json.dumps(choice_document(choice, 2), allow_nan=False))
    assert [row["rank"] for row in document["ranking"]] == [1, 2]
    assert (document["candidates"], document["evaluations"], document["best"]["number"]) == (3, 4, 2)
    assert document["preferences"][0]["scores"] == {"reference": None, "best": 75.0}


def test_a_scalarised_run_serves_any_preference_afterwards(registry: Registry) -> None:
    from railsearch.design_problem import ScalarisedProblem

    plugin, base = registry.get("scalariser", "asf"), TwoObjectives()
    problem = ScalarisedProblem(base, "asf", plugin(plugin.Parameters(), base.objectives, base.worst))
    found = run_search(registry, problem, RunSettings("random", 30, 1), [base.reference]).evaluations
    choice = choose(registry, problem, found, "preference-minmax", {"preferences": ON_BOTH})
    direct = [evaluation.metrics for evaluation in found]
    raw = np.array([[metrics["left"], metrics["right"]] for metrics in direct])
    lowest = np.clip(100.0 * (1.0 - raw / 4.0), 0.0, 100.0).min(axis=1)
    assert choice.scalars[0] == pytest.approx(100.0 - lowest.max())
    assert choice.reference is not None


@pytest.fixture
def two(install: Callable[..., None]) -> None:
    install(samples=sample_problems)


def run_of(railsearch: Cli, folder: Path, *words: object) -> Answer:
    return railsearch("run", "two", "--budget", 40, "--seed", 1, "--out", folder, *words)


@pytest.mark.usefixtures("two")
def test_a_run_by_a_preference_file_is_reported_with_its_scores_and_chosen_from(railsearch: Cli, tmp_path: Path) -> None:
    file, folder = tmp_path / "wishes.toml", tmp_path / "run"
    file.write_text(FILE)
    words = ("--strategy", "random", "--scalarise", "preference-minmax", "--preferences", file)
    answer = run_of(railsearch, folder, *words)
    assert answer.code == 0, answer.err
    assert re.search(r"left \[N\] +linear: best 0, worst 4 +clipped +1 ", answer.out)
    result = json.loads((folder / "result.json").read_text())
    rows = {row["quantity"]: row for row in result["preferences"]}
    for which in ("reference", "best"):
        for name in ("left", "right"):
            expected = 100.0 * (1.0 - min(result[which]["metrics"][name] / 4.0, 1.0))
            assert rows[name]["scores"][which] == pytest.approx(expected)
    lowest = min(row["scores"]["best"] for row in rows.values())
    assert result["best"]["objectives"]["preference-minmax"] == pytest.approx(100.0 - lowest)
    page = Page((folder / "report.html").read_text(encoding="utf-8"))
    assert (folder / "figures" / "preferences.svg").exists()
    assert "preferences" in page.identifiers
    assert "score, best" in page.text
    assert "nothing is evaluated" in run_of(railsearch, folder, *words).err
    chosen = railsearch("choose", folder, "--preferences", file, "--json")
    document = json.loads(chosen.out)
    assert document["best"]["number"] == result["best"]["number"]
    assert document["ranking"][0]["scalar"] == pytest.approx(100.0 - lowest)
    assert (folder / "choice-wishes.html").exists()


@pytest.mark.usefixtures("two")
def test_choosing_from_a_front(railsearch: Cli, tmp_path: Path) -> None:
    file, group, folder = tmp_path / "wishes.toml", tmp_path / "group.toml", tmp_path / "run"
    file.write_text(FILE)
    group.write_text(FILE + "[stakeholders.one]\nweight = 2.0\n[stakeholders.other]\nweights = { left = 0.0 }\n")
    assert run_of(railsearch, folder, "--strategy", "random").code == 0
    answer = railsearch("choose", folder, "--preferences", file, "--top", 1)
    assert answer.code == 0, answer.err
    assert re.search(r"rank +evaluation +preference-minmax +score left +score right +left \[N\] +right \[N·m\]", answer.out)
    assert re.search(r"^ +1 +\d+ ", answer.out, re.MULTILINE)
    assert not re.search(r"^ +2 +\d+ ", answer.out, re.MULTILINE)
    assert "chosen: evaluation" in answer.out
    assert "score one: left" not in answer.out
    answer = railsearch("choose", folder, "--preferences", group)
    assert re.search(r"imap +one: score left +one: score right +other: score left", answer.out)
    page = Page((folder / "choice-group.html").read_text(encoding="utf-8"))
    assert "other: score of left" in page.text
    assert "pseudo-weight of right" in page.text
    assert "preferences" in page.identifiers


@pytest.mark.usefixtures("two")
def test_bad_preference_files_and_scalarisers_are_refused_before_anything_is_evaluated(
    railsearch: Cli, tmp_path: Path
) -> None:
    file, folder = tmp_path / "wishes.toml", tmp_path / "run"
    file.write_text(FILE)
    minmax = ("--scalarise", "preference-minmax")
    for words, text, messages in (
        ((), FILE, ("wishes.toml", "no scalariser is named", "imap, preference-minmax")),
        (("--scalarise", "asf"), FILE, ("scalariser asf does not take them", "imap, preference-minmax")),
        (minmax, FILE + "[stakeholders.one]\n", ("preference-minmax does not take them", "name one that does: imap")),
        (minmax, FILE + "[prefs]\n", ("wishes.toml: unknown parameter 'prefs'", "preferences")),
        (minmax, FILE.replace("worst = 4.0", "worst = 0.0"), ("wishes.toml: preferences.left", "must differ", "0 for both")),
        (minmax, FILE.replace("right", "up"), ("unknown objective 'up'", "left, right")),
        (minmax, FILE.replace('"N"', '"kN"'), ("preferences.left.unit", "'N'", "'kN'")),
        (minmax, FILE + "[weights]\nleft = -1.0", ("weights.left", "≥ 0", "-1.0")),
        (minmax, FILE[: FILE.index("[preferences.right]")], ("a function on right is missing",)),
        (minmax, "[[", ("not a TOML file",)),
    ):
        file.write_text(text)
        refused(run_of(railsearch, folder, "--strategy", "random", "--preferences", file, *words), *messages)
    refused(run_of(railsearch, folder, "--preferences", tmp_path / "absent.toml", *minmax), "absent.toml", "No such file")
    assert not folder.exists()
    file.write_text(FILE)
    assert run_of(railsearch, folder, "--strategy", "random").code == 0
    refused(railsearch("choose", folder, "--preferences", file, "--scalarise", "asf"), "asf does not take them", "imap")
    file.write_text(FILE.replace("right", "speed"))
    refused(railsearch("choose", folder, "--preferences", file), "unknown objective 'speed'", "left, right, comfort")
    file.write_text(FILE[: FILE.index("[preferences.right]")])
    refused(railsearch("choose", folder, "--preferences", file), "a function on right is missing", "weight 0")
    refused(railsearch("choose", tmp_path, "--preferences", file), "holds no run")


@pytest.mark.usefixtures("two")
def test_preferences_in_site_and_campaign_files_are_those_of_a_preference_file(tmp_path: Path) -> None:
    registry = load_plugins()
    site, file, campaign = (tmp_path / name for name in ("site.toml", "wishes.toml", "campaign.toml"))
    file.write_text(FILE)
    site.write_text(FILE.replace("[preferences.", "[scalariser.preference-minmax.preferences."))
    wanted = asked_problem(registry, "two", None, "", "preference-minmax", file).problem
    by_site = asked_problem(registry, "two", site, "", "preference-minmax").problem
    general = '[campaign]\nbudget = 20\nrepetitions = 1\nseed = 1\nstrategies = ["random"]\n[[problem]]\nname = "two"\n'
    campaign.write_text(general + 'scalarise = "preference-minmax"\npreferences = "wishes.toml"\n')
    in_campaign = make_problems(registry, load_campaign(registry, campaign))["two"]
    assert stated_preferences(wanted)
    assert stated_preferences(wanted) == stated_preferences(by_site) == stated_preferences(in_campaign)
    campaign.write_text(general + 'scalarise = "asf"\npreferences = "wishes.toml"\n')
    with pytest.raises(InputError, match="asf does not take them"):
        load_campaign(registry, campaign)


NARROW = FILE.replace("worst = 4.0", "worst = 0.01")


@pytest.mark.usefixtures("two")
def test_a_start_without_a_slope_is_told_with_the_remedy(railsearch: Cli, tmp_path: Path) -> None:
    file, folder = tmp_path / "wishes.toml", tmp_path / "run"
    file.write_text(NARROW)
    words = ("--strategy", "random", "--scalarise", "preference-minmax", "--preferences", file)
    answer = run_of(railsearch, folder, *words)
    assert answer.code == 0, answer.err
    (warning,) = [line for line in answer.err.splitlines() if line.startswith("warning: ")]
    told = "20 of the first 20 evaluations have exactly the same preference-minmax, 100"
    for part in (told, "left, right", "clipped", "extended = true", "wider range"):
        assert part in warning
    page = Page((folder / "report.html").read_text(encoding="utf-8"))
    assert told in page.text
    assert json.loads((folder / "result.json").read_text())["warnings"] == [warning.removeprefix("warning: ")]


@pytest.mark.usefixtures("two")
def test_extended_functions_are_not_warned_of(railsearch: Cli, tmp_path: Path) -> None:
    file, folder = tmp_path / "wishes.toml", tmp_path / "run"
    file.write_text(NARROW.replace("worst = 0.01", "worst = 0.01\nextended = true"))
    words = ("--strategy", "random", "--scalarise", "preference-minmax", "--preferences", file)
    answer = run_of(railsearch, folder, *words)
    assert answer.code == 0, answer.err
    assert "warning" not in answer.err
    assert json.loads((folder / "result.json").read_text())["warnings"] == []


def test_only_the_clipped_objective_is_named(registry: Registry) -> None:
    preferences = {"left": Linear(0.0, 0.001), "right": Linear(0.0, 1000.0)}
    problem = railsearch_package.problem(
        "two-spheres", scalariser="preference-minmax", scalariser_settings={"preferences": preferences}
    )
    result = run_search(registry, problem, RunSettings("random", 30, 1))
    assert "The score of left is clipped" in flat_start(problem, result.evaluations)
    assert flat_start(problem, result.evaluations[:5]) == "", "five designs say little"
    half = [replace(e, objectives=np.array([float(k % 2)])) for k, e in enumerate(result.evaluations)]
    assert flat_start(problem, half) == "", "half of them is not more than half"


@pytest.mark.usefixtures("two")
def test_a_preference_on_a_metric_is_for_choosing(railsearch: Cli, tmp_path: Path) -> None:
    file = tmp_path / "wishes.toml"
    file.write_text(FILE + '[preferences.comfort]\nfunction = "linear"\nbest = 100.0\nworst = 0.0\n')
    words = ("--strategy", "random", "--scalarise", "preference-minmax", "--preferences", file)
    refused(
        run_of(railsearch, tmp_path / "run", *words),
        "wishes.toml: preferences.comfort: comfort is a metric of two, not one of its objectives (left, right)",
        "railsearch choose",
    )


@pytest.mark.usefixtures("two")
def test_an_unknown_objective_is_named_with_the_file_and_the_closest_one(railsearch: Cli, tmp_path: Path) -> None:
    file = tmp_path / "wishes.toml"
    file.write_text(FILE.replace("left", "lefft"))
    wanted = ("wishes.toml: preferences: unknown objective 'lefft', did you mean 'left'?", "left, right")
    words = ("--strategy", "random", "--scalarise", "preference-minmax", "--preferences", file)
    refused(run_of(railsearch, tmp_path / "run", *words), *wanted)
    assert run_of(railsearch, tmp_path / "run", "--strategy", "random").code == 0
    refused(railsearch("choose", tmp_path / "run", "--preferences", file), *wanted)
    campaign = tmp_path / "campaign.toml"
    general = '[campaign]\nbudget = 20\nrepetitions = 1\nseed = 1\nstrategies = ["random"]\n[[problem]]\nname = "two"\n'
    campaign.write_text(general + 'scalarise = "preference-minmax"\npreferences = "wishes.toml"\n')
    refused(railsearch("campaign", campaign, "--dry-run"), *wanted)
