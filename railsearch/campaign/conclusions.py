"""What a campaign says, in plain words and with its uncertainty: from the documents of its problems and its ranking."""

from collections.abc import Mapping, Sequence
from itertools import count
from typing import Any

from railsearch.campaign.comparison import LEVEL, smallest_adjusted

Entry = Mapping[str, Any]
TEST = f"Wilcoxon rank-sum test with Holm's correction at {100.0 * LEVEL:g} %"


def campaign_conclusion(problems: Sequence[Entry], ranking: Entry | None, budget: int) -> str:
    """Which strategy to use at this budget, and how sure that is."""
    if ranking is not None:
        return _over_problems(problems, ranking, budget)
    if len(problems) == 1:
        return problem_conclusion(problems[0], budget)
    if not any(entry["compared"] for entry in problems):
        return "Nothing can be said yet: on no problem is a repetition complete."
    spoken = " ".join(problem_conclusion(entry, budget) for entry in problems if entry["compared"])
    return f"The strategies cannot be ranked over the problems, so each problem speaks for itself. {spoken}"


def problem_conclusion(entry: Entry, budget: int) -> str:
    """Which strategy was best on one problem, better than which others, and how sure that is."""
    strategies, runs = entry["compared"], len(entry["repetitions"])
    where = f"on {entry['label']}"
    if not strategies:
        return f"Nothing can be said {where} yet: no repetition is complete for all strategies that have begun."
    leader = leading(entry)
    if leader is None:
        return f"No strategy can be called better {where}: none found a feasible design in half of its repetitions."
    result = _result(entry, leader)
    if len(strategies) == 1:
        spread = f" ({_quartiles(entry, leader)}, {runs} repetitions)" if runs > 1 else ", in one repetition"
        return (
            f"{leader} alone was run {where}, so there is nothing to compare it with: its median after {budget} "
            f"evaluations is {result}{spread}."
        )
    if runs == 1:
        return (
            f"With one repetition nothing can be concluded {where}: {leader} ended best ({result}), which may be luck; "
            f"{_enough(len(strategies))}."
        )
    return _compared(entry, leader, f"{where}, with {budget} evaluations", result)


def leading(entry: Entry) -> str | None:
    """The strategy with the best final median, of equals the one that is best in most resamples; None without a value."""
    return max(best_medians(entry), key=lambda name: float(entry["probability_best"][name]), default=None)


def best_medians(entry: Entry) -> list[str]:
    """The strategies that have the best final median; none without a value."""
    finals = {row["strategy"]: row["places"][-1]["median"] for row in entry["fixed_budget"]}
    reached = {strategy: value for strategy, value in finals.items() if value is not None}
    best = (max if entry["measure"]["maximised"] else min)(reached.values(), default=None)
    return [name for name, value in reached.items() if value == best]


def beaten_by(entry: Entry, leader: str) -> list[str]:
    """The strategies that `leader` is significantly better than."""
    tests = entry["pairwise"]
    if tests is None:
        return []
    row = tests["strategies"].index(leader)
    return [
        name
        for column, name in enumerate(tests["strategies"])
        if tests["adjusted"][row][column] < tests["level"] and tests["effect"][row][column] > 0.5
    ]


def listed(names: Sequence[str]) -> str:
    """Names as words: a, b and c."""
    return " and ".join(filter(None, (", ".join(names[:-1]), names[-1]))) if names else "none"


def _compared(entry: Entry, leader: str, where: str, result: str) -> str:
    beaten = beaten_by(entry, leader)
    others = [name for name in entry["compared"] if name != leader and name not in beaten]
    share = (
        f"in {_resamples(entry['probability_best'][leader])} of the {len(entry['repetitions'])} repetitions {leader} has "
        "the best median"
    )
    held = f"{result}, {_quartiles(entry, leader)}"
    if not others:
        return f"{leader} is best {where}: median {held}, significantly better than {_all(beaten)} ({TEST}); {share}."
    if beaten:
        return (
            f"{leader} leads {where}: median {held}; it is significantly better than {listed(beaten)}, but not "
            f"distinguishable from {listed(others)} ({TEST}); {share}."
        )
    equals = best_medians(entry)
    has = f"{leader} has" if len(equals) == 1 else f"{listed(equals)} share"
    return f"{_undecided(entry)} {where}: {has} the best median ({held}), {_unproven(entry)}; {share}."


def _undecided(entry: Entry) -> str:
    tests = entry["pairwise"]
    different = any(value < tests["level"] for row in tests["adjusted"] for value in row)
    return "No strategy is distinguishable as the best" if different else "No strategy is distinguishable from the others"


def _unproven(entry: Entry) -> str:
    tests = entry["pairwise"]
    if tests["smallest_adjusted"] >= tests["level"]:
        runs = len(entry["repetitions"])
        return f"but {runs} repetitions are too few to show any difference: {_enough(len(tests['strategies']))} ({TEST})"
    return f"but is not significantly better than any other ({TEST})"


def _over_problems(problems: Sequence[Entry], ranking: Entry, budget: int) -> str:
    names, ranks, shares = ranking["strategies"], ranking["mean_ranks"], ranking["probability_best"]
    place = min(range(len(names)), key=lambda index: (ranks[index], -shares[index]))
    leader = names[place]
    among = [entry for entry in problems if entry["label"] in ranking["problems"]]
    clear = [entry["label"] for entry in among if set(names) - {leader} <= set(beaten_by(entry, leader))]
    facts = (
        f"mean rank {ranks[place]:.3g} of {len(names)}, best median on {ranking['wins'][place]} of {len(among)} problems"
        f"{_clearly(clear)}"
    )
    where = f"on {len(among)} problems, with {budget} evaluations each"
    if ranking["repetitions"] == 1:
        return (
            f"With one repetition nothing can be concluded {where}: {leader} is ahead ({facts}), which may be luck; "
            f"{_enough(len(names))}."
        )
    share = f"in {_resamples(shares[place])} of the repetitions it has the best mean rank"
    separated = _separated(ranking, place)
    if separated == [name for name in names if name != leader]:
        return f"{leader} is best {where}: {facts}, separated from all others by the critical difference of ranks; {share}."
    if clear or separated:
        return f"{leader} leads {where}: {facts}; {_limits(ranking, separated)}; {share}."
    return (
        f"No strategy is distinguishable as the best {where}: {leader} leads ({facts}), but {_limits(ranking, [])}; {share}."
    )


def _separated(ranking: Entry, place: int) -> list[str]:
    """The strategies whose mean rank lies further from the leader's than any group of indistinguishable ones reaches."""
    if ranking["untested"]:
        return []
    together = {place}.union(*(group for group in ranking["groups"] if place in group))
    return [name for index, name in enumerate(ranking["strategies"]) if index not in together]


def _limits(ranking: Entry, separated: Sequence[str]) -> str:
    if ranking["untested"]:
        return "ranks over the problems are not tested for two strategies"
    p_value = f"Friedman test, p = {ranking['p_value']:.3g}"
    if separated:
        return f"the critical difference of ranks separates it from {listed(separated)} ({p_value})"
    return f"the ranks over {len(ranking['problems'])} problems do not separate it from the others ({p_value})"


def _clearly(clear: Sequence[str]) -> str:
    return f", significantly better than every other strategy on {listed(clear)}" if clear else ""


def _all(beaten: Sequence[str]) -> str:
    return {1: beaten[0], 2: "both others"}.get(len(beaten), f"all {len(beaten)} others")


def _enough(strategies: int) -> str:
    """How many repetitions the pairwise test needs before it can show anything."""
    needed = next(runs for runs in count(2) if smallest_adjusted(strategies, runs) < LEVEL)
    return f"a difference among {strategies} strategies can be shown from {needed} repetitions on"


def _result(entry: Entry, strategy: str) -> str:
    return f"{entry['measure']['name']} {_final(entry, strategy, 'median')}{_unit(entry)}"


def _quartiles(entry: Entry, strategy: str) -> str:
    return f"quartiles {_final(entry, strategy, 'lower')} to {_final(entry, strategy, 'upper')}{_unit(entry)}"


def _final(entry: Entry, strategy: str, key: str) -> str:
    places = next(row["places"] for row in entry["fixed_budget"] if row["strategy"] == strategy)
    value = places[-1][key]
    return "none" if value is None else f"{value:.4g}"


def _unit(entry: Entry) -> str:
    unit = entry["measure"]["unit"]
    return f" {unit}" if unit else ""


def _resamples(share: float) -> str:
    """A share of the resamples in whole per cent; what is not all of them is not called so."""
    if share == 1.0:
        return "all resamples"
    return f"{'more than 99' if share > 0.99 else round(100.0 * share)} % of resamples"
