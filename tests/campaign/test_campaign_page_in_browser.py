"""The page of a campaign, opened and clicked through in headless Chromium."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from sample_campaigns import Searcher, synthetic_results

from browser import Browser, browsing
from railsearch.campaign.analysis import campaign_document
from railsearch.report.campaign_page import write_campaign_report
from sample_problems import Sphere, TwoObjectives

pytestmark = pytest.mark.system
CURVES = '[id="1-curves-sphere"]'


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    searchers = {"dycors": Searcher(0.9), "ga": Searcher(0.5, 0.05), "random": Searcher(0.0)}
    results = synthetic_results({"sphere": Sphere(), "two": TwoObjectives()}, searchers, 6, 40)
    path = tmp_path_factory.mktemp("report") / "report.html"
    write_campaign_report(path, campaign_document(results), {})
    return path


@pytest.fixture(scope="module")
def chromium(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    with browsing(tmp_path_factory.mktemp("profile")) as browser:
        yield browser


@pytest.fixture
def page(chromium: Browser, report: Path) -> Iterator[Browser]:
    """The page freshly loaded; afterwards it must have asked for nothing else and complained of nothing."""
    chromium.complaints.clear()
    chromium.requests.clear()
    chromium.open(report)
    yield chromium
    assert chromium.complaints == []
    assert chromium.requests == [report.resolve().as_uri()]


def column(page: Browser, table: str, place: int) -> list[str]:
    rows = f"[...document.querySelectorAll('{table} tbody tr')]"
    return list(page.value(f"{rows}.map(row => row.cells[{place}].firstChild.textContent.trim())"))


def shown(page: Browser, identifier: str) -> bool:
    return bool(page.value(f"getComputedStyle(document.getElementById('{identifier}')).display !== 'none'"))


def readout(page: Browser, figure: str = CURVES) -> str:
    return str(page.value(f"document.querySelector('{figure} .readout').innerText"))


def test_pointing_at_a_curve_shows_the_values_of_all_strategies(page: Browser) -> None:
    assert page.value(f"document.querySelector('{CURVES} .readout').hidden") is True
    plot = page.value("JSON.parse(document.getElementById('plots').textContent)['1-curves-sphere']")
    left, _, right, _ = plot["frame"]
    page.hover(f"{CURVES} svg", right=left + 0.5 * (right - left))
    said = readout(page)
    assert said.startswith("evaluation 20 [m²]")
    for series in plot["series"]:
        assert series["label"] in said
        assert f"{series['values'][19]:.4g}" in said
    assert page.value(f"document.querySelectorAll('{CURVES} .crosshair circle').length") == 3
    page.hover("h1")
    assert page.value(f"document.querySelector('{CURVES} .readout').hidden") is True


def test_the_arrow_keys_move_along_a_curve(page: Browser) -> None:
    page.value(f"document.querySelector('{CURVES}').focus()")
    page.press("ArrowLeft")
    assert readout(page).startswith("evaluation 40")
    page.press("ArrowLeft")
    assert readout(page).startswith("evaluation 39")
    page.press("ArrowRight")
    assert readout(page).startswith("evaluation 40")


def test_a_click_hides_a_strategy_everywhere_and_another_shows_it_again(page: Browser) -> None:
    artists = [f"{figure}-strategy-1-{kind}" for figure in ("1-curves-sphere", "all-targets") for kind in ("line", "label")]
    artists.append("1-curves-sphere-strategy-1-quartiles")
    page.click('.key[data-strategy="1"]')
    assert not any(shown(page, artist) for artist in artists)
    assert shown(page, "1-curves-sphere-strategy-0-line")
    assert page.value("document.querySelector('.key[data-strategy=\"1\"]').getAttribute('aria-pressed')") == "false"
    page.hover(f"{CURVES} svg")
    assert "ga" not in readout(page)
    page.click('.key[data-strategy="1"]')
    assert all(shown(page, artist) for artist in artists)
    page.click("#none")
    assert not shown(page, "1-curves-sphere-strategy-0-line")
    page.click("#all")
    assert shown(page, "1-curves-sphere-strategy-0-line")


def test_the_band_can_be_chosen(page: Browser) -> None:
    quartiles, confidence = (f"1-curves-sphere-strategy-0-{band}" for band in ("quartiles", "confidence"))
    assert (shown(page, quartiles), shown(page, confidence)) == (True, False)
    choose = (
        "(band => {{ const s = document.getElementById('band'); s.value = band; s.dispatchEvent(new Event('change')); }})"
    )
    page.value(f"{choose.format()}('confidence')")
    assert (shown(page, quartiles), shown(page, confidence)) == (False, True)
    page.value(f"{choose.format()}('')")


def test_a_click_on_a_title_sorts_a_table_by_numbers(page: Browser) -> None:
    table = "#problem-1 .pair table.sortable"
    before = column(page, table, 4)
    page.click(f"{table} th:nth-child(5) button")
    numbers = [float(value) for value in column(page, table, 4)]
    assert numbers == sorted(map(float, before))
    page.click(f"{table} th:nth-child(5) button")
    assert [float(value) for value in column(page, table, 4)] == numbers[::-1]
    assert page.value(f"document.querySelector('{table} th:nth-child(5)').ariaSort") == "descending"
    page.click(f"{table} th:nth-child(1) button")
    assert column(page, table, 0) == ["dycors", "ga", "random"]


@pytest.mark.parametrize("width", [375, 1280])
def test_nothing_sticks_out_of_the_window(page: Browser, report: Path, width: int) -> None:
    page.requests.clear()
    page.open(report, width)
    assert page.value("document.documentElement.scrollWidth") <= width
    assert page.value("document.querySelectorAll('svg').length") > 8
    page.hover(f"{CURVES} svg")
    assert "dycors" in readout(page)
    assert page.value("document.documentElement.scrollWidth") <= width


def test_without_its_script_the_page_is_whole(page: Browser, report: Path, tmp_path: Path) -> None:
    page.call("Emulation.setScriptExecutionDisabled", value=True)
    try:
        page.requests.clear()
        page.open(report)
        assert page.value("document.body.classList.contains('live')") is False
        assert shown(page, "1-curves-sphere-strategy-0-quartiles")
        assert not shown(page, "1-curves-sphere-strategy-0-confidence")
        assert page.value("document.querySelectorAll('.readout').length") == 0
        page.print(tmp_path / "page.pdf")
    finally:
        page.call("Emulation.setScriptExecutionDisabled", value=False)
    assert (tmp_path / "page.pdf").read_bytes().startswith(b"%PDF")
