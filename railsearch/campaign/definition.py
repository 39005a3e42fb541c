"""A campaign file (TOML): read, checked in every respect, all of its faults told at once.

    [campaign]
    budget = 200                          # evaluations of each run
    repetitions = 15                      # runs of each strategy on each problem
    seed = 1                              # of all randomness
    name = "crossing"                     # default: the file's name
    batch = 1                             # designs proposed at a time
    timeout = 60.0                        # seconds of one evaluation; default: no limit
    problems = ["sphere"]                 # problems as they are
    strategies = ["lmsrs", "random"]      # strategies as they are

    [[problem]]                           # a problem with more to say
    name = "level-crossing"
    label = "asf"                         # default: its name
    parameters = "my-site.toml"           # a site file, beside this file
    sections = { track = { passage = { speed = 40.0 } } }       # single values in place of those of the site file, as are
    worst = { F_max = 7000.0 }                                  # the worst values
    given = [{ xr1 = 100.0 }]             # designs after the reference design and those of the site file
    scalarise = "asf"                     # default: not scalarised
    scalariser_settings = { rho = 0.1 }

    [[problem]]
    name = "level-crossing"
    label = "stakeholders"
    scalarise = "preference-minmax"
    preferences = "preferences.toml"      # a preference file, beside this file

    [[problem]]
    name = "level-crossing"
    label = "front"
    objectives = ["F_max", "E_max"]       # default: the problem's own choice
    reference_point = { F_max = 6000.0, E_max = 1.5 }           # of hypervolume; default: the worst values

    [[strategy]]                          # a strategy with settings
    name = "dycors"
    label = "dycors-wide"                 # default: its name
    settings = { sigma_start = 0.4 }

The settings of strategies come from this file alone: one that a site file changes is refused. The seed has no default, so
that the file alone determines the campaign. The same strategy or problem may stand under two labels: its runs are then
independent of one another, which is how two equal strategies are seen to come out equal.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar, cast

from railsearch.campaign.cells import Campaign, CampaignProblem, CampaignStrategy
from railsearch.campaign.faults import Faults
from railsearch.campaign.problems import ProblemTable, read_problem
from railsearch.parameters import amend_parameters, parameter
from railsearch.plugin_manager import Registry
from railsearch.run_identity import all_settings
from railsearch.site import read_toml

_EXAMPLES = {"budget": 200, "repetitions": 15, "seed": 1}
# Three labels and a number make a study's name, which Optuna's tables hold up to 512 characters.
LONGEST_LABEL = 100
# More repetitions are a slip of the finger: the names of the cells alone would fill the memory.
MOST_REPETITIONS = 100_000

T = TypeVar("T")


@dataclass(frozen=True)
class _Document:
    """The tables of a campaign file."""

    campaign: dict[str, Any] | None = None
    problem: tuple[dict[str, Any], ...] = ()
    strategy: tuple[dict[str, Any], ...] = ()


@dataclass(frozen=True)
class _CampaignTable:
    """The table [campaign]."""

    name: str | None = None
    budget: int | None = parameter(None, meaning="evaluations of each run", minimum=1)
    repetitions: int | None = parameter(
        None, meaning="runs of each strategy on each problem", minimum=1, maximum=MOST_REPETITIONS
    )
    seed: int | None = parameter(None, meaning="seed of all randomness", minimum=0)
    batch: int = parameter(1, meaning="designs proposed at a time", minimum=1)
    timeout: float | None = parameter(None, meaning="time limit of one evaluation", unit="s", above=0.0)
    problems: tuple[str, ...] = ()
    strategies: tuple[str, ...] = ()


@dataclass(frozen=True)
class _StrategyTable:
    """A table [[strategy]]."""

    name: str = ""
    label: str | None = None
    settings: dict[str, Any] | None = None


def load_campaign(registry: Registry, path: Path) -> Campaign:
    """The campaign of a file. Raises InputError that lists everything that is wrong with the file and its site files."""
    faults = Faults()
    document = _table(_Document, read_toml(path), "campaign file", faults)
    general = _table(_CampaignTable, document.campaign or {}, "[campaign]", faults)
    strategies = _strategies(registry, general, document, faults)
    searched_by = [strategy.name for strategy in strategies]
    problems = _problems(registry, general, document, path.parent, searched_by, faults)
    name = path.stem if general.name is None else general.name
    _check_labels("campaign", [name], faults)
    _check_required(document.campaign or {}, faults)
    faults.raise_all(str(path))
    return Campaign(
        name,
        cast(int, general.budget),
        cast(int, general.repetitions),
        cast(int, general.seed),
        tuple(problems),
        tuple(strategies),
        general.batch,
        general.timeout,
    )


def _table(cls: type[T], values: Mapping[str, object], where: str, faults: Faults) -> T:
    """A table of the file; what is wrong in it is noted, its other values stand."""
    made = cls()
    for key, value in values.items():
        with faults.gathered():
            made = amend_parameters(made, {key: value}, where)
    return made


def _strategies(registry: Registry, general: _CampaignTable, document: _Document, faults: Faults) -> list[CampaignStrategy]:
    tables = [_StrategyTable(name) for name in general.strategies]
    tables += [_table(_StrategyTable, table, f"strategy {_title(table)}", faults) for table in document.strategy]
    labels = [table.name if table.label is None else table.label for table in tables]
    _check_labels("strategy", labels, faults)
    strategies = []
    for label, table in zip(labels, tables, strict=True):
        with faults.gathered():
            settings = all_settings(registry, "strategy", table.name, table.settings or {})
            strategies.append(CampaignStrategy(label, table.name, settings))
    return strategies


def _problems(
    registry: Registry,
    general: _CampaignTable,
    document: _Document,
    folder: Path,
    searched_by: Sequence[str],
    faults: Faults,
) -> list[CampaignProblem]:
    tables = [ProblemTable(name) for name in general.problems]
    tables += [_table(ProblemTable, table, f"problem {_title(table)}", faults) for table in document.problem]
    labels = [table.name if table.label is None else table.label for table in tables]
    _check_labels("problem", labels, faults)
    found = [
        read_problem(registry, table, label, folder, searched_by, faults)
        for label, table in zip(labels, tables, strict=True)
    ]
    return [problem for problem in found if problem is not None]


def _title(table: Mapping[str, object]) -> str:
    return f"{table.get('label', table.get('name', 'without a name'))}"


def _check_required(given: Mapping[str, object], faults: Faults) -> None:
    missing = [name for name in _EXAMPLES if name not in given]
    if missing:
        faults.add(f"[campaign]: {', '.join(missing)} must be given, for instance {missing[0]} = {_EXAMPLES[missing[0]]}")


def _check_labels(kind: str, labels: Sequence[str], faults: Faults) -> None:
    """Labels make the names of studies: printable, not too long, without slashes, different in more than their case."""
    if not labels:
        faults.add(f"{kind}: one or more are needed; name them in [campaign] or in tables [[{kind}]]")
    seen: dict[str, str] = {}
    for label in labels:
        printable = label.isprintable() and label == label.strip()
        if not label or not printable or "/" in label or len(label) > LONGEST_LABEL:
            faults.add(
                f"{kind}: a name or label of 1 to {LONGEST_LABEL} printable characters is needed, without '/' and spaces "
                f"at its ends, received {label!r}"
            )
        elif label.casefold() in seen:
            other = seen[label.casefold()]
            same = "twice" if other == label else f"twice, differing in case alone ('{other}')"
            faults.add(f"{kind}: the label '{label}' is used {same}; give each a label of its own")
        seen.setdefault(label.casefold(), label)
