"""The tables of the study in Markdown."""

from examples.studies import table
from examples.ttb_sensitivity.comparison import PUBLISHED, STUDIES

SHOWN = 6


def study_tables(record):
    """Errors of the surrogates beside the published ones, importances, and safe ranges."""
    parts = ["## Surrogates\n", _errors(record["surrogates"]), "## Extremes\n", _extremes(record["studies"])]
    for label, study in record["studies"].items():
        parts += [f"## {label}\n", _importances(study), _thresholds(study)]
    return "\n".join(parts)


def _errors(surrogates):
    header = ["criterion", "surrogate", "ε_loo", "ε_gen", "published ε_loo", "published ε_gen"]
    header += ["terms", "fit [s]", "value [s]"]
    rows = []
    for key, quality in surrogates.items():
        label, surrogate = key.split()
        errors = [quality["leave_one_out"], quality["generalisation"], *PUBLISHED[STUDIES[label].criterion][surrogate]]
        terms = "" if quality["terms"] is None else quality["terms"]
        times = [f"{quality['fit_seconds']:.1f}", f"{quality['value_seconds']:.1e}"]
        rows.append([label, surrogate, *(f"{error:.2e}" for error in errors), terms, *times])
    return table(header, rows)


def _extremes(studies):
    header = ["criterion", "surrogate", "samples", "extremes", "the model there", "ε_gen"]
    rows = []
    for label, study in studies.items():
        samples, extremes = study["samples"], study["extremes"]
        there = [study["confirmed"][sense]["model"] for sense in ("minimum", "maximum")]
        spans = [(samples["minimum"], samples["maximum"]), (extremes["minimum"], extremes["maximum"]), there]
        words = [f"{_number(low)} to {_number(high)} {study['unit']}".strip() for low, high in spans]
        rows.append([label, study["surrogate"]["name"], *words, f"{study['surrogate']['generalisation']:.1e}"])
    return table(header, rows)


def _importances(study):
    importances, sobol = study["importances"], study["sobol"]
    total = dict(zip(sobol["inputs"], sobol["total"], strict=True))
    single = study["one_at_a_time"]
    first = sorted(importances, key=lambda name: -importances[name])[:SHOWN]
    header = ["input", "worst case", "Sobol' total", "one at a time"]
    return table(
        header, [[name, *(f"{100 * share[name]:.1f} %" for share in (importances, total, single))] for name in first]
    )


def _thresholds(study):
    units = {factor["name"]: factor["unit"] for factor in study["factors"]}
    rows = []
    for threshold in study["thresholds"]:
        safe = [
            f"{factor['name']} {_spans(factor['safe'])} {units[factor['name']]}".strip()
            for factor in threshold["factors"]
            if factor["safe"]
        ]
        rows.append([f"{_number(threshold['value'])} {study['unit']}".strip(), threshold["status"], "; ".join(safe)])
    return table(["threshold", "within the ranges", "out of reach with"], rows)


def _spans(intervals):
    return " or ".join(f"{low:.4g} to {high:.4g}" for low, high in intervals)


def _number(value):
    return "failed" if value is None else f"{value:.4g}"
