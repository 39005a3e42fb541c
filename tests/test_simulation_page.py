"""The page of one simulation: metrics, pictures, parameters, how to repeat it; and what it does without pictures."""

import json
import re
import types
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest

from browser import browsing
from command_line import Answer
from html_page import Page
from railsearch.hookspecs import Register, hookimpl
from railsearch.interfaces import NoParameters, Passage, Quantity, Response, drawing_model, parameter, passage_figures
from railsearch.plugin_manager import Entry, Provenance
from railsearch.report.history_plots import history_figures
from railsearch.report.simulation_page import shown, simulation_page

Cli = Callable[..., Answer]
SHORT = ("--set", "bridge_length=9", "--set", "start_position=-3.01", "--set", "end_position=12", "--set", "vehicles=1")


def written(path: Path) -> Page:
    return Page(path.read_text(encoding="utf-8"))


def row(text: str, name: str) -> list[str]:
    """The cells of the first table row that begins with a name."""
    found = re.search(rf"<tr[^>]*><td[^>]*>{re.escape(name)}</td>.*?</tr>", text)
    assert found is not None, name
    return re.findall(r"<td[^>]*>(.*?)</td>", found[0])


def test_the_page_has_metrics_pictures_parameters_and_the_command(railsearch: Cli, tmp_path: Path) -> None:
    report, histories, site = tmp_path / "passage.html", tmp_path / "passage.npz", tmp_path / "site.toml"
    site.write_text("[track]\npad_stiffness = 3e8\n", encoding="utf-8")
    words = ("simulate", "train-track-bridge", *SHORT, "--parameters", site, "--report", report, "--histories", histories)
    answer = railsearch(*words, "--json")
    assert answer.code == 0, answer.err
    assert f"wrote {report}" in answer.err
    metrics = json.loads(answer.out)["metrics"]
    text, page = report.read_text(encoding="utf-8"), written(report)
    for name, value in metrics.items():
        labels = [label for label in (name, f"{name} [m]", f"{name} [m/s²]", f"{name} [N]", f"{name} [Hz]") if label in text]
        assert row(text, labels[-1])[1] == f"{value:.5g}"
    assert row(text, "pad_stiffness")[1:4] == ["300000000", "800000000", "N/m"]
    assert row(text, "bridge_length")[1:4] == ["9", "50", "m"]
    assert row(text, "start_position")[2] == "not given"
    changed, everything = text.split("<details>")
    assert "sleeper_mass" not in changed
    assert row(everything, "sleeper_mass")[1:3] == ["272.5", "kg"]
    assert row(everything, "vehicle.pitch")[1:3] == ["25", "m"]
    for name in ("snapshot", "force", "histories", "envelopes"):
        assert name in page.identifiers
    assert "times as large" in page.text
    assert "railsearch simulate train-track-bridge --set bridge_length=9" in page.text
    assert "numpy" in page.text
    assert row(text, "track-model")[1:] == [
        "train-track-bridge",
        "railsearch_plugins.track_models.train_track_bridge",
        "railsearch 0.1.0",
    ]
    with np.load(histories) as stored:
        assert "snapshot_time" in stored


def test_the_page_needs_nothing_beside_itself(railsearch: Cli, tmp_path: Path) -> None:
    assert railsearch("simulate", "imported-track", "--report", tmp_path / "page.html").code == 0
    page = written(tmp_path / "page.html")
    assert len(set(page.identifiers)) == len(page.identifiers)
    assert [found for found in page.references if not found.startswith(("#", "data:"))] == []
    assert "script" not in page.tags
    assert "All parameters are as by default." in page.text


def test_metrics_are_those_of_a_simulation_without_a_page(railsearch: Cli, tmp_path: Path) -> None:
    words = ("simulate", "train-track-bridge", *SHORT, "--json")
    assert railsearch(*words).out == railsearch(*words, "--report", tmp_path / "page.html").out


@pytest.mark.parametrize(
    ("option", "file", "message"),
    [
        ("--report", "page.htm", "--report: a file name that ends with .html is needed, received page.htm"),
        ("--report", "folder.html", "--report: a file name that ends with .html is needed, received folder.html"),
        ("--report", "absent/page.html", "received absent/page.html; make absent first"),
        ("--histories", "absent/a.npz", "--histories: a file in a folder that exists is needed, received absent/a.npz"),
    ],
)
def test_a_file_that_cannot_be_is_refused_before_the_simulation(
    railsearch: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, option: str, file: str, message: str
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder.html").mkdir()
    answer = railsearch("simulate", "no-such-model", option, file)
    assert answer.code == 2
    assert message in answer.err
    assert [path.name for path in tmp_path.iterdir()] == ["folder.html"]


@dataclass(frozen=True)
class Slope:
    """Parameters of the model that does not draw."""

    slope: float = parameter(2.0, unit="N/s", meaning="of the force <over time>")
    stops: tuple[float, ...] = parameter((), unit="s", meaning="where it stops")


@dataclass
class Undrawn:
    """A force that grows, of a model that does not draw."""

    Parameters: ClassVar[type] = Slope
    metrics: ClassVar[tuple[Quantity, ...]] = (Quantity("F", "N", "largest force"),)
    histories: ClassVar[tuple[Quantity, ...]] = (
        Quantity("time", "s", "since the start"),
        Quantity("force", "N", "under the wheel"),
        Quantity("wheels", "mm", "of both wheels"),
        Quantity("places", "m", "of the sleepers"),
        Quantity("matrices", "", "of every step"),
    )
    extent: int = field(default=5)

    def warm_up(self) -> None:
        """Nothing to compile."""

    def check(self, parameters: Slope) -> None:
        """Everything is allowed."""

    def simulate(self, parameters: Slope, histories: bool = False) -> Response:
        time = 0.1 * np.arange(self.extent)
        made = {
            "time": time,
            "force": parameters.slope * time,
            "wheels": np.stack([time, -time], axis=1),
            "places": np.ones(3),
            "matrices": np.ones((self.extent, 2, 2)),
        }
        return Response({"F": float(made["force"].max())}, made if histories else {})


def test_a_model_that_does_not_draw_has_plain_plots_of_what_it_returns_over_time() -> None:
    model = Undrawn()
    histories = model.simulate(Slope(), histories=True).histories
    (figure,) = history_figures(model.histories, histories).values()
    force, wheels = figure.axes
    assert (force.get_title(loc="left"), force.get_ylabel()) == ("force: under the wheel", "[N]")
    np.testing.assert_array_equal(force.lines[0].get_xdata(), histories["time"])
    np.testing.assert_array_equal(force.lines[0].get_ydata(), histories["force"])
    assert [line.get_ydata()[-1] for line in wheels.lines] == pytest.approx([0.4, -0.4])
    assert wheels.get_xlabel() == "time [s]"
    assert figure.get_label()


@pytest.mark.parametrize(
    "histories", [{}, {"time": np.arange(3.0)}, {"force": np.arange(3.0)}, {"time": np.ones((3, 1)), "force": np.ones(3)}]
)
def test_without_histories_over_time_there_are_no_plots(histories: Mapping[str, Any]) -> None:
    assert history_figures(Undrawn.histories, histories) == {}


def test_it_is_not_simulated_for_pictures_that_it_does_not_draw() -> None:
    model = Undrawn(extent=-1)
    assert drawing_model(model) is None
    assert passage_figures(model, {"one": "no parameters at all"}) == {}


@pytest.mark.parametrize(("returned", "pictures"), [(True, 1), (False, 0)])
def test_its_page_has_what_there_is(returned: bool, pictures: int) -> None:
    model, slope = Undrawn(), Slope(slope=3.0, stops=tuple(map(float, range(9))))
    entry = Entry("track-model", "undrawn", Undrawn, Provenance("undrawn_module", "undrawn", "1.0"))
    text = simulation_page(entry, model, Passage(slope, model.simulate(slope, returned)), "railsearch simulate undrawn")
    page = Page(text)
    assert page.tags.count("figure") == pictures
    assert row(text, "F [N]") == ["F [N]", "1.2", "largest force"]
    assert row(text, "slope") == ["slope", "3", "2", "N/s", "of the force &lt;over time&gt;"]
    assert row(text, "stops")[1:3] == ["9 values, 0 … 8", "none"]
    assert "A force that grows" in page.text
    assert "undrawn 1.0" in page.text


def test_a_strangers_model_is_simulated_with_a_page(railsearch: Cli, install: Callable[..., None], tmp_path: Path) -> None:
    module = types.ModuleType("stranger")

    @hookimpl
    def railsearch_track_models(register: Register) -> None:
        register("undrawn", Undrawn)

    vars(module)["railsearch_track_models"] = railsearch_track_models
    install(stranger=lambda: module)
    answer = railsearch("simulate", "undrawn", "--set", "slope=4", "--report", tmp_path / "page.html")
    assert answer.code == 0, answer.err
    assert "histories" in written(tmp_path / "page.html").identifiers


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (None, "not given"),
        ("", "not given"),
        (0, "0"),
        (0.0, "0"),
        (False, "False"),
        ("german", "german"),
        (140.0 / 3.6, "38.88888889"),
        (7.416e-7, "7.416e-07"),
        ((), "none"),
        ((0.6, 0.4), "0.6, 0.4"),
        ({"pad": 1120.0}, "pad: 1120"),
    ],
)
def test_values_are_shown_to_be_read(value: object, text: str) -> None:
    assert shown(value) == text


def test_nothing_to_set_is_no_fault() -> None:
    model = Undrawn()
    model_without = types.SimpleNamespace(
        Parameters=NoParameters, metrics=model.metrics, histories=(), simulate=model.simulate
    )
    entry = Entry("track-model", "undrawn", Undrawn, Provenance("undrawn_module", "undrawn", "1.0"))
    passage = Passage(NoParameters(), Response({"F": 1.0}))
    text = simulation_page(entry, model_without, passage, "")  # type: ignore[arg-type]
    assert "All 0 parameters" in text


@pytest.mark.system
def test_the_page_fits_a_desk_and_a_phone(railsearch: Cli, tmp_path: Path) -> None:
    report = tmp_path / "page.html"
    assert railsearch("simulate", "train-track-bridge", *SHORT, "--report", report).code == 0
    with browsing(tmp_path / "profile") as browser:
        for width in (1280, 400):
            browser.open(report, width)
            assert browser.value("document.documentElement.scrollWidth") <= width
            assert browser.value("document.querySelector('details').open") is False
            browser.click("summary")
            assert browser.value("document.querySelector('details').open") is True
            assert browser.value("document.documentElement.scrollWidth") <= width
        assert browser.complaints == []
        assert set(browser.requests) == {report.resolve().as_uri()}
