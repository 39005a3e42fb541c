"""The report of a campaign: one HTML page that needs nothing beside itself, for the screen, the phone and the printer.

Without its script everything can be read; the script adds values under the pointer, strategies that can be hidden, and
tables that can be sorted.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from railsearch.report import campaign_tables as tables
from railsearch.report.design_tables import quantities_table, variables_table
from railsearch.report.markup import Markup, drawing, escaped, page, picture, section, table
from railsearch.run_directory import write_whole

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Entry = Mapping[str, Any]
Pictures = Mapping[str, Mapping[str, "Figure"]]

OVERVIEW_KEY = (
    "Median of the best value at the end of the budget, quartiles beneath. <b>Bold ★</b>: the best median on a problem; "
    "≈: not significantly different from it; without a mark: significantly worse, or not tested. <b>Best rank in</b>: in "
    "how many of the random resamples of the repetitions the strategy has the best mean rank over the problems. Marks "
    "compare within one problem, ranks over all of them: one may show a difference that the other has too little data for."
)
PAIRWISE_KEY = (
    "Probability that the row's strategy ends better than the column's (Vargha and Delaney's A12; 0.5: no tendency), and "
    "the p-value of the Wilcoxon rank-sum test adjusted by Holm for all pairs. ▲ significantly better, ▼ worse."
)
DISTANCE_KEY = (
    "Modified inverted generational distance at the end of the budget, objectives scaled by the box of the hypervolume; "
    "median of the repetitions, quartiles beneath. Lower is better."
)
RUNNING_TIME_KEY = (
    "Evaluations that the strategy is expected to need, restarted until it succeeds, to reach each target; beneath, how "
    "many repetitions reached it. Targets by their share of the way from the first value to the best one found."
)


def write_campaign_report(path: Path, document: Entry, pictures: Pictures) -> None:
    """Write the report of a campaign's document; pictures: of the designs, by problem label and name.

    Raises StorageError if it cannot be written.
    """
    write_whole(path, campaign_page(document, pictures).encode("utf-8"))


def campaign_page(document: Entry, pictures: Pictures) -> str:
    """The HTML text of a campaign's report."""
    from railsearch.report.campaign_figures import campaign_figures

    figures = campaign_figures(document, ("quartiles", "confidence"))
    drawings = {name: picture(name, figure, "plot") for name, figure in figures.items()}
    content = [
        _facts(document),
        _notes(document["notes"]),
        _controls(document),
        _overview(document),
        *(_problem(number, entry, drawings, pictures) for number, entry in enumerate(document["problems"], 1)),
        _over_problems(document, drawings),
        section("Time and failures", _costs(document)),
        section("To run it again", _provenance(document)),
        _plots(document, figures),
    ]
    title = f"Campaign {document['campaign']['name']}"
    return page(title, _stressed(document["conclusion"]), content, ["campaign.css"], ["campaign.js"])


def _stressed(conclusion: str) -> Markup:
    """A conclusion with its main clause, up to the first colon, in bold."""
    clause, colon, rest = conclusion.partition(": ")
    return Markup(f"<strong>{escaped(clause + colon)}</strong>{escaped(rest)}" if colon else escaped(conclusion))


def _facts(document: Entry) -> str:
    campaign = document["campaign"]
    state = "complete" if document["status"] == "complete" else "<b>incomplete</b>"
    planned = (
        f"{len(campaign['problems'])} problems × {len(campaign['strategies'])} strategies × {campaign['repetitions']} "
        f"repetitions with {campaign['budget']} evaluations each"
    )
    done = (
        f"{document['complete']} of {document['planned']} runs finished, {document['evaluations']} evaluations, "
        f"{document['failed']} of them failed"
    )
    return f'<p class="facts">Campaign {state}: {planned}; {done}.</p>'


def _notes(notes: Sequence[str]) -> str:
    return '<ul class="notes">' + "".join(f"<li>{escaped(note)}</li>" for note in notes) + "</ul>" if notes else ""


def _controls(document: Entry) -> str:
    """The legend of all figures, with the switches that the script brings to life."""
    from railsearch.report.campaign_figures import swatch

    keys = "".join(
        f'<button type="button" class="key" data-strategy="{place}" aria-pressed="true" disabled>'
        f"{drawing(f'key-{place}', swatch(place))}<span>{escaped(strategy['label'])}</span></button>"
        for place, strategy in enumerate(document["campaign"]["strategies"])
    )
    return (
        f'<div class="controls"><div class="keys">{keys}</div><div class="switches"><span>Click a strategy to hide it, '
        'twice to see it alone.</span><button type="button" id="all">show all</button><button type="button" id="none">hide '
        'all</button><label>band <select id="band" autocomplete="off"><option value="quartiles">quartiles</option>'
        '<option value="confidence">95 % confidence of the median</option><option value="">none</option></select></label>'
        "</div></div>"
    )


def _overview(document: Entry) -> str:
    anchors = {entry["label"]: f"problem-{number}" for number, entry in enumerate(document["problems"], 1)}
    return section("Overview", f"{tables.overview_table(document, anchors)}<p>{OVERVIEW_KEY}</p>")


def _problem(number: int, entry: Entry, drawings: Mapping[str, str], pictures: Pictures) -> str:
    own = [drawn for name, drawn in drawings.items() if name.startswith(f"{number}-")]
    parts = [f'<p class="verdict">{_stressed(entry["conclusion"])}</p>', _box(entry)]
    if own:
        parts += [f'<div class="plots">{"".join(own)}</div>', *_comparison(entry)]
    parts += _design(number, entry, pictures.get(entry["label"], {}))
    return section(f"{entry['label']}: {entry['title']}", "\n".join(parts), f"problem-{number}").replace(
        "<section ", '<section class="problem" ', 1
    )


def _box(entry: Entry) -> str:
    """Between which points hypervolume is measured."""
    box = entry["measure"]["box"]
    if box is None:
        return ""
    units = {objective["name"]: objective["unit"] for objective in entry["design"]["problem"]["objectives"]}
    ideal, reference = (
        escaped(", ".join(f"{name} = {tables.four(value)} {units[name]}".strip() for name, value in box[which].items()))
        for which in ("ideal", "reference")
    )
    return (
        f"<p>Hypervolume is the dominated share of the box between the ideal point ({ideal}; the best recorded values) and "
        f"the reference point ({reference}; {escaped(box['source'])}).</p>"
    )


def _comparison(entry: Entry) -> list[str]:
    unit = f" [{entry['measure']['unit']}]" if entry["measure"]["unit"] else ""
    budget = (
        f"<h3>Best {escaped(entry['measure']['name'] + unit)} at fractions of the budget</h3>"
        f"{tables.fixed_budget_table(entry)}"
        f"<p>Medians of {len(entry['repetitions'])} repetitions, quartiles beneath; the number of evaluations in brackets."
        "</p>"
    )
    pairs = (
        f"<h3>Which differences are real</h3>{tables.pairwise_table(entry)}<p>{PAIRWISE_KEY}</p>"
        if entry["pairwise"]
        else ""
    )
    parts = [f'<div class="pair"><div>{budget}</div><div>{pairs}</div></div>']
    if entry["front_distance"]:
        parts += ["<h3>Distance from the known front</h3>", tables.front_distance_table(entry), f"<p>{DISTANCE_KEY}</p>"]
    if entry["targets"]:
        inside = f"{tables.running_time_table(entry)}<p>{RUNNING_TIME_KEY}</p>"
        parts.append(f"<details><summary>Expected running time to targets{escaped(unit)}</summary>{inside}</details>")
    return parts


def _design(number: int, entry: Entry, pictures: Mapping[str, Figure]) -> list[str]:
    design, found = entry["design"], entry["design"]["found_by"]
    if found is None:
        return ["<h3>Best design</h3><p>No feasible design was found.</p>"]
    which = (
        f", of a front of {design['front_size']} the one whose worst objective is best" if design["front_size"] > 1 else ""
    )
    return [
        "<h3>Best design</h3>",
        f"<p>Found by {escaped(found['strategy'])} in repetition {found['repetition']} at evaluation "
        f"{design['best']['number']}{which}.</p>",
        f'<div class="wide">{quantities_table(design, design["searched"])}{variables_table(design)}</div>',
        *(picture(f"{number}-design-{name}", figure) for name, figure in pictures.items()),
    ]


def _over_problems(document: Entry, drawings: Mapping[str, str]) -> str:
    own = [drawn for name, drawn in drawings.items() if name.startswith("all-")]
    if not own:
        return ""
    untested = document["ranking"]["untested"]
    reason = f"<p>No test over the problems: {escaped(untested)}.</p>" if untested else ""
    return section("Over all problems", f'<div class="plots">{"".join(own)}</div>{reason}')


def _costs(document: Entry) -> str:
    parts = ["<p>Times are medians per evaluation: inside the evaluation, and inside the strategy before it.</p>"]
    for entry in document["problems"]:
        parts += [f"<h3>{escaped(entry['label'])}</h3>", tables.cells_table(entry)]
    return "\n".join([*parts, "<h3>Failures</h3>", f'<div class="wide">{tables.failures_table(document["problems"])}</div>'])


def _provenance(document: Entry) -> str:
    campaign = document["campaign"]
    strategies = [(f"{s['label']} ({s['name']})", s["settings"]) for s in campaign["strategies"]]
    problems = [(p["label"], {key: value for key, value in p["settings"].items() if value}) for p in campaign["problems"]]
    command = f"<pre>{escaped(document['command'])}</pre>" if document["command"] else ""
    definition = json.dumps(campaign, indent=1, ensure_ascii=False)
    return "\n".join(
        (
            command,
            f"<p>Campaign seed {campaign['seed']}; the seed of every run is in statistics.json.</p>",
            table(["strategy", "settings"], tables.settings_rows(strategies)),
            table(["problem", "settings"], tables.settings_rows(problems)),
            table(["library", "version"], list(document["versions"].items())),
            f"<details><summary>The whole definition</summary><pre>{escaped(definition)}</pre></details>",
        )
    )


def _plots(document: Entry, figures: Mapping[str, Figure]) -> str:
    """What the script needs to show values under the pointer, after the figures have been drawn."""
    from railsearch.report.campaign_plots import plots

    text = json.dumps(plots(document, figures), ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    harmless = text.replace("<", "\\u003c")
    return f'<script type="application/json" id="plots">{harmless}</script>'
