"""Result tables for the terminal."""

from typing import Any

from rich.console import RenderableType
from rich.table import Table

from railsearch.wording import candidate_marks, none_feasible, outside, preference_words, quantity_label, readable

FRONT_ROWS = 12


def result_tables(found: dict[str, Any]) -> list[RenderableType]:
    """Reference against best design: quantities with the improvement, variables, and the front if there is one."""
    tables: list[RenderableType] = [quantities_table(found), variables_table(found)]
    if found["preferences"]:
        tables.insert(1, preference_scores_table(found))
    if len(found["problem"]["objectives"]) > 1:
        tables.append(_front(found))
    if found.get("findings"):
        tables.append(_findings(found))
    return tables


def preference_scores_table(found: dict[str, Any]) -> Table:
    """Preference functions with the scores of the reference and the best design."""
    rows = found["preferences"]
    table = Table("quantity", "preference", "outside", box=None, pad_edge=False)
    for column in ("weight", *(f"score, {label}" for label in rows[0]["scores"])):
        table.add_column(column, justify="right")
    for row in rows:
        who = f"{row['stakeholder']}: " if row["stakeholder"] else ""
        cells = [readable(value) for value in (row["weight"], *row["scores"].values())]
        table.add_row(who + quantity_label(row["quantity"], row["unit"]), preference_words(row), outside(row), *cells)
    return table


def quantities_table(found: dict[str, Any]) -> Table:
    """Objectives and metrics of the reference and the best design, with the improvement."""
    table = Table(box=None, pad_edge=False)
    for column in ("quantity", "reference", "best", "better by [%]"):
        table.add_column(column, justify="left" if column == "quantity" else "right")
    problem = found["problem"]
    rows = {quantity["name"]: quantity for quantity in (*problem["objectives"], *problem["metrics"])}
    for name, quantity in rows.items():
        gain = found["improvement"].get(name)
        table.add_row(
            quantity_label(name, quantity["unit"]),
            readable(_value(found["reference"], name)),
            readable(_value(found["best"], name)),
            "" if gain is None else f"{gain:+.1f}",
        )
    return table


def variables_table(found: dict[str, Any]) -> Table:
    """The variables of the reference and the best design."""
    table = Table(box=None, pad_edge=False)
    for column in ("variable", "reference", "best", "meaning"):
        table.add_column(column, justify="right" if column in ("reference", "best") else "left")
    for variable in found["problem"]["variables"]:
        name = variable["name"]
        cells = [readable(found[which] and found[which]["design"][name]) for which in ("reference", "best")]
        table.add_row(quantity_label(name, variable["unit"]), *cells, variable["meaning"])
    return table


def ranking_table(found: dict[str, Any]) -> Table:
    """The candidates of a choice by rank: scalar, scores, objectives, and what else speaks for them."""
    whose = [f"{row['stakeholder']}: " if row["stakeholder"] else "" for row in found["preferences"]]
    columns = ["rank", "evaluation", found["scalariser"]]
    columns += [f"{who}score {row['quantity']}" for who, row in zip(whose, found["preferences"], strict=True)]
    columns += [quantity_label(q["name"], q["unit"]) for q in found["problem"]["objectives"]]
    table = Table(box=None, pad_edge=False, title="ranking", title_justify="left")
    for column in (*columns, "pseudo-weights"):
        table.add_column(column, justify="right")
    table.add_column("")
    for candidate in found["ranking"]:
        values = [candidate["scalar"], *candidate["scores"], *candidate["objectives"].values()]
        weights = candidate["pseudo_weights"]
        shown = ", ".join(f"{weight:.2f}" for weight in weights.values()) if weights else "–"
        places = (str(candidate["rank"]), str(candidate["number"]))
        table.add_row(*places, *map(readable, values), shown, candidate_marks(candidate))
    return table


def _front(found: dict[str, Any]) -> Table:
    names = [quantity_label(q["name"], q["unit"]) for q in found["problem"]["objectives"]]
    variables = [variable["name"] for variable in found["problem"]["variables"]]
    members = sorted(found["front"], key=lambda member: next(iter(member["objectives"].values())))
    listed = members[:: max(1, -(-len(members) // FRONT_ROWS))]
    fewer = len(listed) < len(members)
    title = f"front: {len(listed)} of its {len(members)} designs, all are in result.json" if fewer else "front"
    table = Table("evaluation", *names, *variables, box=None, pad_edge=False, title=title, title_justify="left")
    for member in listed:
        values = [*member["objectives"].values(), *member["design"].values()]
        table.add_row(str(member["number"]), *(readable(value) for value in values))
    return table


def _findings(found: dict[str, Any]) -> Table:
    table = Table("finding", box=None, pad_edge=False)
    table.add_column("value", justify="right")
    table.add_column("meaning")
    for finding in found["findings"]:
        table.add_row(quantity_label(finding["name"], finding["unit"]), readable(finding["value"]), finding["meaning"])
    return table


def sentence(found: dict[str, Any]) -> str:
    """How much was evaluated, and how the best design came about."""
    best = found["best"]
    place = (
        f"best at evaluation {best['number']} ({best['origin']})" if best else none_feasible(found) or "no feasible design"
    )
    if len(found["problem"]["objectives"]) > 1 and best:
        place = (
            f"front of {len(found['front'])} designs; shown as best is the one whose worst objective is best ({place[8:]})"
        )
    return (
        f"{found['status']}: {len(found['evaluations'])} of {found['budget']} evaluations, {found['failed']} failed, "
        f"seed {found['seed']}, {found['seconds']:.1f} s; {place}"
    )


def _value(evaluation: dict[str, Any] | None, name: str) -> float | None:
    if evaluation is None:
        return None
    values: dict[str, float | None] = evaluation["objectives"] | evaluation["metrics"]
    return values.get(name)
