"""What identifies a campaign and its cells, in plain JSON types, and what may be changed in a campaign that has begun."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from railsearch.campaign.cells import Campaign, CampaignProblem, CampaignStrategy, Cell
from railsearch.design_problem import DesignProblem
from railsearch.errors import InputError
from railsearch.plugin_manager import Registry
from railsearch.problem_factory import given_designs
from railsearch.run import RunSettings
from railsearch.run_identity import all_settings, problem_identity, problem_settings_of, run_identity
from railsearch.seeding import cell_seeds
from railsearch.storage import identity_differences, plain

# What every cell depends on.
FIXED = ("campaign", "budget", "seed", "batch")


@dataclass(frozen=True)
class Changes:
    """How a campaign differs from its record, in sentences; one incompatible change forbids to continue the record."""

    compatible: tuple[str, ...] = ()
    incompatible: tuple[str, ...] = ()

    def check(self, place: str) -> None:
        """Raise InputError if the record at `place` cannot be continued by this campaign, with all reasons and remedies."""
        if self.incompatible:
            rows = "\n- ".join(("", *self.incompatible))
            raise InputError(
                f"{place} holds another campaign than the file describes:{rows}\nNothing was changed. More repetitions, "
                "added or removed problems and strategies, and another timeout or reference point may be continued there"
            )


def campaign_identity(registry: Registry, campaign: Campaign, problems: Mapping[str, DesignProblem]) -> dict[str, Any]:
    """A campaign in plain types with every default spelt out; `problems` are its problems as objects by label."""
    return plain(
        {
            "campaign": campaign.name,
            "budget": campaign.budget,
            "repetitions": campaign.repetitions,
            "seed": campaign.seed,
            "batch": campaign.batch_size,
            "timeout": campaign.timeout,
            "problems": {entry.label: _problem(registry, entry, problems[entry.label]) for entry in campaign.problems},
            "strategies": {
                entry.label: {
                    "name": entry.name,
                    "settings": all_settings(registry, "strategy", entry.name, entry.settings),
                }
                for entry in campaign.strategies
            },
        }
    )


def campaign_of(identity: Mapping[str, Any]) -> Campaign:
    """The campaign with that identity."""
    problems = (
        CampaignProblem(label, problem_settings_of(entry), tuple(entry["given"]), entry["reference_point"])
        for label, entry in identity["problems"].items()
    )
    strategies = (
        CampaignStrategy(label, entry["name"], entry["settings"]) for label, entry in identity["strategies"].items()
    )
    return Campaign(
        identity["campaign"],
        identity["budget"],
        identity["repetitions"],
        identity["seed"],
        tuple(problems),
        tuple(strategies),
        identity["batch"],
        identity["timeout"],
    )


def cell_settings(campaign: Campaign, cell: Cell) -> RunSettings:
    """How the run of a cell searches; its seeds depend on the campaign's seed and the cell alone."""
    strategy = next(entry for entry in campaign.strategies if entry.label == cell.strategy)
    seeds = cell_seeds(campaign.seed, cell.problem, cell.strategy, cell.repetition)
    return RunSettings(
        strategy.name,
        campaign.budget,
        seeds.seed,
        strategy.settings,
        campaign.batch_size,
        campaign.timeout,
        seeds.initial_seed,
    )


def cell_identity(registry: Registry, campaign: Campaign, cell: Cell, problem: DesignProblem) -> dict[str, Any]:
    """What identifies the run of a cell on `problem`: that of a run, and its place in the campaign."""
    entry = next(entry for entry in campaign.problems if entry.label == cell.problem)
    given = given_designs(problem, entry.given)
    place = {
        "campaign": campaign.name,
        "problem": cell.problem,
        "strategy": cell.strategy,
        "repetition": cell.repetition,
    }
    run = run_identity(registry, entry.settings, problem, cell_settings(campaign, cell), given)
    return plain({**run, "cell": place})


def campaign_changes(stored: Mapping[str, Any], wanted: Mapping[str, Any]) -> Changes:
    """What differs between the identity of a recorded campaign and that of the present file."""
    incompatible = [
        f"{name}: there {stored[name]!r}, here {wanted[name]!r}, on which every run depends; go back to "
        f"{stored[name]!r}, or use another folder (--out) and storage for this campaign"
        for name in FIXED
        if stored[name] != wanted[name]
    ]
    compatible = _changed_numbers(stored, wanted)
    for kind, title in (("problems", "problem"), ("strategies", "strategy")):
        old, new = stored[kind], wanted[kind]
        compatible += [f"{title} '{label}' is added" for label in new if label not in old]
        compatible += [
            f"{title} '{label}' is left out; its runs stay in the record and out of the report"
            for label in old
            if label not in new
        ]
        for label in (label for label in new if label in old):
            _compare(f"{title} '{label}'", old[label], new[label], compatible, incompatible)
    return Changes(tuple(compatible), tuple(incompatible))


def _problem(registry: Registry, entry: CampaignProblem, problem: DesignProblem) -> dict[str, Any]:
    identity = problem_identity(registry, entry.settings, problem, given_designs(problem, entry.given))
    return {**identity, "reference_point": dict(entry.reference_point)}


def _changed_numbers(stored: Mapping[str, Any], wanted: Mapping[str, Any]) -> list[str]:
    changes = []
    old, new = stored["repetitions"], wanted["repetitions"]
    if old != new:
        note = "; the others stay in the record and out of the report" if new < old else ""
        changes.append(f"repetitions: {new} instead of {old}{note}")
    old, new = ("none" if entry["timeout"] is None else f"{entry['timeout']:g} s" for entry in (stored, wanted))
    if old != new:
        changes.append(f"timeout: {new} instead of {old}, for the evaluations to come")
    return changes


def _compare(
    title: str, old: Mapping[str, Any], new: Mapping[str, Any], compatible: list[str], incompatible: list[str]
) -> None:
    """Sort the differences of one label: the reference point only measures what was found."""
    for difference in identity_differences(old, new):
        if difference.startswith("reference_point."):
            compatible.append(f"{title}: {difference}; hypervolume is measured anew from there")
        else:
            incompatible.append(f"{title}: {difference}; give what is new a label of its own beside the old one")
