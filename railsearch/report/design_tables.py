"""The best design beside the reference design: quantities, variables, and the front they come from."""

from collections.abc import Mapping, Sequence
from typing import Any

from railsearch.report.markup import (
    labelled,
    table,
)
from railsearch.wording import outside, preference_words, readable


def quantities_table(document: Mapping[str, Any], searched: Sequence[str]) -> str:
    """Objectives and metrics of the reference and the best design; searched: the names in bold.

    document: its keys problem, reference, best and improvement are used, as a result document has them.
    """
    problem = document["problem"]
    rows, marked = [], []
    for quantity in {q["name"]: q for q in (*problem["objectives"], *problem["metrics"])}.values():
        name, gain = quantity["name"], document["improvement"].get(quantity["name"])
        values = [readable(_value(document[which], name)) for which in ("reference", "best")]
        better = "" if gain is None else f"{gain:+.1f} %"
        rows.append([labelled(quantity), *values, better, quantity["meaning"]])
        marked.append(name in searched)
    shown = table(["quantity", "reference", "best", "better by", "meaning"], rows, numbers=(1, 2, 3), marked=marked)
    return shown + "<p>In bold what was searched for. “Better by” is in per cent of the reference design's value.</p>"


def variables_table(document: Mapping[str, Any]) -> str:
    """The variables of the reference and the best design within their ranges."""
    rows = []
    for variable in document["problem"]["variables"]:
        bounds = f"{readable(variable['lower'])} … {readable(variable['upper'])}"
        designs = [
            document[which]["design"][variable["name"]] if document[which] else None for which in ("reference", "best")
        ]
        rows.append([labelled(variable), *map(readable, designs), bounds, variable["meaning"]])
    return table(["variable", "reference", "best", "range", "meaning"], rows, numbers=(1, 2, 3))


def preferences_table(rows: Sequence[Mapping[str, Any]]) -> str:
    """Preference functions with their parameters, and the scores of labelled designs."""
    several = any(row["stakeholder"] for row in rows)
    labels = list(rows[0]["scores"])
    titles = ["stakeholder"] * several + [
        "quantity",
        "function",
        "outside",
        "weight",
        *(f"score, {label}" for label in labels),
    ]
    cells = [
        [row["stakeholder"]] * several
        + [labelled({"name": row["quantity"], "unit": row["unit"]}), preference_words(row), outside(row)]
        + [readable(row["weight"]), *(readable(row["scores"][label]) for label in labels)]
        for row in rows
    ]
    return table(titles, cells, numbers=range(3 + several, len(titles)))


def _value(evaluation: Mapping[str, Any] | None, name: str) -> float | None:
    if evaluation is None:
        return None
    values: dict[str, float | None] = {**evaluation["objectives"], **evaluation["metrics"]}
    return values.get(name)
