"""The tables of the study, in Markdown."""

import numpy as np

from examples.studies import percent, table


def study_tables(record):
    """All tables under their headings."""
    parts = (
        ("The optima", _designs(record)),
        ("Their values", _values(record)),
        ("Every optimum by every measure", _cross(record)),
        ("How far the measures move", _spread(record)),
        ("Beside the publication", _published(record)),
    )
    return "\n".join(f"## {heading}\n\n{text}" for heading, text in parts)


def _designs(record):
    header = [
        "optimum of",
        *(f"{name} [{unit}]" if unit else name for name, unit in record["variables"].items()),
        "found at",
    ]
    rows = [["reference", *record["reference"]["design"].values(), "–"]]
    rows += [[o["label"], *o["design"].values(), f"{o['found_at']} of {o['budget']}"] for o in record["optima"]]
    return table(header, rows)


def _values(record):
    names = record["measures"]
    rows = [["reference", *_metrics(record, record["reference"])]]
    rows += [[o["label"], *_metrics(record, o)] for o in record["optima"]]
    return table(["optimum of", *(f"{name} [{unit}]" for name, unit in names.items())], rows)


def _cross(record):
    start = record["reference"]["metrics"]
    rows = [
        [o["label"], *(percent(o["metrics"][name], start[name]) for name in record["measures"])]
        for o in [*record["optima"], {"label": "published, computed here", **record["published"]["here"]}]
    ]
    return table(["optimum of", *record["measures"]], rows)


def _spread(record):
    """The coefficient of variation over random designs, and the best that was found."""
    start = record["reference"]["metrics"]
    optima = {o["label"]: o["metrics"] for o in record["optima"]}
    rows = []
    for name in record["measures"]:
        values = np.array(record["random"]["values"][name])
        variation = 100.0 * values.std(ddof=1) / values.mean()
        low, high = (percent(float(value), start[name]) for value in (values.min(), values.max()))
        rows.append([name, f"{variation:.3g} %", f"{low} to {high}", percent(optima[name][name], start[name])])
    return table(["measure", "coefficient of variation", "range against the reference", "its own optimum"], rows)


def _published(record):
    published, here = record["published"], record["published"]["here"]["metrics"]
    start = record["reference"]["metrics"]
    both = next(o for o in record["optima"] if o["label"] == "asf")["metrics"]
    rows = []
    for name, unit in record["measures"].items():
        told, found = published["reference"][name], published["optimum"].get(name)
        rows.append(
            [
                f"{name} [{unit}]",
                told,
                start[name],
                "–" if found is None else percent(found, told),
                percent(here[name], start[name]),
                percent(both[name], start[name]),
            ]
        )
    header = ["measure", "reference, published", "reference, here", "published optimum, published"]
    return table([*header, "published optimum, here", "our optimum of both"], rows)


def _metrics(record, entry):
    return [entry["metrics"][name] for name in record["measures"]]
