"""The report of a sensitivity analysis: one HTML page that needs nothing beside itself."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from railsearch.report.markup import escaped, labelled, page, picture, section, table
from railsearch.run_directory import write_whole
from railsearch.wording import readable

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Document = Mapping[str, Any]


def write_sensitivity_report(path: Path, document: Document, figures: Mapping[str, Mapping[str, Figure]]) -> None:
    """Write the report of a document with the figures of every output. Raises StorageError if it cannot be written."""
    write_whole(path, sensitivity_page(document, figures).encode("utf-8"))


def sensitivity_page(document: Document, figures: Mapping[str, Mapping[str, Figure]]) -> str:
    """The HTML text of a report."""
    criteria = document["criteria"]
    sections = [section("The outputs", _overview(criteria))]
    for criterion in criteria:
        name = criterion["name"]
        drawn = {kind: picture(f"{name}-{kind}", figure) for kind, figure in figures[name].items()}
        sections += [
            section(f"Which inputs move {labelled(criterion)}", drawn["importances"] + _importances(criterion), name),
            section(f"Its extremes over each input: {name}", drawn["extremes"]),
            section(f"Limits: {name}", _thresholds(criterion) + drawn["thresholds"]),
            section(f"How good the surrogate is: {name}", _quality(criterion) + drawn["surrogate"]),
        ]
    sections += [section("Inputs", _inputs(document)), section("To repeat it", _provenance(document))]
    return page(f"Sensitivity of {document['of']}", _summary(document), sections)


def _summary(document: Document) -> str:
    first = [
        f"{criterion['name']} by {', '.join(_leading(criterion['importances']))}"
        for criterion in document["criteria"]
        if any(criterion["importances"].values())
    ]
    return f"In the worst case {'; '.join(first)}." if first else "No input moves the extremes of any output."


def _leading(importances: Mapping[str, float]) -> list[str]:
    """The most important inputs, until they make up nine tenths, with their shares."""
    named, sum_so_far = [], 0.0
    for name in sorted(importances, key=lambda name: -importances[name]):
        if sum_so_far >= 0.9:
            break
        sum_so_far += importances[name]
        named.append(f"{name} ({importances[name]:.0%})")
    return named


def _overview(criteria: Any) -> str:
    titles = ["output", "samples", "left out", "error", "they reach", "extremes", "the model there", "check"]
    rows, warnings = [], []
    for criterion in criteria:
        samples, extremes = criterion["samples"], criterion["extremes"]["extremes"]
        rows.append(
            [
                labelled(criterion),
                samples["used"],
                samples["failed"] + samples["repeated"],
                f"{criterion['surrogate']['generalisation']:.1e}",
                f"{readable(samples['minimum'])} to {readable(samples['maximum'])}",
                f"{readable(extremes['minimum'])} to {readable(extremes['maximum'])}",
                _confirmed(criterion["confirmed"]),
                _check(criterion["extremes"]["effort"]["check"]),
            ]
        )
        warnings += [f"{criterion['name']}: {warning}" for warning in criterion["warnings"]]
    listed = "".join(f"<li>{escaped(warning)}</li>" for warning in warnings)
    words = "<p>Error: of the surrogate on samples it had not seen, of the variance.</p>"
    return table(titles, rows, numbers=range(1, 7)) + words + (f"<ul>{listed}</ul>" if warnings else "")


def _confirmed(confirmed: Document) -> str:
    """The model's values where the surrogate has its extremes."""
    if not confirmed:
        return "not asked"
    values = [confirmed[sense]["model"] for sense in ("minimum", "maximum")]
    return " to ".join("failed" if value is None else readable(value) for value in values)


def _check(check: Document | None) -> str:
    if check is None or check["held"]:
        return "no random point of the surrogate is more extreme"
    return "a random point was more extreme at the end: raise the work"


def _importances(criterion: Document) -> str:
    importances, columns = criterion["importances"], _measures(criterion)
    order = sorted(importances, key=lambda name: -importances[name])
    places = [criterion["sobol"]["inputs"].index(name) for name in order]
    rows = [[name, *(cells[place] for cells in columns.values())] for name, place in zip(order, places, strict=True)]
    return table(["input", *columns], rows, numbers=range(1, len(columns) + 1))


def _measures(criterion: Document) -> dict[str, list[str]]:
    """Columns of the table of importances: a cell for each input in the order of the indices."""
    names, unit = criterion["sobol"]["inputs"], f" [{criterion['unit']}]" if criterion["unit"] else ""
    columns = {"worst case": [f"{criterion['importances'][name]:.2%}" for name in names]}
    if spread := criterion["spread"]:
        title = f"{spread['level']:.0%} of {spread['refits']} refits"
        columns[title] = [f"{row['lower']:.2%} to {row['upper']:.2%}" for row in spread["factors"]]
    columns |= {f"Sobol' {kind}": [f"{share:.2%}" for share in criterion["sobol"][kind]] for kind in ("first", "total")}
    shares = criterion["one_at_a_time"]["importances"]
    columns["one at a time"] = [f"{shares[name]:.2%}" for name in names]
    columns[f"mean |effect|{unit}"] = [readable(value) for value in criterion["morris"]["mean_absolute"]]
    columns["its deviation"] = [readable(value) for value in criterion["morris"]["deviation"]]
    if measures := criterion["on_model"]:
        for kind in ("first", "total"):
            pairs = zip(measures["sobol"][kind], measures["sobol"][f"{kind}_half_width"], strict=True)
            columns[f"Sobol' {kind}, model"] = [f"{share:.2%} ± {half:.2%}" for share, half in pairs]
        columns[f"mean |effect|, model{unit}"] = [readable(value) for value in measures["morris"]["mean_absolute"]]
    return columns


def _thresholds(criterion: Document) -> str:
    rows, units = [], {factor["name"]: factor["unit"] for factor in criterion["extremes"]["factors"]}
    for threshold in criterion["thresholds"]["thresholds"]:
        safe = [
            f"{factor['name']} in {_spans(factor['safe'])} {units[factor['name']]}".rstrip()
            for factor in threshold["factors"]
            if factor["critical"] and factor["safe"]
        ]
        rows.append([readable(threshold["value"]), threshold["status"], "; ".join(safe) or "by no input alone"])
    unit = f" [{criterion['unit']}]" if criterion["unit"] else ""
    titles = [f"threshold{unit}", "within the ranges", "kept out of reach, whatever the others are, with"]
    return table(titles, rows, numbers=(0,))


def _spans(intervals: Any) -> str:
    return " or ".join(f"{readable(low)} to {readable(high)}" for low, high in intervals)


def _quality(criterion: Document) -> str:
    quality = criterion["surrogate"]
    own = quality["leave_one_out"]
    rows = [
        ["samples it was fitted to", quality["samples"]],
        ["samples held out, with a fit to the others", quality["held_out"]],
        ["error on them, of the variance", f"{quality['generalisation']:.2e}"],
        ["leave-one-out error, of the variance", "not known" if own is None else f"{own:.2e}"],
        ["terms", "not an expansion" if quality["terms"] is None else quality["terms"]],
        ["seconds to fit", f"{quality['fit_seconds']:.2g}"],
        ["seconds per value", f"{quality['value_seconds']:.1e}"],
    ]
    return table(["surrogate", ""], rows, numbers=(1,))


def _inputs(document: Document) -> str:
    ranges = {factor["name"]: factor for factor in document["criteria"][0]["extremes"]["factors"]}
    rows = [
        [
            item["name"],
            item["unit"],
            item["distribution"],
            readable(ranges[item["name"]]["lower"]),
            readable(ranges[item["name"]]["upper"]),
            f"{len(ranges[item['name']]['grid'])} {ranges[item['name']]['spacing']}",
        ]
        for item in document["inputs"]
    ]
    return table(["input", "unit", "distribution", "from", "to", "grid values"], rows, numbers=(3, 4))


def _provenance(document: Document) -> str:
    surrogate, samples = document["surrogate"], document["samples"]
    settings = ", ".join(f"{name} = {value}" for name, value in surrogate["settings"].items()) or "its defaults"
    return "\n".join(
        (
            f"<pre>{escaped(document['command'])}</pre>",
            f"<p>Seed {document['seed']}; surrogate {escaped(surrogate['name'])} with {escaped(settings)}; "
            f"{samples['number']} samples in {escaped(samples['file'])}. All numbers are in sensitivity.json.</p>",
            table(["library", "version"], list(document["versions"].items())),
        )
    )
