"""What identifies a campaign and its cells, and what may change while it is recorded."""

import copy
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from railsearch.campaign.cells import Campaign, Cell
from railsearch.campaign.definition import load_campaign
from railsearch.campaign.identity import campaign_changes, campaign_identity, campaign_of, cell_identity, cell_settings
from railsearch.campaign.problems import make_problems
from railsearch.errors import InputError
from railsearch.plugin_manager import Registry, load_plugins
from railsearch.problem_factory import given_designs
from railsearch.run_identity import given_of, problem_of, settings_of
from railsearch.seeding import run_generators

TEXT = """
[campaign]
name = "trial"
budget = 50
repetitions = 3
seed = 1
problems = ["sphere"]
strategies = ["random", "dycors"]

[[problem]]
name = "level-crossing"
label = "front"
given = [{ xr1 = 90.0 }]
reference_point = { F_max = 5000.0, E_max = 1.0 }
sections = { track = { passage = { speed = 35.0 } } }

[[problem]]
name = "level-crossing"
label = "asf"
scalarise = "asf"
scalariser_settings = { rho = 0.1 }
worst = { F_max = 7000.0 }

[[strategy]]
name = "nsga2"
settings = { population_size = 12 }
"""
MORE = '[[strategy]]\nname = "dycors"\nlabel = "wide"\nsettings = { sigma_start = 0.4 }\n'

Load = Callable[[str], Campaign]


@pytest.fixture(scope="module")
def registry() -> Registry:
    return load_plugins()


@pytest.fixture
def load(registry: Registry, tmp_path: Path) -> Load:
    def loaded(text: str) -> Campaign:
        path = tmp_path / "trial.toml"
        path.write_text(text)
        return load_campaign(registry, path)

    return loaded


def identity_of(registry: Registry, campaign: Campaign) -> dict[str, Any]:
    return campaign_identity(registry, campaign, make_problems(registry, campaign))


def cells_of(registry: Registry, campaign: Campaign) -> dict[Cell, dict[str, Any]]:
    problems = make_problems(registry, campaign)
    return {cell: cell_identity(registry, campaign, cell, problems[cell.problem]) for cell in campaign.cells()}


def test_a_campaign_is_made_again_from_its_identity(registry: Registry, load: Load) -> None:
    campaign = load(TEXT.replace("seed = 1", "seed = 1\nbatch = 2\ntimeout = 9.0"))
    identity = identity_of(registry, campaign)
    again = campaign_of(json.loads(json.dumps(identity, allow_nan=False)))
    assert identity_of(registry, again) == identity
    assert (again.batch_size, again.timeout) == (2, 9.0)
    assert list(again.cells()) == list(campaign.cells())
    assert cells_of(registry, again) == cells_of(registry, campaign)


def test_an_identity_has_every_default_in_it(registry: Registry, load: Load) -> None:
    identity = identity_of(registry, load(TEXT))
    assert identity["strategies"]["nsga2"]["settings"]["population_size"] == 12
    assert identity["strategies"]["dycors"]["settings"]["sigma_start"] == 0.2
    front = identity["problems"]["front"]
    assert front["objectives"] == ["F_max", "E_max"]
    assert front["sections"]["track"]["passage"]["speed"] == 35.0
    assert front["sections"]["track"]["rail"]["young_modulus"] == 210e9
    assert [design["xr1"] for design in front["given"]] == [1120.0, 90.0], "the reference design comes first"
    assert identity["problems"]["asf"]["scalariser"]["settings"]["aspiration_fraction"] == 0.8


def test_a_cell_is_carried_out_from_its_identity_alone(registry: Registry, load: Load) -> None:
    campaign = load(TEXT.replace("seed = 1", "seed = 1\nbatch = 1\ntimeout = 9.0"))
    problems = make_problems(registry, campaign)
    cell = Cell("front", "nsga2", 2)
    identity = cell_identity(registry, campaign, cell, problems["front"])
    assert settings_of(identity, timeout=9.0).initial_seed == cell_settings(campaign, cell).initial_seed
    assert settings_of(identity).strategy_settings["population_size"] == 12
    problem = problem_of(registry, identity, "identity")
    assert problem.label == problems["front"].label
    expected = given_designs(problems["front"], campaign.problems[1].given)
    assert [design.tolist() for design in given_of(problem, identity)] == [design.tolist() for design in expected]
    place = {"campaign": "trial", "problem": "front", "strategy": "nsga2", "repetition": 2}
    assert identity["cell"] == place
    assert "timeout" not in identity, "the limit may be changed when a run is continued"


def test_no_cell_depends_on_what_else_is_in_the_campaign(registry: Registry, load: Load) -> None:
    cells = cells_of(registry, load(TEXT))
    longer = TEXT.replace("repetitions = 3", "repetitions = 5").replace('["sphere"]', '["rosenbrock", "sphere"]') + MORE
    extended = cells_of(registry, load(longer))
    assert set(cells) < set(extended)
    assert all(extended[cell] == identity for cell, identity in cells.items())


def test_strategies_share_the_initial_design_of_a_repetition_and_nothing_else(load: Load) -> None:
    campaign = load(TEXT)
    settings = {cell: cell_settings(campaign, cell) for cell in campaign.cells()}
    assert len({entry.seed for entry in settings.values()}) == len(settings)
    initial: dict[tuple[str, int], set[float]] = {}
    for cell, entry in settings.items():
        draw = run_generators(entry.seed, entry.initial_seed).initial.random()
        initial.setdefault((cell.problem, cell.repetition), set()).add(draw)
    assert all(len(draws) == 1 for draws in initial.values())
    assert len(set.union(*initial.values())) == len(initial), "another one for every problem and repetition"


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("repetitions = 3", "repetitions = 4", "repetitions: 4 instead of 3"),
        ("repetitions = 3", "repetitions = 2", "repetitions: 2 instead of 3; the others stay in the record"),
        ("budget = 50", "budget = 50\ntimeout = 60", "timeout: 60 s instead of none"),
        ('["sphere"]', '["sphere", "ackley"]', "problem 'ackley' is added"),
        ('["sphere"]', "[]", "problem 'sphere' is left out; its runs stay in the record"),
        ('["random", "dycors"]', '["random"]', "strategy 'dycors' is left out"),
        ('"dycors"]', '"dycors", "lmsrs"]', "strategy 'lmsrs' is added"),
        ("F_max = 5000.0", "F_max = 4000.0", "problem 'front': reference_point.F_max: there 5000.0, here 4000.0"),
    ],
)
def test_what_leaves_recorded_runs_as_they_are_is_compatible(
    registry: Registry, load: Load, old: str, new: str, said: str
) -> None:
    stored = identity_of(registry, load(TEXT))
    changes = campaign_changes(stored, identity_of(registry, load(TEXT.replace(old, new))))
    assert changes.incompatible == ()
    assert len(changes.compatible) == 1
    assert said in changes.compatible[0]
    changes.check("folder")


@pytest.mark.parametrize(
    ("old", "new", "said", "remedy"),
    [
        ("budget = 50", "budget = 60", "budget: there 50, here 60", "another folder"),
        ("seed = 1", "seed = 2", "seed: there 1, here 2", "another folder"),
        ("seed = 1", "seed = 1\nbatch = 4", "batch: there 1, here 4", "another folder"),
        ('"trial"', '"other"', "campaign: there 'trial', here 'other'", "another folder"),
        ("= 12", "= 14", "strategy 'nsga2': settings.population_size: there 12, here 14", "label of its own"),
        ("= 35.0", "= 36.0", "problem 'front': sections.track.passage.speed: there 35.0, here 36.0", "label of its own"),
        ("= 90.0", "= 91.0", "problem 'front': given", "label of its own"),
        ("= 7000.0", "= 8000.0", "problem 'asf': worst.F_max: there 7000.0, here 8000.0", "label of its own"),
        ("rho = 0.1", "rho = 0.2", "problem 'asf': scalariser.settings.rho: there 0.1, here 0.2", "label of its own"),
        ('name = "nsga2"', 'name = "ga"\nlabel = "nsga2"', "strategy 'nsga2': name: there", "label of its own"),
    ],
)
def test_what_would_make_recorded_runs_others_is_not(
    registry: Registry, load: Load, old: str, new: str, said: str, remedy: str
) -> None:
    stored = identity_of(registry, load(TEXT))
    changes = campaign_changes(stored, identity_of(registry, load(TEXT.replace(old, new))))
    assert changes.compatible == ()
    assert len(changes.incompatible) == 1
    assert said in changes.incompatible[0]
    assert remedy in changes.incompatible[0]
    with pytest.raises(InputError, match=r"(?s)folder holds another campaign.*Nothing was changed"):
        changes.check("folder")


def test_an_unchanged_campaign_has_no_changes_whatever_the_order_of_its_parts(registry: Registry, load: Load) -> None:
    stored = identity_of(registry, load(TEXT))
    reordered = copy.deepcopy(stored)
    reordered["problems"] = dict(reversed(reordered["problems"].items()))
    for wanted in (stored, reordered):
        changes = campaign_changes(stored, wanted)
        assert changes.compatible == changes.incompatible == ()


def test_all_differences_are_told_together(registry: Registry, load: Load) -> None:
    stored = identity_of(registry, load(TEXT))
    wanted = identity_of(
        registry, load(TEXT.replace("budget = 50", "budget = 60").replace("= 12", "= 14").replace("ons = 3", "ons = 4"))
    )
    changes = campaign_changes(stored, wanted)
    assert (len(changes.compatible), len(changes.incompatible)) == (1, 2)
    with pytest.raises(InputError) as caught:
        changes.check("folder")
    assert all(word in str(caught.value) for word in ("budget", "population_size"))
