"""Campaign results made on the spot: hand-made records with known answers, and synthetic searches of any size."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from railsearch.campaign.cells import Campaign, CampaignProblem, CampaignStrategy, Cell
from railsearch.campaign.results import CampaignResults, CellRecord
from railsearch.design_problem import DesignProblem
from railsearch.problem_factory import ProblemSettings


@dataclass(frozen=True)
class Searcher:
    """A synthetic strategy: the share of its steps taken near the best design so far, and the share that fails."""

    locality: float
    failing: float = 0.0


def campaign_of(
    problems: Mapping[str, DesignProblem],
    strategies: Sequence[str],
    repetitions: int,
    budget: int,
    reference_points: Mapping[str, Mapping[str, float]] | None = None,
) -> Campaign:
    points = reference_points or {}
    return Campaign(
        name="sample",
        budget=budget,
        repetitions=repetitions,
        seed=7,
        problems=tuple(
            CampaignProblem(label, ProblemSettings(problem.name), reference_point=points.get(label, {}))
            for label, problem in problems.items()
        ),
        strategies=tuple(CampaignStrategy(label, label) for label in strategies),
    )


def record_of(
    problem: DesignProblem,
    objectives: Sequence[float] | Sequence[Sequence[float]],
    reasons: Sequence[str] | None = None,
    designs: np.ndarray | None = None,
    metrics: Mapping[str, np.ndarray] | None = None,
) -> CellRecord:
    """A record of these objectives (n,) or (n, m), as they are minimised; the first design is the reference design."""
    values = np.asarray(objectives, dtype=float).reshape(len(objectives), -1)
    count = len(values)
    if designs is None:
        designs = np.tile(problem.space.rounded(problem.space.lower), (count, 1))
        designs[0] = designs[0] if problem.reference is None else problem.reference
    return CellRecord(
        identity={"seed": 11},
        designs=designs,
        objectives=values,
        constraints=np.zeros((count, problem.n_ieq_constr)),
        metrics=metrics or {},
        origins=["given"] + ["random"] * (count - 1),
        trajectories=np.zeros(count, dtype=np.int64),
        reasons=list(reasons or [""] * count),
        durations=np.full(count, 0.05),
        overheads=np.full(count, 0.002),
    )


def results_of(
    problem: DesignProblem,
    finals: Mapping[str, Sequence[float]],
    budget: int = 4,
    repetitions: int | None = None,
) -> CampaignResults:
    """One problem `p`; every cell falls from 100 to its final value (by strategy, one for each repetition) half way."""
    count = repetitions or max(len(values) for values in finals.values())
    campaign = campaign_of({"p": problem}, list(finals), count, budget)
    half = budget // 2
    records = {
        Cell("p", strategy, repetition): record_of(problem, [100.0] * half + [value] * (budget - half))
        for strategy, values in finals.items()
        for repetition, value in enumerate(values, 1)
    }
    return CampaignResults(campaign, {"p": problem}, records)


def synthetic_results(
    problems: Mapping[str, DesignProblem],
    searchers: Mapping[str, Searcher],
    repetitions: int,
    budget: int,
    seed: int = 1,
) -> CampaignResults:
    """A complete campaign of synthetic searches, truly evaluated."""
    campaign = campaign_of(problems, list(searchers), repetitions, budget)
    generator = np.random.default_rng(seed)
    records = {
        cell: searched(problems[cell.problem], searchers[cell.strategy], budget, generator) for cell in campaign.cells()
    }
    return CampaignResults(campaign, problems, records)


def searched(problem: DesignProblem, searcher: Searcher, budget: int, generator: np.random.Generator) -> CellRecord:
    """A search that steps near the best design so far (by the sum of objectives), or anywhere."""
    designs, outcomes, incumbent, lowest = [], [], problem.space.to_unit(problem.reference), np.inf
    near = generator.random(budget) < searcher.locality
    failing = generator.random(budget) < searcher.failing
    for number in range(budget):
        step = incumbent + generator.normal(0.0, 0.08, incumbent.size) if near[number] else generator.random(incumbent.size)
        design = problem.reference if number == 0 else problem.space.from_unit(np.clip(step, 0.0, 1.0))
        outcome = problem.simulate(design)
        if outcome.objectives.sum() < lowest and not failing[number]:
            incumbent, lowest = problem.space.to_unit(design), outcome.objectives.sum()
        designs.append(design)
        outcomes.append(outcome)
    lost = np.where(failing & (np.arange(budget) > 0), np.nan, 0.0)
    return CellRecord(
        identity={"seed": int(generator.integers(2**31))},
        designs=np.array(designs),
        objectives=np.array([outcome.objectives for outcome in outcomes]) + lost[:, None],
        constraints=np.array([outcome.constraints for outcome in outcomes]).reshape(budget, -1) + lost[:, None],
        metrics={q.name: np.array([o.metrics.get(q.name, np.nan) for o in outcomes]) + lost for q in problem.metrics},
        origins=["given"] + ["perturbation" if inside else "random" for inside in near[1:]],
        trajectories=np.zeros(budget, dtype=np.int64),
        reasons=["SimulationError: the integration diverged" if np.isnan(value) else "" for value in lost],
        durations=generator.lognormal(-3.0, 0.2, budget),
        overheads=generator.lognormal(-7.0 + 2.0 * searcher.locality, 0.3, budget),
    )
