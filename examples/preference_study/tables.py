"""The tables of the study, in Markdown."""

from examples.preference_study.record import worst_score
from examples.studies import table

ROUTES = {"direct": "direct search", "fixed": "fixed surrogates"}


def study_tables(record):
    """All tables under their headings."""
    parts = [("What the preferences range over", _extremes(record))]
    for name in record["preferences"]:
        parts += [(f"Designs and scores, {name} ranges", _scored(record, name))]
    parts += [("The compromises", _designs(record)), ("The surrogates", _surrogates(record))]
    return "\n".join(f"## {heading}\n\n{text}" for heading, text in parts)


def compromises(record, name):
    """The designs that the routes found with the ranges called `name`, by the words for the route."""
    return {ROUTES[route]: found[name] for route, found in record["found"].items() if name in found}


def _extremes(record):
    header = ["objective", "smallest", "found at", "largest", "found at", "own range", "published range"]
    rows = []
    for objective, unit in record["objectives"].items():
        ends = record["extremes"][objective]
        cells = [cell for word in ("smallest", "largest") for cell in (ends[word]["value"], _when(ends[word]))]
        ranges = [record["preferences"][name][objective] for name in ("own", "published")]
        rows.append([f"{objective} [{unit}]", *cells, *(f"{r['best']:g} to {r['worst']:g}" for r in ranges)])
    return table(header, rows)


def _when(end):
    return f"{end['found_at']} of {end['budget']}" if end["budget"] else "closed form"


def _scored(record, name):
    """Values and scores of all designs by the ranges called `name`; the worst score of each in bold."""
    entries = {entry["label"]: entry for entry in record["designs"]} | compromises(record, name)
    header = ["design", *(f"{o} [{unit}]" for o, unit in record["objectives"].items())]
    header += [f"score of {objective}" for objective in record["objectives"]]
    rows = []
    for label, entry in entries.items():
        scores, worst = entry["scores"][name], worst_score(entry, name)
        shown = [f"**{score:.1f}**" if score == worst else f"{score:.1f}" for score in scores.values()]
        rows.append([label, *(entry["metrics"][objective] for objective in record["objectives"]), *shown])
    point = record["points"][name]
    values = [point["metrics"][objective] for objective in record["objectives"]]
    rows.append([f"best of {record['points']['number']} points", *values, f"worst **{point['worst_score']:.1f}**", "", ""])
    return table(header, rows)


def _designs(record):
    header = ["ranges", "route", *(f"{name} [{unit}]" if unit else name for name, unit in record["variables"].items())]
    rows = [
        [name, route, *entry["design"].values(), f"{entry['found_at']} of {entry['budget']}"]
        for name in record["preferences"]
        for route, entry in compromises(record, name).items()
    ]
    return table([*header, "found at"], rows)


def _surrogates(record):
    rows = [[f["name"], f"{f['value']:.3g} {f['unit']}".strip(), f["meaning"]] for f in record["surrogates"]]
    return table(["finding", "value", "meaning"], rows)
