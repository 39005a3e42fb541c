"""What the study found, as one plain document."""

from railsearch.sensitivity.extremes import SENSES

DIGITS = 7


def make_record(documents, comparison):
    """Of every study what its tables need and the curves of the inputs; the comparison of the surrogates."""
    first = next(iter(documents.values()))
    return {
        "format": "railsearch ttb sensitivity study 1",
        "inputs": first["inputs"],
        "versions": first["versions"],
        "seed": first["seed"],
        "samples": first["samples"]["number"],
        "studies": {label: _short(document) for label, document in documents.items()},
        "surrogates": comparison,
    }


def _short(document):
    (criterion,) = document["criteria"]
    kept = ("name", "unit", "samples", "importances", "sobol", "morris", "warnings", "confirmed")
    return {key: criterion[key] for key in kept} | {
        "surrogate": document["surrogate"] | criterion["surrogate"],
        "extremes": criterion["extremes"]["extremes"],
        "check": criterion["extremes"]["effort"]["check"],
        "factors": [_factor(factor) for factor in criterion["extremes"]["factors"]],
        "thresholds": [_threshold(threshold) for threshold in criterion["thresholds"]["thresholds"]],
        "one_at_a_time": criterion["one_at_a_time"]["importances"],
    }


def _factor(factor):
    """Bounds, and both curves as text, so that a line holds one."""
    kept = ("name", "unit", "lower", "upper", "spacing")
    curves = {sense: factor[sense]["values"] for sense in SENSES}
    return {key: factor[key] for key in kept} | {
        name: " ".join(f"{value:.{DIGITS}g}" for value in values)
        for name, values in {"grid": factor["grid"], **curves}.items()
    }


def _threshold(threshold):
    factors = [
        {key: factor[key] for key in ("name", "critical", "safe")} for factor in threshold["factors"] if factor["critical"]
    ]
    return {"value": threshold["value"], "status": threshold["status"], "factors": factors}
