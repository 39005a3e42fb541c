"""How participants stand to one another over problems whose values cannot be compared.

| symbol | meaning | shape | unit |
|---|---|---|---|
| b | budgets | (3,) | evaluations |
| x | best value of a run after b evaluations, minimised | (3,) | of the objective |
| f* | best known value of its problem | scalar | of the objective |
| m | median over the repetitions of what random search has found after b evaluations | (3,) | of the objective |
| S | score of a run, min(2, (x − f*)/(m − f*)): 0 the best known, 1 like random search | (3,) | - |
| R | mean S of a participant over that of the reference, over the runs that both have | (3,) | - |
| W | share of these in which x is better than the reference's; equal ones count half | (3,) | - |
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

from railsearch.errors import InputError
from railsearch.space import FloatArray
from railsearch.statistics import Friedman, friedman, holm, pairwise_comparison
from railsearch_peers.cells import BUDGETS, CellResult

REFERENCE = "pysot-dycors"
FLOOR = "random"
CAP = 2.0
LEVEL = 0.05

Key = tuple[str, str, int]


@dataclass(frozen=True)
class Standing:
    """A participant beside the reference: the number of runs of both, its mean S, R, W, and p over the problems.

    significant: on how many problems its final values are better, and worse, than the reference's (rank-sum test, Holm's
    adjustment over the participants); p_value: of the signed-rank test of the differences of mean scores of the problems at
    each budget, adjusted likewise.
    """

    strategy: str
    runs: int
    problems: int
    mean: FloatArray
    ratio: FloatArray
    wins: FloatArray
    p_value: FloatArray
    significant: tuple[int, int]


@dataclass(frozen=True)
class Ranking:
    """Mean ranks (3, k) of k participants over the problems on which all of them have runs of the same repetitions."""

    strategies: tuple[str, ...]
    problems: tuple[str, ...]
    runs: int
    ranks: tuple[Friedman, ...]


def score(best: FloatArray, best_known: float, floor: FloatArray) -> FloatArray:
    """S of best values x (…, 3) for m (3,). Raises InputError where random search is as good as the best known value."""
    if not np.all(floor > best_known):
        raise InputError(f"score: random search must be worse than the best known value {best_known}, received {floor}")
    scaled: FloatArray = np.minimum(CAP, (best - best_known) / (floor - best_known))
    return scaled


def scored(cells: Sequence[CellResult], best_known: Mapping[str, float]) -> dict[Key, FloatArray]:
    """S of every run, by its key; problems without a run of random search are left out."""
    scores: dict[Key, FloatArray] = {}
    for problem in {cell.problem for cell in cells}:
        own = [cell for cell in cells if cell.problem == problem]
        floors = [cell.best for cell in own if cell.strategy == FLOOR]
        if floors:
            floor = np.median(np.array(floors), axis=0)
            scores |= {cell.key: score(np.array(cell.best), best_known[problem], floor) for cell in own}
    return scores


def standings(cells: Sequence[CellResult], best_known: Mapping[str, float]) -> list[Standing]:
    """All participants that have runs beside the reference, and itself, in the order of their ratio at the full budget."""
    scores = scored(cells, best_known)
    best = {cell.key: np.array(cell.best) for cell in cells}
    pairs = {name: _pairs(scores, name) for name in sorted({strategy for _, strategy, _ in scores})}
    pairs = {name: own for name, own in pairs.items() if own}
    others = {name: own for name, own in pairs.items() if name != REFERENCE}
    p_values = {REFERENCE: np.ones(len(BUDGETS)), **_signed_ranks(scores, others)}
    counts = {REFERENCE: (0, 0), **_significant(best, others)}
    found = [_standing(name, own, scores, best, p_values[name], counts[name]) for name, own in pairs.items()]
    return sorted(found, key=lambda standing: standing.ratio[-1])


def ranking(cells: Sequence[CellResult], strategies: Iterable[str]) -> Ranking | None:
    """Ranks by the medians over the repetitions that all of these participants have; None without such a problem."""
    names = tuple(strategies)
    best = {cell.key: cell.best for cell in cells}
    tables, problems, runs = [], [], 0
    for problem in sorted({cell.problem for cell in cells}):
        common = _common(best, problem, names)
        if common:
            tables.append([np.median([best[problem, name, k] for k in common], axis=0) for name in names])
            problems.append(problem)
            runs += len(common)
    if not problems:
        return None
    medians = np.array(tables)
    return Ranking(names, tuple(problems), runs, tuple(friedman(medians[..., b], LEVEL) for b in range(len(BUDGETS))))


def _common(best: Mapping[Key, object], problem: str, names: Sequence[str]) -> list[int]:
    """The repetitions of a problem that all participants have."""
    found = [{k for place, name, k in best if (place, name) == (problem, wanted)} for wanted in names]
    return sorted(set.intersection(*found))


def _pairs(scores: Mapping[Key, FloatArray], name: str) -> list[tuple[Key, Key]]:
    """The runs of a participant, each with that of the reference."""
    pairs = [((problem, name, k), (problem, REFERENCE, k)) for problem, other, k in sorted(scores) if other == name]
    return [pair for pair in pairs if pair[1] in scores]


def _standing(
    name: str,
    pairs: Sequence[tuple[Key, Key]],
    scores: Mapping[Key, FloatArray],
    best: Mapping[Key, FloatArray],
    p_value: FloatArray,
    significant: tuple[int, int],
) -> Standing:
    mean = np.mean([scores[own] for own, _ in pairs], axis=0)
    reference = np.mean([scores[other] for _, other in pairs], axis=0)
    wins = np.mean([(best[own] < best[other]) + 0.5 * (best[own] == best[other]) for own, other in pairs], axis=0)
    problems = len({own[0] for own, _ in pairs})
    with np.errstate(divide="ignore", invalid="ignore"):
        return Standing(name, len(pairs), problems, mean, mean / reference, wins, p_value, significant)


def _signed_ranks(scores: Mapping[Key, FloatArray], pairs: Mapping[str, Sequence[tuple[Key, Key]]]) -> dict[str, FloatArray]:
    """Adjusted p-values (3,) of the signed-rank test over the problems, by participant."""
    raw = np.array([_signed_rank(scores, own) for own in pairs.values()]).reshape(-1, len(BUDGETS))
    adjusted = np.column_stack([holm(column) for column in raw.T]) if len(raw) else raw
    return dict(zip(pairs, adjusted, strict=True))


def _signed_rank(scores: Mapping[Key, FloatArray], pairs: Sequence[tuple[Key, Key]]) -> list[float]:
    by_problem: dict[str, list[FloatArray]] = {}
    for own, other in pairs:
        by_problem.setdefault(own[0], []).append(scores[own] - scores[other])
    differences = np.array([np.mean(found, axis=0) for found in by_problem.values()])
    return [float(stats.wilcoxon(column).pvalue) if np.any(column) else 1.0 for column in differences.T]


def _significant(
    best: Mapping[Key, FloatArray], pairs: Mapping[str, Sequence[tuple[Key, Key]]]
) -> dict[str, tuple[int, int]]:
    """On how many problems participants are better, and worse, than the reference at the full budget."""
    counts = {name: [0, 0] for name in pairs}
    for problem in {own[0] for found in pairs.values() for own, _ in found}:
        for name, side in _sides(best, pairs, problem).items():
            counts[name][side] += 1
    return {name: (better, worse) for name, (better, worse) in counts.items()}


def _sides(best: Mapping[Key, FloatArray], pairs: Mapping[str, Sequence[tuple[Key, Key]]], problem: str) -> dict[str, int]:
    """Who differs from the reference on a problem: 0 for better, 1 for worse."""
    tests = {}
    for name, found in pairs.items():
        here = [(best[own][-1], best[other][-1]) for own, other in found if own[0] == problem]
        if here:
            tests[name] = pairwise_comparison([np.array(side) for side in zip(*here, strict=True)])
    adjusted = holm([test.p_values[0, 1] for test in tests.values()])
    return {
        name: 0 if test.effect[0, 1] > 0.5 else 1
        for (name, test), p in zip(tests.items(), adjusted, strict=True)
        if p < LEVEL
    }
