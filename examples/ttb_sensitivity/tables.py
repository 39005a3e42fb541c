"""The tables of the study in Markdown."""

from examples.studies import table
from examples.ttb_sensitivity.comparison import CRITERIA, PUBLISHED, SURROGATES

SHOWN = 6


def study_tables(record):
    """Errors of the surrogates beside the published ones, importances, and safe ranges."""
    parts = ["## Surrogates\n", _errors(record["surrogates"])]
    for name, document in record["definitions"].items():
        for criterion in document["criteria"]:
            title = f"## {criterion['name']}, {name}\n"
            parts += [title, _importances(criterion), _thresholds(criterion)]
    return "\n".join(parts)


def _errors(surrogates):
    header = [
        "criterion",
        "surrogate",
        "ε_loo",
        "ε_gen",
        "published ε_loo",
        "published ε_gen",
        "terms",
        "fit [s]",
        "value [s]",
    ]
    rows = []
    for name in CRITERIA["pass-by"]:
        for surrogate in SURROGATES:
            quality = surrogates[f"{name} {surrogate}"]
            errors = [quality["leave_one_out"], quality["generalisation"], *PUBLISHED[name][surrogate]]
            shown = ["" if error is None else f"{error:.2e}" for error in errors]
            terms = "" if quality["terms"] is None else quality["terms"]
            rows.append([name, surrogate, *shown, terms, f"{quality['fit_seconds']:.1f}", f"{quality['value_seconds']:.1e}"])
    return table(header, rows)


def _importances(criterion):
    importances, sobol = criterion["importances"], criterion["sobol"]
    total = dict(zip(sobol["inputs"], sobol["total"], strict=True))
    single = criterion["one_at_a_time"]
    first = sorted(importances, key=lambda name: -importances[name])[:SHOWN]
    header = ["input", "worst case", "Sobol' total", "one at a time"]
    return table(
        header, [[name, *(f"{100 * share[name]:.1f} %" for share in (importances, total, single))] for name in first]
    )


def _thresholds(criterion):
    units = {factor["name"]: factor["unit"] for factor in criterion["extremes"]["factors"]}
    rows = []
    for threshold in criterion["thresholds"]["thresholds"]:
        safe = [
            f"{factor['name']} {_spans(factor['safe'])} {units[factor['name']]}".strip()
            for factor in threshold["factors"]
            if factor["critical"] and factor["safe"]
        ]
        rows.append([f"{threshold['value']:.4g} {criterion['unit']}".strip(), threshold["status"], "; ".join(safe)])
    return table(["threshold", "within the ranges", "out of reach with"], rows)


def _spans(intervals):
    return " or ".join(f"{low:.4g} to {high:.4g}" for low, high in intervals)
