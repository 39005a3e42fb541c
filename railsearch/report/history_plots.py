"""Plain plots of what a track model returns over time, for models that do not draw their passages themselves."""

from collections.abc import Mapping, Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from railsearch.interfaces import Quantity
from railsearch.wording import quantity_label

TIME = "time"
COLOUR = "#0072B2"
PANEL, ROOM = 1.5, 1.1


def history_figures(quantities: Sequence[Quantity], histories: Mapping[str, NDArray[Any]]) -> dict[str, Figure]:
    """One figure, `histories`, with a panel for every history (t,) or (t, k) over that called `time` (t,); none without."""
    known = {quantity.name: quantity for quantity in quantities}
    shown = [known[name] for name, values in histories.items() if name in known and _over_time(name, values, histories)]
    if not shown:
        return {}
    figure = Figure(figsize=(10.0, ROOM + PANEL * len(shown)), layout="constrained")
    figure.suptitle("Histories", x=0.01, ha="left", fontsize=12, fontweight="bold")
    panels = figure.subplots(len(shown), 1, sharex=True, squeeze=False)[:, 0]
    for axes, quantity in zip(panels, shown, strict=True):
        _draw(axes, quantity, histories)
    panels[-1].set_xlabel(quantity_label(TIME, known[TIME].unit) if TIME in known else TIME)
    panels[-1].set_xlim(histories[TIME][0], histories[TIME][-1])
    figure.set_label("What the track model returns over time; where it returns several values at a time, a line for each.")
    return {"histories": figure}


def _over_time(name: str, values: NDArray[Any], histories: Mapping[str, NDArray[Any]]) -> bool:
    """One value or one row for every time."""
    time = histories.get(TIME)
    return time is not None and time.ndim == 1 and name != TIME and values.ndim in (1, 2) and len(values) == len(time)


def _draw(axes: Axes, quantity: Quantity, histories: Mapping[str, NDArray[Any]]) -> None:
    values = histories[quantity.name]
    single = values.ndim == 1 or values.shape[1] == 1
    axes.plot(histories[TIME], values, lw=1.1 if single else 0.8, color=COLOUR if single else None, label=quantity.name)
    axes.set_title(f"{quantity.name}: {quantity.meaning}" if quantity.meaning else quantity.name, loc="left", fontsize=9)
    axes.set_ylabel(f"[{quantity.unit}]" if quantity.unit else "", fontsize=9)
    axes.tick_params(labelsize=9)
    axes.grid(axis="y", color="#E3E3E3", lw=0.6)
