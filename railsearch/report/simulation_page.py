"""The page of one simulation: metrics, pictures and parameters of a passage, and how to repeat it."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from railsearch.interfaces import Passage, Quantity, TrackModel, drawing_model
from railsearch.parameters import Description, describe_parameters
from railsearch.plugin_manager import Entry
from railsearch.report.history_plots import history_figures
from railsearch.report.markup import escaped, page, picture, section, table
from railsearch.result import versions
from railsearch.wording import quantity_label, readable

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LABEL = "passage"
MOST_VALUES = 6


def simulation_page(entry: Entry, model: TrackModel, passage: Passage, command: str) -> str:
    """The HTML text of the page of a passage of `model`, registered as `entry`; command: how to make it again."""
    parts = [
        section("Metrics", _metrics(model.metrics, passage.response.metrics)),
        *(picture(name, figure) for name, figure in _figures(model, passage).items()),
        section("Parameters", _parameters(passage.parameters, model.Parameters())),
        section("To repeat it", _provenance(entry, command)),
    ]
    return page(f"{entry.name}: one passage", f"Simulated with the track model {entry.name}. {entry.summary}", parts)


def _figures(model: TrackModel, passage: Passage) -> Mapping[str, Figure]:
    """The model's own pictures, or plain plots of its histories."""
    drawing = drawing_model(model)
    if drawing is None:
        return history_figures(model.histories, passage.response.histories)
    return drawing.figures({LABEL: passage})


def _metrics(quantities: Sequence[Quantity], metrics: Mapping[str, float]) -> str:
    rows = [
        [quantity_label(quantity.name, quantity.unit), readable(metrics[quantity.name]), quantity.meaning]
        for quantity in quantities
    ]
    return table(["quantity", "value", "meaning"], rows, numbers=(1,))


def _parameters(used: object, default: object) -> str:
    """Those that are not as by default, and folded away all of them."""
    all_used, defaults = list(describe_parameters(used)), {row.name: row.default for row in describe_parameters(default)}
    changed = [row for row in all_used if row.default != defaults[row.name]]
    titles = ["parameter", "value", "default", "unit", "meaning"]
    rows = [[row.name, shown(row.default), shown(defaults[row.name]), row.unit, row.meaning] for row in changed]
    above = table(titles, rows, numbers=(1, 2)) if rows else "<p>All parameters are as by default.</p>"
    return f"{above}\n<details><summary>All {len(all_used)} parameters</summary>{_all(all_used)}</details>"


def _all(descriptions: Sequence[Description]) -> str:
    rows = [[row.name, shown(row.default), row.unit, row.meaning, row.source] for row in descriptions]
    return table(["parameter", "value", "unit", "meaning", "source"], rows, numbers=(1,))


def shown(value: object) -> str:
    """A parameter's value to ten significant digits; of a long list its length and its ends."""
    if value is None or value == "":
        return "not given"
    if isinstance(value, float):
        return f"{value:.10g}"
    if isinstance(value, Mapping):
        return ", ".join(f"{name}: {shown(item)}" for name, item in value.items())
    if isinstance(value, list | tuple):
        if len(value) > MOST_VALUES:
            return f"{len(value)} values, {shown(value[0])} … {shown(value[-1])}"
        return ", ".join(map(shown, value)) or "none"
    return str(value)


def _provenance(entry: Entry, command: str) -> str:
    origin = dataclasses.asdict(entry.provenance)
    plugin = [[entry.kind, entry.name, origin["module"], f"{origin['distribution']} {origin['version']}".strip()]]
    return "\n".join(
        (
            f"<pre>{escaped(command)}</pre>",
            table(["plugin", "name", "module", "from"], plugin),
            table(["library", "version"], list(versions().items())),
        )
    )
