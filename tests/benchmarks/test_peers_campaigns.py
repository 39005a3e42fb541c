import dataclasses
import tomllib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from railsearch_peers.cells import BUDGETS, cell_results
from railsearch_peers.peer import ENDED, PeerParameters
from railsearch_peers.scores import FLOOR, REFERENCE

from railsearch.campaign.cells import Campaign, CampaignProblem, CampaignStrategy, Cell
from railsearch.campaign.definition import load_campaign
from railsearch.campaign.results import CampaignResults, CellRecord
from railsearch.errors import InputError
from railsearch.plugin_manager import Registry
from railsearch.problem_factory import ProblemSettings, make_problem

PEERS = Path(__file__).resolve().parent.parent.parent / "benchmarks" / "peers"
FAST, SLOW, OURS = (PEERS / f"{name}.toml" for name in ("campaign", "campaign_slow", "campaign_ours"))


def peers(path: Path) -> dict[str, PeerParameters]:
    tables = tomllib.loads(path.read_text())["strategy"]
    return {table["label"]: PeerParameters(**table["settings"]) for table in tables if table["name"] == "peer"}


def test_the_campaigns_pair_their_runs(registry: Registry) -> None:
    fast, slow, ours = (load_campaign(registry, path) for path in (FAST, SLOW, OURS))
    assert [campaign.repetitions for campaign in (fast, slow, ours)] == [15, 5, 15]
    assert {(campaign.seed, campaign.budget) for campaign in (fast, slow, ours)} == {(fast.seed, BUDGETS[-1])}
    assert ours.problems == fast.problems
    assert {REFERENCE, FLOOR} <= {strategy.label for strategy in fast.strategies}
    assert slow.problems == tuple(problem for problem in fast.problems if "-20" not in problem.label)
    assert len(fast.problems) == 21
    dimensions = {p.label: make_problem(registry, p.settings).space for p in fast.problems}
    halves = [space for label, space in dimensions.items() if label.endswith("half-integer")]
    assert [2 * int(space.integer.sum()) for space in halves] == [space.dimension for space in halves]
    instances = {p.settings.sections["coco"]["instance"] for p in fast.problems if "coco" in p.settings.sections}
    assert instances == {7}


@pytest.mark.parametrize("path", [FAST, SLOW])
def test_versions_asked_for_are_those_installed_and_clients_have_the_algorithms(path: Path) -> None:
    for label, settings in peers(path).items():
        requirements = (PEERS / "requirements" / f"{settings.peer}.txt").read_text().splitlines()
        first = next(line for line in requirements if not line.startswith("#"))
        client = (PEERS / "clients" / f"{settings.peer}_client.py").read_text()
        assert first.endswith(f"=={settings.version}"), label
        assert f'DISTRIBUTIONS = ("{first.split("==")[0]}"' in client
        assert f'"{settings.algorithm}": ' in client.split("ALGORITHMS = ")[1]


def test_requirements_name_versions_and_no_index() -> None:
    for path in (PEERS / "requirements").glob("*.txt"):
        lines = [line for line in path.read_text().splitlines() if not line.startswith("#")]
        assert all(line.count("==") == 1 and "/" not in line and " " not in line for line in lines), path.name


def record(origins: list[str], values: list[float]) -> CellRecord:
    n = len(origins)
    designs = np.random.default_rng(1).random((n, 3))
    nothing = np.empty((n, 0))
    overheads = np.array([0.004 if origin == "peer" else 100.0 for origin in origins])
    whole = np.zeros(n, dtype=np.int64)
    return CellRecord(
        {"seed": 11}, designs, np.array(values)[:, None], nothing, {}, origins, whole, [""] * n, np.ones(n), overheads
    )


def results(registry: Registry, budget: int, records: dict[Cell, CellRecord]) -> CampaignResults:
    sphere = CampaignProblem("p", ProblemSettings("sphere", sections={"function": {"dimension": 3}}))
    campaign = Campaign("c", budget, 2, 1, (sphere,), (CampaignStrategy("s", "random"),))
    return CampaignResults(campaign, {"p": make_problem(registry, sphere.settings)}, records)


def test_a_run_keeps_what_the_participant_itself_found(registry: Registry) -> None:
    origins = ["given"] + ["initial"] * 19 + ["peer"] * 100 + [f"{ENDED}it stopped by itself"] * 80
    values = np.linspace(300.0, 101.0, 200)
    whole, part = record(origins, values), record(origins[:150], values[:150])
    found = cell_results(results(registry, 200, {Cell("p", "s", 1): whole, Cell("p", "s", 2): part}))
    assert [cell.repetition for cell in found] == [1]
    assert found[0].best == (values[49], values[99], values[119])
    assert (found[0].seed, found[0].ended) == (11, "it stopped by itself")
    assert found[0].overhead == pytest.approx(0.004, rel=1e-12)


def test_the_start_is_told_by_its_designs(registry: Registry) -> None:
    origins, values = ["initial"] * 20 + ["peer"] * 180, np.ones(200)
    one = record(origins, values)
    later, early = one.designs.copy(), one.designs.copy()
    later[20] += 0.1
    early[19, 2] += 1e-15
    others = (dataclasses.replace(one, designs=designs) for designs in (one.designs.copy(), later, early))
    cells = {Cell("p", name, 1): each for name, each in zip("stu", others, strict=True)}
    starts = [cell.start for cell in cell_results(results(registry, 200, cells))]
    assert starts[0] == starts[1] != starts[2]


def test_a_campaign_of_another_budget_is_refused(registry: Registry) -> None:
    with pytest.raises(InputError, match="the campaign has 100"):
        cell_results(results(registry, 100, {}))


def test_a_campaign_with_a_peer_is_carried_out(
    registry: Registry, fake_peer: Callable[[], int], settings: Callable[..., dict[str, object]], tmp_path: Path
) -> None:
    from railsearch.campaign.coordinator import Coordinator
    from railsearch.campaign.places import places_here
    from railsearch.campaign.problems import make_problems
    from railsearch.campaign.reading import read_campaign
    from railsearch.campaign.tasks import cell_tasks
    from railsearch.storage import Storage

    sphere = CampaignProblem("p", ProblemSettings("sphere", sections={"function": {"dimension": 3}}))
    strategies = tuple(CampaignStrategy(name, "peer", settings(name)) for name in ("random", "crashing"))
    campaign = Campaign("c", 25, 2, 1, (sphere,), strategies)
    tasks = cell_tasks(registry, campaign, make_problems(registry, campaign), campaign.cells(), "")
    url = f"sqlite:///{tmp_path / 'study.db'}"
    coordinator = Coordinator(Storage(url), tasks)
    coordinator.carry_out(places_here(registry, 1))
    assert not coordinator.failed
    records = read_campaign(registry, url, campaign).records
    last = {cell.strategy: record.origins[-1] for cell, record in records.items()}
    assert [len(record.origins) for record in records.values()] == [25] * 4
    assert last == {"random": "peer", "crashing": f"{ENDED}ZeroDivisionError: no third question"}
