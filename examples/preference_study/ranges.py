"""The ranges of the preferences: how small and how large every objective can be made, rounded outward."""

import itertools
import math
from dataclasses import replace

import numpy as np

from examples.studies import Search, carry_out, optimum, simulated
from railsearch.preferences import Linear
from railsearch.problem_factory import make_problem

SIMULATED = ("E_max", "A_max")


def find_extremes(registry, site, settings, folder):
    """The smallest and the largest value of every objective: by searches, and for the cost by its closed form."""
    found = {}
    for objective in SIMULATED:
        asked = replace(site, objectives=(objective,))
        found[objective] = {
            word: optimum(carry_out(registry, Search(f"{word} {objective}", asked, settings, word == "largest"), folder))
            for word in ("smallest", "largest")
        }
    return found | {"C_cap": _extremes_of_cost(make_problem(registry, site))}


def linear_preferences(extremes):
    """A linear preference for every objective, from its smallest value to its largest one, rounded outward."""
    return {
        objective: Linear(*outward(ends["smallest"]["value"], ends["largest"]["value"]))
        for objective, ends in extremes.items()
    }


def outward(low, high):
    """Both ends of a range rounded outward, to a tenth of the power of ten below its length."""
    power = math.floor(math.log10(high - low)) - 1
    step = 10.0**power
    # The quotients of round numbers may miss whole ones by rounding.
    ends = math.floor(low / step + 1e-9), math.ceil(high / step - 1e-9)
    return tuple(round(end * step, max(0, -power)) for end in ends)


def preference_file(preferences, units, origin):
    """A preference file for `railsearch run --preferences`."""
    lines = [f"# {origin}"]
    for objective, function in preferences.items():
        lines += [
            "",
            f"[preferences.{objective}]",
            f'function = "{function.function}"',
            f'unit = "{units[objective]}"',
            f"best = {function.best}",
            f"worst = {function.worst}",
        ]
    return "\n".join(lines) + "\n"


def _extremes_of_cost(problem):
    """The cheapest and the dearest design; only spacing and strengthened sleepers count, the rest is the reference's."""
    spaces = [range(int(problem.space.lower[row]), int(problem.space.upper[row]) + 1) for row in (0, 1)]
    designs = np.array([[*pair, *problem.reference[2:]] for pair in itertools.product(*spaces)], dtype=float)
    cost = problem.construction_cost(designs)
    return {
        word: {"label": f"{word} C_cap", "budget": 0, "value": float(cost[row]), **simulated(problem, designs[row])}
        for word, row in (("smallest", int(np.argmin(cost))), ("largest", int(np.argmax(cost))))
    }
