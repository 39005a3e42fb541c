"""What a scalariser has to fulfil."""

import copy
import json
from collections.abc import Mapping
from typing import Any

import numpy as np

from railsearch.interfaces import Quantity
from railsearch.parameters import make_parameters
from railsearch.testing.requirement import require


def check_scalariser(plugin: Any, settings: Mapping[str, object] | None = None) -> None:
    """Check a scalariser class, made with `settings` of its parameters, on three objectives between 0 and 10.

    Ready after `prepare`; a copy may be prepared without the original (a problem keeps its own copy); one finite scalar per
    row, the same for many rows as one by one; better in every objective is better in the scalar; inputs are not altered;
    `values` are plain and finite; its parameters have defaults, for the template of a site file.
    Settings that it needs must leave a slope from -1 to 10. Raises AssertionError with an explanation.
    """
    parameters = make_parameters(plugin.Parameters, dict(settings or {}), "scalariser")
    quantities = [Quantity(name) for name in ("f1", "f2", "f3")]
    original = plugin(parameters, quantities, {quantity.name: 10.0 for quantity in quantities})
    scalariser, was_ready = copy.copy(original), original.ready
    if not was_ready:
        scalariser.prepare(np.array([4.0, 5.0, 6.0]))
    require(scalariser.ready, "the scalariser is not ready after it was given the reference design's objectives")
    require(original.ready == was_ready, "preparing a copy of the scalariser prepared the original too")
    objectives = np.random.default_rng(3).uniform(0.0, 10.0, (50, 3))
    before = objectives.copy()
    scalars = np.asarray(scalariser(objectives))
    require(np.array_equal(objectives, before), "the scalariser altered the objectives it was given")
    require(scalars.shape == (50,), f"50 rows of objectives must give scalars of shape (50,), received {scalars.shape}")
    require(bool(np.isfinite(scalars).all()), "the scalariser gives scalars that are not finite")
    single = np.concatenate([scalariser(row[None, :]) for row in objectives])
    require(bool(np.allclose(single, scalars, rtol=1e-12, atol=1e-12)), "many rows at once differ from row by row")
    better = np.asarray(scalariser(0.9 * objectives - 0.1))
    require(bool(np.all(better < scalars)), "a design better in every objective does not get a lower scalar")
    _check_record(plugin, scalariser)


def _check_record(plugin: Any, scalariser: Any) -> None:
    try:
        json.dumps(dict(scalariser.values), allow_nan=False)
    except (TypeError, ValueError) as error:
        require(False, f"`values` are not plain numbers, strings, lists and dictionaries by name: {error}")
    try:
        plugin.Parameters()
    except Exception as error:  # noqa: BLE001 - a stranger's parameters may raise anything
        require(False, f"the Parameters of a scalariser cannot be made without values: {error}")
