"""How numbers and names are shown, in tables, pages and figures alike."""

import difflib
from collections.abc import Mapping, Sequence
from typing import Any


def readable(value: object) -> str:
    """A number with five significant digits, zero without a sign, a dash for nothing, anything else as it is."""
    if value is None:
        return "–"
    return f"{value + 0.0:.5g}" if isinstance(value, float) else str(value)


def preference_words(row: Mapping[str, Any]) -> str:
    """A described preference function with its parameters."""
    words = [f"{name.replace('_', ' ')} {_listed(value)}" for name, value in row["parameters"].items()]
    return f"{row['function']}: {', '.join(words)}"


def outside(row: Mapping[str, Any]) -> str:
    """What a described preference function does outside its range of values."""
    return "extended" if row["extended"] else "clipped"


def candidate_marks(candidate: Mapping[str, Any]) -> str:
    """What speaks for a candidate of a choice besides its preference scores."""
    marks = {"nearest_pseudo_weights": "nearest pseudo-weights", "high_trade_off": "high trade-off"}
    return ", ".join(words for key, words in marks.items() if candidate[key])


def none_feasible(document: Mapping[str, Any]) -> str:
    """That a run has found no feasible design, and how near it came; empty if it has found one or only failures.

    document: its key evaluations is used, as a result document has it.
    """
    made = [row for row in document["evaluations"] if row.get("violation") is not None]
    if not made or any(row["violation"] == 0.0 for row in made):
        return ""
    nearest = min(made, key=lambda row: float(row["violation"]))
    return (
        f"none of {len(made)} designs is feasible; the smallest violation is {readable(nearest['violation'])}, summed over "
        f"the constraints, at evaluation {nearest['number']}"
    )


def install_remedy(extra: str) -> str:
    """How to install an extra of railsearch, for messages about something that is missing."""
    return f"`.venv/bin/pip install '.[{extra}]'` in a clone, else `pip install 'railsearch[{extra}]'`"


def did_you_mean(name: str, known: Sequence[str]) -> str:
    """The end of a message about an unknown name: the closest known one, or all of them."""
    close = difflib.get_close_matches(name, known, n=1)
    return f"; did you mean '{close[0]}'?" if close else f"; allowed are {', '.join(known) or 'none'}"


def closest(name: str, known: Sequence[str]) -> str:
    """The question whether the closest known name was meant, for a message that goes on with all of them; or nothing."""
    close = difflib.get_close_matches(name, known, n=1)
    return f", did you mean '{close[0]}'?" if close else ""


def _listed(value: object) -> str:
    return f"({', '.join(map(_listed, value))})" if isinstance(value, list | tuple) else readable(value)


def quantity_label(name: str, unit: str) -> str:
    """A name with its unit in brackets."""
    return f"{name} [{unit}]" if unit else name
