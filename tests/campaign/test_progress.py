"""The progress of a campaign counts every evaluation once, whoever makes it."""

from pathlib import Path
from typing import Any

import pytest
from campaign_runs import Trial
from rich.progress import Progress

from railsearch.campaign.problems import make_problems
from railsearch.campaign.tasks import cell_tasks, recorded
from railsearch.commands import campaign_progress as module
from railsearch.plugin_manager import load_plugins
from railsearch.storage import StudyProgress
from sample_problems import sphere_evaluation

pytestmark = pytest.mark.usefixtures("sample_plugin")


def test_evaluations_of_this_and_of_other_processes_are_counted_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bars: list[Progress] = []

    class Seen(Progress):
        def __init__(self, *columns: Any, **options: Any) -> None:
            super().__init__(*columns, **options)
            bars.append(self)

    monkeypatch.setattr(module, "Progress", Seen)
    registry, campaign = load_plugins(), Trial(tmp_path, repetitions=1, budget=25).campaign()
    problems = make_problems(registry, campaign)
    first, second = cell_tasks(registry, campaign, problems, campaign.cells(), "")
    before = recorded([first, second], {first.description.name: StudyProgress({}, 20)})
    assert (before.complete, before.evaluations, before.missing) == (0, 20, {"journalled": 30})
    evaluations = [sphere_evaluation(number) for number in range(25)]
    with module.campaign_progress(problems, [first, second], before) as watcher:
        (bar,) = bars[0].tasks
        assert (bar.completed, bar.total) == (20, 50)
        watcher.evaluation(first, evaluations[20])
        assert bar.completed == 21
        watcher.complete(first, evaluations)
        assert bar.completed == 25
        watcher.complete(second, evaluations)
        assert (bar.completed, bar.fields["cells"]) == (50, 2)
        assert bar.fields["last"].startswith("last random on journalled: distance")


def test_without_a_terminal_a_line_from_time_to_time_tells_the_progress(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(module, "LOG_EVERY", -1.0)
    registry, campaign = load_plugins(), Trial(tmp_path, repetitions=1).campaign()
    problems = make_problems(registry, campaign)
    tasks = cell_tasks(registry, campaign, problems, campaign.cells(), "")
    with module.campaign_progress(problems, tasks, recorded(tasks, {})) as watcher:
        for number in range(3):
            watcher.evaluation(tasks[0], sphere_evaluation(number))
    lines = capsys.readouterr().err.splitlines()
    assert lines[-1].startswith("3 of 50 evaluations, 0 of 2 cells, about 0 min left")
