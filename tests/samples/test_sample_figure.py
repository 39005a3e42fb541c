import dataclasses
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from uncertain_problem import Uncertain, plugin

from command_line import Answer
from railsearch.interfaces import Evaluation, Quantity
from railsearch.report.sample_figure import sample_figure
from railsearch.run import MemoryRecord
from railsearch.samples import Experiment, ExperimentDesign, evaluate_samples, natural_values
from railsearch.simulation import simulators


@pytest.fixture(scope="module")
def evaluations() -> list[Evaluation]:
    problem = Uncertain()
    experiment = Experiment(ExperimentDesign.SOBOL, 256, 1)
    return evaluate_samples(problem, experiment, MemoryRecord(), lambda evaluation: None, simulators(problem))


def test_bars_hold_all_values_and_lines_stand_at_the_quantiles(evaluations: list[Evaluation]) -> None:
    figure = sample_figure(Uncertain(), evaluations)
    panels = {axes.get_xlabel(): axes for part in figure.subfigs for axes in part.axes if axes.get_visible()}
    assert set(panels) == {"comfort [kN]", "load [kN]", "gap [mm]", "sag [mm]", "seconds"}
    succeeded = [evaluation for evaluation in evaluations if not evaluation.failed]
    comfort = natural_values(Uncertain(), succeeded, "comfort")
    assert sum(bar.get_height() for bar in panels["comfort [kN]"].patches) == len(succeeded) < len(evaluations)
    lines = sorted(line.get_xdata()[0] for line in panels["comfort [kN]"].lines)
    np.testing.assert_allclose(lines, np.quantile(comfort, [0.01, 0.5, 0.9, 0.99]))
    assert sum(bar.get_height() for bar in panels["sag [mm]"].patches) == len(evaluations), "every design was drawn"


def test_the_curve_of_a_variable_has_the_area_of_its_bars(evaluations: list[Evaluation]) -> None:
    figure = sample_figure(Uncertain(), evaluations)
    (axes,) = (axes for axes in figure.subfigs[1].axes if axes.get_xlabel() == "sag [mm]")
    (curve,) = axes.lines
    bars = sum(bar.get_height() * bar.get_width() for bar in axes.patches)
    # 256 Sobol' points of a normal distribution, drawn between the smallest and the largest: 0.8 % lie beyond.
    assert np.trapezoid(curve.get_ydata(), curve.get_xdata()) == pytest.approx(bars, rel=0.02)


def test_a_power_of_ten_goes_with_the_unit(evaluations: list[Evaluation]) -> None:
    class Stiff(Uncertain):
        def __init__(self) -> None:
            super().__init__()
            self.metrics = (Quantity("gap", "N/m"),)

    large = [
        dataclasses.replace(evaluation, metrics={"gap": 1e8 + 1e5 * evaluation.number}, reason="")
        for evaluation in evaluations
    ]
    figure = sample_figure(Stiff(), large)
    figure.draw_without_rendering()
    axes = figure.subfigs[0].axes[2]
    assert axes.get_xlabel() == "gap [$10^{6}$ N/m]"
    ticks = [float(label.get_text()) for label in axes.get_xticklabels()]
    np.testing.assert_allclose(ticks, axes.get_xticks() / 1e6)


def test_the_figure_is_beside_the_file(
    railsearch: Callable[..., Answer],
    install: Callable[..., None],
    tmp_path: Path,
) -> None:
    install(samples=plugin)
    answer = railsearch("sample", "uncertain", "--n", 20, "--seed", 1, "--out", tmp_path / "s.csv")
    assert answer.code == 0
    assert (tmp_path / "s.png").read_bytes().startswith(b"\x89PNG")
    assert f"wrote {tmp_path / 's.png'}" in answer.err
