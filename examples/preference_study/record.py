"""What the study found, as one plain document from which tables and figures are made."""

import numpy as np

from examples.studies import improvements, optimum, simulated
from railsearch.preferences import scores
from railsearch.result import stated_preferences, versions

# Shang, Binnekamp & Wolfert 2023: the compromise found on Kriging surrogates; about 82 on each score. For comparison only.
PUBLISHED = [11, 0, 89, 50, 50, 53]


def make_record(problem, extremes, routes, points):
    """The record of the extremes of every objective, of the searches by route and ranges, and of the surrogates' points.

    routes: {route: {ranges: searched}}; points: the evaluations to which the surrogates were fitted.
    """
    stated = {name: stated_preferences(searched.problem) for name, searched in routes["direct"].items()}
    published = np.array(PUBLISHED, dtype=float)
    alone = [extremes[quantity.name]["smallest"] for quantity in problem.objectives]
    designs = [
        {"label": "no measures", **simulated(problem, problem.reference)},
        *alone,
        {"label": "published compromise", **simulated(problem, published)},
    ]
    found = {
        route: {name: optimum(search) | {"history": improvements(search)} for name, search in by_ranges.items()}
        for route, by_ranges in routes.items()
    }
    return {
        "format": "railsearch preference study 1",
        "objectives": {quantity.name: quantity.unit for quantity in problem.objectives},
        "variables": {variable.name: variable.unit for variable in problem.space.variables},
        "extremes": extremes,
        "preferences": {name: _ranges(preferences) for name, preferences in stated.items()},
        "designs": [entry | {"scores": _scores(stated, entry)} for entry in designs],
        "found": {
            route: {name: entry | {"scores": _scores(stated, entry)} for name, entry in by_ranges.items()}
            for route, by_ranges in found.items()
        },
        "surrogates": [vars(finding) for finding in routes["fixed"]["own"].findings],
        "points": {"number": len(points)} | {name: _best_point(problem, stated[name], points) for name in stated},
        "versions": versions(),
    }


def worst_score(entry, name):
    """The worst score of a recorded design by the ranges called `name`."""
    return min(entry["scores"][name].values())


def _best_point(problem, preferences, points):
    """The one of the points with the highest worst score."""
    worst = [np.nan if e.failed else _row(preferences, e.metrics).min() for e in points]
    best = int(np.nanargmax(worst))
    return {
        "design": problem.space.named(points[best].design),
        "metrics": dict(points[best].metrics),
        "worst_score": float(worst[best]),
    }


def _ranges(preferences):
    return {p.quantity.name: {"best": p.function.best, "worst": p.function.worst} for p in preferences}


def _scores(stated, entry):
    """The scores of a recorded design by every set of ranges, by objective."""
    return {
        name: {
            p.quantity.name: float(score) for p, score in zip(preferences, _row(preferences, entry["metrics"]), strict=True)
        }
        for name, preferences in stated.items()
    }


def _row(preferences, metrics):
    return scores(preferences, {name: np.array([value]) for name, value in metrics.items()})[0]
