"""Campaign files: what they mean, and what is refused."""

import json
import re
import textwrap
import types
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from railsearch.campaign import definition
from railsearch.campaign.capability import Refusal, capable_cells, check_capable, refusals
from railsearch.campaign.cells import Campaign, CampaignStrategy, Cell
from railsearch.campaign.definition import load_campaign
from railsearch.campaign.problems import make_problems
from railsearch.campaign.template import campaign_template
from railsearch.design_problem import DesignProblem
from railsearch.errors import CapabilityError, InputError
from railsearch.hookspecs import hookimpl
from railsearch.interfaces import Capabilities, NoParameters, Outcome, Quantity
from railsearch.plugin_manager import Registry, load_plugins
from railsearch.problem_factory import given_designs
from railsearch.site import site_template
from railsearch.space import FloatArray, Space, Variable

HEAD = "[campaign]\nbudget = 50\nrepetitions = 3\nseed = 1\n"
BOTH = HEAD + 'problems = ["sphere"]\nstrategies = ["random"]\n'
EXAMPLES = Path(__file__).parents[2] / "examples"


class Plain(DesignProblem):
    """Two objectives, one of them maximised, a constraint, no reference design and no worst values."""

    def __init__(self) -> None:
        space = Space((Variable("x", 0.0, 1.0), Variable("n", 0, 3, integer=True)))
        super().__init__("plain", space, [Quantity("cost", "€"), Quantity("comfort", maximised=True)], n_constraints=1)

    def simulate(self, design: FloatArray) -> Outcome:
        return Outcome(np.array([design[0], design[1] - 3.0]), constraints=np.array([-1.0]))


class Narrow:
    """One objective, real variables, one design at a time; breaks when it is made for fewer than 10 evaluations."""

    Parameters = NoParameters
    capabilities = Capabilities()

    def __init__(self, context: Any, parameters: NoParameters) -> None:
        if context.budget < 10:
            raise ZeroDivisionError("no generations")

    ask = tell = None


@hookimpl
def _problems(register: Callable[[str, Any], None]) -> None:
    register("plain", Plain)


@hookimpl
def _strategies(register: Callable[[str, Any], None]) -> None:
    register("narrow", Narrow)


@pytest.fixture
def registry(install: Callable[..., None]) -> Registry:
    module = types.SimpleNamespace(railsearch_problems=_problems, railsearch_strategies=_strategies)
    install(acme=lambda: module)
    return load_plugins()


@pytest.fixture
def load(registry: Registry, tmp_path: Path) -> Callable[[str], Campaign]:
    def loaded(text: str) -> Campaign:
        path = tmp_path / "trial.toml"
        path.write_text(text, encoding="utf-8")
        return load_campaign(registry, path)

    return loaded


Load = Callable[[str], Campaign]


def refused(load: Load, text: str) -> str:
    with pytest.raises(InputError) as caught:
        load(text)
    return str(caught.value)


def test_the_format_in_the_documentation_is_read(load: Load, registry: Registry, tmp_path: Path) -> None:
    text = textwrap.dedent(re.search(r"\n\n(    \[campaign\].*?)\n\n[A-Z]", definition.__doc__ or "", re.DOTALL)[1])
    (tmp_path / "my-site.toml").write_text(site_template(registry, "level-crossing"), encoding="utf-8")
    linear = '[preferences.{}]\nfunction = "linear"\nbest = 0.0\nworst = 1.0\n'
    (tmp_path / "preferences.toml").write_text(linear.format("F_max") + linear.format("E_max"), encoding="utf-8")
    campaign = load(text)
    assert (campaign.name, campaign.budget, campaign.repetitions, campaign.seed) == ("crossing", 200, 15, 1)
    assert (campaign.batch_size, campaign.timeout) == (1, 60.0)
    assert [(entry.label, entry.name) for entry in campaign.strategies] == [
        ("lmsrs", "lmsrs"),
        ("random", "random"),
        ("dycors-wide", "dycors"),
    ]
    assert campaign.strategies[2].settings["sigma_start"] == 0.4
    assert campaign.strategies[2].settings["tree_search"] is True, "defaults are spelt out"
    assert [entry.label for entry in campaign.problems] == ["sphere", "asf", "stakeholders", "front"]
    assert campaign.problems[2].settings.scalariser_settings["preferences"]["F_max"]["worst"] == 1.0
    assert campaign.problems[3].settings.objectives == ("F_max", "E_max")
    assert campaign.problems[3].reference_point == {"F_max": 6000.0, "E_max": 1.5}
    settings = campaign.problems[1].settings
    assert (settings.name, settings.objectives, settings.scalariser) == ("level-crossing", (), "asf")
    assert settings.scalariser_settings["rho"] == 0.1
    assert settings.worst["F_max"] == 7000.0


def test_the_campaign_file_of_the_manual_is_read(load: Load, registry: Registry) -> None:
    manual = (EXAMPLES.parent / "docs" / "campaigns.md").read_text(encoding="utf-8")
    (text,) = re.findall(r"^```toml\n(.*?)^```", manual, re.DOTALL | re.MULTILINE)
    campaign = load(text)
    assert [entry.label for entry in campaign.problems] == ["sphere", "asf", "front"]
    assert campaign.problems[1].settings.sections == {"track": {"passage": {"speed": 40.0}}}
    assert refusals(registry, campaign, make_problems(registry, campaign)) == []


def test_what_is_left_out_has_the_stated_default(load: Load) -> None:
    campaign = load(BOTH)
    assert (campaign.name, campaign.batch_size, campaign.timeout) == ("trial", 1, None)
    assert len(list(campaign.cells())) == 3
    assert campaign.problems[0].given == ()
    assert campaign.strategies == (CampaignStrategy("random", "random", {}),)


@pytest.mark.parametrize("name", ["level-crossing", "sphere", "two-spheres"])
def test_the_template_is_a_campaign_as_it_stands_and_with_all_its_comments(
    load: Load, registry: Registry, tmp_path: Path, name: str
) -> None:
    text = campaign_template(registry, name)
    campaign = load(text)
    several = name == "two-spheres"
    assert {entry.name for entry in campaign.strategies} >= (
        {"nsga2", "random"} if several else {"dycors", "lmsrs", "random"}
    )
    assert "narrow" in {entry.name for entry in campaign.strategies} if name == "sphere" else True
    problems = make_problems(registry, campaign)
    assert refusals(registry, campaign, problems) == []
    assert [problem.n_obj for problem in problems.values()] == [1 + several]
    (tmp_path / "my-site.toml").write_text(site_template(registry, name), encoding="utf-8")
    in_full = re.sub(r"^# (?=\[\[|\w+ = )", "", text, flags=re.MULTILINE)
    single = "\n".join(line for line in in_full.splitlines() if not line.startswith(("scalari", "preferences")))
    assert load(single).problems[0].label == "my-label"
    assert load(single).timeout == 60.0


def test_a_site_file_is_overlaid_by_the_campaign_file(load: Load, registry: Registry, tmp_path: Path) -> None:
    (tmp_path / "site.toml").write_text(
        "[track.passage]\nspeed = 30.0\ntime_step = 2e-3\n[worst]\nF_max = 7000.0\nE_max = 2.0\n[[given]]\nxr1 = 90.0\n"
        "[scalariser.asf]\nrho = 0.2\naspiration_fraction = 0.7\n[strategy.dycors]\ntree_search = true\n"
        "[strategy.ga]\ncrossover_eta = 3.0\n"
    )
    campaign = load(
        HEAD + 'strategies = ["dycors"]\n[[problem]]\nname = "level-crossing"\nscalarise = "asf"\nparameters = "site.toml"\n'
        "scalariser_settings = { rho = 0.3 }\nworst = { E_max = 3.0 }\ngiven = [{ xn = 4 }]\n"
        "[problem.sections.track.passage]\nspeed = 35.0\n"
    )
    entry = campaign.problems[0]
    assert entry.settings.sections == {"track": {"passage": {"speed": 35.0, "time_step": 2e-3}}}
    assert entry.settings.worst == {"F_max": 7000.0, "E_max": 3.0}
    assert entry.settings.scalariser_settings == {"rho": 0.3, "aspiration_fraction": 0.7}
    assert entry.given == ({"xr1": 90.0}, {"xn": 4})
    problem = make_problems(registry, campaign)["level-crossing"]
    first, *others = given_designs(problem, entry.given)
    assert np.array_equal(first, problem.reference)
    assert [problem.space.named(design)[name] for name, design in zip(("xr1", "xn"), others, strict=True)] == [90.0, 4]


def test_a_complete_site_file_with_its_default_strategies_is_accepted(load: Load) -> None:
    text = HEAD + 'strategies = ["dycors"]\n[[problem]]\nname = "level-crossing"\nobjectives = ["F_max"]\nparameters = '
    assert load(f'{text}"{EXAMPLES}/dutch_crossing.toml"').problems[0].settings.sections["track"]


def test_strategies_are_not_changed_by_a_site_file(load: Load, tmp_path: Path) -> None:
    (tmp_path / "site.toml").write_text("[strategy.dycors]\nsigma_start = 0.3\n")
    text = HEAD + 'strategies = ["dycors"]\n[[problem]]\nname = "level-crossing"\nparameters = "site.toml"\n'
    message = refused(load, text)
    assert all(word in message for word in ("problem level-crossing", "dycors.sigma_start = 0.3", "[[strategy]]")), message


def test_a_list_may_stand_in_a_file_beside_the_campaign_file(load: Load, tmp_path: Path) -> None:
    (tmp_path / "pads.csv").write_text("# stiffness\n1e8\n2e8\n3e8\n")
    campaign = load(
        HEAD + 'strategies = ["random"]\n[[problem]]\nname = "level-crossing"\n'
        '[problem.sections.track.zone]\npad_stiffness = { file = "pads.csv", column = 1 }\n'
    )
    assert campaign.problems[0].settings.sections["track"]["zone"]["pad_stiffness"] == [1e8, 2e8, 3e8]


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("budget = 0", ("[campaign].budget", "≥ 1", "0")),
        ("budget = 2.5", ("[campaign].budget", "an integer", "2.5")),
        ('budget = "many"', ("[campaign].budget", "'many'")),
        ("repetitions = 0", ("[campaign].repetitions", "≥ 1")),
        ("repetitions = 1000000000", ("[campaign].repetitions", "≤ 100000")),
        ("seed = -1", ("[campaign].seed", "≥ 0", "-1")),
        ("seed = true", ("[campaign].seed", "an integer", "True")),
        ("batch = 0", ("[campaign].batch", "≥ 1")),
        ("timeout = 0", ("[campaign].timeout", "> 0", "s")),
        ("timeout = inf", ("[campaign].timeout", "finite", "inf")),
        ("timeout = nan", ("[campaign].timeout", "finite", "nan")),
        ("budgett = 3", ("'budgett'", "did you mean 'budget'")),
        ("name = 3", ("[campaign].name", "a string")),
        ('name = "a/b"', ("campaign", "'/'", "'a/b'")),
        ('name = ""', ("campaign", "1 to 100", "''")),
        ('name = " a"', ("campaign", "' a'")),
        (f'name = "{"a" * 101}"', ("campaign", "1 to 100")),
        ('name = "a\\u0007"', ("campaign", "printable")),
        ("problems = []", ("problem: one or more are needed", "[[problem]]")),
        ("strategies = []", ("strategy: one or more are needed", "[[strategy]]")),
        ('problems = "sphere"', ("[campaign].problems", "a list", "'sphere'")),
        ('strategies = ["dycor"]', ("unknown strategy 'dycor'", "did you mean 'dycors'")),
        ('strategies = ["random", "random"]', ("strategy", "'random' is used twice", "label of its own")),
        ('problems = ["shpere"]', ("problem shpere", "unknown problem 'shpere'", "did you mean 'sphere'")),
        ('problems = ["plain"]', ("problem plain", "reference_point", "cost, comfort")),
    ],
)
def test_a_value_that_is_not_allowed_is_named_with_its_place(load: Load, line: str, words: tuple[str, ...]) -> None:
    key = line.split(" =")[0]
    text = "\n".join([*(row for row in BOTH.splitlines() if not row.startswith(f"{key} =")), line])
    message = refused(load, text)
    assert all(word in message for word in words), message


@pytest.mark.parametrize(
    ("table", "words"),
    [
        (
            '[[problem]]\nname = "level-crossing"\nobjectives = ["F_mx", "E"]',
            ("unknown 'F_mx', 'E'; there are F_rms, F_max"),
        ),
        ('[[problem]]\nname = "level-crossing"\nobjectives = ["F_max", "F_max"]', ("each may be named once")),
        ('[[problem]]\nname = "level-crossing"\nscalarise = "asg"', ("unknown scalariser 'asg', did you mean 'asf'")),
        ('[[problem]]\nname = "level-crossing"\nscalarise = "asf"\nobjectives = ["F_max"]', ("two objectives or more")),
        (
            '[[problem]]\nname = "level-crossing"\nscalarise = "asf"\nobjectives = ["F_rms", "E_rms"]',
            ("F_rms, E_rms is not"),
        ),
        ('[[problem]]\nname = "level-crossing"\nscalariser_settings = {rho = 1.0}', ('scalarise = "asf"')),
        (
            '[[problem]]\nname = "level-crossing"\nscalarise = "asf"\nscalariser_settings = {roh = 1.0}',
            ("did you mean 'rho'"),
        ),
        ('[[problem]]\nname = "level-crossing"\nparameters = "absent.toml"', ("absent.toml: cannot be read")),
        ('[[problem]]\nname = "level-crossing"\nsections = {trak = {}}', ("unknown section [trak]")),
        ('[[problem]]\nname = "level-crossing"\nsections = {track = {pasage = {}}}', ("did you mean 'passage'")),
        ('[[problem]]\nname = "level-crossing"\nworst = {F_maxi = 1.0}', ("worst: unknown 'F_maxi'")),
        ('[[problem]]\nname = "level-crossing"\nworst = {F_max = "high"}', ("worst.F_max: a finite number is needed")),
        ('[[problem]]\nname = "level-crossing"\nreference_point = {F_mx = 1.0}', ("reference_point: unknown 'F_mx'")),
        ('[[problem]]\nname = "level-crossing"\nreference_point = {F_rms = 1.0}', ("F_rms is not minimised here")),
        (
            '[[problem]]\nname = "level-crossing"\nreference_point = {F_max = nan}',
            ("reference_point.F_max: a finite number"),
        ),
        (
            '[[problem]]\nname = "sphere"\nlabel = "s"\nreference_point = {f = 1.0}',
            ("two objectives or more", "leave it out"),
        ),
        (
            '[[problem]]\nname = "level-crossing"\ngiven = [{xr1 = 100.0}, {xr9 = 1}]',
            ("given design 2: unknown variable 'xr9'"),
        ),
        ('[[problem]]\nname = "level-crossing"\ngiven = [{xn = 1.5}]', ("given design 1: variable xn: a whole number")),
        (
            '[[problem]]\nname = "level-crossing"\ngiven = {xn = 1}',
            ("level-crossing.given: a list of tables is needed"),
        ),
        ('[[problem]]\nname = "level-crossing"\nobjektives = []', ("'objektives'", "did you mean 'objectives'")),
        ('[[problem]]\nlabel = "nameless"', ("problem nameless", "unknown problem ''")),
        ('[[problem]]\nname = "level-crossing"\nlabel = "Sphere"', ("differing in case alone ('sphere')")),
        ('[[problem]]\nname = "level-crossing"\nlabel = "a/b"', ("problem", "'/'", "'a/b'")),
        ('[[problem]]\nname = "plain"\nscalarise = "asf"', ("worst value of cost, comfort is not known")),
        (
            '[[problem]]\nname = "plain"\nscalarise = "asf"\nworst = {cost = 2.0, comfort = 0.0}',
            ("asf needs the objectives of a reference design", "aspiration"),
        ),
        ('[[strategy]]\nname = "dycors"\nsettings = {sigma = 1}', ("strategy dycors", "unknown parameter 'sigma'")),
        ('[[strategy]]\nname = "dycors"\nsetings = {}', ("strategy dycors", "did you mean 'settings'")),
        ("[strategy.dycors]\nsigma_start = 0.3", ("campaign file.strategy", "a list of tables is needed")),
        ("[[problems]]\n", ("'problems'", "did you mean 'problem'")),
    ],
)
def test_a_table_that_is_not_allowed_is_refused(load: Load, table: str, words: tuple[str, ...] | str) -> None:
    message = refused(load, f"{BOTH}{table}\n")
    assert all(word in message for word in ([words] if isinstance(words, str) else words)), message


def test_all_faults_are_told_at_once(load: Load) -> None:
    message = refused(
        load,
        '[campaign]\nbudget = -1\ncolour = "red"\nproblems = ["shpere", "nowhere"]\nstrategies = ["dycor", "gaa"]\n'
        '[[problem]]\nname = "level-crossing"\nobjectives = ["F_mx"]\nscalarise = "asg"\nworst = {E = 1.0}\n'
        "sections = {trak = {}, track = {pasage = {}, raill = {}}}\n"
        '[[strategy]]\nname = "dycors"\nsettings = {sigma = 1, weights = 3}\n',
    )
    expected = ("budget: allowed", "'colour'", "repetitions, seed must", "'shpere'", "'nowhere'", "'dycor'", "'gaa'")
    expected += ("'F_mx'", "'asg'", "'E'", "[trak]", "'pasage'", "'raill'", "'sigma'", "dycors.weights")
    assert all(message.count(word) == 1 for word in expected), message
    assert "trial.toml has 13 faults:\n- " in message


def test_missing_values_are_asked_for_with_an_example(load: Load) -> None:
    message = refused(load, '[campaign]\nproblems = ["sphere"]\nstrategies = ["random"]\n')
    assert "budget, repetitions, seed must be given, for instance budget = 200" in message
    assert "trial.toml: [campaign]: seed must" in refused(load, BOTH.replace("seed", "# seed")), "one fault, one line"
    assert "[campaign]: budget" in refused(load, "")


def test_a_file_that_cannot_be_read_is_named(registry: Registry, load: Load, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"absent\.toml: cannot be read"):
        load_campaign(registry, tmp_path / "absent.toml")
    assert "(at line 2, column 10)" in refused(load, "[campaign]\nbudget = \n")
    assert "campaign file.problem: a list of tables is needed" in refused(load, 'problem = "level-crossing"\n')


def test_hypervolume_is_measured_from_given_values_completed_by_the_worst_known(load: Load) -> None:
    text = HEAD + 'strategies = ["random"]\n[[problem]]\n'
    crossing = text + 'name = "level-crossing"\n'
    assert load(crossing).problems[0].reference_point == {}, "the worst values serve"
    point = load(crossing + "reference_point = { F_max = 4000 }\n").problems[0].reference_point
    assert point == {"F_max": 4000.0, "E_max": 1.5}
    plain = load(text + 'name = "plain"\nreference_point = { cost = 2, comfort = -1.0 }\n').problems[0]
    assert plain.reference_point == {"cost": 2.0, "comfort": -1.0}, "natural signs, in the order of the objectives"
    assert load(text + 'name = "plain"\nworst = { cost = 2, comfort = -1.0 }\n').problems[0].reference_point == {}


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.text(st.characters(exclude_categories=["Cs"]), max_size=130))
def test_every_label_that_is_accepted_names_its_study_without_doubt(load: Load, label: str) -> None:
    written = json.dumps(label, ensure_ascii=False)
    text = f'name = {written}\n[[problem]]\nname = "sphere"\nlabel = {written}\n[[strategy]]\nname = "random"\n'
    accepted = None
    with suppress(InputError):
        accepted = load(f"{HEAD}{text}label = {written}\n")
    if re.fullmatch(r"[\w.+-]([\w.+ -]{0,98}[\w.+-])?", label):
        assert accepted is not None, "words, points, signs and spaces between them are allowed"
    for cell in accepted.cells() if accepted else ():
        name = cell.study_name(label)
        assert name.split("/") == [label, cell.problem, cell.strategy, str(cell.repetition)]
        assert len(name) <= 512


def test_one_strategy_under_two_labels_is_two_strategies(load: Load) -> None:
    campaign = load(BOTH + '[[strategy]]\nname = "random"\nlabel = "again"\n')
    assert [entry.label for entry in campaign.strategies] == ["random", "again"]


@pytest.fixture
def mixed(load: Load, registry: Registry) -> tuple[Campaign, Mapping[str, DesignProblem]]:
    campaign = load(
        '[campaign]\nbudget = 19\nrepetitions = 2\nseed = 1\nbatch = 2\nproblems = ["sphere", "level-crossing"]\n'
        'strategies = ["random", "dycors", "narrow", "nsga2"]\n'
        '[[problem]]\nname = "plain"\nreference_point = { cost = 2, comfort = 0 }\n'
    )
    return campaign, make_problems(registry, campaign)


def test_every_pair_that_cannot_be_run_is_found(
    mixed: tuple[Campaign, Mapping[str, DesignProblem]], registry: Registry
) -> None:
    found = {(refusal.problem, refusal.strategy): refusal.reason for refusal in refusals(registry, *mixed)}
    assert "batch of 2" in found["sphere", "narrow"]
    assert "one objective" in found["level-crossing", "narrow"]
    assert "one objective" in found["plain", "dycors"]
    assert set(found) >= {("sphere", "dycors"), ("level-crossing", "dycors"), ("plain", "narrow")}
    assert not any(strategy in ("random", "nsga2") for problem, strategy in found if problem != "plain")


def test_a_budget_below_the_start_of_a_strategy_is_refused_for_that_pair(load: Load, registry: Registry) -> None:
    campaign = load(BOTH.replace("50", "9").replace('["random"]', '["random", "lmsrs", "narrow"]'))
    found = {refusal.strategy: refusal.reason for refusal in refusals(registry, campaign, make_problems(registry, campaign))}
    assert set(found) == {"lmsrs", "narrow"}
    assert "at least 22 evaluations" in found["lmsrs"]
    assert "received 9" in found["lmsrs"]
    assert "ZeroDivisionError: no generations" in found["narrow"], "a stranger's strategy that breaks is one refusal"


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ('surrogate = "rfb"', ("unknown surrogate 'rfb'", "did you mean 'rbf'")),
        ('surrogate_settings = { kernal = "linear" }', ("surrogate rbf", "did you mean 'kernel'")),
    ],
)
def test_a_surrogate_that_is_not_there_is_refused_before_anything_is_evaluated(
    load: Load, registry: Registry, settings: str, words: tuple[str, ...]
) -> None:
    campaign = load(BOTH + f'[[strategy]]\nname = "dycors"\nsettings = {{ {settings} }}\n')
    (refusal,) = refusals(registry, campaign, make_problems(registry, campaign))
    assert refusal.strategy == "dycors"
    assert all(word in refusal.reason for word in words), refusal.reason


def test_more_given_designs_than_evaluations_are_refused(load: Load, registry: Registry) -> None:
    rows = ", ".join(f"{{ x1 = {number / 20} }}" for number in range(61))
    campaign = load(HEAD + f'strategies = ["random"]\n[[problem]]\nname = "sphere"\ngiven = [{rows}]\n')
    (refusal,) = refusals(registry, campaign, make_problems(registry, campaign))
    assert "61 of them given" in refusal.reason


def test_refusals_are_raised_together_unless_they_are_to_be_skipped(load: Load) -> None:
    campaign = load(BOTH.replace('["random"]', '["random", "lmsrs", "ga"]'))
    refused_pairs = [Refusal("sphere", "lmsrs", "too dear"), Refusal("sphere", "ga", "too slow")]
    with pytest.raises(CapabilityError) as caught:
        check_capable(campaign, refused_pairs)
    message = str(caught.value)
    words = ("2 of 3 pairs", "lmsrs on sphere: too dear", "ga on sphere: too slow", "--skip-incapable")
    assert all(word in message for word in words), message
    check_capable(campaign, refused_pairs, skip_incapable=True)
    check_capable(campaign, [])
    cells = list(capable_cells(campaign, refused_pairs))
    assert cells == [Cell("sphere", "random", repetition) for repetition in (1, 2, 3)]
    everything = [*refused_pairs, Refusal("sphere", "random", "too plain")]
    with pytest.raises(CapabilityError, match="No pair is left"):
        check_capable(campaign, everything, skip_incapable=True)
