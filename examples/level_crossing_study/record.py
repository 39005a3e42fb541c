"""What the study found, as one plain document from which tables and figures are made."""

import numpy as np

from examples.studies import improvements, optimum, simulated
from railsearch.problem_factory import ProblemSettings, make_problem
from railsearch.result import scalariser_values, versions

# Shang et al. 2023: the two-objective optimum found with 400 evaluations, and its improvements. For comparison only.
PUBLISHED = {
    "design": [214, 155, 50, 5, 6, 7, 3, 0],
    "reference": {"F_rms": 49667.0, "F_max": 10636.0, "E_rms": 1.6299, "E_max": 0.3676},
    "optimum": {"F_max": 5662.6, "E_max": 0.1919},
}


def make_record(registry, done):
    """The record of searches that are done: one per measure, `asf`, and `random` as the last."""
    *searched, sampled = done
    asked = searched[0].search.asked
    problem = make_problem(registry, ProblemSettings(asked.name, ("F_rms", "F_max", "E_rms", "E_max"), asked.sections))
    published = np.array(PUBLISHED["design"], dtype=float)
    return {
        "format": "railsearch level-crossing study 1",
        "seed": searched[0].search.settings.seed,
        "sections": dict(asked.sections),
        "achievement": scalariser_values(searched[-1].problem),
        "static_load": problem.track.vehicle.static_load,
        "measures": {quantity.name: quantity.unit for quantity in problem.objectives},
        "variables": {variable.name: variable.unit for variable in problem.space.variables},
        "reference": simulated(problem, problem.reference),
        "published": PUBLISHED | {"here": simulated(problem, published)},
        "optima": [optimum(search) | {"history": improvements(search)} for search in searched],
        "random": _sample(sampled, problem),
        "versions": versions(),
    }


def _sample(sampled, problem):
    """The measures of all random designs; the first evaluation is the reference design and is left out."""
    designs = [evaluation for evaluation in sampled.evaluations if evaluation.origin != "given"]
    values = {
        quantity.name: [evaluation.metrics[quantity.name] for evaluation in designs] for quantity in problem.objectives
    }
    return {"number": len(designs), "values": values}
