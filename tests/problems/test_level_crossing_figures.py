"""The pictures of a crossing say what the numbers say."""

import dataclasses

import numpy as np
import pytest
from matplotlib import colormaps
from matplotlib.colors import LogNorm
from matplotlib.patches import Polygon, Rectangle

import railsearch
from railsearch.errors import InputError
from railsearch.interfaces import passage_figures

REFERENCE = np.array([1120.0, 1120.0, 1120.0, 8, 6, 6, 4, 0])
OTHER = np.array([124.0, 604.0, 509.0, 3, 6, 7, 3, 53])


@pytest.fixture(scope="module")
def problem():
    return railsearch.problem("level-crossing")


@pytest.fixture(scope="module")
def figures(problem):
    return problem.figures({"reference": REFERENCE, "best": OTHER})


@pytest.fixture(scope="module")
def views(figures):
    """Overview, approach and departure detail of the reference, then of the other design."""
    return [axes for axes in figures["zone"].axes if axes.get_xlabel().startswith("Position")]


def patches(axes, name):
    return [patch for patch in axes.patches if patch.get_label() == name]


def centres(axes, *names):
    found = [patch for name in names for patch in patches(axes, name)]
    return np.array(sorted(np.mean([point[0] for point in patch.get_xy()[:4]]) for patch in found))


def test_there_are_three_pictures_with_captions(figures):
    assert list(figures) == ["force", "energy", "zone"]
    assert all(len(figure.get_label()) > 80 for figure in figures.values())


def test_the_section_is_to_scale(views):
    assert len(views) == 6
    for axes in views:
        assert axes.get_aspect() == 1.0
        width, height = axes.get_position().size * axes.figure.get_size_inches()
        across, up = np.ptp(axes.get_xlim()), np.ptp(axes.get_ylim())
        assert width / across == pytest.approx(height / up, rel=1e-9)


@pytest.mark.parametrize(
    ("view", "expected"),
    [
        (1, [-2.2, -1.6, -1.0, -0.4]),
        (2, [12.4, 13.0, 13.6, 14.2]),
        (4, [-2.2, -1.6, -1.0, -0.3]),
        (5, [12.3, 13.0, 13.6, 14.2]),
    ],
)
def test_sleepers_stand_where_the_design_puts_them(views, view, expected):
    places = centres(views[view], "sleeper", "strengthened sleeper")
    inside = places[(places > views[view].get_xlim()[0]) & (places < views[view].get_xlim()[1])]
    assert np.allclose(inside, expected, atol=1e-9)


def test_strengthened_sleepers_are_counted_from_the_crossing_on_both_sides(views):
    for view, count in ((0, 8), (3, 3)):
        places = centres(views[view], "strengthened sleeper")
        assert np.sum(places < 0.0) == np.sum(places > 12.0) == count
        plain = centres(views[view], "sleeper")
        assert plain[plain < 0.0].max(initial=-99.0) < places[places < 0.0].min()


def test_pads_are_coloured_by_their_stiffness(views):
    norm = LogNorm(124.0, 1120.0)
    expected = {-1.6: 124.0, -1.0: 604.0, -0.3: 509.0, -2.2: 1120.0}
    pads = {round(pad.get_x() + pad.get_width() / 2, 6): pad for pad in patches(views[4], "pad")}
    for place, stiffness in expected.items():
        assert np.allclose(pads[place].get_facecolor(), colormaps["viridis"](float(norm(stiffness))))
    written = {text.get_position()[0]: text.get_text() for text in views[4].texts if text.get_position()[1] < 0.0}
    assert {round(place, 6): text for place, text in written.items()} == {-0.3: "509", -1.0: "604", -1.6: "124"}


def test_distances_are_written_between_the_sleepers(views):
    for view, expected in ((1, ["0.4", "0.6", "0.6"]), (4, ["0.3", "0.7", "0.6"]), (5, ["0.3", "0.7", "0.6"])):
        texts = [text.get_text() for text in views[view].texts if text.get_position()[1] > 0.0 and text.get_text()]
        assert texts == expected


def test_slabs_and_strips_have_their_lengths(views):
    assert [(slab.get_x(), slab.get_width()) for slab in patches(views[0], "slab")] == [(0.0, 6.0), (6.0, 6.0)]
    assert patches(views[0], "Type II strip") == []
    (second,), (first,) = patches(views[3], "Type II strip"), patches(views[3], "Type I strip")
    assert isinstance(second, Rectangle)
    assert (second.get_x(), second.get_width()) == (0.0, 5.3)
    assert first.get_x() == 5.3
    assert first.get_x() + first.get_width() == pytest.approx(12.0)
    assert all(isinstance(sleeper, Polygon) for sleeper in patches(views[0], "sleeper"))


@pytest.mark.parametrize(("name", "metric", "scale"), [("force", "F_max", 1e3), ("energy", "E_max", 1.0)])
def test_bars_and_numbers_are_the_measured_ranges(problem, figures, name, metric, scale):
    _, ranges = figures[name].axes
    for bar, design, label in zip(ranges.patches, (REFERENCE, OTHER), ranges.get_xticklabels(), strict=True):
        expected = problem.simulate(design).metrics[metric] / scale
        assert bar.get_height() == pytest.approx(expected, rel=1e-9)
        assert f"{expected:.3f} kN" in label.get_text() or f"{expected:.4f} N·m" in label.get_text()
    texts = [float(text.get_text()) for text in ranges.texts]
    assert texts[1] - texts[0] == pytest.approx(ranges.patches[0].get_height(), abs=0.011 if name == "force" else 0.0011)


def test_the_curves_are_the_histories_from_the_first_interface(problem, figures):
    response = problem.model.simulate(problem.parameters(OTHER), histories=True)
    axes, _ = figures["force"].axes
    (curve,) = [line for line in axes.lines if line.get_label() == "best"]
    position = response.histories["wheel_position"] - 100.0
    assert np.allclose(
        np.interp(curve.get_xdata(), position, response.histories["wheel_rail_force"]) / 1e3, curve.get_ydata()
    )
    axes, _ = figures["energy"].axes
    (curve,) = [line for line in axes.lines if line.get_label() == "best"]
    assert len(curve.get_xdata()) == 20
    before = response.histories["sleeper_position"] < 100.0
    assert np.allclose(curve.get_ydata(), response.histories["sleeper_energy"][before][-20:])


def test_extreme_designs_are_drawn(problem):
    lowest, highest = problem.space.lower, problem.space.upper
    assert len(problem.figures({"reference": lowest, "best": highest})) == 3
    assert len(problem.figures({"best": highest})) == 3


@pytest.mark.parametrize("stiffness", [300.0, 700.0, 1120.0])
def test_the_colour_bar_has_numbers_when_all_pads_are_equal(problem, stiffness):
    pads = problem.track.railpad
    track = dataclasses.replace(
        problem.track,
        railpad=dataclasses.replace(pads, stiffness=stiffness * 1e6),
        zone=dataclasses.replace(problem.track.zone, pad_stiffness=(stiffness * 1e6,) * 3),
    )
    (bar,) = [axes for axes in passage_figures(problem.model, {"only": track})["zone"].axes if "pad" in axes.get_xlabel()]
    low, high = bar.get_xlim()
    rounding = 1e-9 * high
    assert sum(low - rounding <= tick <= high + rounding for tick in bar.get_xticks()) >= 2


def test_the_model_draws_what_is_asked_for_in_that_order(problem):
    parameters = {"only": problem.track}
    assert list(passage_figures(problem.model, parameters)) == ["force", "energy", "acceleration", "zone"]
    assert list(passage_figures(problem.model, parameters, ("zone", "energy-adjacent"))) == ["zone", "energy-adjacent"]
    with pytest.raises(InputError, match="unknown 'forces'; there are force, energy, energy-adjacent"):
        passage_figures(problem.model, parameters, ("forces",))
