"""The tables of a campaign's report."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from railsearch.report.markup import (
    Markup,
    Row,
    escaped,
    labelled,
    table,
)
from railsearch.wording import readable

Entry = Mapping[str, Any]
TARGETS_SHOWN = 5
SORTABLE = "sortable"


def overview_table(document: Entry, anchors: Mapping[str, str]) -> str:
    """Strategies over problems: medians of the best value; anchors: where each problem's section is."""
    problems, ranking = document["problems"], document["ranking"]
    titles: list[object] = ["strategy"]
    titles += [_problem_title(entry, anchors[entry["label"]]) for entry in problems]
    names = _by_rank(document)
    rows = [[name, *(overview_cell(entry, name) for entry in problems)] for name in names]
    if ranking is not None:
        titles += ["mean rank", "best rank in"]
        rows = [[*row, *_rank_cells(ranking, name)] for name, row in zip(names, rows, strict=True)]
    return table(titles, rows, numbers=range(1, len(titles)), kind=SORTABLE)


def overview_cell(entry: Entry, strategy: str) -> object:
    """The final median with its quartiles, bold for the best, with ≈ for one that cannot be told from the best."""
    if strategy in entry["not_applicable"]:
        return "n/a"
    place = final_place(entry, strategy)
    if place is None:
        return "–"
    value = four(place["median"])
    shown = (
        f"<b>{value}</b> ★" if strategy == entry["leader"] else f"{value} ≈" if _equal_to_best(entry, strategy) else value
    )
    return Markup(f"{shown}<small>{spread_words(place)}</small>")


def final_place(entry: Entry, strategy: str) -> Entry | None:
    """The last column of the fixed-budget table of a strategy; None if it is not compared."""
    return next((row["places"][-1] for row in entry["fixed_budget"] if row["strategy"] == strategy), None)


def fixed_budget_table(entry: Entry) -> str:
    """Median and quartiles of the best value at fractions of the budget, the best strategy first."""
    rows = {row["strategy"]: row["places"] for row in entry["fixed_budget"]}
    first = next(iter(rows.values()))
    titles = ["strategy", *(f"{100 * place['fraction']:g} % ({place['evaluations']})" for place in first)]
    cells = [[name, *(_median_cell(place) for place in rows[name])] for name in by_final(entry)]
    marked = [name == entry["leader"] for name in by_final(entry)]
    return table(titles, cells, numbers=range(1, len(titles)), marked=marked, kind=SORTABLE)


def pairwise_table(entry: Entry) -> str:
    """A12 of row against column with the adjusted p-value; significant ones marked by shade and triangle."""
    tests, names = entry["pairwise"], by_final(entry)
    places = {name: place for place, name in enumerate(tests["strategies"])}
    head = "".join(f'<th class="number">{escaped(name)}</th>' for name in names)
    lines = []
    for row in names:
        cells = "".join(_pair_cell(tests, places[row], places[column]) for column in names)
        lines.append(f"<tr><th>{escaped(row)}</th>{cells}</tr>")
    return (
        f'<div class="scroll"><table class="matrix"><thead><tr><th>A12</th>{head}</tr></thead>\n<tbody>\n'
        + "\n".join(lines)
        + "\n</tbody></table></div>"
    )


def front_distance_table(entry: Entry) -> str:
    """The distance IGD+ of every strategy's fronts from the problem's known front, the closest first."""
    distances = entry["front_distance"]
    order = sorted(distances, key=lambda name: (distances[name]["median"] is None, distances[name]["median"] or 0.0))
    return table(
        ["strategy", "IGD+"], [[name, _median_cell(distances[name])] for name in order], numbers=(1,), kind=SORTABLE
    )


def running_time_table(entry: Entry) -> str:
    """Expected running times to some of the targets, with how many repetitions reach them."""
    targets, runs = entry["targets"], len(entry["repetitions"])
    count = len(targets["values"])
    shown = sorted({round((step + 1) * count / TARGETS_SHOWN) - 1 for step in range(TARGETS_SHOWN)})
    titles = ["strategy", *(f"{four(targets['values'][place])} ({_way(targets['fractions'][place])})" for place in shown)]
    rows = [
        [
            name,
            *(
                _time_cell(targets["expected_running_time"][name][place], targets["successes"][name][place], runs)
                for place in shown
            ),
        ]
        for name in by_final(entry)
    ]
    return table(titles, rows, numbers=range(1, len(titles)), kind=SORTABLE)


def cells_table(entry: Entry) -> str:
    """Runs, evaluations, failures and times of every strategy on one problem."""
    titles = ["strategy", "runs finished", "evaluations", "failed", "infeasible", "evaluation [s]", "strategy's own [s]"]
    rows = [
        [
            cell["strategy"],
            f"{cell['complete']} of {cell['planned']}" if cell["planned"] else "n/a",
            cell["evaluations"],
            cell["failed"],
            cell["infeasible"],
            four(cell["evaluation_seconds"]),
            four(cell["overhead_seconds"]),
        ]
        for cell in entry["cells"]
    ]
    return table(titles, rows, numbers=range(1, len(titles)), kind=SORTABLE)


def failures_table(problems: Iterable[Entry]) -> str:
    """Why evaluations failed, the most frequent reasons; empty if none did."""
    rows = [
        [entry["label"], cell["strategy"], reason["count"], reason["reason"]]
        for entry in problems
        for cell in entry["cells"]
        for reason in cell["reasons"]
    ]
    if not rows:
        return "<p>No evaluation failed.</p>"
    return table(["problem", "strategy", "failed", "reason"], rows, numbers=(2,), kind=SORTABLE)


def by_final(entry: Entry) -> list[str]:
    """The compared strategies, the best final median first, those without one last."""
    sign = -1.0 if entry["measure"]["maximised"] else 1.0
    finals = {row["strategy"]: row["places"][-1]["median"] for row in entry["fixed_budget"]}
    return sorted(finals, key=lambda name: (finals[name] is None, sign * (finals[name] or 0.0)))


def four(value: float | None) -> str:
    """A number with four significant digits, a dash for nothing."""
    return readable(None) if value is None else f"{value:.4g}"


def spread_words(place: Entry) -> str:
    """The quartiles of a place in the fixed-budget table."""
    return f"{four(place['lower'])} … {four(place['upper'])}"


def _median_cell(place: Entry) -> Markup:
    return Markup(f"{four(place['median'])}<small>{spread_words(place)}</small>")


def _problem_title(entry: Entry, anchor: str) -> Markup:
    return Markup(f'<a href="#{anchor}">{escaped(entry["label"])}</a><small>{escaped(labelled(entry["measure"]))}</small>')


def _by_rank(document: Entry) -> list[str]:
    """All strategies, by mean rank where there is one, otherwise by the first problem, otherwise as they were named."""
    names = [strategy["label"] for strategy in document["campaign"]["strategies"]]
    ranking, problems = document["ranking"], document["problems"]
    if ranking is not None:
        order = [name for _, name in sorted(zip(ranking["mean_ranks"], ranking["strategies"], strict=True))]
    else:
        order = by_final(problems[0])
    return order + [name for name in names if name not in order]


def _rank_cells(ranking: Entry, name: str) -> list[object]:
    if name not in ranking["strategies"]:
        return ["–", "–"]
    place = ranking["strategies"].index(name)
    return [f"{ranking['mean_ranks'][place]:.2f}", f"{100.0 * ranking['probability_best'][place]:.0f} %"]


def _equal_to_best(entry: Entry, strategy: str) -> bool:
    tests = entry["pairwise"]
    if tests is None or entry["leader"] is None:
        return False
    row, column = tests["strategies"].index(entry["leader"]), tests["strategies"].index(strategy)
    return bool(tests["adjusted"][row][column] >= tests["level"])


def _pair_cell(tests: Entry, row: int, column: int) -> str:
    if row == column:
        return "<td></td>"
    effect, p_value = tests["effect"][row][column], tests["adjusted"][row][column]
    significant = p_value < tests["level"] and effect != 0.5
    better = effect > 0.5
    kind = (" better" if better else " worse") if significant else ""
    mark = ("▲ " if better else "▼ ") if significant else ""
    return f'<td class="number{kind}">{mark}{effect:.2f}<small>p {p_words(p_value)}</small></td>'


def p_words(p_value: float) -> str:
    """A p-value with two digits, below 0.001 as a bound."""
    return "&lt; 0.001" if p_value < 0.001 else f"{p_value:.2g}"


def _way(fraction: float) -> str:
    return f"{100.0 * (1.0 - fraction):.3g} % of the way"


def _time_cell(time: float | None, successes: int, runs: int) -> Markup:
    return Markup(f"{'–' if time is None else f'{time:.0f}'}<small>{successes} of {runs}</small>")


def settings_rows(pairs: Sequence[tuple[str, Mapping[str, Any]]]) -> list[Row]:
    """Names with their settings in words."""
    return [[name, ", ".join(f"{key} = {value}" for key, value in values.items()) or "defaults"] for name, values in pairs]
