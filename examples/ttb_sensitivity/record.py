"""What the study found, as one plain document."""

SENSES = ("maximum", "minimum")


def make_record(documents, comparison):
    """The documents of both definitions without the points where extremes are attained, and the comparison."""
    return {
        "format": "railsearch ttb sensitivity study 1",
        "definitions": {
            name: {**document, "criteria": list(map(_short, document["criteria"]))} for name, document in documents.items()
        },
        "surrogates": comparison,
    }


def _short(criterion):
    extremes = criterion["extremes"]
    factors = [
        {key: value for key, value in factor.items() if key not in SENSES}
        | {sense: {"values": factor[sense]["values"]} for sense in SENSES}
        for factor in extremes["factors"]
    ]
    kept = ("name", "unit", "samples", "surrogate", "importances", "sobol", "morris")
    return {key: criterion[key] for key in kept} | {
        "extremes": {**extremes, "factors": factors},
        "thresholds": criterion["thresholds"],
        "one_at_a_time": criterion["one_at_a_time"]["importances"],
    }
