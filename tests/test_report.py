import json
import math
import re
import xml.etree.ElementTree as ElementTree
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from command_line import Answer
from html_page import Page
from railsearch.interfaces import Evaluation, Quantity
from railsearch.report import write_figures, write_report
from railsearch.report.figures import drawn
from railsearch.report.history import history_figure, incumbents, resets, upper_limit
from sample_problems import Sphere, TwoObjectives
from test_cli import sample_problems


def evaluation(number: int, value: float, origin: str = "perturbation", trajectory: int = 0, reason: str = "") -> Evaluation:
    design = np.array([number / 10.0, 0.0, 0.0, 0.0])
    return Evaluation(number, design, np.array([value]), np.empty(0), {}, origin, trajectory, reason)


HISTORY = [
    evaluation(0, 5.0, "given"),
    evaluation(1, 900.0, "initial"),
    evaluation(2, 4.0, "initial"),
    evaluation(3, math.nan, "perturbation", reason="ZeroDivisionError"),
    evaluation(4, 3.0, "perturbation"),
    evaluation(5, 6.0, "initial", 1),
    evaluation(6, 5.5, "home-made", 1),
    evaluation(7, 2.0, "tree-search", 1),
]


def test_the_incumbent_is_the_best_since_the_last_reset() -> None:
    values = np.array([e.objectives[0] for e in HISTORY])
    assert incumbents(HISTORY, values).tolist() == [5.0, 5.0, 4.0, 4.0, 3.0, 6.0, 5.5, 2.0]
    assert resets(HISTORY) == [6]


def test_a_bad_value_does_not_squash_the_picture() -> None:
    values = np.append(np.linspace(1.0, 2.0, 99), 1e6)
    assert 2.0 < upper_limit(values) < 4.0
    assert upper_limit(np.array([1.0, 1.0])) == 1.0
    assert upper_limit(np.linspace(0.0, 1.0, 11)) == 1.0


def drawn_points(axes: Any) -> dict[str, list[tuple[float, float]]]:
    points: dict[str, list[tuple[float, float]]] = {}
    for collection in axes.collections:
        label = collection.get_label().split(" (")[0]
        points.setdefault(label, []).extend(map(tuple, collection.get_offsets().tolist()))
    return points


def test_every_evaluation_is_drawn_by_its_origin() -> None:
    (axes,) = history_figure(Sphere(), HISTORY).axes
    points = drawn_points(axes)
    assert points["given"] == [(1.0, 5.0)]
    assert (3.0, 4.0) in points["initial"]
    assert (2.0, 900.0) not in points["initial"], "it is a triangle at the edge"
    assert [x for x, _ in points["failed"]] == [4.0]
    assert points["home-made"] == [(7.0, 5.5)]
    lines = {line.get_label(): line.get_ydata() for line in axes.lines}
    assert list(lines["best so far"]) == [5.0, 5.0, 4.0, 4.0, 3.0, 3.0, 3.0, 2.0]
    assert list(lines["incumbent"]) == [5.0, 5.0, 4.0, 4.0, 3.0, 6.0, 5.5, 2.0]
    assert [text.get_text() for text in axes.texts] == ["reset at 6"]
    assert axes.get_ylabel() == "distance [m²]"


def test_a_history_of_failures_alone_is_drawn() -> None:
    failed = [replace(e, objectives=np.array([np.nan]), reason="no") for e in HISTORY]
    (axes,) = history_figure(Sphere(), failed).axes
    assert len(drawn_points(axes)["failed"]) == 8


def test_two_objectives_are_drawn_against_each_other_with_their_front() -> None:
    problem = TwoObjectives()
    generator = np.random.default_rng(1)
    evaluations = []
    for number in range(30):
        design = problem.space.from_unit(generator.random(4))
        outcome = problem.simulate(design)
        evaluations.append(Evaluation(number, design, outcome.objectives, np.empty(0), {}, "random"))
    (axes,) = history_figure(problem, evaluations).axes
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("left [N]", "right [N·m]")
    (line,) = axes.lines
    x, y = np.array(line.get_xdata()), np.array(line.get_ydata())
    assert np.all(np.diff(x) > 0.0)
    assert np.all(np.diff(y) < 0.0)


def test_a_wide_front_is_whole_and_its_axes_logarithmic() -> None:
    problem = TwoObjectives()
    left = np.geomspace(1.0, 1000.0, 20)
    rows = [Evaluation(k, np.zeros(4), np.array([x, 3.0 + 1.0 / x]), np.empty(0), {}, "random") for k, x in enumerate(left)]
    (axes,) = history_figure(problem, rows).axes
    assert (axes.get_xscale(), axes.get_yscale()) == ("log", "linear")
    assert sorted(x for x, _ in drawn_points(axes)["random"]) == pytest.approx(left)


def test_front_members_are_never_moved_to_the_edge() -> None:
    dull = [Evaluation(k, np.zeros(4), np.array([50.0, 50.0 + k]), np.empty(0), {}, "random") for k in range(30)]
    ends = [Evaluation(30, np.zeros(4), np.array([1.0, 90.0]), np.empty(0), {}, "random")]
    ends.append(Evaluation(31, np.zeros(4), np.array([90.0, 1.0]), np.empty(0), {}, "random"))
    (axes,) = history_figure(TwoObjectives(), dull + ends).axes
    points = drawn_points(axes)["random"]
    assert (1.0, 90.0) in points
    assert (90.0, 1.0) in points


def test_the_same_figure_is_the_same_bytes(tmp_path: Path) -> None:
    for folder in ("one", "two"):
        write_figures(tmp_path / folder, {"history": history_figure(Sphere(), HISTORY)})
    for name in ("history.svg", "history.png"):
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "two" / name).read_bytes()
    ElementTree.fromstring(drawn(history_figure(Sphere(), HISTORY), "svg", "history"))


CONSTRAINED = [replace(evaluation(k, 5.0 - k, "initial"), constraints=np.array([1.0 + k % 3, -9.0, 0.5])) for k in range(6)]


def test_where_no_design_is_feasible_the_history_is_one_of_violations() -> None:
    failed = replace(evaluation(6, math.nan, reason="no ballast"), constraints=np.full(3, np.nan))
    figure = history_figure(Sphere(), [*CONSTRAINED, failed])
    (axes,) = figure.axes
    assert drawn_points(axes)["initial"] == [(k + 1.0, 1.5 + k % 3) for k in range(6)]
    assert [c.get_facecolor().size for c in axes.collections if "initial" in c.get_label()] == [0]
    (line,) = axes.lines
    assert list(line.get_ydata()) == [1.5] * 7
    assert "violation" in axes.get_ylabel()
    assert "none is feasible" in figure.get_label()


@pytest.mark.parametrize("objectives", [1, 2, 3])
def test_infeasible_designs_are_hollow_beside_feasible_ones(objectives: int) -> None:
    rows = [replace(e, objectives=np.full(objectives, e.objectives[0])) for e in CONSTRAINED]
    rows += [replace(e, number=k + 6, constraints=-e.constraints * 0.0) for k, e in enumerate(rows[:3])]
    problem = make_problem_with(objectives)
    figure = history_figure(problem, rows)
    for axes in figure.axes:
        counts = Counter({True: 0, False: 0})
        for collection in axes.collections:
            counts[collection.get_facecolor().size > 0] += len(collection.get_offsets())
        assert counts == {True: 3, False: 6}
    assert "Hollow marks are infeasible designs" in figure.get_label()


def make_problem_with(objectives: int) -> Sphere:
    problem = Sphere()
    problem.objectives = tuple(Quantity(f"f{k}") for k in range(objectives))
    return problem


def test_a_caption_explains_only_what_is_drawn() -> None:
    plain = history_figure(Sphere(), [evaluation(k, 5.0 - k) for k in range(4)]).get_label()
    assert "best so far" in plain
    for word in ("incumbent", "riangle", "rosses", "ollow"):
        assert word not in plain
    everything = history_figure(Sphere(), HISTORY).get_label()
    for word in ("best so far", "incumbent", "riangle", "Crosses"):
        assert word in everything


@pytest.mark.parametrize("objectives", [1, 2])
@pytest.mark.filterwarnings("error")
def test_a_history_of_failures_has_no_legend_without_entries(objectives: int) -> None:
    failed = [replace(e, objectives=np.full(objectives, np.nan), reason="no") for e in HISTORY]
    figure = history_figure(make_problem_with(objectives), failed)
    legends = [axes.get_legend() for axes in figure.axes if axes.get_legend() is not None]
    assert all(legend.get_texts() for legend in legends)


def test_a_run_without_a_feasible_design_says_so_at_once(railsearch: Callable[..., Answer], tmp_path: Path) -> None:
    answer = railsearch("run", "pymoo:g6", "--strategy", "de", "--budget", 40, "--seed", 1, "--out", tmp_path)
    document = json.loads((tmp_path / "result.json").read_text(encoding="utf-8"))
    assert document["best"] is None
    least = min(row["violation"] for row in document["evaluations"])
    words = f"none of 40 designs is feasible; the smallest violation is {least:.5g}"
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    lead = text[text.index('<p class="lead">') :].split("</p>")[0]
    assert words in lead
    assert words in answer.out
    assert "Warning" not in answer.err


@pytest.fixture
def result(railsearch: Callable[..., Answer], install: Callable[..., None], tmp_path: Path) -> Path:
    install(samples=sample_problems)
    words = ("run", "troubled", "--strategy", "random", "--budget", 16, "--seed", 3, "--timeout", 0.4, "--out", tmp_path)
    assert railsearch(*words).code == 0
    return tmp_path


def test_the_report_stands_alone_and_tells_everything(result: Path) -> None:
    text = (result / "report.html").read_text(encoding="utf-8")
    page = Page(text)
    assert all(reference.startswith("#") for reference in page.references)
    assert not re.search(r"url\((?!#)|@import|<script", text)
    assert len(set(page.identifiers)) == len(page.identifiers)
    assert {reference[1:] for reference in page.references} <= set(page.identifiers)
    assert page.tags.count("svg") == page.tags.count("figcaption") == 1
    for word in ("sphere (distance)", "16 of 16 evaluations", "distance [m²]", "stiffness [MN/m]", "Seed 3", "no ballast"):
        assert word in page.text, word
    assert "railsearch run troubled" in page.text


def test_hostile_text_stays_text(result: Path) -> None:
    document = json.loads((result / "result.json").read_text(encoding="utf-8"))
    document["problem"]["label"] = "<script>alert(1)</script>"
    document["command"] = "railsearch run \"<img src='x'>\""
    document["evaluations"][0]["reason"] = "</table><b>& so on"
    write_report(result / "hostile.html", document, {})
    page = Page((result / "hostile.html").read_text(encoding="utf-8"))
    assert not {"script", "img", "b"} & set(page.tags)
    assert "<script>alert(1)</script>" in page.text
    assert "</table><b>& so on" in page.text


def test_figures_of_an_earlier_report_do_not_stay(tmp_path: Path) -> None:
    figure = history_figure(Sphere(), HISTORY)
    write_figures(tmp_path, {"1-curves-old": figure, "all": figure})
    (tmp_path / "notes.txt").write_text("mine")
    write_figures(tmp_path, {"1-curves-new": figure, "all": figure})
    names = {path.name for path in tmp_path.iterdir()}
    assert names == {"1-curves-new.png", "1-curves-new.svg", "all.png", "all.svg", "notes.txt"}
