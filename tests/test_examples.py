"""The examples are used as their users would."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from command_line import Answer
from railsearch.campaign.definition import load_campaign
from railsearch.plugin_manager import load_plugins
from railsearch.site import site_template

EXAMPLES = Path(__file__).parents[1] / "examples"


def test_the_dutch_case_is_the_template() -> None:
    assert (EXAMPLES / "dutch_crossing.toml").read_text(encoding="utf-8") == site_template(load_plugins(), "level-crossing")


@pytest.mark.parametrize("site", sorted(EXAMPLES.glob("*.toml")), ids=lambda path: path.stem)
def test_a_site_is_searched(railsearch: Callable[..., Answer], tmp_path: Path, site: Path) -> None:
    words = ("run", "level-crossing", "--parameters", site, "--scalarise", "asf", "--budget", 26, "--seed", 1)
    answer = railsearch(*words, "--out", tmp_path, "--json")
    assert answer.code == 0, answer.err
    document = json.loads(answer.out)
    assert document["failed"] == 0
    assert all(document["improvement"][name] > 0.0 for name in ("F_max", "E_max"))


def test_the_recorded_campaign_is_that_of_its_file_and_the_readme_says_what_was_found() -> None:
    folder = EXAMPLES / "campaign_level_crossing"
    found = json.loads((folder / "statistics.json").read_text(encoding="utf-8"))
    campaign = load_campaign(load_plugins(), folder / "campaign.toml")
    assert (found["status"], found["complete"], found["failed"]) == ("complete", len(list(campaign.cells())), 0)
    recorded = found["campaign"]
    assert [recorded[key] for key in ("name", "budget", "repetitions", "seed")] == [
        campaign.name,
        campaign.budget,
        campaign.repetitions,
        campaign.seed,
    ]
    assert [entry["label"] for entry in recorded["problems"]] == [problem.label for problem in campaign.problems]
    assert [entry["name"] for entry in recorded["strategies"]] == [strategy.name for strategy in campaign.strategies]
    root, own = ((path / "README.md").read_text(encoding="utf-8") for path in (EXAMPLES.parent, folder))
    assert found["conclusion"] in " ".join(root.split())
    for entry in found["problems"]:
        assert entry["conclusion"] in " ".join(own.split())
        for row in entry["fixed_budget"]:
            final = row["places"][-1]
            numbers = " | ".join(f"{final[key]:.4g}" for key in ("median", "lower", "upper"))
            assert f"| {entry['label']} | {row['strategy']} | {numbers} |" in own
            assert f"| {row['strategy']} |" in root
