"""The report of a run: one HTML page that needs nothing beside itself, for the screen, the phone and the printer."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from railsearch.report.design_tables import preferences_table, quantities_table, variables_table
from railsearch.report.markup import (
    escaped,
    labelled,
    page,
    picture,
    section,
    table,
)
from railsearch.run_directory import write_whole
from railsearch.wording import none_feasible, readable

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FAILURES_LISTED = 20


def write_report(path: Path, document: Mapping[str, Any], figures: Mapping[str, Figure]) -> None:
    """Write the report of a result document with its figures. Raises StorageError if it cannot be written."""
    write_whole(path, report_page(document, figures).encode("utf-8"))


def report_page(document: Mapping[str, Any], figures: Mapping[str, Figure]) -> str:
    """The HTML text of a report."""
    sections = [
        section("Result", quantities_table(document, _searched(document))),
        section("Design", variables_table(document)),
        *(picture(name, figure) for name, figure in figures.items()),
        *([section("What the strategy found out", _findings(document))] if document.get("findings") else []),
        section("How the designs came about", _origins(document)),
        section("To repeat it", _provenance(document)),
    ]
    if len(document["problem"]["objectives"]) > 1:
        sections.insert(2, section("Front", _front(document)))
    if document["preferences"]:
        sections.insert(1, section("Preferences", preferences_table(document["preferences"])))
    if document["warnings"]:
        sections.insert(0, section("Warning", "".join(f"<p>{escaped(warning)}.</p>" for warning in document["warnings"])))
    return page(document["problem"]["label"], _summary(document), sections)


def _summary(document: Mapping[str, Any]) -> str:
    gains = [
        f"{name} {'better' if gain >= 0.0 else 'worse'} by {abs(gain):.1f} %"
        for name, gain in document["improvement"].items()
        if gain is not None and name in _searched(document)
    ]
    found = f"Compared with the reference design, the best one has {' and '.join(gains)}." if gains else ""
    counted = (
        f"{len(document['evaluations'])} of {document['budget']} evaluations with strategy {document['strategy']['name']}, "
        f"{document['failed']} of them failed"
    )
    infeasible = none_feasible(document)
    return f"{counted}: {infeasible}." if infeasible else f"{counted}. {found}".strip()


def _searched(document: Mapping[str, Any]) -> list[str]:
    """Names of the objectives, behind the scalar too."""
    scalariser = document["scalariser"]
    own = [objective["name"] for objective in document["problem"]["objectives"]]
    return own + (scalariser["objectives"] if scalariser else [])


def _front(document: Mapping[str, Any]) -> str:
    problem = document["problem"]
    titles = [labelled(quantity) for quantity in (*problem["objectives"], *problem["variables"])]
    members = sorted(document["front"], key=lambda member: list(member["objectives"].values()))
    rows = [
        [member["number"], *map(readable, member["objectives"].values()), *map(readable, member["design"].values())]
        for member in members
    ]
    best = document["best"]
    which = f"<p>The best one above is evaluation {best['number']}: its worst objective is best.</p>" if best else ""
    return which + table(["evaluation", *titles], rows, numbers=range(len(titles) + 1))


def _findings(document: Mapping[str, Any]) -> str:
    rows = [[labelled(finding), readable(finding["value"]), finding["meaning"]] for finding in document["findings"]]
    return table(["finding", "value", "meaning"], rows, numbers=(1,))


def _origins(document: Mapping[str, Any]) -> str:
    evaluations = document["evaluations"]
    counts = Counter(evaluation["origin"] for evaluation in evaluations)
    starts = {evaluation["trajectory"]: evaluation["number"] for evaluation in reversed(evaluations)}
    restarts = ", ".join(f"{number}" for trajectory, number in sorted(starts.items()) if trajectory > 0)
    failures = [[row["number"], row["origin"], row["reason"]] for row in evaluations if row["reason"]]
    parts = [
        table(["origin", "evaluations"], [[origin, str(count)] for origin, count in counts.most_common()], numbers=(1,)),
        f"<p>Resets at evaluation: {restarts or 'none'}. Designs asked for again and answered from memory, free of charge: "
        f"{document['repeats']}. Simulation and search took {document['seconds']:.1f} s.</p>",
    ]
    if failures:
        listed = f"<p>{len(failures)} evaluations failed" + (
            ", the first of them:" if len(failures) > FAILURES_LISTED else ":"
        )
        parts += [listed + "</p>", table(["evaluation", "origin", "reason"], failures[:FAILURES_LISTED], numbers=(0,))]
    return "\n".join(parts)


def _provenance(document: Mapping[str, Any]) -> str:
    strategy, scalariser = document["strategy"], document["scalariser"]
    settings = [[f"{strategy['name']}: {name}", value] for name, value in strategy["settings"].items()]
    if scalariser:
        used = {name: value for name, value in scalariser["values"].items() if name != "preferences"}
        settings += [[f"{scalariser['name']}: {name}", value] for name, value in used.items()]
    plugins = [[p["kind"], p["name"], p["module"], f"{p['distribution']} {p['version']}"] for p in document["plugins"]]
    return "\n".join(
        (
            f"<pre>{escaped(document['command'])}</pre>",
            f"<p>Seed {document['seed']}. Everything about the run, every evaluation included, is in result.json.</p>",
            table(["setting", "value"], [[name, "not given" if value is None else value] for name, value in settings]),
            table(["plugin", "name", "module", "from"], plugins),
            table(["library", "version"], list(document["versions"].items())),
        )
    )
