"""The comparison of strategies on one problem, in plain JSON types.

Only repetitions that are complete for all compared strategies count, so that every strategy has had the same chances. All
values are given with their natural sign; what is not a finite number is null.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from railsearch.campaign.cells import Cell
from railsearch.campaign.measure import Measure
from railsearch.campaign.results import CampaignResults, CellRecord
from railsearch.indicators import attainment_surface, igd_plus, non_dominated
from railsearch.space import FloatArray
from railsearch.statistics import (
    Targets,
    bootstrap_median_band,
    expected_running_time,
    pairwise_comparison,
    probability_best,
    quantile_bands,
    relative_targets,
    runlength_ecdf,
    runlengths,
)

Numbers = NDArray[np.int64]

LEVEL = 0.05
CONFIDENCE = 0.95
BUDGET_FRACTIONS = (0.1, 0.25, 0.5, 1.0)
ATTAINMENT_FRACTIONS = (0.25, 0.5, 0.75)
NUMBERS_SHOWN = 200
CORNERS_SHOWN = 100


@dataclass(frozen=True)
class Compared:
    """What is compared on one problem: by which measure, in which repetitions, and the curves (r, budget) by strategy.

    The curves are minimised, NaN until there is a value.
    """

    label: str
    measure: Measure
    repetitions: tuple[int, ...]
    curves: Mapping[str, FloatArray]

    @property
    def strategies(self) -> list[str]:
        """The strategies that are compared."""
        return list(self.curves)

    @property
    def finals(self) -> list[FloatArray]:
        """The final values (r,) of each strategy, +∞ without one."""
        return [np.nan_to_num(curves[:, -1], nan=np.inf) for curves in self.curves.values()]

    @property
    def medians(self) -> FloatArray:
        """The medians (strategies,) of the final values."""
        return np.array([np.median(final) for final in self.finals])

    @property
    def targets(self) -> Targets:
        """Targets common to all strategies."""
        return relative_targets(np.concatenate(list(self.curves.values())))

    @property
    def runlengths(self) -> dict[str, FloatArray]:
        """Runlengths (r, targets) by strategy."""
        targets = self.targets.values
        return {strategy: runlengths(curves, targets) for strategy, curves in self.curves.items()}


def compared(results: CampaignResults, label: str, measure: Measure) -> Compared:
    """The balanced comparison on one problem; strategies without a complete repetition are left out."""
    problem, campaign = results.problems[label], results.campaign
    complete = {strategy.label: complete_repetitions(results, label, strategy.label) for strategy in campaign.strategies}
    begun = {strategy: numbers for strategy, numbers in complete.items() if numbers}
    common = tuple(sorted(set.intersection(*begun.values()))) if begun else ()
    if not common:
        return Compared(label, measure, (), {})
    budget = int(min(campaign.budget, problem.space.size))
    curves = {
        strategy: np.array([measure.curve(results.records[Cell(label, strategy, number)], budget) for number in common])
        for strategy in begun
    }
    return Compared(label, measure, common, curves)


def complete_repetitions(results: CampaignResults, problem: str, strategy: str) -> set[int]:
    """The repetitions of a cell that have used their budget, or evaluated every design there is."""
    needed = min(results.campaign.budget, results.problems[problem].space.size)
    numbers = range(1, results.campaign.repetitions + 1)
    cells = {number: results.records.get(Cell(problem, strategy, number)) for number in numbers}
    return {number for number, record in cells.items() if record is not None and len(record.objectives) >= needed}


def comparison_document(data: Compared, generator: np.random.Generator) -> dict[str, Any]:
    """Curves, fixed-budget table, runlengths, pairwise tests and chances of being best; empty without a repetition."""
    if not data.curves:
        return {"numbers": [], "curves": {}, "fixed_budget": [], "targets": None, "pairwise": None, "probability_best": {}}
    numbers = shown_numbers(next(iter(data.curves.values())).shape[1])
    return {
        "numbers": numbers.tolist(),
        "curves": {
            strategy: _curve(data.measure, curves[:, numbers - 1], generator) for strategy, curves in data.curves.items()
        },
        "fixed_budget": _fixed_budget(data),
        "targets": _targets(data, numbers),
        "pairwise": _pairwise(data),
        "probability_best": dict(zip(data.strategies, probability_best(data.finals, generator).tolist(), strict=True)),
    }


def shown_numbers(budget: int) -> Numbers:
    """Evaluation numbers, from 1 to the budget, at which curves are given: all of few, otherwise denser at the start."""
    if budget <= NUMBERS_SHOWN:
        return np.arange(1, budget + 1)
    half = NUMBERS_SHOWN // 2
    spread = np.concatenate([np.linspace(1, budget, half), np.geomspace(1, budget, half)])
    return np.unique(np.round(spread).astype(np.int64))


def _curve(measure: Measure, curves: FloatArray, generator: np.random.Generator) -> dict[str, list[float | None]]:
    lower, median, upper = quantile_bands(curves)
    low, high = bootstrap_median_band(curves, generator, CONFIDENCE)
    names = ("median", "lower", "upper", "confidence_lower", "confidence_upper")
    ordered = (lower, upper, low, high) if not measure.quantity.maximised else (upper, lower, high, low)
    return {name: plain(measure.natural(row)) for name, row in zip(names, (median, *ordered), strict=True)}


def _fixed_budget(data: Compared) -> list[dict[str, Any]]:
    """Median and quartiles of the best value at fractions of the budget, by strategy."""
    rows = []
    for strategy, curves in data.curves.items():
        numbers = np.array([max(1, math.ceil(fraction * curves.shape[1] - 1e-9)) for fraction in BUDGET_FRACTIONS])
        bands = data.measure.natural(quantile_bands(curves[:, numbers - 1]))
        lower, median, upper = bands[::-1] if data.measure.quantity.maximised else bands
        places = zip(BUDGET_FRACTIONS, numbers.tolist(), plain(median), plain(lower), plain(upper), strict=True)
        keys = ("fraction", "evaluations", "median", "lower", "upper")
        rows.append({"strategy": strategy, "places": [dict(zip(keys, place, strict=True)) for place in places]})
    return rows


def _targets(data: Compared, numbers: Numbers) -> dict[str, Any] | None:
    """Targets with what they were made from, the share of them reached over the evaluations, expected running times."""
    targets = data.targets
    if not targets.values.size:
        return None
    lengths, budget = data.runlengths, next(iter(data.curves.values())).shape[1]
    natural = data.measure.natural
    return {
        "values": plain(natural(targets.values)),
        "fractions": plain(targets.fractions),
        "start": float(natural(np.array(targets.start))),
        "best": float(natural(np.array(targets.best))),
        "ecdf": {strategy: plain(runlength_ecdf(length, numbers)) for strategy, length in lengths.items()},
        "expected_running_time": {
            strategy: plain(expected_running_time(length, budget)) for strategy, length in lengths.items()
        },
        "successes": {strategy: np.isfinite(length).sum(axis=0).tolist() for strategy, length in lengths.items()},
    }


def _pairwise(data: Compared) -> dict[str, Any] | None:
    """The rank-sum tests of all pairs; None for one strategy or one repetition."""
    if len(data.curves) < 2 or len(data.repetitions) < 2:
        return None
    tests = pairwise_comparison(data.finals)
    return {
        "strategies": data.strategies,
        "p_values": tests.p_values.tolist(),
        "adjusted": tests.adjusted.tolist(),
        "effect": tests.effect.tolist(),
        "level": LEVEL,
        "smallest_adjusted": smallest_adjusted(len(data.curves), len(data.repetitions)),
    }


def smallest_adjusted(strategies: int, repetitions: int) -> float:
    """The smallest adjusted p-value that the rank-sum test can give one pair: 2/C(2r, r) times the number of pairs."""
    return min(1.0, 2.0 / math.comb(2 * repetitions, repetitions) * math.comb(strategies, 2))


def attainment_document(results: CampaignResults, data: Compared, signs: FloatArray) -> dict[str, list[list[list[float]]]]:
    """For each strategy and attainment fraction the corners (p, 2) of what so many repetitions attain, thinned.

    signs: (2,), −1 for an objective that is maximised. Every corner kept is a corner of the whole surface.
    """
    surfaces = {}
    for strategy in data.strategies:
        fronts = [
            _front(results.records[Cell(data.label, strategy, number)], results.campaign.budget)
            for number in data.repetitions
        ]
        levels = attainment_surface(fronts, ATTAINMENT_FRACTIONS)
        surfaces[strategy] = [(signs * thinned(corners)).tolist() for corners in levels]
    return surfaces


def front_distance_document(results: CampaignResults, data: Compared, front: FloatArray | None) -> dict[str, Any]:
    """For each strategy median and quartiles of the final IGD+ to the problem's known front (q, m), as it is minimised.

    Objectives are scaled by the box of the hypervolume. Empty without a known front or several objectives.
    """
    box = data.measure.box
    if front is None or box is None:
        return {}
    width = box.reference - box.ideal
    distances = {}
    for strategy in data.strategies:
        cells = [Cell(data.label, strategy, number) for number in data.repetitions]
        found = [_front(results.records[cell], results.campaign.budget) / width for cell in cells]
        values = np.array([[igd_plus(front_of_run, front / width)] for front_of_run in found])
        lower, median, upper = plain(quantile_bands(values)[:, 0])
        distances[strategy] = {"median": median, "lower": lower, "upper": upper}
    return distances


def thinned(corners: FloatArray) -> FloatArray:
    """At most CORNERS_SHOWN of the corners (p, 2), evenly by their order, the ends among them."""
    if len(corners) <= CORNERS_SHOWN:
        return corners
    rows = np.unique(np.round(np.linspace(0, len(corners) - 1, CORNERS_SHOWN)).astype(int))
    kept: FloatArray = corners[rows]
    return kept


def plain(values: FloatArray) -> list[float | None]:
    """Numbers as a list, null for what is not finite."""
    return [float(value) if math.isfinite(value) else None for value in values]


def _front(record: CellRecord, budget: int) -> FloatArray:
    feasible = record.objectives[:budget][record.feasible[:budget]]
    front: FloatArray = feasible[non_dominated(feasible)] if len(feasible) else feasible
    return front
