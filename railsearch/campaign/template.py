"""A commented campaign file to begin with."""

import json
from collections.abc import Iterable, Sequence

from railsearch.campaign.capability import refusals
from railsearch.campaign.cells import Campaign, CampaignProblem, CampaignStrategy
from railsearch.design_problem import DesignProblem
from railsearch.errors import InputError
from railsearch.plugin_manager import Registry
from railsearch.problem_factory import ProblemSettings, make_problem

BUDGET, REPETITIONS, SEED = 200, 15, 1


def campaign_template(registry: Registry, name: str) -> str:
    """A campaign file for a problem's first objective and all strategies that can search it, everything else commented.

    Where objectives cannot be chosen, for all of them.
    Raises PluginError for an unknown problem.
    """
    settings, problem = _searched(registry, name)
    return "\n".join((*_campaign_lines(_capable(registry, settings, problem)), *_entry_lines(problem))) + "\n"


def _searched(registry: Registry, name: str) -> tuple[ProblemSettings, DesignProblem]:
    whole = ProblemSettings(name)
    problem = make_problem(registry, whole)
    first = ProblemSettings(name, (problem.objectives[0].name,))
    try:
        return first, make_problem(registry, first)
    except InputError:
        return whole, problem


def _capable(registry: Registry, settings: ProblemSettings, problem: DesignProblem) -> list[str]:
    names = [entry.name for entry in registry.entries("strategy")]
    strategies = tuple(CampaignStrategy(name, name) for name in names)
    entry = CampaignProblem("template", settings)
    campaign = Campaign("template", BUDGET, REPETITIONS, SEED, (entry,), strategies)
    refused = {refusal.strategy for refusal in refusals(registry, campaign, {entry.label: problem})}
    return [name for name in names if name not in refused]


def _campaign_lines(strategies: Sequence[str]) -> Iterable[str]:
    return (
        "# A campaign: every strategy searches every problem, again and again, on the same budget of evaluations.",
        "[campaign]",
        '# name = "my-campaign"          # of the studies in the storage; default: the name of this file',
        f"budget = {BUDGET}                    # evaluations of each run, those of the reference and given designs included",
        f"repetitions = {REPETITIONS}                # runs of each strategy on each problem; more may be added later",
        f"seed = {SEED}                        # of all randomness",
        "# batch = 1                     # designs that a strategy proposes at a time",
        "# timeout = 60.0                # seconds after which an evaluation has failed",
        f"strategies = {json.dumps(list(strategies))}",
    )


def _entry_lines(problem: DesignProblem) -> Iterable[str]:
    quantities = problem.available_objectives or problem.objectives
    known = ", ".join(f"{quantity.name} [{quantity.unit}]" if quantity.unit else quantity.name for quantity in quantities)
    first = problem.space.variables[0]
    return (
        "",
        "[[problem]]                     # and further ones like it",
        f"name = {json.dumps(problem.name)}",
        '# label = "my-label"            # default: the name',
        f"# the objectives are {known}",
        f"objectives = {json.dumps([objective.name for objective in problem.objectives])}",
        '# scalarise = "asf"             # of two objectives or more',
        "# scalariser_settings = {}      # `railsearch describe asf` tells them",
        '# preferences = "my-preferences.toml"   # a preference file beside this one, for preference-minmax and imap',
        '# parameters = "my-site.toml"   # a site file beside this one; `railsearch init` writes one',
        "# sections = {}                 # single values of a site file, in place of those there",
        "# worst = {}                    # worst values by objective, for scalarisers",
        "# designs to evaluate first, after the reference design, whose values hold where none is given",
        f"# given = [{{ {json.dumps(first.name)} = {first.lower!r} }}]",
        "# reference_point = {}          # of hypervolume by objective; default: the worst values",
        "",
        "# [[strategy]]                  # a strategy with settings; `railsearch describe` tells them",
        '# name = "dycors"',
        '# label = "dycors-wide"         # default: the name',
        "# settings = { sigma_start = 0.4 }",
    )
