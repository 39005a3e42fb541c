import json
import re
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.backends.backend_agg import FigureCanvasAgg
from sample_campaigns import Searcher, results_of, synthetic_results

from html_page import Page
from railsearch.campaign.analysis import campaign_document
from railsearch.report import campaign_tables as tables
from railsearch.report.campaign_figures import (
    attainment_figure,
    campaign_figures,
    curves_figure,
    figure_name,
    ranks_figure,
    spread,
    swatch,
    targets_figure,
)
from railsearch.report.campaign_page import campaign_page
from railsearch.report.campaign_plots import plots
from railsearch.report.figures import drawn
from sample_problems import Sphere, TwoObjectives

SEARCHERS = {"dycors": Searcher(0.9), "ga": Searcher(0.5, 0.05), "random": Searcher(0.0)}
HOSTILE = '</script><b>x & "y"</b>'


@pytest.fixture(scope="module")
def document() -> dict[str, Any]:
    problems = {"sphere": Sphere(), "two sides": TwoObjectives()}
    return campaign_document(synthetic_results(problems, SEARCHERS, 6, 40), command="railsearch campaign sample.toml")


@pytest.fixture(scope="module")
def text(document: dict[str, Any]) -> str:
    pictures = {"sphere": {"zone": targets_figure("Zone", [1, 2], {"dycors": [0.0, 1.0]}, {"dycors": 0})}}
    return campaign_page(document, pictures)


def test_the_page_stands_alone_and_is_well_formed(text: str) -> None:
    page = Page(text)
    assert all(reference.startswith("#") for reference in page.references)
    assert not re.search(r"url\((?!#)|@import|src=", text)
    assert len(set(page.identifiers)) == len(page.identifiers)
    assert {reference[1:] for reference in page.references} <= set(page.identifiers)


def test_the_page_tells_everything_without_its_script(text: str, document: dict[str, Any]) -> None:
    page = Page(text)
    said = page.text
    assert document["conclusion"] in said
    for entry in document["problems"]:
        assert entry["conclusion"] in said
        for row in entry["fixed_budget"]:
            for place in row["places"]:
                assert f"{place['median']:.4g}" in said
        assert f"{entry['design']['best']['number']}" in said
    words = (
        "railsearch campaign sample.toml",
        "Campaign seed 7",
        "SimulationError: the integration diverged",
        "stiffness [MN/m]",
    )
    for word in (*words, "left = ", " N, right = ", "N·m", "numpy", "mean rank"):
        assert word in said, word
    assert page.tags.count("figure") == 8, "two of the first problem and its picture, three of the second, two over both"


def test_hostile_text_stays_text(document: dict[str, Any]) -> None:
    hostile = json.loads(json.dumps(document).replace("dycors", json.dumps(HOSTILE)[1:-1]))
    hostile["campaign"]["name"] = hostile["command"] = HOSTILE
    hostile["problems"][0]["cells"][1]["reasons"] = [{"reason": HOSTILE, "count": 1}]
    hostile["problems"][0]["label"] = HOSTILE
    hostile["ranking"]["problems"][0] = HOSTILE
    text = campaign_page(hostile, {})
    assert HOSTILE not in text
    page = Page(text)
    assert page.tags.count("script") == 2
    assert page.text.count(HOSTILE) > 20
    (data,) = re.findall(r'<script type="application/json" id="plots">(.*?)</script>', text, flags=re.DOTALL)
    assert HOSTILE in {series["label"] for plot in json.loads(data).values() for series in plot["series"]}


@pytest.mark.parametrize(
    "finals", [{"a": [1.0, 2.0, 3.0]}, {"a": [1.0], "b": [2.0]}], ids=["one strategy", "one repetition"]
)
def test_a_campaign_that_says_little_has_a_page(finals: dict[str, list[float]]) -> None:
    found = campaign_document(results_of(Sphere(), finals))
    page = Page(campaign_page(found, {}))
    assert found["conclusion"] in page.text
    assert "Which differences are real" not in page.text


def test_a_campaign_without_a_record_has_a_page() -> None:
    results = results_of(Sphere(), {"a": [1.0, 2.0]})
    page = Page(campaign_page(campaign_document(type(results)(results.campaign, results.problems, {})), {}))
    assert "Nothing can be said on p yet" in page.text
    assert "No feasible design was found" in page.text


# Figures


def lines_of(figure: Any) -> dict[str, Any]:
    return {line.get_gid(): line for line in figure.axes[0].lines if line.get_gid()}


def test_curves_are_drawn_as_the_document_has_them(document: dict[str, Any]) -> None:
    places = {"dycors": 0, "ga": 1, "random": 2}
    (entry, _) = document["problems"]
    figure = curves_figure(entry, places, ("quartiles", "confidence"))
    for label, place in places.items():
        line = lines_of(figure)[f"strategy-{place}-line"]
        assert line.get_ydata().tolist() == entry["curves"][label]["median"]
        assert line.get_xdata().tolist() == entry["numbers"]
    (axes,) = figure.axes
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("evaluation", "distance [m²]")
    bands = {collection.get_gid() for collection in axes.collections}
    assert bands == {f"strategy-{place}-{band}" for place in range(3) for band in ("quartiles", "confidence")}
    assert sorted(text.get_text() for text in axes.texts) == sorted(places)


def test_figures_of_every_problem_and_over_all(document: dict[str, Any]) -> None:
    names = list(campaign_figures(document))
    assert names == [
        "1-curves-sphere",
        "1-targets-sphere",
        "2-curves-two-sides",
        "2-targets-two-sides",
        "2-attainment-two-sides",
        "all-targets",
        "all-ranks",
    ]
    assert figure_name(3, "curves", "Ä/../b c") == "3-curves-b-c"


def test_bands_of_many_strategies_are_those_of_the_best() -> None:
    finals = {name: [value, value + 0.5] for name, value in zip("abcdef", (6.0, 5.0, 4.0, 3.0, 2.0, 1.0), strict=True)}
    (entry,) = campaign_document(results_of(Sphere(), finals))["problems"]
    figure = curves_figure(entry, {name: place for place, name in enumerate("abcdef")}, ("quartiles",))
    bands = [collection.get_gid() for collection in figure.axes[0].collections]
    assert sorted(bands) == ["strategy-3-quartiles", "strategy-4-quartiles", "strategy-5-quartiles"]
    assert "for the best 3" in figure.get_label()


def test_twenty_eight_strategies_look_different() -> None:
    looks = set()
    for place in range(28):
        drawing = drawn(swatch(place), "svg", "key").decode()
        (line,) = [style for style in re.findall(r'style="([^"]*)"', drawing) if "stroke-width: 1.7" in style]
        looks.add(tuple(re.findall(r"(?:stroke|stroke-dasharray): ([^;]+)", line)))
    assert len(looks) == 28


def test_best_values_are_steps() -> None:
    figure = targets_figure("", [1, 2], {"a": [0.0, 1.0]}, {"a": 0})
    assert lines_of(figure)["strategy-0-line"].get_drawstyle() == "steps-post"


@given(st.lists(st.floats(0.0, 1.0), min_size=1, max_size=12))
def test_labels_keep_order_and_distance(values: list[float]) -> None:
    wanted, gap = np.array(values), 0.06
    placed = spread(wanted, gap)
    order = np.argsort(wanted, kind="stable")
    assert np.all(np.diff(placed[order]) >= gap - 1e-12)
    assert placed.min() >= 0.0
    assert placed.max() <= 1.0 + 1e-12
    if np.all(np.diff(wanted[order]) >= gap) and wanted.max() <= 1.0 - 1e-12:
        assert placed == pytest.approx(np.clip(wanted, 0.0, 1.0))


def test_the_script_is_told_where_the_frame_of_a_figure_is(document: dict[str, Any]) -> None:
    figures = campaign_figures(document)
    for name, figure in figures.items():
        drawn(figure, "svg", name)
    told = plots(document, figures)
    assert sorted(told) == [
        "1-curves-sphere",
        "1-targets-sphere",
        "2-curves-two-sides",
        "2-targets-two-sides",
        "all-targets",
    ]
    for name, plot in told.items():
        axes = figures[name].axes[0]
        # A point of the axes in pixels of the figure must be where the frame and the limits put it.
        number, value = plot["numbers"][-1], plot["series"][0]["values"][-1]
        x, y = figures[name].transFigure.inverted().transform(axes.transData.transform((number, value)))
        left, top, right, bottom = plot["frame"]
        shares = [
            (np.log(v / low) / np.log(high / low) if logarithmic else (v - low) / (high - low))
            for v, (low, high, logarithmic) in ((number, plot["x"]), (value, plot["y"]))
        ]
        assert left + (right - left) * shares[0] == pytest.approx(x, abs=1e-3)
        assert bottom - (bottom - top) * shares[1] == pytest.approx(1.0 - y, abs=1e-3)


def test_ranks_are_drawn_where_they_are_with_bars_over_equals() -> None:
    ranking = {
        "strategies": ["a", "b", "c"],
        "problems": list("pqrstu"),
        "mean_ranks": [2.0, 1.25, 2.75],
        "groups": [[1, 0], [0, 2]],
        "critical_difference": 1.35,
        "level": 0.05,
        "p_value": 0.03,
    }
    figure = ranks_figure(ranking, {"a": 0, "b": 1, "c": 2})
    lines = lines_of(figure)
    assert [lines[f"strategy-{place}-rank"].get_xdata()[0] for place in range(3)] == [2.0, 1.25, 2.75]
    assert [tuple(np.round(lines[f"group-{row}"].get_xdata(), 2)) for row in range(2)] == [(1.22, 2.03), (1.97, 2.78)]
    texts = [text.get_text() for text in figure.axes[0].texts]
    assert texts == ["b  1.25", "a  2.00", "2.75  c", "CD = 1.35"]


@pytest.mark.parametrize("count", [2, 12, 13, 20, 40])
def test_the_numbers_of_many_ranks_do_not_overlap(count: int) -> None:
    names = [f"strategy-{place}" for place in range(count)]
    ranking = {
        "strategies": names,
        "problems": ["p"],
        "mean_ranks": list(range(1, count + 1)),
        "groups": [],
        "critical_difference": count,
        "level": 0.05,
        "p_value": 0.03,
    }
    figure = ranks_figure(ranking, {name: place for place, name in enumerate(names)})
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    edges = [label.get_window_extent(canvas.get_renderer()) for label in figure.axes[0].get_xticklabels()]
    assert count > 12 or len(edges) == count, "few ranks all have their number"
    assert all(left.x1 + 2.0 < right.x0 for left, right in pairwise(edges))


def test_surfaces_are_staircases_through_their_corners() -> None:
    objectives = [{"name": "f", "unit": "N", "maximised": False}, {"name": "g", "unit": "", "maximised": True}]
    entry = {
        "design": {"problem": {"objectives": objectives}},
        "attainment": {"a": [[], [[1.0, 2.0], [4.0, 7.0]], [[4.0, 5.0]]]},
    }
    lines = lines_of(attainment_figure(entry, {"a": 0}))
    corners = list(zip(*lines["strategy-0-line"].get_data(), strict=True))
    assert corners == [(1.0, 2.0), (4.0, 2.0), (4.0, 7.0)], "worse in f before better in g"
    assert set(lines) == {"strategy-0-line", "strategy-0-most"}


def test_many_evaluations_are_drawn_on_a_logarithmic_axis() -> None:
    few, many = (targets_figure("", [1, budget], {"a": [0.0, 1.0]}, {"a": 0}).axes[0] for budget in (1000, 1001))
    assert (few.get_xscale(), many.get_xscale()) == ("linear", "log")
    assert many.get_xlim() == (1.0, 1001.0)


# Tables


def cells_of(table: str) -> list[list[str]]:
    rows = re.findall(r"<tr[^>]*>(.*?)</tr>", table, flags=re.DOTALL)
    return [
        [re.sub(r"<[^>]*>", " ", cell).strip() for cell in re.findall(r"<t[dh][^>]*>(.*?)</t[dh]>", row)] for row in rows
    ]


CLEAR = {"poor": [20.0, 21.0, 22.0, 23.0, 24.0], "good": [1.0, 2.0, 3.0, 4.0, 5.0], "like": [1.5, 2.5, 3.5, 4.5, 5.5]}


def test_the_overview_marks_the_best_and_its_equals() -> None:
    found = campaign_document(results_of(Sphere(), CLEAR))
    rows = cells_of(tables.overview_table(found, {"p": "problem-1"}))
    assert [row[0] for row in rows] == ["strategy", "good", "like", "poor"]
    assert [row[1].split()[0] for row in rows[1:]] == ["3", "3.5", "22"]
    assert ["★" in row[1] for row in rows[1:]] == [True, False, False]
    assert ["≈" in row[1] for row in rows[1:]] == [False, True, False]


def test_the_matrix_shows_both_sides_of_a_difference() -> None:
    (entry,) = campaign_document(results_of(Sphere(), CLEAR))["problems"]
    head, good, like, poor = cells_of(tables.pairwise_table(entry))
    assert head == ["A12", "good", "like", "poor"]
    assert (good[3].split()[:2], poor[1].split()[:2]) == (["▲", "1.00"], ["▼", "0.00"])
    assert (good[2].split()[0], like[1].split()[0]) == ("0.60", "0.40"), "not significant"
    assert good[1] == ""


def test_running_times_are_shown_with_their_successes() -> None:
    (entry,) = campaign_document(results_of(Sphere(), {"a": [0.0, 0.0], "b": [0.0, 50.0]}, budget=10))["problems"]
    head, first, second = cells_of(tables.running_time_table(entry))
    assert head[-1] == "1 (99 % of the way)"
    assert (first[-1].split(), second[-1].split()) == (["6", "2", "of", "2"], ["16", "1", "of", "2"])


def test_distances_from_a_known_front_are_sorted_and_shown() -> None:
    far, near = ({"median": value, "lower": value, "upper": value} for value in (0.2, 0.1))
    rows = cells_of(tables.front_distance_table({"front_distance": {"far": far, "near": near}}))
    assert [row[0] for row in rows] == ["strategy", "near", "far"]
