"""The report of a run: one HTML page that needs nothing beside itself, for the screen, the phone and the printer."""

from __future__ import annotations

import html
import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING, Any

from railsearch.report.figures import drawn
from railsearch.run_directory import write_whole

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Row = Sequence[object]
FAILURES_LISTED = 20

PAGE = Template("""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>$title</title>
<style>
:root { color-scheme: light; }
body { font: 16px/1.5 system-ui, sans-serif; color: #1b1b1b; background: #fff; margin: 0 auto; max-width: 1080px; }
body { padding: 0 1rem 3rem; }
h1 { font-size: 1.7rem; line-height: 1.2; margin: 1.5rem 0 .5rem; }
h2 { font-size: 1.25rem; margin: 2.2rem 0 .6rem; }
.lead { font-size: 1.1rem; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
th, td { padding: .3rem .7rem .3rem 0; text-align: left; vertical-align: top; border-bottom: 1px solid #e2e2e2; }
th.number, td.number { text-align: right; white-space: nowrap; }
tr.objective td { font-weight: 600; }
figure { margin: 1rem 0 2rem; }
figure svg { width: 100%; height: auto; min-width: 640px; }
figcaption { color: #444; }
code, pre { font: 14px/1.4 ui-monospace, monospace; background: #f4f4f4; }
pre { padding: .7rem; overflow-x: auto; white-space: pre-wrap; overflow-wrap: anywhere; }
@media (max-width: 600px) {
  table { font-size: 13px; }
  th, td { padding-right: .45rem; }
  th:last-child:not(.number), td:last-child:not(.number) { min-width: 18rem; }
}
@media print {
  body { max-width: none; }
  h2 { break-after: avoid; }
  figure, table { break-inside: avoid; }
  figure svg { min-width: 0; }
}
</style>
</head>
<body>
<h1>$title</h1>
<p class="lead">$summary</p>
$sections
</body>
</html>
""")


def write_report(path: Path, document: Mapping[str, Any], figures: Mapping[str, Figure]) -> None:
    """Write the report of a result document with its figures. Raises StorageError if it cannot be written."""
    write_whole(path, report_page(document, figures).encode("utf-8"))


def report_page(document: Mapping[str, Any], figures: Mapping[str, Figure]) -> str:
    """The HTML text of a report."""
    sections = [
        _section("Result", _quantities(document)),
        _section("Design", _variables(document)),
        *(_figure(name, figure) for name, figure in figures.items()),
        _section("How the designs came about", _origins(document)),
        _section("To repeat it", _provenance(document)),
    ]
    if len(document["problem"]["objectives"]) > 1:
        sections.insert(2, _section("Front", _front(document)))
    return PAGE.substitute(
        title=_escaped(document["problem"]["label"]), summary=_escaped(_summary(document)), sections="\n".join(sections)
    )


def readable(value: object) -> str:
    """A number with five significant digits, a dash for nothing, anything else as it is."""
    if value is None:
        return "–"
    return f"{value:.5g}" if isinstance(value, float) else str(value)


def _summary(document: Mapping[str, Any]) -> str:
    gains = [
        f"{name} {'better' if gain >= 0.0 else 'worse'} by {abs(gain):.1f} %"
        for name, gain in document["improvement"].items()
        if gain is not None and name in _searched(document)
    ]
    found = f"Compared with the reference design, the best one has {' and '.join(gains)}." if gains else ""
    counted = (
        f"{len(document['evaluations'])} of {document['budget']} evaluations with strategy {document['strategy']['name']}, "
        f"{document['failed']} of them failed."
    )
    return f"{counted} {found}".strip()


def _searched(document: Mapping[str, Any]) -> list[str]:
    """Names of the objectives, behind the scalar too."""
    scalariser = document["scalariser"]
    own = [objective["name"] for objective in document["problem"]["objectives"]]
    return own + list(scalariser["values"].get("aspiration", {}) if scalariser else [])


def _quantities(document: Mapping[str, Any]) -> str:
    problem = document["problem"]
    rows, marked = [], []
    for quantity in {q["name"]: q for q in (*problem["objectives"], *problem["metrics"])}.values():
        name, gain = quantity["name"], document["improvement"].get(quantity["name"])
        values = [readable(_value(document[which], name)) for which in ("reference", "best")]
        better = "" if gain is None else f"{gain:+.1f} %"
        rows.append([_labelled(quantity), *values, better, quantity["meaning"]])
        marked.append(name in _searched(document))
    table = _table(["quantity", "reference", "best", "better by", "meaning"], rows, numbers=(1, 2, 3), marked=marked)
    return table + "<p>In bold what was searched for. “Better by” is in per cent of the reference design's value.</p>"


def _variables(document: Mapping[str, Any]) -> str:
    rows = []
    for variable in document["problem"]["variables"]:
        bounds = f"{readable(variable['lower'])} … {readable(variable['upper'])}"
        designs = [
            document[which]["design"][variable["name"]] if document[which] else None for which in ("reference", "best")
        ]
        rows.append([_labelled(variable), *map(readable, designs), bounds, variable["meaning"]])
    return _table(["variable", "reference", "best", "range", "meaning"], rows, numbers=(1, 2, 3))


def _front(document: Mapping[str, Any]) -> str:
    problem = document["problem"]
    titles = [_labelled(quantity) for quantity in (*problem["objectives"], *problem["variables"])]
    members = sorted(document["front"], key=lambda member: list(member["objectives"].values()))
    rows = [
        [member["number"], *map(readable, member["objectives"].values()), *map(readable, member["design"].values())]
        for member in members
    ]
    best = document["best"]
    which = f"<p>The best one above is evaluation {best['number']}: its worst objective is best.</p>" if best else ""
    return which + _table(["evaluation", *titles], rows, numbers=range(len(titles) + 1))


def _figure(name: str, figure: Figure) -> str:
    picture = inlined(drawn(figure, "svg", name).decode("utf-8"), name)
    caption = _escaped(str(figure.get_label()))
    return f'<figure id="{_escaped(name)}"><div class="scroll">{picture}</div><figcaption>{caption}</figcaption></figure>'


def inlined(picture: str, name: str) -> str:
    """An SVG file as an element of a page: no header, no metadata, identifiers made unique by the figure's name."""
    element = re.sub(r"<metadata>.*?</metadata>", "", picture[picture.index("<svg") :], flags=re.DOTALL)
    return re.sub(r'(\bid="|url\(#|href="#)', rf"\g<1>{name}-", element)


def _origins(document: Mapping[str, Any]) -> str:
    evaluations = document["evaluations"]
    counts = Counter(evaluation["origin"] for evaluation in evaluations)
    starts = {evaluation["trajectory"]: evaluation["number"] for evaluation in reversed(evaluations)}
    restarts = ", ".join(f"{number}" for trajectory, number in sorted(starts.items()) if trajectory > 0)
    failures = [[row["number"], row["origin"], row["reason"]] for row in evaluations if row["reason"]]
    parts = [
        _table(["origin", "evaluations"], [[origin, str(count)] for origin, count in counts.most_common()], numbers=(1,)),
        f"<p>Resets at evaluation: {restarts or 'none'}. Designs asked for again and answered from memory, free of charge: "
        f"{document['repeats']}. Simulation and search took {document['seconds']:.1f} s.</p>",
    ]
    if failures:
        listed = f"<p>{len(failures)} evaluations failed" + (
            ", the first of them:" if len(failures) > FAILURES_LISTED else ":"
        )
        parts += [listed + "</p>", _table(["evaluation", "origin", "reason"], failures[:FAILURES_LISTED], numbers=(0,))]
    return "\n".join(parts)


def _provenance(document: Mapping[str, Any]) -> str:
    strategy, scalariser = document["strategy"], document["scalariser"]
    settings = [[f"{strategy['name']}: {name}", value] for name, value in strategy["settings"].items()]
    if scalariser:
        settings += [[f"{scalariser['name']}: {name}", value] for name, value in scalariser["values"].items()]
    plugins = [[p["kind"], p["name"], p["module"], f"{p['distribution']} {p['version']}"] for p in document["plugins"]]
    return "\n".join(
        (
            f"<pre>{_escaped(document['command'])}</pre>",
            f"<p>Seed {document['seed']}. Everything about the run, every evaluation included, is in result.json.</p>",
            _table(["setting", "value"], [[name, "not given" if value is None else value] for name, value in settings]),
            _table(["plugin", "name", "module", "from"], plugins),
            _table(["library", "version"], list(document["versions"].items())),
        )
    )


def _section(title: str, content: str) -> str:
    return f"<section><h2>{_escaped(title)}</h2>\n{content}\n</section>"


def _table(titles: Sequence[str], rows: Iterable[Row], numbers: Iterable[int] = (), marked: Sequence[bool] = ()) -> str:
    right = set(numbers)

    def line(cells: Row, tag: str) -> str:
        kinds = [' class="number"' if position in right else "" for position in range(len(cells))]
        return "".join(f"<{tag}{kind}>{_escaped(cell)}</{tag}>" for kind, cell in zip(kinds, cells, strict=True))

    kinds = [
        ' class="objective"' if position < len(marked) and marked[position] else "" for position in range(len(list(rows)))
    ]
    body = "\n".join(f"<tr{kind}>{line(row, 'td')}</tr>" for kind, row in zip(kinds, rows, strict=True))
    return (
        f'<div class="scroll"><table><thead><tr>{line(titles, "th")}</tr></thead>\n<tbody>\n{body}\n</tbody></table></div>'
    )


def _labelled(quantity: Mapping[str, Any]) -> str:
    """A name with its unit in brackets."""
    return f"{quantity['name']} [{quantity['unit']}]" if quantity["unit"] else str(quantity["name"])


def _value(evaluation: Mapping[str, Any] | None, name: str) -> float | None:
    if evaluation is None:
        return None
    values: dict[str, float | None] = {**evaluation["objectives"], **evaluation["metrics"]}
    return values.get(name)


def _escaped(value: object) -> str:
    return html.escape(str(value))
