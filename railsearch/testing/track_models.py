"""Conformance of track models."""

import copy
from collections.abc import Mapping
from typing import Any

import numpy as np

from railsearch.errors import InputError
from railsearch.interfaces import DrawnTrackModel, Passage, TrackModel, drawing_model
from railsearch.parameters import describe_parameters, make_parameters
from railsearch.testing.requirement import require


def check_track_model(plugin: Any, settings: Mapping[str, object] | None = None) -> None:
    """Check a track model class on its default parameters, or on `settings` of them.

    What it returns is what it announces: metrics and histories by name, finite numbers; the same passage gives the same
    numbers to the last bit, with histories or without; parameters are described and are left as they were; one that draws
    its passages draws the figures asked for, with captions, and refuses others. What a model conserves, its symmetry and its
    rates of convergence are its own tests'.
    Raises AssertionError with what is wrong.
    """
    parameters = make_parameters(plugin.Parameters, settings or {}, "settings")
    before = copy.deepcopy(parameters)
    model: TrackModel = plugin()
    model.warm_up()
    model.check(parameters)
    plain, whole = model.simulate(parameters), model.simulate(parameters, histories=True)
    require(parameters == before, "simulate changed its parameters")
    _check_metrics(model, plain.metrics)
    require(not plain.histories, "histories were returned without being asked for")
    require(dict(plain.metrics) == dict(whole.metrics), "metrics differ when histories are asked for")
    again = plugin().simulate(parameters)
    require(dict(plain.metrics) == dict(again.metrics), "two passages with the same parameters differ")
    _check_histories(model, whole.histories)
    drawing = drawing_model(model)
    if drawing is not None:
        _check_figures(drawing, Passage(parameters, whole))
    for description in describe_parameters(parameters):
        require(bool(description.meaning), f"parameter {description.name} has no meaning")


def _check_metrics(model: TrackModel, metrics: Mapping[str, float]) -> None:
    announced = [quantity.name for quantity in model.metrics]
    require(sorted(metrics) == sorted(announced), f"metrics {sorted(metrics)} are not the announced {sorted(announced)}")
    for name, value in metrics.items():
        require(isinstance(value, float) and bool(np.isfinite(value)), f"metric {name} is {value!r}, not a finite float")


def _check_histories(model: TrackModel, histories: Mapping[str, Any]) -> None:
    announced = [quantity.name for quantity in model.histories]
    require(
        sorted(histories) == sorted(announced), f"histories {sorted(histories)} are not the announced {sorted(announced)}"
    )
    for name, values in histories.items():
        sound = isinstance(values, np.ndarray) and values.ndim >= 1 and bool(np.isfinite(values).all())
        require(sound, f"history {name} is not an array of finite numbers")


def _check_figures(model: DrawnTrackModel, passage: Passage) -> None:
    figures = model.figures({"one": passage, "other": passage})
    require(bool(figures), "there is a method figures, but there are none")
    for name, figure in figures.items():
        require(bool(figure.get_label()), f"figure {name} has no label, which is its caption")
    asked = list(figures)[-1:]
    require(list(model.figures({"one": passage}, asked)) == asked, f"other figures are returned than {asked[0]}, asked for")
    try:
        model.figures({"one": passage}, ["no such figure"])
    except InputError:
        return
    require(False, "a figure that there is not is not refused with an InputError")
