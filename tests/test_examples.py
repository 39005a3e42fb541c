"""The examples are used as their users would."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from conftest import Answer
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
