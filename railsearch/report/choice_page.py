"""The page of a choice: the chosen design beside the reference, the preferences, and the candidates ranked."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from railsearch.choice import Choice, choice_document
from railsearch.report.design_tables import preferences_table, quantities_table, variables_table
from railsearch.report.markup import escaped, labelled, page, picture, section, table
from railsearch.report.preferences import preference_figure
from railsearch.result import values_of
from railsearch.wording import candidate_marks, readable

MEANINGS = (
    "Nearest pseudo-weights: the design of the front that serves the objectives in the proportions of the stated weights. "
    "High trade-off: a design from which every neighbour on the front costs much and gains little."
)


def choice_page(choice: Choice, title: str, command: str) -> str:
    """The HTML text of the page; command: how to make it again."""
    document = choice_document(choice)
    searched = [objective["name"] for objective in document["problem"]["objectives"]]
    best = document["best"]
    summary = (
        f"Of {document['candidates']} designs that no other one dominates, among {document['evaluations']} evaluations, "
        f"{choice.scalariser} chooses evaluation {best['number']}: scores {', '.join(_scores(document))}."
    )
    parts = [
        section("Chosen design", quantities_table(document, searched) + variables_table(document)),
        section("Preferences", preferences_table(document["preferences"])),
        picture("preferences", _figure(choice)),
        section("Ranking", _ranking(document) + f"<p>{MEANINGS}</p>"),
        section("To repeat it", f"<pre>{escaped(command)}</pre>"),
    ]
    return page(title, summary, parts)


def _scores(document: Mapping[str, Any]) -> list[str]:
    rows = document["preferences"]
    return [f"{_whose(row)}{row['quantity']} {readable(row['scores']['best'])}" for row in rows]


def _whose(row: Mapping[str, Any]) -> str:
    return f"{row['stakeholder']}: " if row["stakeholder"] else ""


def _figure(choice: Choice) -> Figure:
    designs = {"reference": choice.reference, "best": choice.candidates[0]}
    values = {label: values_of(choice.problem, design) for label, design in designs.items() if design is not None}
    rows = [values_of(choice.problem, candidate) for candidate in choice.candidates[1:]]
    names = {preference.quantity.name for preference in choice.preferences}
    return preference_figure(choice.preferences, values, {name: np.array([row[name] for row in rows]) for name in names})


def _ranking(document: Mapping[str, Any]) -> str:
    problem, preferences = document["problem"], document["preferences"]
    titles: Sequence[str] = [
        "rank",
        "evaluation",
        document["scalariser"],
        *(f"{_whose(row)}score of {row['quantity']}" for row in preferences),
        *(labelled(quantity) for quantity in (*problem["objectives"], *problem["variables"])),
        *(f"pseudo-weight of {objective['name']}" for objective in problem["objectives"]),
        "",
    ]
    rows = [_row(candidate, len(problem["objectives"])) for candidate in document["ranking"]]
    return table(titles, rows, numbers=range(len(titles)), marked=[True])


def _row(candidate: Mapping[str, Any], n_objectives: int) -> list[object]:
    weights = candidate["pseudo_weights"]
    shown = [f"{weight:.2f}" for weight in weights.values()] if weights else ["–"] * n_objectives
    numbers = (candidate["scalar"], *candidate["scores"], *candidate["objectives"].values(), *candidate["design"].values())
    return [candidate["rank"], candidate["number"], *map(readable, numbers), *shown, candidate_marks(candidate)]
