import json
import re
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sample_campaigns import Searcher, results_of, synthetic_results

from html_page import Page
from railsearch.campaign.analysis import campaign_document
from railsearch.report.campaign_figures import (
    COLOURS,
    DASHES,
    campaign_figures,
    curves_figure,
    figure_name,
    spread,
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
    looks = {(place % len(COLOURS), place % len(DASHES)) for place in range(28)}
    assert len(looks) == 28


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
