"""What the study found, as one plain document, and its tables."""

import dataclasses
import importlib.metadata

from examples.studies import improvements, optimum, percent, simulated, table
from railsearch.result import scalariser_values, versions

SHOWN = ("F_max", "E_max", "E_rms", "A_max")


def make_record(done, assembled):
    """The record of the search and of the track that was searched."""
    base = done.problem.simulated
    best = optimum(done)
    return {
        "format": "railsearch imported-track study 1",
        "seed": done.search.settings.seed,
        "section": dataclasses.asdict(assembled.section),
        "unknowns": assembled.export.matrices["mass"].shape[0],
        "achievement": scalariser_values(done.problem),
        "measures": {quantity.name: quantity.unit for quantity in base.metrics},
        "variables": {variable.name: variable.unit for variable in base.space.variables},
        "reference": simulated(base, base.reference),
        "best": best | {"history": improvements(done)},
        "evaluations": [dict(evaluation.metrics) for evaluation in done.evaluations],
        "seconds_per_evaluation": sum(e.duration for e in done.evaluations) / len(done.evaluations),
        "versions": versions() | {"scikit-fem": importlib.metadata.version("scikit-fem")},
    }


def study_tables(record):
    """The designs and their measures in Markdown."""
    rows = {"reference": record["reference"], "best": record["best"]}
    names, measures = list(record["variables"]), record["measures"]
    designs = table(
        ["design", *(f"{name} [{record['variables'][name]}]" for name in names)],
        [[label, *(float(row["design"][name]) for name in names)] for label, row in rows.items()],
    )
    start = record["reference"]["metrics"]
    values = [[label, *(row["metrics"][name] for name in SHOWN)] for label, row in rows.items()]
    values.append(["change", *(percent(record["best"]["metrics"][name], start[name]) for name in SHOWN)])
    return designs + "\n" + table(["design", *(f"{name} [{measures[name]}]" for name in SHOWN)], values)
