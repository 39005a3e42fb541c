"""The pictures of a train on a bridge say what the histories and metrics say."""

from dataclasses import replace

import numpy as np
import pytest
from bridges import short_bridge
from matplotlib.patches import Circle, Polygon

from railsearch.errors import InputError
from railsearch.interfaces import Passage, passage_figures
from railsearch_plugins.dynamics.vehicles import at_rest
from railsearch_plugins.track_models.train_track_bridge import TrainTrackBridge
from railsearch_plugins.track_models.train_track_bridge.assembly import make_train
from railsearch_plugins.track_models.train_track_bridge.figures.snapshot_figure import exaggeration
from railsearch_plugins.track_models.train_track_bridge.ride_comfort import ride_comfort_index

SPAN = 9.0
ONE = short_bridge(end_position=20.0)
TWO = replace(ONE, vehicles=2, pad_stiffness=1e8, start_position=-2.0137, carbody_mass_factor=1.2, irregularity_file="")


@pytest.fixture(scope="module")
def responses():
    return {label: TrainTrackBridge().simulate(track, histories=True) for label, track in (("one", ONE), ("two", TWO))}


@pytest.fixture(scope="module")
def alone(responses):
    return TrainTrackBridge().figures({"one": Passage(ONE, responses["one"])})


@pytest.fixture(scope="module")
def both(responses):
    return TrainTrackBridge().figures({"one": Passage(ONE, responses["one"]), "two": Passage(TWO, responses["two"])})


def lines(figure, ending):
    return [line for axes in figure.axes for line in axes.lines if str(line.get_label()).endswith(ending)]


def artists(axes, name):
    return [patch for patch in axes.patches if patch.get_label() == name]


def factor(figure):
    return float(figure.get_label().split(" times as large")[0].split()[-1])


def heights(line, scale=1.0):
    return -scale * np.asarray(line.get_ydata())


def test_there_are_four_pictures_with_captions_and_units(alone, both):
    for figures in (alone, both):
        assert list(figures) == ["snapshot", "force", "histories", "envelopes"]
        for figure in figures.values():
            assert len(figure.get_label()) > 150
            named = [axes for axes in figure.axes if axes.axison]
            assert all(axes.get_ylabel().endswith(("[kN]", "[mm]", "[m/s²]")) for axes in named)
            assert "[m]" in named[-1].get_xlabel()


def test_figures_are_drawn_in_the_order_asked_for_and_others_are_refused(responses):
    passages = {"one": Passage(ONE, responses["one"])}
    assert list(TrainTrackBridge().figures(passages, ("envelopes", "snapshot"))) == ["envelopes", "snapshot"]
    with pytest.raises(InputError, match="unknown 'snap'; there are snapshot, force, histories, envelopes"):
        TrainTrackBridge().figures(passages, ("snap",))


def test_the_model_draws_what_it_simulates():
    assert list(passage_figures(TrainTrackBridge(), {"short": short_bridge(end_position=4.0)}, ("force",))) == ["force"]


def test_every_axle_has_its_force(responses, alone, both):
    for figures, labels in ((alone, ["one"]), (both, ["one", "two"])):
        for label in labels:
            histories = responses[label].histories
            for axle in range(histories["contact_force"].shape[1]):
                (line,) = lines(figures["force"], f"_{label}, axle {axle + 1}")
                assert line.axes is figures["force"].axes[axle // 4]
                np.testing.assert_array_equal(line.get_xdata(), histories["axle_position"][:, 0])
                np.testing.assert_allclose(line.get_ydata(), 1e-3 * histories["contact_force"][:, axle], rtol=1e-14)


def test_static_load_and_extreme_forces_are_marked(responses, both):
    first, second = (1e-3 * make_train(track).static_load[0] for track in (ONE, TWO))
    loads = [line.get_ydata()[0] for line in lines(both["force"], "_static load")]
    assert loads == pytest.approx([first, second, second])
    marked = {line.get_label(): line for line in lines(both["force"], " kN")}
    for response in responses.values():
        for metric in ("contact_force_max", "contact_force_min"):
            value = 1e-3 * response.metrics[metric]
            assert marked[f"{value:.4g} kN"].get_ydata()[0] == pytest.approx(value)


def test_the_bridge_is_shaded_where_what_is_shown_is_on_it(both):
    """The last axle of a vehicle is 21.56 m behind its first, the second vehicle 25 m behind the first one."""
    behind, second = 2.0 * (9.5 + 1.28), 25.0
    one, two = (0.0, SPAN + behind), (second, second + SPAN + behind)
    ends = {"envelopes": [(0.0, SPAN)] * 4, "force": [one, two], "histories": [one, two, (0.0, two[1]), (0.0, SPAN)]}
    for name, expected in ends.items():
        shades = [artists(axes, "_bridge")[0] for axes in both[name].axes]
        found = [(shade.get_x(), shade.get_x() + shade.get_width()) for shade in shades]
        np.testing.assert_allclose(found, expected, atol=1e-9)
    assert "the bridge, 9 m" in both["envelopes"].axes[-1].get_xlabel()


def test_carbodies_have_their_accelerations_and_comfort(responses, both):
    axes = both["histories"].axes
    for label, track in (("one", ONE), ("two", TWO)):
        histories = responses[label].histories
        measured = histories["axle_position"][:, 0] >= -track.approach_length
        assert measured.all()
        for vehicle in range(track.vehicles):
            acceleration = histories["carbody_acceleration"][:, vehicle]
            index = ride_comfort_index(acceleration, histories["time"][1])
            (line,) = [line for line in axes[vehicle].lines if line.get_label() == f"W_z {index:.4g}"]
            np.testing.assert_array_equal(line.get_ydata(), acceleration)
        largest = f"W_z {responses[label].metrics['W_z']:.4g}"
        assert largest in [line.get_label() for panel in axes for line in panel.lines]


def test_comfort_counts_from_the_measured_approach(responses):
    late = replace(ONE, approach_length=1.0)
    response = TrainTrackBridge().simulate(late, histories=True)
    figure = TrainTrackBridge().figures({"late": Passage(late, response)}, ("histories",))["histories"]
    assert f"W_z {response.metrics['W_z']:.4g}" in [line.get_label() for line in figure.axes[0].lines]
    assert response.metrics["W_z"] != responses["one"].metrics["W_z"]


def test_deck_and_irregularity_are_the_histories(responses, both):
    *_, deck, irregularity = both["histories"].axes
    assert deck.yaxis_inverted()
    for label, response in responses.items():
        (line,) = [line for line in deck.lines if line.get_label() == f"_{label}"]
        np.testing.assert_allclose(line.get_ydata(), 1e3 * response.histories["deck_deflection"], rtol=1e-14)
        (line,) = [line for line in irregularity.lines if line.get_label() == label]
        np.testing.assert_allclose(line.get_ydata(), 1e3 * response.histories["irregularity"][:, 0], rtol=1e-14)
        mark = f"U_d {1e3 * response.metrics['U_d']:.4g} mm"
        assert mark in [line.get_label() for line in deck.lines]


def test_envelopes_are_the_largest_values(responses, both):
    deflection, acceleration, sleepers, rail = both["envelopes"].axes
    assert [axes.yaxis_inverted() for axes in both["envelopes"].axes] == [True, False, False, True]
    for number, (label, response) in enumerate(responses.items()):
        histories, metrics = response.histories, response.metrics
        np.testing.assert_allclose(deflection.lines[number].get_ydata(), 1e3 * histories["bridge_deflection_max"])
        np.testing.assert_allclose(acceleration.lines[number].get_ydata(), histories["bridge_acceleration_max"])
        (measured,) = [line for line in sleepers.lines if line.get_label() == f"A_s {metrics['A_s']:.4g} m/s²"]
        (others,) = [line for line in sleepers.lines if line.get_label() == f"_{label}, not measured"]
        assert max(measured.get_ydata()) == metrics["A_s"]
        places = histories["sleeper_position"]
        np.testing.assert_array_equal(measured.get_xdata(), places[(places > -20.01) & (places < SPAN + 20.01)])
        assert measured.get_markerfacecolor() != others.get_markerfacecolor() == "white"
        together = np.concatenate([measured.get_xdata(), others.get_xdata()])
        np.testing.assert_array_equal(np.sort(together), histories["sleeper_position"])
        (lowest,) = [line for line in rail.lines if line.get_label() == f"U_r {1e3 * metrics['U_r']:.4g} mm"]
        (highest,) = [line for line in rail.lines if line.get_label() == f"_{label}, highest"]
        np.testing.assert_allclose(lowest.get_ydata(), 1e3 * histories["rail_lowest"], rtol=1e-14)
        np.testing.assert_allclose(highest.get_ydata(), -1e3 * histories["rail_highest"], rtol=1e-14)


def test_the_snapshot_is_to_scale_with_one_factor_and_view(both):
    drawings, curves = both["snapshot"].axes[::2], both["snapshot"].axes[1::2]
    assert len(drawings) == len(curves) == 2
    for axes in drawings:
        width, height = axes.get_position().size * axes.figure.get_size_inches()
        assert width / np.ptp(axes.get_xlim()) == pytest.approx(height / np.ptp(axes.get_ylim()))
        assert axes.get_xlim() == drawings[0].get_xlim()
    assert all(axes.yaxis_inverted() and axes.get_ylim() == curves[0].get_ylim() for axes in curves)


def test_track_and_bridge_of_the_snapshot_are_the_state(responses, both):
    times = factor(both["snapshot"])
    for number, response in enumerate(responses.values()):
        drawing, curves = both["snapshot"].axes[2 * number : 2 * number + 2]
        histories = response.histories
        (rail,) = [line for line in drawing.lines if line.get_label() == "rail"]
        state = np.interp(rail.get_xdata(), histories["rail_position"], histories["snapshot_rail_displacement"])
        np.testing.assert_allclose(heights(rail), times * state, atol=1e-12)
        (deck,) = [line for line in drawing.lines if line.get_label() == "deck"]
        sag = heights(deck) - heights(deck)[0]
        np.testing.assert_allclose(sag, times * histories["snapshot_bridge_deflection"], atol=1e-12)
        (sleepers,) = [made for made in drawing.containers if made.get_label() == "sleepers"]
        places = [bar.get_x() + 0.5 * bar.get_width() for bar in sleepers]
        lowered = np.interp(places, histories["sleeper_position"], histories["snapshot_sleeper_displacement"])
        feet = np.array([bar.get_y() for bar in sleepers])
        np.testing.assert_allclose(-(feet + 0.38), times * lowered, atol=1e-9)
        known = {line.get_label(): np.asarray(line.get_ydata()) for line in curves.lines}
        np.testing.assert_array_equal(known["rail"], histories["snapshot_rail_displacement"] / 1e-3)
        np.testing.assert_array_equal(known["sleepers"], histories["snapshot_sleeper_displacement"] / 1e-3)
        np.testing.assert_array_equal(known["bridge"], histories["snapshot_bridge_deflection"] / 1e-3)


def test_the_bodies_of_the_snapshot_are_where_they_are(responses, both):
    times = factor(both["snapshot"])
    for number, (response, track) in enumerate(zip(responses.values(), (ONE, TWO), strict=True)):
        histories, drawing = response.histories, both["snapshot"].axes[2 * number]
        step = int(np.searchsorted(histories["time"], histories["snapshot_time"][0] - 1e-9))
        axles, level = histories["axle_position"][step], -histories["irregularity"][step]
        wheels = artists(drawing, "wheel")
        assert all(isinstance(wheel, Circle) for wheel in wheels)
        np.testing.assert_allclose([wheel.center[0] for wheel in wheels], axles)
        lowered = histories["snapshot_wheel_displacement"] - level
        np.testing.assert_allclose([0.46 - wheel.center[1] for wheel in wheels], times * lowered, atol=1e-12)
        np.testing.assert_allclose(lowered, histories["rail_displacement"][step], atol=1e-15)
        standing = at_rest(make_train(track), level)[: 6 * track.vehicles].reshape(-1, 6)
        bodies = artists(drawing, "carbody")
        assert len(bodies) == track.vehicles
        assert all(isinstance(body, Polygon) for body in bodies)
        for row, body in enumerate(bodies):
            back, front, top, _ = body.get_xy()[:4]
            assert 0.5 * (back[0] + front[0]) == pytest.approx(axles[4 * row : 4 * row + 4].mean())
            drop = 1.15 - 0.5 * (back[1] + front[1])
            tilt = (back[1] - front[1]) / (front[0] - back[0])
            assert drop == pytest.approx(times * (histories["snapshot_carbody_displacement"][row] - standing[row, 0]))
            assert tilt == pytest.approx(times * (histories["snapshot_carbody_pitch"][row] - standing[row, 1]))
            assert top[1] - front[1] == pytest.approx(2.7)
        bogies = artists(drawing, "bogie")
        for row, body in enumerate(bogies):
            vehicle, place = row // 2, 2 + 2 * (row % 2)
            drop = 0.5 - 0.5 * (body.get_xy()[0][1] + body.get_xy()[1][1])
            assert drop == pytest.approx(
                times * (histories["snapshot_bogie_displacement"][row] - standing[vehicle, place]), abs=1e-12
            )
            assert body.get_xy()[:2, 0].mean() == pytest.approx(axles[2 * row : 2 * row + 2].mean())


def test_the_caption_tells_factor_time_and_place(responses, both):
    caption = both["snapshot"].get_label()
    assert exaggeration(0.0) == 1.0
    for label, response in responses.items():
        time, axles = response.histories["snapshot_time"][0], response.histories["axle_position"]
        front = axles[int(np.argmin(np.abs(response.histories["time"] - time))), 0]
        assert f"{label}: {time:.3f} s after the start, first axle at {front:.2f} m" in caption


@pytest.mark.parametrize(("largest", "expected"), [(1.0, 1.0), (1.1e-3, 500.0), (5e-3, 200.0), (0.99e-2, 100.0), (3.0, 0.2)])
def test_displacements_are_drawn_as_large_as_fits(largest, expected):
    assert exaggeration(largest) == pytest.approx(expected)


@pytest.mark.parametrize(
    "changes",
    [
        {"snapshot_time": 0.0},
        {"sleeper_range": "all", "contact_stiffness": 1.4e9},
        {"bridge_length": 0.6, "irregularity_file": "", "irregularity_spectrum": "none"},
        {"vehicles": 5, "irregularity_file": "", "end_position": 6.0},
    ],
)
def test_unusual_passages_are_drawn(changes):
    assert len(passage_figures(TrainTrackBridge(), {"unusual": replace(ONE, **changes)})) == 4
